"""Writing clouds: every point, in order, with the columns and faces that the format has room for."""

from __future__ import annotations

import re
import warnings
from pathlib import Path

import numpy as np

from ido.clouds import CloudWarning
from ido.disk import written_beside
from ido.files.cloud_file import CloudFile
from ido.types import FloatArray

SUFFIXES = (".ply", ".xyz")
"""Endings of the files that are written."""

_ROWS = 100_000  # written at a time

_PLY_TYPES = {
    "i1": "char",
    "u1": "uchar",
    "i2": "short",
    "u2": "ushort",
    "i4": "int",
    "u4": "uint",
    "f4": "float",
    "f8": "double",
}


def save_cloud(path: str | Path, cloud: CloudFile | FloatArray) -> None:
    """Write points (N, 3), or all of a file that was read, to a PLY or XYZ file without losing digits.

    It is written whole or not at all. A `CloudWarning` tells what the format has no room for: faces in XYZ, whole
    numbers of more than 53 bits in PLY.

    Raises:
        ValueError: the file's name ends in something else.
        OSError: it cannot be written.
    """
    path = Path(path)
    file = cloud if isinstance(cloud, CloudFile) else CloudFile(np.asarray(cloud, dtype=np.float64))
    if path.suffix.lower() not in SUFFIXES:
        raise ValueError(f"{path}: the name must end in {' or '.join(SUFFIXES)}")
    with written_beside(path) as temporary:
        (_write_xyz if path.suffix.lower() == ".xyz" else _write_ply)(temporary, file)


def _write_xyz(path: Path, file: CloudFile) -> None:
    if file.faces is not None:
        warnings.warn(
            f"{len(file.faces)} faces are not written, for XYZ has no room for them", CloudWarning, stacklevel=3
        )
    columns = {
        name: values.astype("u1") if values.dtype.kind == "b" else values for name, values in file.columns.items()
    }
    formats = ["%.12g"] * 3 + ["%d" if values.dtype.kind in "iu" else "%.17g" for values in columns.values()]
    names = " ".join(["x", "y", "z", *map(_word, columns)]) if columns else ""
    table = np.empty(len(file.points), dtype=[(f"{i}", "f8") for i in range(3)] + _fields(columns))
    for i in range(3):
        table[f"{i}"] = file.points[:, i]
    for i, values in enumerate(columns.values(), start=3):
        table[f"{i}"] = values
    np.savetxt(path, table, fmt=formats, header=names)


def _fields(columns: dict[str, np.ndarray]) -> list[tuple[str, str]]:
    return [(f"{i}", values.dtype.str) for i, values in enumerate(columns.values(), start=3)]


def _write_ply(path: Path, file: CloudFile) -> None:
    columns = {name: _in_ply(name, values) for name, values in file.columns.items()}
    columns = {"x": file.points[:, 0], "y": file.points[:, 1], "z": file.points[:, 2], **columns}
    kinds = [values.dtype.str[1:] for values in columns.values()]
    lines = ["ply", "format binary_little_endian 1.0", f"element vertex {len(file.points)}"]
    lines += [f"property {_PLY_TYPES[kind]} {_word(name)}" for kind, name in zip(kinds, columns, strict=True)]
    faces = np.empty(0 if file.faces is None else len(file.faces), dtype=[("n", "u1"), ("corners", "<i4", (3,))])
    if file.faces is not None:
        lines += [f"element face {len(faces)}", "property list uchar int vertex_indices"]
        faces["n"], faces["corners"] = 3, file.faces
    row = np.dtype([(f"{i}", f"<{kind}") for i, kind in enumerate(kinds)])
    with path.open("wb") as out:
        out.write(("\n".join([*lines, "end_header"]) + "\n").encode("ascii"))
        for first in range(0, len(file.points), _ROWS):
            part = slice(first, first + _ROWS)
            rows = np.empty(len(file.points[part]), row)
            for i, values in enumerate(columns.values()):
                rows[f"{i}"] = values[part]
            out.write(rows.data)
        out.write(faces.data)


def _in_ply(name: str, values: np.ndarray) -> np.ndarray:
    """Values in a type that PLY has, which has no whole numbers of 64 bits."""
    if values.dtype.kind == "b":
        return values.astype("u1")
    if values.dtype.kind == "f" and values.dtype.itemsize not in (4, 8):
        return values.astype("f4" if values.dtype.itemsize < 4 else "f8")
    if values.dtype.kind == "f" or values.dtype.itemsize < 8:
        return values
    for kind in ("i4", "u4", "f8"):
        converted = values.astype(kind)
        if (converted.astype(values.dtype) == values).all():
            return converted
    warnings.warn(f"{name} is rounded to 53 bits, for PLY has no longer numbers", CloudWarning, stacklevel=4)
    return values.astype("f8")


def _word(name: str) -> str:
    """A name without what would end it in a head."""
    return re.sub(r"[^!-~]+", "_", name.strip()) or "_"
