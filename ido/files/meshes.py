"""OBJ, STL and OFF files: vertices in their order, and triangles."""

from __future__ import annotations

import re
import struct
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ido.clouds import CloudError
from ido.files.cloud_file import CloudFile, check_count
from ido.files.faces import triangles_of
from ido.types import FloatArray

_STL_HEAD = 84  # bytes: a remark and the number of triangles
_STL_TRIANGLE = 50  # bytes


def read_obj(path: Path) -> CloudFile:
    """Vertices of all its objects, and their faces cut into triangles; materials are not looked at.

    Raises:
        CloudError: a vertex or a face is not as it should be.
    """
    vertices: list[str] = []
    faces: list[list[int]] = []
    with path.open(encoding="utf-8", errors="replace") as file:
        for number, line in enumerate(file, start=1):
            words = line.split()
            if words[:1] == ["v"]:
                if len(words) < 4:
                    raise CloudError(f"line {number}: a vertex needs three coordinates")
                vertices.append(line.strip()[1:])
            elif words[:1] == ["f"]:
                if len(words) < 4:
                    raise CloudError(f"line {number}: a face needs three corners")
                faces.append([_corner(word, len(vertices), number) for word in words[1:]])
    points = _numbers(vertices)
    return CloudFile(points, faces=triangles_of(faces, len(points)))


def _corner(word: str, count: int, line: int) -> int:
    """A vertex of a face, counted from 0; the format counts from 1, or back from the last one."""
    text = word.split("/")[0]
    if not text.lstrip("-").isdigit() or int(text) == 0 or int(text) < -count:
        raise CloudError(f"line {line}: {word[:20]!r} is no corner of a face")
    return int(text) - 1 if int(text) > 0 else count + int(text)


def read_stl(path: Path) -> CloudFile:
    """The corners of its triangles, each corner as often as the file has it.

    Raises:
        CloudError: cut off, or longer than it promises.
    """
    with path.open("rb") as file:
        head = file.read(1000)
    if head.lstrip().lower().startswith(b"solid") and b"facet" in head.lower():
        promised = _triangles_of_text(path)
    else:
        promised = _triangles_of_binary(path, head)
    read = _read(path)
    if (0 if read.faces is None else len(read.faces)) != promised:
        raise CloudError(f"has {promised} triangles, of which not all can be read; write it anew as a binary STL")
    return read


def _triangles_of_text(path: Path) -> int:
    """How many triangles a text has, each of three corners, in solids that all end."""
    words, last = Counter[str](), ""
    with path.open(encoding="utf-8", errors="replace") as file:
        for line in file:
            first = line.split(maxsplit=1)[:1]
            if first:
                last = first[0].lower()
                words[last] += 1
    triangles, ends = words["facet"], words["solid"] == words["endsolid"] and last == "endsolid"
    if not ends or words["endfacet"] != triangles or words["vertex"] != 3 * triangles:
        raise CloudError("is cut off, or damaged: not every solid and facet ends")
    return check_count(triangles)


def _triangles_of_binary(path: Path, head: bytes) -> int:
    """How many triangles a binary file promises, if it has so many."""
    size = path.stat().st_size
    if len(head) < _STL_HEAD:
        raise CloudError("is not an STL file, or cut off within its head")
    promised = struct.unpack_from("<I", head, _STL_HEAD - 4)[0]
    there, rest = divmod(size - _STL_HEAD, _STL_TRIANGLE)
    if promised != there or rest:
        what = "cut off" if there < promised else "longer than that"
        raise CloudError(f"is not an STL file, or {what}: it promises {promised} triangles and has room for {there}")
    return check_count(promised)


def read_off(path: Path) -> CloudFile:
    """Vertices, and faces cut into triangles; colours, normals and places in pictures are not looked at.

    Raises:
        CloudError: not an OFF file, cut off, or longer than it promises.
    """
    with path.open(encoding="ascii", errors="replace") as file:
        rows = [row for line in file if (row := line.partition("#")[0].strip())]
    words = rows[0].split() if rows else []
    if words and re.fullmatch(r"(ST)?C?N?OFF", words[0].upper()):
        rows[0] = " ".join(words[1:])  # the counts may follow in the same line
        rows = rows if rows[0] else rows[1:]
    promised = rows[0].split()[:2] if rows else []
    if len(promised) < 2 or not all(word.isdigit() for word in promised):
        raise CloudError("is not an OFF file: it does not say how many points and faces it has")
    count, n_faces = (check_count(int(word)) for word in promised)
    if len(rows) != 1 + count + n_faces:
        what = "is cut off" if len(rows) < 1 + count + n_faces else "holds more than it promises"
        raise CloudError(f"{what}: {count} points and {n_faces} faces are promised, {len(rows) - 1} lines follow")
    points = _numbers(rows[1 : 1 + count])
    return CloudFile(points, faces=triangles_of([_face(row) for row in rows[1 + count :]], count))


def _face(row: str) -> list[int]:
    """The corners of a face of an OFF file, which their number precedes and a colour may follow."""
    size, *words = row.split()
    corners = words[: int(size)] if size.isdigit() else []
    if len(corners) < 3 or len(corners) != int(size) or not all(corner.isdigit() for corner in corners):
        raise CloudError(f"is cut off, or damaged: {row[:40]!r} is no face")
    return [int(corner) for corner in corners]


def _numbers(rows: Sequence[str]) -> FloatArray:
    """The first three numbers of each row, shape (N, 3).

    Raises:
        CloudError: a row has none.
    """
    try:
        return np.loadtxt(rows, comments=None, usecols=(0, 1, 2), ndmin=2) if rows else np.empty((0, 3))
    except ValueError as error:
        raise CloudError(f"is cut off, or damaged: a point does not have three coordinates ({error})") from error


def _read(path: Path) -> CloudFile:
    import trimesh

    loaded = trimesh.load(path, process=False, maintain_order=True)
    if isinstance(loaded, trimesh.Scene):  # a text STL of several solids
        loaded = loaded.to_mesh()
    points = np.asarray(getattr(loaded, "vertices", np.empty((0, 3))), dtype=np.float64)
    faces = np.asarray(getattr(loaded, "faces", np.empty((0, 3), dtype=np.int64)))
    return CloudFile(points, faces=faces if len(faces) else None)
