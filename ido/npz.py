"""Files of arrays, .npz: read whole or refused, written whole or not at all, never a pickle."""

from __future__ import annotations

import io
import secrets
import zipfile
from collections.abc import Mapping
from pathlib import Path

import numpy as np


def read_arrays(path: str | Path, error: type[ValueError], kind: str, remedy: str) -> dict[str, np.ndarray]:
    """All arrays of a file.

    Args:
        path: the file.
        error: what is raised if it cannot be used.
        kind: what the file should be, as ``a maps file``.
        remedy: what the user should do, as ``make one with `ido train```.

    Raises:
        error: missing, cut-off, damaged or foreign file.
    """
    path = Path(path)
    if not path.is_file():
        raise error(f"{path}: no such file; {remedy}")
    if not zipfile.is_zipfile(path):
        raise error(f"{path.name}: not {kind}, or cut off; {remedy}")
    try:
        with np.load(path, allow_pickle=False) as file:
            return {name: file[name] for name in file.files}
    except Exception as reason:  # zlib, zipfile and NumPy each raise their own
        raise error(f"{path.name}: damaged ({reason}); {remedy}") from reason


def packed(arrays: Mapping[str, np.ndarray]) -> bytes:
    """The content of a compressed file of arrays."""
    content = io.BytesIO()
    np.savez_compressed(content, allow_pickle=False, **arrays)
    return content.getvalue()


def write_whole(path: str | Path, content: bytes) -> None:
    """Write a file beside its place and rename it, so that one already there is replaced only by a whole one."""
    path = Path(path)
    temporary = path.with_name(f".{path.name}.{secrets.token_hex(4)}")
    try:
        with temporary.open("xb") as file:
            file.write(content)
        temporary.replace(path)
    except BaseException:
        temporary.unlink(missing_ok=True)
        raise
