"""The paper's test sweeps: one perturbation varies, the others stay at their defaults."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from ido.clouds import Cloud
from ido.histograms import SceneBatch
from ido.maps import Maps
from ido.perturbation import Perturbation, Scene, perturb
from ido.registration import EPSILON, register_batch
from ido.scores import score
from ido.types import FloatArray

LEVELS: dict[str, tuple[float, ...]] = {
    "noise": (0, 0.02, 0.04, 0.06, 0.08, 0.1),
    "points": (100, 400, 1000, 2500, 4000),
    "outliers": (0, 150, 300, 450, 600),
    "incomplete": (0, 0.2, 0.4, 0.55, 0.7),
    "rotation": (0, 30, 60, 90, 120, 150, 180),
    "translation": (0, 0.2, 0.4, 0.6, 0.8, 1.0),
}
"""Levels of each sweep. The paper gives their ranges, not the levels."""


def level_scene(base: Perturbation, name: str, level: float, trial: int, scenes: int, seed: int) -> Perturbation:
    """The perturbation of a sweep's scene: trial 0 .. scenes - 1 at a level, each with a draw of its own.

    All methods meet the same scenes.
    """
    value = int(level) if name in ("points", "outliers") else level
    first = seed + 10_000 * list(LEVELS).index(name)
    draw = first + LEVELS[name].index(level) * scenes + trial
    return replace(base, seed=draw, **{name: value})


def sweep_scenes(cloud: Cloud, base: Perturbation, name: str, scenes: int, seed: int) -> Iterator[list[Scene]]:
    """The scenes of a sweep, level by level."""
    for level in LEVELS[name]:
        yield [perturb(cloud, level_scene(base, name, level, trial, scenes, seed)) for trial in range(scenes)]


def sweep(
    cloud: Cloud,
    maps: Maps,
    name: str,
    *,
    base: Perturbation | None = None,
    scenes: int = 100,
    seed: int = 1_000_000,
    epsilon: float = EPSILON,
) -> FloatArray:
    """PointAcc and PointRMSE of every registration of a sweep, shape (levels, scenes, 2)."""
    results = []
    for level in sweep_scenes(cloud, base or Perturbation(), name, scenes, seed):
        tracks = register_batch(maps, SceneBatch.of([scene.points for scene in level]), epsilon=epsilon)
        scores = [score(scene, track.T_model_scene[-1]) for scene, track in zip(level, tracks, strict=True)]
        results.append([(s.accuracy, s.rmse) for s in scores])
    return np.array(results, dtype=np.float64)


def mean_and_interval(values: FloatArray) -> tuple[float, float]:
    """Mean of a sweep's values (levels, scenes) and half of its 95% confidence interval.

    The levels are given and the scenes at each are independent draws, so the levels' variances add up.
    """
    n_levels, n_scenes = values.shape
    variance = values.var(axis=1, ddof=1).sum() / (n_scenes * n_levels**2)
    return float(values.mean()), float(1.96 * np.sqrt(variance))
