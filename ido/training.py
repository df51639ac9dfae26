"""Training: many perturbed scenes become a sequence of maps (paper, Algorithm 1; docs/method.md, "Training")."""

from __future__ import annotations

import importlib.metadata
import warnings
from collections.abc import Callable
from concurrent.futures import Executor

import numpy as np
import scipy.linalg

from ido import poses
from ido.clouds import Cloud
from ido.folding import Folding
from ido.histograms import Histogram, SceneBatch
from ido.maps import Maps, TrainingCurves, TrainingSettings
from ido.perturbation import RANGES, Perturbation, perturb
from ido.types import FloatArray

SHOWN_SAMPLES = 600
"""Samples whose errors are kept for the paper's training-curve figure."""

_CHUNK = 1000  # scenes handed out at a time

Progress = Callable[[int, float], None]
"""Called with the number of maps trained so far and the mean training error ‖x* - x_k‖²."""


def train(
    cloud: Cloud,
    histogram: Histogram,
    settings: TrainingSettings | None = None,
    *,
    progress: Progress | None = None,
    executor: Executor | None = None,
) -> Maps:
    """Learn D_1 .. D_K.

    At every map, D_{k+1} = argmin (1/N) Σ ‖x* - x_k + D h(x_k)‖² + λ ‖D‖²_F, then x_{k+1} = x_k - D_{k+1} h(x_k)
    (docs/method.md, Eq. 13 and 14). Ctrl-C ends it; the maps finished by then are returned (`Maps.complete` is False).

    Args:
        cloud: what training scenes are drawn from.
        histogram: the feature to learn on, with its model.
        settings: the paper's unless given.
        progress: called before the first map and after each.
        executor: shares the scenes out; without one, the histogram's `batch` runs here. The maps are the same.

    Raises:
        KeyboardInterrupt: interrupted before the first map was finished.
    """
    learner = Learner(cloud, histogram, settings or TrainingSettings(), executor=executor)
    try:
        for k in range(learner.settings.maps):
            if progress:
                progress(k, learner.error)
            learner.learn()
        if progress:
            progress(learner.settings.maps, learner.error)
    except KeyboardInterrupt:
        if learner.learned == 0:
            raise
    return learner.maps()


class Learner:
    """Learns map after map; `maps` gives those learned so far, so that learning can be watched.

    Args:
        cloud: what training scenes are drawn from.
        histogram: the feature to learn on, with its model.
        settings: how many scenes and maps, and of which kind.
        scenes: as `training_scenes` draws them, where several learners share them; drawn unless given.
        executor: shares the scenes out.
    """

    def __init__(
        self,
        cloud: Cloud,
        histogram: Histogram,
        settings: TrainingSettings,
        *,
        scenes: tuple[SceneBatch, FloatArray] | None = None,
        executor: Executor | None = None,
    ) -> None:
        self.settings = settings
        self._histogram, self._frame, self._executor = histogram, cloud.frame, executor
        self._scenes, self._x_true = scenes or training_scenes(cloud, settings)
        self._x = np.zeros_like(self._x_true)
        self._folding = Folding.of(histogram)
        self._shown = np.random.default_rng(settings.seed).permutation(len(self._x))[:SHOWN_SAMPLES]
        self._maps: list[FloatArray] = []
        self._errors = [_errors(self._x_true)]
        self._kept = [self._x_true[self._shown]]

    @property
    def learned(self) -> int:
        """Number of maps so far."""
        return len(self._maps)

    @property
    def error(self) -> float:
        """The mean training error ‖x* - x_k‖² after the maps so far."""
        return self._errors[self.learned][0]

    def learn(self) -> None:
        """Learn the next map (docs/method.md, Eq. 13 and 14). Warns when the training error did not fall."""
        z = _folded(self._histogram, self._folding, self._scenes, self._x, self._executor)
        E = solve(z, self._x - self._x_true, self.settings.ridge_of(self.learned))
        self._x = self._x - z @ E.T
        self._errors.append(_errors(self._x_true - self._x))
        self._kept.append((self._x_true - self._x)[self._shown])
        self._maps.append(self._folding.unfold(E))  # last: what counts is finished whenever an interrupt comes
        if not self._errors[-1][0] < self._errors[-2][0]:
            warnings.warn(f"the training error did not fall at map {self.learned} (Theorem 1)", stacklevel=3)

    def maps(self) -> Maps:
        """The maps so far, at least one."""
        n = self.learned + 1
        mean, deviation, translation, rotation = np.array(self._errors[:n]).T
        return Maps(
            maps=np.stack(self._maps),
            histogram=self._histogram,
            frame=self._frame,
            settings=self.settings,
            curves=TrainingCurves(mean, deviation, translation, rotation, np.stack(self._kept[:n]).astype(np.float32)),
            version=importlib.metadata.version("ido-explorer"),
        )


def training_scenes(cloud: Cloud, settings: TrainingSettings) -> tuple[SceneBatch, FloatArray]:
    """The training scenes and their true x* (N, 6): every perturbation uniform in the settings' training range.

    docs/method.md, Eq. 4.
    """
    rng = np.random.default_rng(settings.seed)
    names = sorted(RANGES, key=lambda name: RANGES[name].stream)  # their order decides the draws
    low, high = np.array([settings.ranges[name] for name in names]).T
    draws = rng.uniform(low, high, (settings.samples, len(names)))
    seeds = rng.integers(0, 2**32, settings.samples)
    scenes = []
    for draw, seed in zip(draws, seeds, strict=True):
        values = {n: round(v) if n in ("points", "outliers") else v for n, v in zip(names, draw, strict=True)}
        perturbation = Perturbation(**values, outlier_kind=settings.outlier_kind, seed=int(seed))
        scenes.append(perturb(cloud, perturbation))
    x_true = poses.log(np.stack([scene.T_model_scene for scene in scenes]))
    return SceneBatch.of([scene.points for scene in scenes]), x_true


def solve(h: FloatArray, step: FloatArray, ridge: float) -> FloatArray:
    """The map D = [(1/N) Σ step hᵀ] [(1/N) Σ h hᵀ + λI]⁻¹ that predicts each step from its histogram.

    docs/method.md, Eq. 15. With fewer scenes than bins, it is solved in as many unknowns as there are scenes: with the
    histograms as rows of H, (Hᵀ H / N + λI)⁻¹ Hᵀ = Hᵀ (H Hᵀ / N + λI)⁻¹.

    Args:
        h: histograms, shape (N, n_bins), float32.
        step: x_k - x*, shape (N, 6).
        ridge: λ.

    Returns:
        shape (6, n_bins), float32.
    """
    n, n_bins = h.shape
    step = step.astype(np.float32)
    if n < n_bins:
        return _solve(h @ h.T, step, n, ridge).T @ h
    return np.ascontiguousarray(_solve(h.T @ h, h.T @ step, n, ridge).T)


def _solve(products: FloatArray, right: FloatArray, n: int, ridge: float) -> FloatArray:
    """(P / N + λI)⁻¹ R / N, found in double precision; float32."""
    gram = products.astype(np.float64) / n
    gram[np.diag_indices_from(gram)] += ridge
    factor = scipy.linalg.cho_factor(gram, overwrite_a=True, check_finite=False)
    solution = scipy.linalg.cho_solve(factor, (right / np.float32(n)).astype(np.float64), check_finite=False)
    return solution.astype(np.float32)


def _folded(
    histogram: Histogram, folding: Folding, scenes: SceneBatch, x: FloatArray, executor: Executor | None
) -> FloatArray:
    """The folded histograms of all scenes, moved by x (N, 6); the whole ones are never in memory at once."""
    z = np.empty((len(scenes), folding.n_numbers), dtype=np.float32)
    parts = [(begin, min(begin + _CHUNK, len(scenes))) for begin in range(0, len(scenes), _CHUNK)]
    batches = [scenes.part(*part) for part in parts]
    poses_x = [x[begin:end] for begin, end in parts]
    described = (map if executor is None else executor.map)(histogram.batch, batches, poses_x)
    for (begin, end), h in zip(parts, described, strict=True):
        z[begin:end] = folding.fold(h)
    return z


def _errors(residual: FloatArray) -> tuple[float, float, float, float]:
    """Mean and deviation of ‖x* - x‖², and the means of its translation and rotation parts."""
    squares = residual**2
    total = squares.sum(axis=1)
    return total.mean(), total.std(), squares[:, :3].sum(axis=1).mean(), squares[:, 3:].sum(axis=1).mean()
