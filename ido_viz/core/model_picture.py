"""What the model looks like: its surface where it has one, else many of its points, shaded so that depth is seen."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from ido.clouds import Cloud, local_normals
from ido.types import FloatArray, IntArray
from ido_viz.core.geometry import upright
from ido_viz.core.library import Subject

MOST_POINTS = 8_000
"""Of a cloud without a surface, so many are drawn."""

_LIGHT = np.array([-0.4, -0.6, 0.7])  # from the left, the front and above, with z up


@dataclass(frozen=True, slots=True, eq=False)
class ModelPicture:
    """The model as it is drawn, model units.

    Args:
        vertices: of the surface (V, 3), or the points (V, 3).
        faces: of the surface, shape (F, 3); none for points.
        shades: of the points, 0 dark to 1 light, shape (V,).
    """

    vertices: FloatArray
    faces: IntArray
    shades: FloatArray


def picture_of(subject: Subject) -> ModelPicture:
    """The picture of a shape: the same one for the same cloud, whatever was learned on it since."""
    return _surface_picture(subject) if subject.surface() is not None else _points_picture(subject.cloud(), subject.up)


@lru_cache(maxsize=8)
def _surface_picture(subject: Subject) -> ModelPicture:
    surface = subject.surface()
    assert surface is not None
    vertices, faces = surface
    return ModelPicture(vertices, faces, np.ones(len(vertices)))


@lru_cache(maxsize=8)
def _points_picture(cloud: Cloud, up: tuple[float, float, float]) -> ModelPicture:
    points = cloud.points
    some = np.random.default_rng(0).choice(len(points), min(MOST_POINTS, len(points)), replace=False)
    drawn = points[np.sort(some)]
    normals = local_normals(drawn, np.array(up))
    light = upright(up).inv().apply(_LIGHT / np.linalg.norm(_LIGHT))
    return ModelPicture(drawn, np.zeros((0, 3), dtype=np.int64), 0.5 + 0.5 * (normals @ light))
