"""How a scene lies in the 3D view: which way is up, what a click meets, and lines to where points belong."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from ido import Scene, poses
from ido.types import DoubleArray, FloatArray

VIEW_DIRECTION = np.array([0.0, -1.0, 0.35])
"""From which the panes are first seen."""


def upright(up: tuple[float, float, float]) -> Rotation:
    """The rotation that turns a shape's up direction to +z."""
    return Rotation.align_vectors(np.array([[0.0, 0.0, 1.0]]), np.array([up]))[0]


def quaternion(rotation: Rotation) -> DoubleArray:
    """A rotation as viser takes it: (w, x, y, z)."""
    return rotation.as_quat(scalar_first=True)


def error_vectors(scene: Scene, T_model_scene: FloatArray, one: int | None = None) -> np.ndarray:
    """From where each scene point that is no outlier lies at a pose to where it belongs; float32, shape (n, 2, 3).

    Args:
        scene: whose points.
        T_model_scene: the pose, shape (4, 4).
        one: number of a scene point, for its line alone; None for all. An outlier belongs nowhere and has none.
    """
    chosen = ~scene.is_outlier
    if one is not None:
        chosen &= np.arange(len(chosen)) == one
    points = scene.points[chosen]
    ends = [poses.transform(T, points) for T in (T_model_scene, scene.T_model_scene)]
    return np.stack(ends, axis=1).astype(np.float32)


def track_of(scene: Scene, T_model_scene: FloatArray) -> np.ndarray:
    """The way of the true points' middle over poses (n + 1, 4, 4), as lines; float32, shape (n, 2, 3)."""
    middle = scene.points[~scene.is_outlier].mean(axis=0)
    track = poses.transform(T_model_scene, middle[None])[:, 0].astype(np.float32)
    return np.stack([track[:-1], track[1:]], axis=1)


_BEHIND = 20.0  # so many times further behind another one is as far as beside the ray


def point_on_ray(points: FloatArray, origin: FloatArray, direction: FloatArray, reach: float) -> int | None:
    """Number of the point (M, 3) nearest to a ray, if it is within reach of it; of nearly equal ones the first met."""
    direction = np.asarray(direction, dtype=np.float64) / np.linalg.norm(direction)
    offset = points - np.asarray(origin, dtype=np.float64)
    along = offset @ direction
    away = np.linalg.norm(offset - along[:, None] * direction, axis=1)
    hit = (away < reach) & (along > 0)
    if not hit.any():
        return None
    return int(np.argmin(np.where(hit, along + _BEHIND * away, np.inf)))
