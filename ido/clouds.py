"""Clouds: normalise, and pick the model points that maps are trained for, with their normals."""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy.spatial import KDTree

from ido.types import FloatArray

MODEL_POINTS = 514
"""Number of model points, as in the paper."""

NORMAL_NEIGHBOURS = 6
"""Neighbours that a point's local plane is fitted to, as in the paper."""

LARGEST_CLOUD = 1_000_000
"""Larger clouds are thinned to this many points, at random with a fixed seed."""

Orientation = Literal["outward", "up"]


class CloudError(ValueError):
    """A cloud or its file cannot be used; the message says why and what to do."""


class CloudWarning(UserWarning):
    """Something of a cloud or its file is not used; the message says how much and why."""


@dataclass(frozen=True, slots=True, eq=False)
class Frame:
    """Where model units lie in the user's units: ``original = centre + scale * normalised`` (docs/method.md, Eq. 3).

    Args:
        centre: the model origin in the user's units, shape (3,), float64.
        scale: user's units per model unit.
    """

    centre: FloatArray
    scale: float

    def to_model_units(self, points: FloatArray) -> FloatArray:
        """Points from the user's units to model units, float64 (docs/method.md, Eq. 3)."""
        return (np.asarray(points, dtype=np.float64) - self.centre) / self.scale

    def to_user_units(self, points: FloatArray) -> FloatArray:
        """Points from model units to the user's units, float64."""
        return np.asarray(points, dtype=np.float64) * self.scale + self.centre

    def pose_in_user_units(self, T: FloatArray) -> FloatArray:
        """The poses that do in the user's units what `T` (..., 4, 4) do in model units."""
        T = np.array(T, dtype=np.float64)
        T[..., :3, 3] = self.scale * T[..., :3, 3] + self.centre - T[..., :3, :3] @ self.centre
        return T


@dataclass(frozen=True, slots=True, eq=False)
class Cloud:
    """A normalised cloud, within [-1, 1] on every axis.

    Args:
        points: shape (N, 3), float32, model units.
        frame: where model units lie in the user's units.
    """

    points: FloatArray
    frame: Frame

    @classmethod
    def of(cls, original: FloatArray) -> Cloud:
        """Normalise points given in the user's units, shape (N, 3): the bounding-box centre becomes the origin.

        docs/method.md, Eq. 3. Of more than `LARGEST_CLOUD` points that many are used, and a `CloudWarning` tells so.

        Raises:
            CloudError: fewer than 10 points, coordinates that are not finite, or all points in one place.
        """
        original = _thinned(checked_points(original))
        low, high = original.min(axis=0), original.max(axis=0)
        frame = Frame((low + high) / 2, float((high - low).max() / 2))
        return cls(frame.to_model_units(original).astype(np.float32), frame)


@dataclass(frozen=True, slots=True, eq=False)
class Model:
    """The fixed cloud M that maps are trained for.

    Args:
        points: m_a, shape (M, 3), float32, model units.
        normals: n_a, unit vectors, shape (M, 3), float32.
    """

    points: FloatArray
    normals: FloatArray

    @classmethod
    def of(cls, cloud: Cloud, n_points: int = MODEL_POINTS, orientation: Orientation = "outward") -> Model:
        """Pick model points spread evenly over the cloud (farthest-point sampling), and their normals.

        Flipping a normal swaps two bins and their weights, so the orientation changes no result; it is fixed for
        the pictures' sake: ``outward`` from the centroid, or ``up`` (+z) for terrain.
        """
        import open3d as o3d  # takes 2 s to import

        if len(cloud.points) < n_points:
            raise CloudError(f"the cloud has {len(cloud.points)} points, a model needs at least {n_points}")
        dense = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(cloud.points.astype(np.float64)))
        points = np.asarray(dense.farthest_point_down_sample(n_points).points)
        if len(np.unique(points, axis=0)) < n_points:
            raise CloudError(f"the cloud has fewer than {n_points} different points; give a denser one")
        hint = points - points.mean(axis=0) if orientation == "outward" else np.array([0.0, 0.0, 1.0])
        return cls(points.astype(np.float32), local_normals(points, hint).astype(np.float32))


def local_normals(points: FloatArray, hint: FloatArray) -> FloatArray:
    """Normals of the planes fitted to each point and its 6 nearest neighbours, on the side of `hint`; shape (M, 3).

    A plane has the direction in which they spread least (Hoppe et al. 1992: docs/method.md, "Sources").
    """
    _, neighbours = KDTree(points).query(points, k=NORMAL_NEIGHBOURS + 1)
    patches = points[neighbours] - points[neighbours].mean(axis=1, keepdims=True)
    _, axes = np.linalg.eigh(np.einsum("mki,mkj->mij", patches, patches))
    normals = axes[:, :, 0]  # to the smallest eigenvalue
    return np.where((normals * hint).sum(axis=1, keepdims=True) < 0, -normals, normals)


def checked_points(points: FloatArray) -> FloatArray:
    """The points as float64, shape (N, 3).

    Raises:
        CloudError: not a cloud of at least 10 finite points in different places.
    """
    try:
        points = np.asarray(points, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise CloudError(f"coordinates must be numbers ({error})") from error
    if points.ndim != 2 or points.shape[1] != 3:
        raise CloudError(f"a cloud needs three columns x, y, z; this has the shape {points.shape}")
    if len(points) < 10:
        raise CloudError(f"a cloud needs at least 10 points; this has {len(points)}")
    low, high = points.min(axis=0), points.max(axis=0)  # both are NaN where any coordinate is
    if not (np.isfinite(low).all() and np.isfinite(high).all()):
        bad = int((~np.isfinite(points).all(axis=1)).sum())
        raise CloudError(
            f"{bad} of {len(points)} points have coordinates that are not finite; remove them first, as "
            "`ido register` and `ido train` do with --drop-invalid"
        )
    largest = max(-low.min(), high.max())
    if largest > 1e15:
        raise CloudError("coordinates beyond 1e15 cannot be used; check the file's units")
    if not (high - low).max() > 2e-9 * max(1.0, largest):
        raise CloudError("all points of the cloud lie in one place; check the file's units and columns")
    return points


def _thinned(points: FloatArray) -> FloatArray:
    if len(points) <= LARGEST_CLOUD:
        return points
    note = f"of {len(points)} points {LARGEST_CLOUD} are used, drawn at random, always the same ones"
    warnings.warn(note, CloudWarning, stacklevel=3)
    return np.random.default_rng(0).choice(points, LARGEST_CLOUD, replace=False)
