"""Clouds: load, normalise, and pick the model points that maps are trained for, with their normals."""

from __future__ import annotations

import warnings
import zipfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
from scipy.spatial import KDTree

from ido.types import FloatArray

MODEL_POINTS = 514
"""Number of model points, as in the paper."""

NORMAL_NEIGHBOURS = 6
"""Neighbours that a point's local plane is fitted to, as in the paper."""

MESH_SAMPLES = 30_000
"""Points sampled, evenly by area, from a file that holds a mesh."""

LARGEST_CLOUD = 1_000_000
"""Larger clouds are thinned to this many points, at random with a fixed seed."""

Orientation = Literal["outward", "up"]


class CloudError(ValueError):
    """A cloud or its file cannot be used; the message says why and what to do."""


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

        docs/method.md, Eq. 3.

        Raises:
            CloudError: fewer than 10 points, coordinates that are not finite, or all points in one place.
        """
        original = checked_points(original)
        low, high = original.min(axis=0), original.max(axis=0)
        frame = Frame((low + high) / 2, float((high - low).max() / 2))
        if not frame.scale > 1e-9 * max(1.0, float(np.abs(frame.centre).max())):
            raise CloudError("all points of the cloud lie in one place; check the file's units and columns")
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
    """Normals of the planes fitted to each point and its 6 nearest neighbours, on the side of `hint`; shape (M, 3)."""
    _, neighbours = KDTree(points).query(points, k=NORMAL_NEIGHBOURS + 1)
    patches = points[neighbours] - points[neighbours].mean(axis=1, keepdims=True)
    _, axes = np.linalg.eigh(np.einsum("mki,mkj->mij", patches, patches))
    normals = axes[:, :, 0]  # the direction in which a patch spreads least
    return np.where((normals * hint).sum(axis=1, keepdims=True) < 0, -normals, normals)


def load_cloud(path: str | Path) -> FloatArray:
    """Points of a file in its own units, shape (N, 3), float64.

    Reads PLY, PCD, XYZ, NPZ, OBJ, STL and OFF; meshes are sampled evenly by area.

    Raises:
        CloudError: the file is missing, unreadable, of another format, or holds no usable cloud.
    """
    path = Path(path)
    reader = _READERS.get(path.suffix.lower())
    if reader is None:
        raise CloudError(f"{path.name}: unknown kind of file; give one of {', '.join(sorted(_READERS))}")
    if not path.is_file():
        raise CloudError(f"{path}: no such file")
    try:
        points = reader(path)
    except CloudError:
        raise
    except Exception as error:  # readers raise whatever they like on a broken file
        raise CloudError(f"{path.name}: cannot be read as {path.suffix[1:].upper()} ({error})") from error
    try:
        return checked_points(points)
    except CloudError as error:
        raise CloudError(f"{path.name}: {error}") from error


def save_cloud(path: str | Path, points: FloatArray) -> None:
    """Write points (N, 3) to a PLY or XYZ file without losing digits."""
    if Path(path).suffix.lower() == ".xyz":
        np.savetxt(path, points, fmt="%.12g")
        return
    import open3d as o3d  # trimesh would write float32, too coarse for coordinates of a map

    cloud = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(np.asarray(points, dtype=np.float64)))
    with o3d.utility.VerbosityContextManager(o3d.utility.VerbosityLevel.Error):
        written = o3d.io.write_point_cloud(Path(path), cloud)
    if not written:
        raise OSError(f"{path}: cannot be written")


def checked_points(points: FloatArray) -> FloatArray:
    """The points as float64, shape (N, 3), thinned when there are very many.

    Raises:
        CloudError: not a cloud of at least 10 finite points.
    """
    try:
        points = np.asarray(points, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise CloudError(f"coordinates must be numbers ({error})") from error
    if points.ndim != 2 or points.shape[1] != 3:
        raise CloudError(f"a cloud needs three columns x, y, z; this has the shape {points.shape}")
    if len(points) < 10:
        raise CloudError(f"a cloud needs at least 10 points; this has {len(points)}")
    if not np.isfinite(points).all():
        bad = int((~np.isfinite(points).all(axis=1)).sum())
        raise CloudError(f"{bad} of {len(points)} points have coordinates that are not finite; remove them first")
    if np.abs(points).max() > 1e15:
        raise CloudError("coordinates beyond 1e15 cannot be used; check the file's units")
    if len(points) > LARGEST_CLOUD:
        points = np.random.default_rng(0).choice(points, LARGEST_CLOUD, replace=False)
    return points


def _read_trimesh(path: Path) -> FloatArray:
    import trimesh

    loaded = trimesh.load(path)
    if isinstance(loaded, trimesh.Scene):
        loaded = loaded.to_mesh()
    if isinstance(loaded, trimesh.Trimesh) and len(loaded.faces):
        samples = trimesh.sample.sample_surface(loaded, MESH_SAMPLES, seed=0)[0]
        return np.asarray(samples)
    return np.asarray(getattr(loaded, "vertices", np.empty((0, 3))))


def _read_xyz(path: Path) -> FloatArray:
    with path.open(encoding="utf-8") as file, warnings.catch_warnings():
        warnings.simplefilter("ignore")  # an empty file is refused later
        return np.loadtxt((line.replace(",", " ") for line in file), usecols=(0, 1, 2), ndmin=2)


def _read_pcd(path: Path) -> FloatArray:
    import open3d as o3d

    with o3d.utility.VerbosityContextManager(o3d.utility.VerbosityLevel.Error):  # it warns on standard output
        cloud = o3d.io.read_point_cloud(path, remove_nan_points=False)
    if not cloud.has_points():
        raise CloudError(f"{path.name}: holds no points, or is not a PCD file")
    return np.asarray(cloud.points)


def _read_npz(path: Path) -> FloatArray:
    if not zipfile.is_zipfile(path):
        raise CloudError(f"{path.name}: not an NPZ file")
    with np.load(path, allow_pickle=False) as arrays:
        if "points" in arrays:
            return arrays["points"]
        clouds = [arrays[key] for key in arrays if arrays[key].ndim == 2 and arrays[key].shape[1] == 3]
    if len(clouds) != 1:
        raise CloudError(f"{path.name}: an NPZ needs an array 'points' of shape (N, 3)")
    return clouds[0]


_READERS: dict[str, Callable[[Path], FloatArray]] = {
    ".ply": _read_trimesh,
    ".obj": _read_trimesh,
    ".stl": _read_trimesh,
    ".off": _read_trimesh,
    ".xyz": _read_xyz,
    ".pcd": _read_pcd,
    ".npz": _read_npz,
}
