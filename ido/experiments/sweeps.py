"""The paper's test sweeps: one perturbation varies, the others stay at their defaults."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from ido.clouds import Cloud
from ido.histograms import SceneBatch
from ido.maps import Maps
from ido.perturbation import Perturbation, Scene, perturb
from ido.registration import EPSILON, register_batch
from ido.scores import score
from ido.types import FloatArray


@dataclass(frozen=True, slots=True)
class Sweep:
    """Levels of one perturbation. The numbers decide which scenes are drawn, so they must never change.

    Args:
        number: of the sweep.
        levels: each with its number. The paper gives their range, not the levels.
    """

    number: int
    levels: Mapping[float, int]


SWEEPS: dict[str, Sweep] = {
    "noise": Sweep(0, {0: 0, 0.02: 1, 0.04: 2, 0.06: 3, 0.08: 4, 0.1: 5}),
    "points": Sweep(1, {100: 0, 400: 1, 1000: 2, 2500: 3, 4000: 4}),
    "outliers": Sweep(2, {0: 0, 150: 1, 300: 2, 450: 3, 600: 4}),
    "incomplete": Sweep(3, {0: 0, 0.2: 1, 0.4: 2, 0.55: 3, 0.7: 4}),
    "rotation": Sweep(4, {0: 0, 30: 1, 60: 2, 90: 3, 120: 4, 150: 5, 180: 6}),
    "translation": Sweep(5, {0: 0, 0.2: 1, 0.4: 2, 0.6: 3, 0.8: 4, 1.0: 5}),
}
"""Every sweep, by the perturbation that it varies."""

LEVELS: dict[str, tuple[float, ...]] = {name: tuple(sorted(its.levels)) for name, its in SWEEPS.items()}
"""Levels of each sweep, rising."""


def level_scene(base: Perturbation, name: str, level: float, trial: int, scenes: int, seed: int) -> Perturbation:
    """The perturbation of a sweep's scene: trial 0 .. scenes - 1 at a level, each with a draw of its own.

    All methods meet the same scenes.
    """
    value = int(level) if name in ("points", "outliers") else level
    its = SWEEPS[name]
    draw = seed + 10_000 * its.number + its.levels[level] * scenes + trial
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
