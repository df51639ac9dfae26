"""OBJ, STL and OFF files: vertices in their order, and triangles."""

from __future__ import annotations

import struct
import warnings
from pathlib import Path

import numpy as np

from ido.clouds import CloudError
from ido.files.cloud_file import CloudFile, check_count


def read_obj(path: Path) -> CloudFile:
    """Vertices of all its objects, and their faces cut into triangles; materials are not looked at.

    Raises:
        CloudError: a vertex or a face is not as it should be.
    """
    vertices, faces = [], []
    with path.open(encoding="utf-8", errors="replace") as file:
        for number, line in enumerate(file, start=1):
            words = line.split()
            if words[:1] == ["v"] and len(words) < 4:
                raise CloudError(f"line {number}: a vertex needs three coordinates")
            if words[:1] == ["v"]:
                vertices.append(" ".join(words[1:4]))
            elif words[:1] == ["f"]:
                corners = [_corner(word, len(vertices), number) for word in words[1:]]
                faces += [(corners[0], corners[i], corners[i + 1]) for i in range(1, len(corners) - 1)]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # an empty file is refused later
        points = np.loadtxt(vertices, ndmin=2) if vertices else np.empty((0, 3))
    if faces and max(map(max, faces)) >= len(points):
        raise CloudError("is cut off: a face names a vertex that is not there")
    return CloudFile(points, faces=np.array(faces) if faces else None)


def _corner(word: str, count: int, line: int) -> int:
    """A vertex of a face, counted from 0; the format counts from 1, or back from the last one."""
    text = word.split("/")[0]
    if not text.lstrip("-").isdigit() or int(text) == 0 or int(text) < -count:
        raise CloudError(f"line {line}: {word[:20]!r} is no corner of a face")
    return int(text) - 1 if int(text) > 0 else count + int(text)


def read_stl(path: Path) -> CloudFile:
    """The corners of its triangles, each corner as often as the file has it.

    Raises:
        CloudError: cut off.
    """
    with path.open("rb") as file:
        head = file.read(1000)
        file.seek(max(path.stat().st_size - 1000, 0))
        tail = file.read()
    if head.lstrip().startswith(b"solid") and b"facet" in head:  # the reader takes what there is of a text
        if b"endsolid" not in tail:
            raise CloudError("is cut off: it has no line endsolid")
    elif len(head) < 84 or 84 + 50 * struct.unpack_from("<I", head, 80)[0] != path.stat().st_size:
        raise CloudError("is not an STL file, or cut off: its size is not that of the triangles that it promises")
    return _read(path)


def read_off(path: Path) -> CloudFile:
    """Vertices and triangles.

    Raises:
        CloudError: not an OFF file, or cut off.
    """
    with path.open(encoding="ascii", errors="replace") as file:
        words = [word for line in file for word in line.partition("#")[0].split()][:3]
    first = 1 if words and words[0].upper().endswith("OFF") else 0
    if len(words) < first + 2 or not all(word.isdigit() for word in words[first : first + 2]):
        raise CloudError("is not an OFF file: it does not say how many points and faces it has")
    promised, faces = map(int, words[first : first + 2])
    check_count(promised)
    read = _read(path)
    if len(read.points) != promised or (0 if read.faces is None else len(read.faces)) < faces:
        raise CloudError(f"is cut off: it promises {promised} points and {faces} faces")
    return read


def _read(path: Path) -> CloudFile:
    import trimesh

    loaded = trimesh.load(path, process=False, maintain_order=True)
    if isinstance(loaded, trimesh.Scene):  # a text STL of several solids
        loaded = loaded.to_mesh()
    points = np.asarray(getattr(loaded, "vertices", np.empty((0, 3))), dtype=np.float64)
    faces = np.asarray(getattr(loaded, "faces", np.empty((0, 3), dtype=np.int64)))
    return CloudFile(points, faces=faces if len(faces) else None)
