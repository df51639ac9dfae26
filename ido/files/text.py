"""Text files of points: one rule finds the separator and the columns, and what does not follow it is refused."""

from __future__ import annotations

import codecs
import re
from collections.abc import Collection
from dataclasses import dataclass
from itertools import islice
from pathlib import Path

import numpy as np

from ido.clouds import CloudError
from ido.files.cloud_file import CloudFile, check_count
from ido.types import FloatArray

_COMMENTS = ("#", "//", "%")
_ENCODINGS = {codecs.BOM_UTF8: "utf-8-sig", codecs.BOM_UTF16_LE: "utf-16", codecs.BOM_UTF16_BE: "utf-16"}
_SHOWN = 60  # letters of a line in a message


@dataclass(frozen=True, slots=True)
class Layout:
    """How a file's lines are read.

    Args:
        encoding: of its letters.
        separator: between columns; None for spaces.
        names: of its columns, when it names them.
        width: number of columns.
        head: number of lines before the first row.
        count: number of rows, when the file promises it.
    """

    encoding: str
    separator: str | None
    names: tuple[str, ...] | None
    width: int
    head: int
    count: int | None

    def words(self, line: str) -> list[str]:
        """The columns of a line; a separator at its end adds none."""
        if self.separator is None:
            return line.split()
        return [word.strip() for word in line.rstrip(f"{self.separator} \t").split(self.separator)]


def read_text(path: Path, *, whole: bool) -> CloudFile:
    """Points and, if the whole file is wanted, its other columns of numbers.

    Raises:
        CloudError: a line does not follow the rule of docs/files.md; the message has its number.
    """
    layout = _layout(path)
    places = _places(layout)
    table, notes = _table(path, layout, range(layout.width) if whole else places), ()
    if table is None and whole:
        table = _table(path, layout, places)
        notes = ("its columns besides x, y and z are not all numbers and are not kept",)
    if table is None:
        raise _explained(path, layout, places)
    if layout.count not in (None, len(table)):
        raise CloudError(f"its first line promises {layout.count} points, {len(table)} follow")
    points = np.column_stack([table[f"{place}"] for place in places])
    if layout.names is None and layout.width > 3:
        _refuse_doubtful(layout, points)
    others = [i for i in range(layout.width) if i not in places] if whole and not notes else []
    return CloudFile(points, {_name(layout, i): table[f"{i}"] for i in others}, notes=notes)


def _name(layout: Layout, column: int) -> str:
    """What a column is called; by its number where names are missing or repeated."""
    name = layout.names[column] if layout.names else ""
    alone = layout.names is not None and layout.names.count(name) == 1
    return name if name and alone else f"{name or 'column'}{column + 1}"


def _layout(path: Path) -> Layout:
    with path.open("rb") as file:
        first = file.read(3)
    encoding = next((name for mark, name in _ENCODINGS.items() if first.startswith(mark)), "utf-8")
    count, names, comment, head = None, None, "", 0
    with path.open(encoding=encoding, errors="replace") as file:
        for number, line in enumerate(file, start=1):
            text = line.strip()
            if not text or text.startswith(_COMMENTS):
                comment = text or comment
                continue
            if head == 0 and re.fullmatch(r"\d{1,18}", text):
                count, head = check_count(int(text)), number
                continue
            separator = next((mark for mark in ";,\t" if mark in text), None)
            layout = Layout(encoding, separator, names, 0, head, count)
            words = layout.words(text.partition("#")[0].strip())
            if names is None and not all(_is_number(word) for word in words[:3]):
                if complaint := _complaint(number, words):
                    raise complaint
                names, head = tuple(word.strip("\"'") for word in words), number
                if not {"x", "y", "z"} <= {name.lower() for name in names}:
                    raise CloudError(
                        f"line {number} holds neither numbers nor the names of columns x, y and z: {text[:_SHOWN]!r}"
                    )
                continue
            if names is None:
                names = _named_by_comment(comment, layout, len(words))
            if names is not None and len(names) != len(words):
                raise CloudError(f"line {number} has {len(words)} columns, the line of names has {len(names)}")
            return Layout(encoding, separator, names, len(words), head, count)
    raise CloudError("holds no points")


def _named_by_comment(comment: str, layout: Layout, width: int) -> tuple[str, ...] | None:
    """Names that stand in the last comment before the first row, as CloudCompare writes them."""
    words = tuple(layout.words(comment.lstrip("".join(_COMMENTS)).strip()))
    named = len(words) == width and {"x", "y", "z"} <= {word.lower() for word in words}
    return words if named else None


def _places(layout: Layout) -> list[int]:
    """Which columns x, y and z are: by their names, else the first three."""
    if layout.width < 3:
        raise CloudError(f"a cloud needs three columns x, y, z; its first row has {layout.width}")
    if layout.names is None:
        return [0, 1, 2]
    lower = [name.lower() for name in layout.names]
    for axis in "xyz":
        if lower.count(axis) > 1:
            raise CloudError(f"names a column {axis} twice")
    return [lower.index(axis) for axis in "xyz"]


def _table(path: Path, layout: Layout, numbers: Collection[int]) -> np.ndarray | None:
    """All rows, with fields 0, 1, ...; None when one has another width, or no number where numbers are wanted."""
    row = np.dtype([(f"{i}", "f8" if i in numbers else "S1") for i in range(layout.width)])
    with path.open(encoding=layout.encoding, errors="replace") as file:
        lines = (line for line in islice(file, layout.head, None) if not line.startswith(_COMMENTS))
        if layout.separator:  # one at the end would begin another column
            end = f" \t\r\n{layout.separator}"
            lines = (line.rstrip(end) for line in lines)
        try:
            return np.loadtxt(lines, row, comments="#", delimiter=layout.separator, ndmin=1)
        except ValueError:
            return None


def _explained(path: Path, layout: Layout, places: list[int]) -> CloudError:
    """What is wrong with the first line that cannot be read."""
    with path.open(encoding=layout.encoding, errors="replace") as file:
        lines = file.readlines()
    for number, line in islice(enumerate(lines, start=1), layout.head, None):
        words = layout.words(line.partition("#")[0].strip())
        if words in ([], [""]) or line.startswith(_COMMENTS):
            continue
        right = len(words) == layout.width
        wanted = [words[place] for place in places] if right else words
        if complaint := _complaint(number, wanted):
            return complaint
        if not right:
            return CloudError(f"line {number} has {len(words)} columns, the first row has {layout.width}")
        for bad in filter(lambda word: not _is_number(word), wanted):
            return CloudError(f"line {number}: {bad[:_SHOWN]!r} is not a number")
    return CloudError("cannot be read as a table of numbers")


def _complaint(number: int, words: list[str]) -> CloudError | None:
    """What is wrong with a line in which something looks like a number and is none."""
    for word in words:
        if re.fullmatch(r"[-+\d.,'\s]*\d[-+\d.,'\s]*", word) and not _is_number(word):
            return CloudError(
                f"line {number}: {word[:_SHOWN]!r} is not a number here; write decimal points, no marks between "
                "thousands, and one separator throughout"
            )
    return None


def _refuse_doubtful(layout: Layout, points: FloatArray) -> None:
    """Refuse files without names whose first three columns may be something else.

    Raises:
        CloudError: they may be parts of numbers, or the first may only count.
    """
    in_parts = layout.separator in (",", None) and layout.width >= 6
    if in_parts and all((points[:, i] == np.round(points[:, i])).all() for i in (0, 2)):
        raise CloudError(
            "its commas or blanks may stand within numbers; write decimal points and nothing between thousands, or "
            "name the columns in a first line, as: x y z red green blue"
        )
    if len(points) > 1 and (np.diff(points[:, 0]) == 1).all():
        raise CloudError("its first column only counts; name the columns in a first line, as: number x y z")


def _is_number(word: str) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return "_" not in word and word.isascii()
