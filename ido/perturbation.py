"""A perturbation is a value; with a cloud it makes one scene, always the same (docs/method.md, "Perturbation").

Each of the six kinds draws from a random stream of its own, so that neighbouring values give neighbouring scenes: a
larger noise scales the same noise, more outliers keep the earlier ones, a longer translation keeps its direction.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Literal, get_args

import numpy as np

from ido.clouds import Cloud
from ido.kernels import pose_of
from ido.poses import invert, transform
from ido.types import BoolArray, FloatArray

OutlierKind = Literal["uniform", "structured"]

OUTLIER_REACH = 1.5
"""Outliers lie within ±1.5 of the scene's origin (model units)."""

STRUCTURED_DEVIATION = (1 / 9, 1 / 4)
"""Range of the standard deviation of the Gaussian ball that structured outliers form (model units)."""


LARGEST_SEED = 2**32 - 1


@dataclass(frozen=True, slots=True)
class Range:
    """What a perturbation may be, and what the paper trains and tests on."""

    low: float
    high: float
    """Highest value of the paper's test sweep."""
    limit: float
    """Highest value that `Perturbation` takes."""
    train: tuple[float, float]
    unit: str
    stream: int
    """Number of the random stream that it draws from. It decides every scene, so it must never change."""


RANGES: dict[str, Range] = {
    "noise": Range(0.0, 0.1, 1.0, (0.0, 0.05), "standard deviation, model units", stream=0),
    "points": Range(100, 4000, 100_000, (400, 800), "points before removal", stream=1),
    "outliers": Range(0, 600, 100_000, (0, 300), "points", stream=2),
    "incomplete": Range(0.0, 0.7, 0.99, (0.0, 0.3), "share removed", stream=3),
    "rotation": Range(0.0, 180.0, 180.0, (0.0, 90.0), "degrees", stream=4),
    "translation": Range(0.0, 1.0, 10.0, (0.0, 0.3), "model units", stream=5),
}
"""The six kinds of perturbation, in the order of the paper."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Perturbation:
    """How a scene differs from the model. The defaults are the paper's test defaults.

    Args:
        noise: standard deviation of the Gaussian noise on every point (model units).
        points: number of points drawn from the cloud, before any is removed.
        outliers: number of outliers added.
        incomplete: share of the points removed, all on one side of a random plane.
        rotation: angle about a random axis (degrees).
        translation: length of a translation in a random direction (model units).
        outlier_kind: ``uniform`` spreads outliers in a cube, ``structured`` gathers them in one Gaussian ball.
        seed: the random draw; the same value gives the same scene everywhere.

    Raises:
        ValueError: a value is not finite or out of range.
    """

    noise: float = 0.05
    points: int = 400
    outliers: int = 300
    incomplete: float = 0.3
    rotation: float = 60.0
    translation: float = 0.3
    outlier_kind: OutlierKind = "uniform"
    seed: int = 0

    def __post_init__(self) -> None:
        for name, allowed in RANGES.items():
            value = getattr(self, name)
            low = 1 if name == "points" else allowed.low
            if not (math.isfinite(value) and low <= value <= allowed.limit):
                raise ValueError(f"{name} must lie between {low:g} and {allowed.limit:g}, not {value}")
        for name in ("points", "outliers", "seed"):
            if not isinstance(getattr(self, name), int | np.integer) or isinstance(getattr(self, name), bool):
                raise ValueError(f"{name} must be a whole number, not {getattr(self, name)}")
        if not 0 <= self.seed <= LARGEST_SEED:
            raise ValueError(f"seed must lie between 0 and {LARGEST_SEED}, not {self.seed}")
        if self.outlier_kind not in get_args(OutlierKind):
            raise ValueError(f"outlier_kind must be one of {get_args(OutlierKind)}, not {self.outlier_kind!r}")


@dataclass(frozen=True, slots=True, eq=False)
class Scene:
    """A perturbed cloud to register.

    Args:
        points: shape (S, 3), float32; the true points first, outliers last.
        is_outlier: shape (S,).
        T_model_scene: the true pose, shape (4, 4).
    """

    points: FloatArray
    is_outlier: BoolArray
    T_model_scene: FloatArray

    def moved(self, T: FloatArray) -> Scene:
        """The scene moved as a whole, outliers and all, by a pose T, shape (4, 4)."""
        return replace(
            self,
            points=transform(T, self.points).astype(np.float32),
            T_model_scene=self.T_model_scene @ invert(T),
        )


def start_pose(perturbation: Perturbation) -> FloatArray:
    """T_scene_model of a perturbation: a turn about a random axis and a shift in a random direction; shape (4, 4)."""
    p = perturbation
    T = pose_of(np.concatenate([np.zeros(3), _direction(_stream(p.seed, "rotation")) * np.deg2rad(p.rotation)]))
    T[:3, 3] = _direction(_stream(p.seed, "translation")) * p.translation
    return T


def perturb(cloud: Cloud, perturbation: Perturbation) -> Scene:
    """The scene that a perturbation makes of a cloud (docs/method.md, Eq. 4).

    In this order: draw points with replacement, rotate and translate, add noise, remove one side of a plane, append
    outliers.
    """
    p = perturbation
    drawn = (_stream(p.seed, "points").random(p.points) * len(cloud.points)).astype(np.int64)
    T = start_pose(p)
    R, t = T[:3, :3], T[:3, 3]
    points = cloud.points[drawn] @ R.T + t
    points += p.noise * _stream(p.seed, "noise").standard_normal((p.points, 3))
    points = points[_kept(points, _direction(_stream(p.seed, "incomplete")), p.incomplete)]
    outliers = _outliers(_stream(p.seed, "outliers"), p.outliers, p.outlier_kind)
    T_model_scene = np.eye(4)
    T_model_scene[:3, :3], T_model_scene[:3, 3] = R.T, -R.T @ t
    return Scene(
        points=np.concatenate([points, outliers]).astype(np.float32),
        is_outlier=np.arange(len(points) + len(outliers)) >= len(points),
        T_model_scene=T_model_scene,
    )


def _stream(seed: int, kind: str) -> np.random.Generator:
    return np.random.Generator(np.random.PCG64(np.random.SeedSequence([seed, RANGES[kind].stream])))


def _direction(rng: np.random.Generator) -> FloatArray:
    vector = rng.standard_normal(3)
    return vector / np.linalg.norm(vector)


def _kept(points: FloatArray, direction: FloatArray, incomplete: float) -> BoolArray:
    """All but the given share of the points, the removed ones farthest along the direction; at least one is kept."""
    n_kept = max(1, len(points) - round(incomplete * len(points)))
    kept = np.zeros(len(points), dtype=bool)
    kept[np.argsort(points @ direction, kind="stable")[:n_kept]] = True
    return kept


def _outliers(rng: np.random.Generator, count: int, kind: OutlierKind) -> FloatArray:
    if kind == "uniform":
        return rng.uniform(-OUTLIER_REACH, OUTLIER_REACH, (count, 3))
    centre = rng.uniform(-OUTLIER_REACH, OUTLIER_REACH, 3)
    return centre + rng.uniform(*STRUCTURED_DEVIATION) * rng.standard_normal((count, 3))
