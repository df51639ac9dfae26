"""Faces of any number of corners, cut into triangles."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ido.clouds import CloudError

Polygons = Sequence[Sequence[int]]
"""The corners of each face, as numbers of points."""


def triangles_of(polygons: np.ndarray | Polygons, count: int) -> np.ndarray | None:
    """Triangles of faces, shape (F, 3), each face cut from its first corner; None when there are none.

    Args:
        polygons: the faces; as an array they are triangles already.
        count: number of points that there are.

    Raises:
        CloudError: a corner is no point.
    """
    if not isinstance(polygons, np.ndarray):
        cut = [(face[0], face[i], face[i + 1]) for face in polygons for i in range(1, len(face) - 1)]
        polygons = np.array(cut, dtype=np.int64).reshape(-1, 3)
    if len(polygons) and not (polygons.min() >= 0 and polygons.max() < count):
        raise CloudError("a face names a point that is not there")
    return polygons if len(polygons) else None
