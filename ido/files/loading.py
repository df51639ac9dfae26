"""Files of clouds by their endings: docs/files.md says what is read, refused and left out."""

from __future__ import annotations

import gzip
import tempfile
import warnings
from collections.abc import Callable
from pathlib import Path

from ido.clouds import CloudError, CloudWarning
from ido.disk import why_unreadable
from ido.files.arrays import read_npy, read_npz
from ido.files.cloud_file import CloudFile, UsedPoints, used_points
from ido.files.las import read_las
from ido.files.meshes import read_obj, read_off, read_stl
from ido.files.pcd import read_pcd
from ido.files.ply import read_ply
from ido.files.text import read_text
from ido.types import FloatArray

MOST_UNPACKED = 4 << 30
"""Bytes beyond which a .gz is not unpacked."""

TEXT = (".asc", ".csv", ".pts", ".txt", ".xyz")
"""Endings of text files, all read by the same rule."""

_STEP = 1 << 24  # bytes unpacked at a time


def load_cloud(path: str | Path, *, drop_invalid: bool = False) -> FloatArray:
    """Points of a file in its own units, shape (N, 3), float64; of a mesh, points sampled evenly by area.

    A `CloudWarning` tells what of the file is left out, how many points and why.

    Args:
        path: the file; its ending is one of `READERS`, or one of these and .gz.
        drop_invalid: leave out points with coordinates that are not finite, instead of refusing the file.

    Raises:
        CloudError: the file is missing, unreadable, of another format, cut off, or holds no usable cloud.
    """
    path = Path(path)
    _, used = open_cloud(path, drop_invalid=drop_invalid)
    for note in used.notes:
        warnings.warn(f"{path.name}: {note}", CloudWarning, stacklevel=2)
    return used.points


def open_cloud(path: str | Path, *, whole: bool = False, drop_invalid: bool = False) -> tuple[CloudFile, UsedPoints]:
    """What a file holds, as by `read_cloud`, and the points that are worked with, as by `used_points`.

    Raises:
        CloudError: as both do; the message names the file.
    """
    file = read_cloud(path, whole=whole)
    try:
        return file, used_points(file, drop_invalid=drop_invalid)
    except CloudError as error:
        raise CloudError(f"{Path(path).name}: {error}") from error


def read_cloud(path: str | Path, *, whole: bool = False) -> CloudFile:
    """What a file holds: every point in its order and, if the whole file is wanted, all its other columns.

    Raises:
        CloudError: the file is missing, unreadable, of another format or cut off.
    """
    path = Path(path)
    last = path.suffix.lower()
    before = Path(path.stem).suffix.lower()
    reader = READERS.get(before if last == ".gz" else last)
    if reader is None:
        raise CloudError(
            f"{path.name}: unknown kind of file; give one of {', '.join(sorted(READERS))}, or that and .gz"
        )
    if why := why_unreadable(path):
        raise CloudError(f"{path}: {why}")
    try:
        if last == ".gz":
            return _unpacked(path, reader, whole)
        return reader(path, whole)
    except CloudError as error:
        raise CloudError(f"{path.name}: {error}") from error
    except MemoryError:
        raise
    except Exception as error:  # libraries raise whatever they like on a broken file
        raise CloudError(f"{path.name}: cannot be read as {path.suffix[1:].upper()} ({error})") from error


def _unpacked(path: Path, reader: Reader, whole: bool) -> CloudFile:
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        unpacked = Path(folder) / path.stem
        with gzip.open(path) as source, unpacked.open("wb") as file:
            while content := source.read(_STEP):
                if file.tell() + len(content) > MOST_UNPACKED:
                    raise CloudError(f"unpacks to more than {MOST_UNPACKED >> 30} GB; unpack it yourself, and thin it")
                file.write(content)
        return reader(unpacked, whole)


Reader = Callable[[Path, bool], CloudFile]
"""Reads a file; whether its other columns are wanted, too."""


def _all_of(read: Callable[[Path], CloudFile]) -> Reader:
    """A reader that gets the other columns without further work."""
    return lambda path, whole: read(path)


READERS: dict[str, Reader] = {
    ".las": lambda path, whole: read_las(path, whole=whole),
    ".laz": lambda path, whole: read_las(path, whole=whole),
    ".npy": _all_of(read_npy),
    ".npz": _all_of(read_npz),
    ".obj": _all_of(read_obj),
    ".off": _all_of(read_off),
    ".pcd": _all_of(read_pcd),
    ".ply": _all_of(read_ply),
    ".stl": _all_of(read_stl),
    **dict.fromkeys(TEXT, lambda path, whole: read_text(path, whole=whole)),
}
"""What reads a file, by its ending in small letters."""
