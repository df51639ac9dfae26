"""Scenes that the paper does not have, and that nothing in the global method mirrors.

A single view that hides what lies behind, ball-shaped holes, clutter of another shape, and density that changes over
the cloud. Each is turned and shifted at random, as far as the paper's sweeps go.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from ido.experiments.sweeps import LEVELS
from ido.one_thread import on_one_processor
from ido.perturbation import OUTLIER_REACH, Scene
from ido.poses import invert, transform
from ido.shipped import SHAPES, shipped_cloud
from ido.types import DoubleArray, FloatArray

POINTS, NOISE, OUTLIERS, TRANSLATION = 400, 0.02, 100, 1.0
"""Of every scene: true points, deviation of their noise, scattered outliers, and the longest shift (model units)."""

_HOLES = 3
_DISTANCE, _REACH = 4.0, 400.0  # of the camera; and of the mirrored points that hidden point removal works with


def _view(cloud: FloatArray, rng: np.random.Generator, _: float) -> FloatArray:
    """What a camera sees from a random direction (hidden point removal, Katz et al. 2007)."""
    with on_one_processor():
        import open3d as o3d  # takes 2 s to import

    dense = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(cloud.astype(np.float64)))
    camera = rng.standard_normal(3)
    seen = dense.hidden_point_removal(_DISTANCE * camera / np.linalg.norm(camera), _REACH)[1]
    return cloud[np.asarray(seen)]


def _holes(cloud: FloatArray, rng: np.random.Generator, share: float) -> FloatArray:
    """All but a share of the points: those nearest to three of them are missing."""
    middles = cloud[rng.integers(len(cloud), size=_HOLES)]
    distance = np.linalg.norm(cloud[:, None] - middles, axis=2).min(axis=1)
    return cloud[distance > np.quantile(distance, share)]


def _density(cloud: FloatArray, rng: np.random.Generator, ratio: float) -> FloatArray:
    """Points drawn so that the density falls evenly, by this ratio, from one end to the other."""
    way = rng.standard_normal(3)
    along = cloud @ (way / np.linalg.norm(way))
    weight = ratio ** -((along - along.min()) / np.ptp(along))
    return cloud[rng.choice(len(cloud), len(cloud), p=weight / weight.sum())]


def _whole(cloud: FloatArray, _: np.random.Generator, __: float) -> FloatArray:
    return cloud


@dataclass(frozen=True, slots=True)
class Kind:
    """A kind of scenes. The numbers decide which scenes are drawn, so they must never change.

    Args:
        number: of the kind.
        levels: each with its number.
        left: what is left of the cloud at a level.
    """

    number: int
    levels: Mapping[float, int]
    left: Callable[[FloatArray, np.random.Generator, float], FloatArray]


BEYOND: dict[str, Kind] = {
    "view": Kind(0, {1.0: 0}, _view),
    "holes": Kind(1, {0.2: 0, 0.4: 1, 0.6: 2}, _holes),
    "clutter": Kind(2, {0.5: 0, 1.0: 1}, _whole),
    "density": Kind(3, {4.0: 0, 16.0: 1}, _density),
}
"""The kinds. A level is the share that is missing (holes), the points of the other shape as multiple of the true ones
(clutter), or how many times denser one end is (density)."""

ALL_LEVELS: dict[str, tuple[float, ...]] = {**LEVELS, **{kind: tuple(its.levels) for kind, its in BEYOND.items()}}
"""Levels of the paper's sweeps, and of the kinds."""


def beyond_seed(kind: str, level: float, trial: int, scenes: int, seed: int) -> int:
    """The seed of a scene: trial 0 .. scenes - 1 of a level."""
    its = BEYOND[kind]
    return seed + 500_000 + 10_000 * its.number + its.levels[level] * scenes + trial


def beyond_scene(shape: str, kind: str, level: float, seed: int) -> Scene:
    """A scene of a shipped shape; the same seed gives the same scene everywhere."""
    rng = np.random.default_rng([seed, BEYOND[kind].number])
    left = BEYOND[kind].left(shipped_cloud(shape).points, rng, level)
    points = left[rng.integers(len(left), size=POINTS)] + NOISE * rng.standard_normal((POINTS, 3))
    T = _start(rng)
    parts = [transform(T, points), rng.uniform(-OUTLIER_REACH, OUTLIER_REACH, (OUTLIERS, 3))]
    if kind == "clutter":
        other = shipped_cloud(next(name for name in SHAPES if name != shape)).points
        drawn = other[rng.integers(len(other), size=round(level * POINTS))]
        parts.append(transform(_start(rng), drawn + NOISE * rng.standard_normal(drawn.shape)))
    everything = np.concatenate(parts).astype(np.float32)
    return Scene(everything, np.arange(len(everything)) >= POINTS, invert(T))


def _start(rng: np.random.Generator) -> DoubleArray:
    """T_scene_model: any rotation, each as likely, and a shift of any length up to `TRANSLATION`."""
    quaternion, way = rng.standard_normal(4), rng.standard_normal(3)
    T = np.eye(4)
    T[:3, :3] = Rotation.from_quat(quaternion).as_matrix()
    T[:3, 3] = rng.uniform(0, TRANSLATION) * way / np.linalg.norm(way)
    return T
