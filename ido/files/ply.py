"""PLY files: text, or binary of either byte order, with every type of number, and faces of any number of corners."""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ido.clouds import CloudError
from ido.files.cloud_file import CloudFile, check_count
from ido.files.faces import Polygons, triangles_of
from ido.files.rows import (
    binary_rows,
    check_end,
    check_text_end,
    columns_of,
    read_head,
    text_lines,
    text_rows,
    whole_number,
)

_TYPES = {
    **dict.fromkeys(("char", "int8"), "i1"),
    **dict.fromkeys(("uchar", "uint8"), "u1"),
    **dict.fromkeys(("short", "int16"), "i2"),
    **dict.fromkeys(("ushort", "uint16"), "u2"),
    **dict.fromkeys(("int", "int32"), "i4"),
    **dict.fromkeys(("uint", "uint32"), "u4"),
    **dict.fromkeys(("float", "float32"), "f4"),
    **dict.fromkeys(("double", "float64"), "f8"),
}
_ORDERS = {"ascii": "=", "binary_little_endian": "<", "binary_big_endian": ">"}
_CORNERS = ("vertex_indices", "vertex_index")

Property = tuple[str, str, str | None]
"""Name, type of a value, and type of the number of values when it is a list."""


@dataclass(frozen=True, slots=True)
class Element:
    """Rows of one kind."""

    name: str
    count: int
    properties: tuple[Property, ...]

    def row(self, length: int = 0) -> np.dtype:
        """One row; lists are taken to have this length, which stands before each."""
        fields: list[tuple[str, str] | tuple[str, str, tuple[int, ...]]] = []
        for name, kind, counted in self.properties:
            if counted is None:
                fields.append((name, kind))
            else:
                fields += [(f"{name} length", counted), (name, kind, (length,))]
        return np.dtype(fields)

    @property
    def has_lists(self) -> bool:
        return any(counted for _, _, counted in self.properties)


def read_ply(path: Path) -> CloudFile:
    """Points, their other properties, and faces, cut into triangles.

    Raises:
        CloudError: not a PLY file, cut off, or longer than its head promises.
    """
    head = read_head(path, "end_header")
    if head.lines[0] != ["ply"]:
        raise CloudError("is not a PLY file: it does not begin with the word ply")
    order, elements = _elements(head.lines[1:-1])
    vertices: dict[str, np.ndarray] = {}
    faces: np.ndarray | None = None
    notes = []
    with path.open("rb") as file:
        file.seek(head.end)
        lines, start = text_lines(file), head.end
        for element in elements:
            if order == "=":
                rows, lists = _from_text(lines, element)
            else:
                rows, lists, start = _from_binary(path, start, element)
            if element.name == "vertex" and rows is not None:
                vertices = dict(columns_of(rows))
            elif element.name == "face" and element.count:
                faces = triangles_of(lists, next(e.count for e in elements if e.name == "vertex"))
                if faces is None:
                    notes.append(f"{element.count} faces without a list of three corners or more are not used")
            elif element.count:
                notes.append(f"{element.count} rows of the kind {element.name!r} are not used")
        if order == "=":
            check_text_end(lines)
        else:
            check_end(path, start, next(e for e in elements if e.name == "vertex").row())
    return CloudFile.of(vertices, faces, *notes)


def _elements(lines: tuple[list[str], ...]) -> tuple[str, list[Element]]:
    """The byte order, and what follows the head."""
    order, elements = "", []
    for words in lines:
        match words:
            case ["format", kind, _] if kind in _ORDERS:
                order = _ORDERS[kind]
            case ["element", name, count]:
                elements.append(Element(name, check_count(whole_number(count)), ()))
            case ["property", "list", counted, kind, name] if elements and {counted, kind} <= _TYPES.keys():
                _add(elements, (name, order + _TYPES[kind], order + _TYPES[counted]))
            case ["property", kind, name] if elements and kind in _TYPES:
                _add(elements, (name, order + _TYPES[kind], None))
            case _:
                raise CloudError(f"its head has a line that is not understood: {' '.join(words)[:80]}")
    if not order:
        raise CloudError("its head names no format")
    if [e.has_lists for e in elements if e.name == "vertex"] != [False]:
        raise CloudError("needs one element vertex without lists")
    return order, elements


def _add(elements: list[Element], added: Property) -> None:
    last = elements[-1]
    if added[0] in [name for name, *_ in last.properties]:
        raise CloudError(f"its head names {added[0]} twice")
    elements[-1] = Element(last.name, last.count, (*last.properties, added))


def _from_text(lines: Iterator[str], element: Element) -> tuple[np.ndarray | None, np.ndarray | Polygons]:
    """Rows when there are no lists in them, and the corners of faces."""
    if not element.has_lists:
        return text_rows(lines, element.count, element.row()), []
    polygons = []
    for _ in range(element.count):
        words = next(lines, "").split()
        polygons.append(_walk(element, lambda kind, words=words: _next_number(words, kind)))
        if words:
            raise CloudError("a face has more numbers than it promises")
    return None, polygons


def _next_number(words: list[str], kind: str) -> float:
    try:
        return float(words.pop(0)) if "f" in kind else int(words.pop(0))
    except (IndexError, ValueError) as error:
        raise CloudError("is cut off, or a face is not as its head promises") from error


def _from_binary(path: Path, start: int, element: Element) -> tuple[np.ndarray | None, np.ndarray | Polygons, int]:
    """Rows when there are no lists in them, the corners of faces, and the place after them."""
    if not element.has_lists:
        row = element.row()
        return binary_rows(path, start, element.count, row), [], start + element.count * row.itemsize
    row = element.row(length=3)
    corners = next((name for name in _CORNERS if name in (row.names or ())), None)
    if corners and start + element.count * row.itemsize <= path.stat().st_size:
        rows = binary_rows(path, start, element.count, row)
        if all((rows[name] == 3).all() for name in row.names or () if name.endswith(" length")):
            return None, rows[corners], start + element.count * row.itemsize
    with path.open("rb") as file:
        file.seek(start)

        def read(kind: str) -> float:
            size = np.dtype(kind).itemsize
            content = file.read(size)
            if len(content) < size:
                raise CloudError("is cut off within its faces")
            return struct.unpack(kind[0] + np.dtype(kind).char, content)[0]

        return None, [_walk(element, read) for _ in range(element.count)], file.tell()


def _walk(element: Element, read: Callable[[str], float]) -> list[int]:
    """Read one row with lists; gives the corners."""
    corners: list[int] = []
    for name, kind, counted in element.properties:
        values = [read(kind) for _ in range(int(read(counted)) if counted else 1)]
        if name in _CORNERS:
            corners = [int(value) for value in values]
    return corners
