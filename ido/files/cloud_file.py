"""What a file of a cloud holds, and what of it is used."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from ido.clouds import CloudError, checked_points
from ido.types import FloatArray

MOST_POINTS = 50_000_000
"""Files that promise more points are refused before memory is taken for them."""

MESH_SAMPLES = 30_000
"""Points sampled, evenly by area, from a file that holds a mesh."""

MOST_LOOSE = 0.1
"""A file with faces counts as a mesh unless more than this share of its vertices lies in none of them."""

NORMALS = (("nx", "ny", "nz"), ("normal_x", "normal_y", "normal_z"))
"""Names of columns that hold directions, which turn with the cloud."""


@dataclass(frozen=True, slots=True, eq=False)
class CloudFile:
    """All that was read from a file.

    Args:
        points: every point, in the file's order and units, shape (N, 3), float64; may hold NaN.
        columns: what else it says of each point, by name, each of shape (N,).
        faces: triangles as numbers of points, shape (F, 3); none unless the file has some.
        notes: what of the file was not read.
    """

    points: FloatArray
    columns: Mapping[str, np.ndarray] = field(default_factory=dict)
    faces: np.ndarray | None = None
    notes: tuple[str, ...] = ()

    @classmethod
    def of(cls, columns: Mapping[str, np.ndarray], faces: np.ndarray | None = None, *notes: str) -> CloudFile:
        """A file whose columns, each of shape (N,) or (N, k), have names; x, y and z may be in capitals.

        Raises:
            CloudError: x, y or z is missing, there twice, or no column of numbers.
        """
        axes = {axis: [name for name in columns if name.strip().lower() == axis] for axis in "xyz"}
        if any(len(found) != 1 for found in axes.values()):
            raise CloudError(f"needs one column each of the names x, y and z; it has {', '.join(columns) or 'none'}")
        xyz = [columns[name] for (name,) in axes.values()]
        if any(values.ndim != 1 or values.dtype.kind not in "fiu" for values in xyz):
            raise CloudError("its columns x, y and z must hold one number for each point")
        points = np.empty((len(xyz[0]), 3))
        for i, values in enumerate(xyz):
            points[:, i] = values
        others = {name: values for name, values in columns.items() if name.strip().lower() not in axes}
        return cls(points, single(others), faces, notes)

    def moved(self, T: FloatArray) -> CloudFile:
        """All of it where the pose T (4, 4) in the file's units moves it; normals are turned."""
        columns = dict(self.columns)
        for names in NORMALS:
            if all(name in columns for name in names):
                turned = np.column_stack([columns[name] for name in names]) @ T[:3, :3].T
                columns |= {name: turned[:, i].astype(columns[name].dtype) for i, name in enumerate(names)}
        points = self.points @ T[:3, :3].T
        points += T[:3, 3]
        return CloudFile(points, columns, self.faces, self.notes)


@dataclass(frozen=True, slots=True, eq=False)
class UsedPoints:
    """The points of a file that are worked with.

    Args:
        points: shape (M, 3), the file's units, float64.
        read: points in the file.
        invalid: those of them that were dropped because a coordinate is not finite.
        notes: what was left out, how many and why.
    """

    points: FloatArray
    read: int
    invalid: int
    notes: tuple[str, ...]


def used_points(file: CloudFile, *, drop_invalid: bool = False) -> UsedPoints:
    """The points of a scan, or points sampled evenly by area of a mesh, always the same.

    Args:
        file: as it was read.
        drop_invalid: leave out points with coordinates that are not finite, instead of refusing the file.

    Raises:
        CloudError: fewer than 10 usable points, or coordinates that are not finite.
    """
    points, notes = file.points, list(file.notes)
    loose = _loose(file)
    if file.faces is not None and loose <= MOST_LOOSE * len(points):
        return _sampled(file, loose)
    if file.faces is not None:
        notes.append(
            f"{loose} of {len(points)} points belong to none of its {len(file.faces)} faces, so it is taken for a scan "
            "whose points are used and whose faces are not"
        )
    if drop_invalid:
        points = points[np.isfinite(points).all(axis=1)]
    invalid = len(file.points) - len(points)
    if invalid:
        notes.append(f"{invalid} of {len(file.points)} points have coordinates that are not finite and are dropped")
    return UsedPoints(checked_points(points), len(file.points), invalid, tuple(notes))


def _loose(file: CloudFile) -> int:
    """Number of points that belong to no face."""
    if file.faces is None:
        return len(file.points)
    in_face = np.zeros(len(file.points), dtype=bool)
    in_face[file.faces] = True
    return len(in_face) - int(in_face.sum())


def _sampled(file: CloudFile, loose: int) -> UsedPoints:
    import trimesh

    assert file.faces is not None
    bad = int((~np.isfinite(file.points[file.faces]).all(axis=(1, 2))).sum())
    if bad:
        raise CloudError(f"{bad} faces have corners whose coordinates are not finite; repair the mesh")
    mesh = trimesh.Trimesh(file.points, file.faces, process=False)
    if not mesh.area > 0:
        raise CloudError("its faces have no area; give the points alone")
    samples = np.asarray(trimesh.sample.sample_surface(mesh, MESH_SAMPLES, seed=0)[0])
    notes = [*file.notes]
    if loose:
        notes.append(f"{loose} of {len(file.points)} points belong to no face of the mesh and are not used")
    return UsedPoints(checked_points(samples), len(file.points), 0, tuple(notes))


def check_count(count: int) -> int:
    """The number of points that a file promises, when it can be meant.

    Raises:
        CloudError: it is negative or beyond `MOST_POINTS`.
    """
    if not 0 <= count <= MOST_POINTS:
        raise CloudError(f"promises {count:,} points; thin it to at most {MOST_POINTS:,}")
    return count


def single(columns: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Columns of one value each: one of k values, shape (N, k), becomes name_0 .. name_(k-1)."""
    single = {}
    for name, values in columns.items():
        if values.ndim == 1:
            single[name] = values
        else:
            single |= {f"{name}_{i}": part for i, part in enumerate(values.reshape(len(values), -1).T)}
    return single
