"""Files of arrays, .npz: read whole or refused, never a pickle, never more than they may hold."""

from __future__ import annotations

import io
import math
import zipfile
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import IO, NamedTuple

import numpy as np

from ido.disk import why_unreadable

MOST_BYTES = 1 << 30
"""Unpacked size of all arrays of a file, beyond which it is refused; ours have a hundredth of it."""


class Promise(NamedTuple):
    """What an array will be, as its head says before it is unpacked."""

    shape: tuple[int, ...]
    dtype: np.dtype

    @property
    def size(self) -> int:
        """Bytes in memory."""
        return math.prod(self.shape) * self.dtype.itemsize


def promises(path: Path) -> dict[str, Promise]:
    """What the arrays of an .npz will be, by name; nothing is unpacked but their heads. Other files in it are bytes.

    Raises:
        ValueError: an array is none, or a pickle.
    """
    found = {}
    with zipfile.ZipFile(path) as archive:
        for member in archive.infolist():
            if not member.filename.endswith(".npy"):
                found[member.filename] = Promise((member.file_size,), np.dtype(np.uint8))
                continue
            with archive.open(member) as file:
                try:
                    found[member.filename.removesuffix(".npy")] = promise(file)
                except ValueError as error:
                    raise ValueError(f"{member.filename}: {error}") from error
    return found


def promise(file: IO[bytes]) -> Promise:
    """What an array will be, from the head of its .npy; the file then stands at the array's first byte.

    Raises:
        ValueError: it is no array, or a pickle.
    """
    version = np.lib.format.read_magic(file)
    read = np.lib.format.read_array_header_1_0 if version == (1, 0) else np.lib.format.read_array_header_2_0
    shape, _, dtype = read(file)
    if dtype.hasobject:
        raise ValueError("holds Python objects, which are not read")
    return Promise(shape, dtype)


def read_arrays(path: str | Path, error: type[ValueError], kind: str, remedy: str) -> dict[str, np.ndarray]:
    """All arrays of a file.

    Args:
        path: the file.
        error: what is raised if it cannot be used.
        kind: what the file should be, as ``a maps file``.
        remedy: what the user should do, as ``make one with `ido train```.

    Raises:
        error: missing, cut-off, damaged or foreign file, or one that unpacks to more than `MOST_BYTES`.
    """
    path = Path(path)
    if why := why_unreadable(path):
        raise error(f"{path}: {why}; {remedy}")
    if not zipfile.is_zipfile(path):
        raise error(f"{path.name}: not {kind}, or cut off; {remedy}")
    try:
        found = promises(path)
        size = sum(array.size for array in found.values())
        if size > MOST_BYTES:
            raise ValueError(f"it would unpack to {size / 1e9:.1f} GB")
        return loaded(path, found)
    except Exception as reason:  # zlib, zipfile and NumPy each raise their own
        raise error(f"{path.name}: damaged ({reason}); {remedy}") from reason


def loaded(path: Path, names: Iterable[str]) -> dict[str, np.ndarray]:
    """Some arrays of a file; `promises` says before how large they are."""
    with np.load(path, allow_pickle=False) as file:
        return {name: file[name] for name in names}


def packed(arrays: Mapping[str, np.ndarray]) -> bytes:
    """The content of a compressed file of arrays."""
    content = io.BytesIO()
    np.savez_compressed(content, allow_pickle=False, **arrays)
    return content.getvalue()
