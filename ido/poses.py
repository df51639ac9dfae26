"""Rigid poses as 4x4 matrices and as exponential coordinates x = [ρ, φ] (docs/method.md, "Poses").

`T_model_scene` always maps scene points into the model frame: ``p_model = R @ p_scene + t``.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import RigidTransform, Rotation, Slerp

from ido.types import FloatArray

PARAMETERS = ("ρx", "ρy", "ρz", "φx", "φy", "φz")
"""Names of the six coordinates of x, in order."""


def exp(x: FloatArray) -> FloatArray:
    """Pose of exponential coordinates, T = exp(x^) (docs/method.md, Eq. 2).

    Args:
        x: shape (..., 6), ρ (translation part, model units) first, φ (rotation vector, radians) last.

    Returns:
        T_model_scene, shape (..., 4, 4), float64.
    """
    x = np.asarray(x, dtype=np.float64)
    rotation_first = np.concatenate([x[..., 3:], x[..., :3]], axis=-1)  # SciPy's order
    return RigidTransform.from_exp_coords(rotation_first).as_matrix()


def log(T: FloatArray) -> FloatArray:
    """Exponential coordinates of a pose, the inverse of `exp` for rotation angles up to π (docs/method.md, Eq. 2).

    Args:
        T: T_model_scene, shape (..., 4, 4).

    Returns:
        x = [ρ, φ], shape (..., 6), float64.
    """
    coords = RigidTransform.from_matrix(np.asarray(T, dtype=np.float64)).as_exp_coords()
    return np.concatenate([coords[..., 3:], coords[..., :3]], axis=-1)


def transform(T: FloatArray, points: FloatArray) -> FloatArray:
    """Points moved by a pose: shape (..., S, 3) for T (..., 4, 4) and points (..., S, 3) (docs/method.md, Eq. 1)."""
    T = np.asarray(T, dtype=np.float64)
    return points @ np.swapaxes(T[..., :3, :3], -1, -2) + T[..., None, :3, 3]


def between(start: FloatArray, end: FloatArray, share: float) -> FloatArray:
    """The pose a share of the way from one to another, both (4, 4): turned evenly, and shifted along a line."""
    turn = Slerp([0.0, 1.0], Rotation.from_matrix(np.stack([start[:3, :3], end[:3, :3]])))(share)
    T = np.eye(4)
    T[:3, :3] = turn.as_matrix()
    T[:3, 3] = (1 - share) * start[:3, 3] + share * end[:3, 3]
    return T


def invert(T: FloatArray) -> FloatArray:
    """Inverse pose, shape (..., 4, 4): T_scene_model of T_model_scene."""
    return RigidTransform.from_matrix(np.asarray(T, dtype=np.float64)).inv().as_matrix()
