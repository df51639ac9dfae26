"""Scores of a registration against the true pose (docs/method.md, "Scores")."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from ido.perturbation import Scene
from ido.types import BoolArray, FloatArray

ACCURACY_THRESHOLD = 0.1
"""t_pt: a point within this distance of its true place counts as registered (model units)."""


@dataclass(frozen=True, slots=True, eq=False)
class Scores:
    """Scores of one pose or of many, each a number or an array of the poses' leading shape.

    Args:
        accuracy: PointAcc, share of the true scene points (no outliers) within 0.1 of their true place
            (docs/method.md, Eq. 17).
        rmse: PointRMSE, root mean square of those distances (model units; docs/method.md, Eq. 18).
        rotation: angle of the rotation error (degrees).
        translation: length of the translation error (model units).
    """

    accuracy: FloatArray
    rmse: FloatArray
    rotation: FloatArray
    translation: FloatArray


def registered(scene: Scene, T_model_scene: FloatArray) -> BoolArray:
    """Which of the true scene points lie within 0.1 of their true place at poses (..., 4, 4); shape (..., n)."""
    return _squared_errors(scene, np.asarray(T_model_scene, dtype=np.float64)) < ACCURACY_THRESHOLD**2


def _squared_errors(scene: Scene, T: FloatArray) -> FloatArray:
    points = scene.points[~scene.is_outlier].astype(np.float64)
    wrong = T[..., :3, :] - scene.T_model_scene[:3]
    away = wrong[..., :3].reshape(-1, 3) @ points.T + wrong[..., 3].reshape(-1, 1)  # of all poses in one product
    return (away**2).reshape(*T.shape[:-2], 3, len(points)).sum(axis=-2)


def score(scene: Scene, T_model_scene: FloatArray) -> Scores:
    """Scores of estimated poses, shape (..., 4, 4), of a scene (docs/method.md, Eq. 17 and 18)."""
    T = np.asarray(T_model_scene, dtype=np.float64)
    squared = _squared_errors(scene, T)
    difference = scene.T_model_scene[:3, :3].T @ T[..., :3, :3]
    return Scores(
        accuracy=(squared < ACCURACY_THRESHOLD**2).mean(axis=-1),
        rmse=np.sqrt(squared.mean(axis=-1)),
        rotation=np.rad2deg(Rotation.from_matrix(difference).magnitude()),
        translation=np.linalg.norm(T[..., :3, 3] - scene.T_model_scene[:3, 3], axis=-1),
    )
