"""PCD files: text, binary and compressed, with fields of every size and type that the format has."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ido.clouds import CloudError
from ido.files.cloud_file import CloudFile, check_count
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

_KINDS = {"F": "f", "I": "i", "U": "u"}
_SIZES = {"F": (4, 8), "I": (1, 2, 4, 8), "U": (1, 2, 4, 8)}
_MOST_PACKED = 100  # LZF packs at most 264 bytes into 3


def read_pcd(path: Path) -> CloudFile:
    """Points and their other fields.

    Raises:
        CloudError: not a PCD file, cut off, or longer than its head promises.
    """
    head = read_head(path, "DATA")
    said = {words[0]: words[1:] for words in head.lines}
    row, count = _row(said), _count(said)
    match said["DATA"]:
        case ["ascii"]:
            with path.open("rb") as file:
                file.seek(head.end)
                lines = text_lines(file)
                columns = columns_of(text_rows(lines, count, row))
                check_text_end(lines)
        case ["binary"]:
            columns = columns_of(binary_rows(path, head.end, count, row))
            check_end(path, head.end + count * row.itemsize, row)
        case ["binary_compressed"]:
            columns = _unpacked(path, head.end, count, row)
        case other:
            raise CloudError(f"its DATA is {' '.join(other)!r}, not ascii, binary or binary_compressed")
    return CloudFile.of({name: values for name, values in columns.items() if not name.startswith("_")})


def _row(said: dict[str, list[str]]) -> np.dtype:
    names, kinds = said.get("FIELDS", []), said.get("TYPE", [])
    sizes = [whole_number(word) for word in said.get("SIZE", [])]
    counts = [whole_number(word) for word in said.get("COUNT", ["1"] * len(names))]
    if not names or not len(names) == len(kinds) == len(sizes) == len(counts):
        raise CloudError("its head must name as many FIELDS as it has of SIZE, TYPE and COUNT")
    fields = []
    for i, (name, kind, size, count) in enumerate(zip(names, kinds, sizes, counts, strict=True)):
        if size not in _SIZES.get(kind, ()):
            raise CloudError(
                f"its field {name} has the type {kind} and the size {size}, which the format does not have"
            )
        named = f"_{i}" if name == "_" else name  # room between the fields
        fields.append((named, f"<{_KINDS[kind]}{size}") if count == 1 else (named, f"<{_KINDS[kind]}{size}", (count,)))
    if len({named for named, *_ in fields}) < len(fields):
        raise CloudError("its head names a field twice")
    return np.dtype(fields)


def _count(said: dict[str, list[str]]) -> int:
    numbers = {key: whole_number(said[key][0]) for key in ("WIDTH", "HEIGHT", "POINTS") if said.get(key)}
    if numbers.keys() >= {"WIDTH", "HEIGHT"}:
        cells = numbers["WIDTH"] * numbers["HEIGHT"]
        if numbers.get("POINTS", cells) != cells:
            raise CloudError(f"its head promises {numbers['POINTS']} POINTS, but WIDTH x HEIGHT are {cells}")
        return check_count(cells)
    if "POINTS" not in numbers:
        raise CloudError("its head does not say how many POINTS there are")
    return check_count(numbers["POINTS"])


def _unpacked(path: Path, start: int, count: int, row: np.dtype) -> dict[str, np.ndarray]:
    """Fields of the compressed form, which has one after the other, each for all points."""
    import lzf

    with path.open("rb") as file:
        file.seek(start)
        sizes = np.frombuffer(file.read(8), "<u4")
        packed = file.read()
    if len(sizes) < 2 or sizes[0] != len(packed):
        raise CloudError(f"is cut off, or longer than its head promises: {len(packed)} bytes of packed points")
    expected = count * row.itemsize
    if sizes[1] != expected or expected > _MOST_PACKED * max(len(packed), 1):
        raise CloudError(f"its head promises {expected} bytes of points, its packed points are {sizes[1]}")
    content = lzf.decompress(packed, expected) if expected else b""
    if content is None or len(content) != expected:
        raise CloudError("is damaged: its points cannot be unpacked")
    columns, offset = {}, 0
    for name in row.names or ():
        kind, shape = row[name].base, row[name].shape
        columns[name] = np.frombuffer(content, kind, count * int(np.prod(shape)), offset).reshape(count, *shape)
        offset += count * row[name].itemsize
    return columns
