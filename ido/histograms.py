"""Histograms: what a method sees of a scene at a pose (paper, "Original Discriminative Optimization" and "Improved").

Each class holds the plain NumPy definition, `describe`, beside the compiled one that is used, `__call__` and `batch`.
"""

from __future__ import annotations

import os
from abc import ABC, abstractmethod
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar, Literal

import numpy as np

from ido import kernels, poses
from ido.clouds import Model
from ido.types import FloatArray

SIGMA2 = 0.03
"""σ² of the Gaussian weight exp(-d²/σ²), in squared model units, as in the paper."""

_SCENES_A_THREAD = 8

Normalisation = Literal["unit-norm", "unit-sum"]


def finite(points: FloatArray) -> FloatArray:
    """Points as the compiled loops want them: float32, in one piece, and none that would lead them out of bounds.

    Raises:
        ValueError: coordinates are not finite.
    """
    points = np.ascontiguousarray(points, dtype=np.float32)
    if not np.isfinite(points).all():
        raise ValueError("the scene has coordinates that are not finite; remove those points first")
    return points


@dataclass(frozen=True, slots=True, eq=False)
class SceneBatch:
    """Many scenes in one array: scene i is ``points[starts[i]:starts[i + 1]]``."""

    points: FloatArray
    starts: np.ndarray

    @classmethod
    def of(cls, scenes: Sequence[FloatArray]) -> SceneBatch:
        """Pack scenes, each of shape (S_i, 3).

        Raises:
            ValueError: coordinates are not finite.
        """
        starts = np.concatenate([[0], np.cumsum([len(scene) for scene in scenes])]).astype(np.int64)
        return cls(finite(np.concatenate([*scenes, np.empty((0, 3))])), starts)

    def __len__(self) -> int:
        return len(self.starts) - 1

    def __getitem__(self, i: int) -> FloatArray:
        return self.points[self.starts[i] : self.starts[i + 1]]

    def part(self, begin: int, end: int) -> SceneBatch:
        """Scenes begin to end, without copying."""
        starts = self.starts[begin : end + 1]
        return SceneBatch(self.points[starts[0] : starts[-1]], starts - starts[0])

    def choose(self, chosen: np.ndarray) -> SceneBatch:
        """The chosen scenes, copied."""
        return SceneBatch.of([self[i] for i in chosen])


class Histogram(ABC):
    """A feature of a scene relative to a model. A new one needs a name, `blocks` and `describe`.

    Args:
        model: the model that it is relative to.
    """

    name: ClassVar[str]
    blocks: ClassVar[tuple[tuple[str, str], ...]]
    """The two sides of each block; a block has 2 M bins, the first M for the first side."""

    def __init__(self, model: Model) -> None:
        self.model = model

    @abstractmethod
    def describe(self, moved: FloatArray) -> FloatArray:
        """The histogram of points (S, 3) in the model frame; shape (n_bins,)."""

    def __call__(self, points: FloatArray, x: FloatArray) -> FloatArray:
        """The histogram of a scene (S, 3) moved by exponential coordinates x (6,); shape (n_bins,), float32."""
        return self.describe(poses.transform(poses.exp(x), points)).astype(np.float32)

    def batch(self, scenes: SceneBatch, x: FloatArray) -> FloatArray:
        """Histograms of many scenes, moved by x (B, 6); shape (B, n_bins), float32."""
        rows = [self(scenes[i], x[i]) for i in range(len(scenes))]
        return np.stack(rows) if rows else np.empty((0, self.n_bins), dtype=np.float32)

    @property
    def n_bins(self) -> int:
        return 2 * len(self.blocks) * len(self.model.points)

    @cached_property
    def reference(self) -> FloatArray:
        """The reference line: the histogram of the model against itself, shape (n_bins,)."""
        return self(self.model.points, np.zeros(6))


class _Compiled(Histogram):
    """What the two histograms of the paper share: the compiled path, bin weights and normalised blocks."""

    normalisation: ClassVar[Normalisation] = "unit-norm"

    @cached_property
    def weights(self) -> FloatArray:
        """Weight of each bin, shape (sides, M)."""
        return np.ones((2 * len(self.blocks), len(self.model.points)), dtype=np.float32)

    @cached_property
    def _boxed(self) -> kernels.BoxedModel:
        return kernels.box_model(self.model.points, self.model.normals, SIGMA2)

    def __call__(self, points: FloatArray, x: FloatArray) -> FloatArray:
        points = np.ascontiguousarray(points, dtype=np.float32)
        x = np.ascontiguousarray(x, dtype=np.float64)
        return kernels.histogram(points, x, self._boxed, self.weights, self.normalisation == "unit-norm")

    def batch(self, scenes: SceneBatch, x: FloatArray) -> FloatArray:
        x = np.ascontiguousarray(x, dtype=np.float64)
        out = np.empty((len(scenes), *self.weights.shape), dtype=np.float32)
        unit_norm = self.normalisation == "unit-norm"
        boxed, weights = self._boxed, self.weights

        def fill(begin: int, end: int) -> None:
            part = scenes.part(begin, end)
            kernels.histograms(part.points, part.starts, x[begin:end], boxed, weights, unit_norm, out[begin:end])

        n_threads = min(os.cpu_count() or 1, -(-len(scenes) // _SCENES_A_THREAD))
        if n_threads > 1:  # a pool for each call: a lasting one would not survive a fork
            step = max(_SCENES_A_THREAD, -(-len(scenes) // (4 * n_threads)))
            begins = range(0, len(scenes), step)
            with ThreadPoolExecutor(n_threads) as pool:
                list(pool.map(fill, begins, [min(begin + step, len(scenes)) for begin in begins]))
        else:
            fill(0, len(scenes))
        return out.reshape(len(scenes), -1)

    def describe(self, moved: FloatArray) -> FloatArray:
        sides = self.sides(np.asarray(moved, dtype=np.float64)) * self.weights
        blocks = sides.reshape(len(self.blocks), -1)
        size = np.linalg.norm(blocks, axis=1) if self.normalisation == "unit-norm" else blocks.sum(axis=1)
        return (blocks / np.where(size > 0, size, 1.0)[:, None]).reshape(-1)

    @abstractmethod
    def sides(self, moved: FloatArray) -> FloatArray:
        """The blocks before weighting and normalising, shape (sides, M)."""


class FrontBack(_Compiled):
    """DO: Σ w over the scene points in front of each model point, and over those behind it.

    w = exp(-‖s - m_a‖² / σ²), or nothing where that is below 1e-6; s is in front when n_a · (s - m_a) > 0.
    """

    name = "front-back"
    blocks = (("front", "back"),)

    def sides(self, moved: FloatArray) -> FloatArray:
        offset = moved[None] - self.model.points.astype(np.float64)[:, None]  # (M, S, 3)
        weight = np.exp(-(offset**2).sum(axis=-1) / SIGMA2)
        weight = np.where(weight > kernels.SMALLEST_WEIGHT, weight, 0.0)
        in_front = (offset * self.model.normals.astype(np.float64)[:, None]).sum(axis=-1) > 0
        return np.stack([(weight * in_front).sum(axis=1), (weight * ~in_front).sum(axis=1)])


class TripleBinary(FrontBack):
    """Improved DO: front / back, and how many scene points lie above / below and clockwise / anticlockwise.

    Up: elevation θ_s > θ_a, θ = atan2(z, hypot(x, y)). Clockwise: azimuth ω_s > ω_a, ω = atan2(y, x).
    """

    name = "triple-binary"
    blocks = (("front", "back"), ("up", "down"), ("clockwise", "anticlockwise"))

    def sides(self, moved: FloatArray) -> FloatArray:
        model = self.model.points.astype(np.float64)
        counts = []
        for angle in (elevation, azimuth):
            greater = (angle(moved)[None] > angle(model)[:, None]).sum(axis=1)
            counts += [greater, len(moved) - greater]
        return np.concatenate([super().sides(moved), counts])


class AsPrinted(TripleBinary):
    """Improved DO with the paper's weights: α, β, γ on the first sides, 1-α, 1-β, 1-γ on the second ones.

    α_a, β_a, γ_a are the shares of the model points in front of, above and clockwise of m_a.
    """

    name = "as-printed"

    @cached_property
    def weights(self) -> FloatArray:
        model = self.model.points.astype(np.float64)
        offset = model[None] - model[:, None]
        in_front = (offset * self.model.normals.astype(np.float64)[:, None]).sum(axis=-1) > 0
        shares = [in_front.mean(axis=1)]
        shares += [(angle(model)[None] > angle(model)[:, None]).mean(axis=1) for angle in (elevation, azimuth)]
        return np.concatenate([[share, 1 - share] for share in shares]).astype(np.float32)


def elevation(points: FloatArray) -> FloatArray:
    """θ = atan2(z, hypot(x, y)) of points (S, 3), radians."""
    return np.arctan2(points[:, 2], np.hypot(points[:, 0], points[:, 1]))


def azimuth(points: FloatArray) -> FloatArray:
    """ω = atan2(y, x) of points (S, 3), radians in (-π, π]."""
    return np.arctan2(points[:, 1], points[:, 0])


HISTOGRAMS: dict[str, type[Histogram]] = {h.name: h for h in (FrontBack, TripleBinary, AsPrinted)}
"""The histograms that a maps file may name."""
