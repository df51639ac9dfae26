"""What scenes are registered onto from any start: a cloud's fields and turned transforms, made once."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import KDTree

from ido.clouds import Model
from ido.global_registration.fields import SIGMAS, Field
from ido.global_registration.planes import FEW_DIRECTIONS, FEW_KEPT, Planes
from ido.global_registration.search import Search
from ido.types import FloatArray

_SAMPLE = 600  # points that measure how much of the model a plane keeps
_DISC = 64  # points that stand for the surface around one model point


@dataclass(frozen=True, slots=True, eq=False)
class GlobalModel:
    """A cloud, ready for `GlobalRegistration`; about 60 MB.

    Args:
        fields: its density at every width of `SIGMAS`.
        search: its turned transforms.
        planes: beyond which a scene may miss it.
        few_planes: fewer and coarser ones, for a first look at many poses.
    """

    fields: tuple[Field, ...]
    search: Search
    planes: Planes
    few_planes: Planes

    @classmethod
    def of(cls, points: FloatArray, rotations: int = 768) -> GlobalModel:
        """Prepare a cloud, points (N, 3) within ±1 (`ido.Cloud.points`).

        Args:
            points: the cloud; the denser, the better. `surface_of` makes a dense one of a few points with normals.
            rotations: how many are searched.
        """
        fields = tuple(Field.of(points, sigma) for sigma in SIGMAS)
        sample = np.random.default_rng(0).choice(points, min(len(points), _SAMPLE), replace=False)
        few = Planes.of(sample, FEW_DIRECTIONS, FEW_KEPT)
        return cls(fields, Search.of(fields[-1], rotations), Planes.of(sample), few)


def surface_of(model: Model) -> FloatArray:
    """The surface that the points of maps stand for: a flat Gaussian disc about each, shape (64 M, 3), float32.

    A disc spreads as far as the point's sixth neighbour is away, halved: so discs meet, and leave no holes.
    """
    points, normals = model.points.astype(np.float64), model.normals.astype(np.float64)
    radius = KDTree(points).query(points, k=7)[0][:, -1] / 2
    spread = np.random.default_rng(0).standard_normal((len(points), _DISC, 3)) * radius[:, None, None] / np.sqrt(2)
    spread -= (spread @ normals[:, :, None]) * normals[:, None]
    return (points[:, None] + spread).reshape(-1, 3).astype(np.float32)
