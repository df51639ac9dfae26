"""NumPy files of points, .npy and .npz: their heads are read first, and a pickle never."""

from __future__ import annotations

import zipfile
from pathlib import Path

import numpy as np

from ido.clouds import CloudError
from ido.files.cloud_file import CloudFile, check_count, single
from ido.npz import Promise, loaded, promise, promises


def read_npy(path: Path) -> CloudFile:
    """Points, of an array (N, 3) or of one with fields x, y and z.

    Raises:
        CloudError: no such array, or the file is cut off.
    """
    with path.open("rb") as file:
        try:
            found = promise(file)
        except ValueError as error:
            raise CloudError(f"is not an NPY file, or {error}") from error
        left = path.stat().st_size - file.tell()
    if left != found.size:
        raise CloudError(f"is cut off, or longer than its head promises: {left} bytes instead of {found.size}")
    if found.dtype.names:
        _check(found, len(found.shape) == 1)
        rows = np.load(path, allow_pickle=False)
        return CloudFile.of({name: rows[name] for name in found.dtype.names})
    _check(found, _is_cloud(found))
    return CloudFile(np.asarray(np.load(path, mmap_mode="r", allow_pickle=False), dtype=np.float64))


def read_npz(path: Path) -> CloudFile:
    """Points, of the array ``points`` or of the only one of shape (N, 3); arrays of as many rows are its columns.

    Raises:
        CloudError: no such array.
    """
    if not zipfile.is_zipfile(path):
        raise CloudError("is not an NPZ file, or cut off")
    found = promises(path)
    clouds = ["points"] if "points" in found else [name for name, array in found.items() if _is_cloud(array)]
    if len(clouds) != 1:
        raise CloudError("an NPZ needs an array 'points' of shape (N, 3)")
    _check(found[clouds[0]], _is_cloud(found[clouds[0]]))
    rows = found[clouds[0]].shape[:1]
    columns = [
        name
        for name, array in found.items()
        if name != clouds[0] and array.shape[:1] == rows and array.dtype.kind in "fiub"
    ]
    arrays = loaded(path, [*clouds, *columns])
    points = np.asarray(arrays.pop(clouds[0]), dtype=np.float64)
    return CloudFile(points, single(arrays))


def _is_cloud(array: Promise) -> bool:
    return len(array.shape) == 2 and array.shape[1] == 3


def _check(array: Promise, right: bool) -> None:
    if not right:
        raise CloudError(f"a cloud needs three columns x, y, z; this has the shape {array.shape}")
    if not array.dtype.names and array.dtype.kind not in "fiu":
        raise CloudError(f"coordinates must be numbers, not {array.dtype}")
    check_count(array.shape[0])
