"""Rows of numbers as PLY and PCD files hold them: so many as their head promises, or none."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import BinaryIO

import numpy as np

from ido.clouds import CloudError

_HEAD = 1_000_000  # bytes that a head may have


@dataclass(frozen=True, slots=True)
class Head:
    """The lines of a file before its numbers, each as its words, and the place of the first byte after them."""

    lines: tuple[list[str], ...]
    end: int


def read_head(path: Path, last_word: str) -> Head:
    """The head of a file, whose last line begins with a word; comments and empty lines are left out.

    Raises:
        CloudError: there is no such line.
    """
    lines = []
    with path.open("rb") as file:
        while (line := file.readline(_HEAD)) and file.tell() <= _HEAD:
            words = line.decode("ascii", "replace").split()
            if words and not words[0].startswith(("#", "comment", "obj_info")):
                lines.append(words)
                if words[0] == last_word:
                    return Head(tuple(lines), file.tell())
    raise CloudError(f"is cut off, or not what its name says: it has no line {last_word}")


def binary_rows(path: Path, start: int, count: int, row: np.dtype) -> np.ndarray:
    """Rows of a binary file, shape (count,), read as they are used.

    Raises:
        CloudError: the file ends before the last of them.
    """
    left = path.stat().st_size - start
    if left < count * row.itemsize:
        raise CloudError(f"is cut off: its head promises {count} rows, it holds {left // row.itemsize}")
    if not count:
        return np.empty(0, row)
    return np.memmap(path, row, "r", start, (count,))


def check_end(path: Path, end: int, row: np.dtype) -> None:
    """See that no row follows those that the head promises.

    Raises:
        CloudError: some do.
    """
    extra = (path.stat().st_size - end) // max(row.itemsize, 1)
    if extra:
        raise _too_many(extra)


def text_rows(lines: Iterator[str], count: int, row: np.dtype) -> np.ndarray:
    """Rows of a text, shape (count,), taken from its lines.

    Raises:
        CloudError: there are fewer lines, or one is not as it should be.
    """
    if not count:
        return np.empty(0, row)
    try:
        rows = np.loadtxt(islice(lines, count), dtype=row, comments=None, ndmin=1)
    except ValueError as error:
        raise CloudError(f"a row is not as its head promises ({error})") from error
    if len(rows) != count:
        raise CloudError(f"is cut off: its head promises {count} rows, it holds {len(rows)}")
    return rows


def text_lines(file: BinaryIO) -> Iterator[str]:
    """The lines that are left of an open file, without empty ones."""
    return (line for raw in file if (line := raw.decode("ascii", "replace").strip()))


def check_text_end(lines: Iterator[str]) -> None:
    """See that no line follows those that the head promises.

    Raises:
        CloudError: some do.
    """
    extra = sum(1 for _ in lines)
    if extra:
        raise _too_many(extra)


def _too_many(extra: int) -> CloudError:
    return CloudError(f"holds {extra} rows more than its head promises; which of them are meant cannot be known")


def whole_number(word: str) -> int:
    """A number of a head.

    Raises:
        CloudError: it is none.
    """
    if not re.fullmatch(r"\d{1,18}", word):
        raise CloudError(f"its head says {word!r} where a whole number belongs")
    return int(word)


def columns_of(rows: np.ndarray) -> Mapping[str, np.ndarray]:
    """The fields of structured rows, by name."""
    return {name: rows[name] for name in rows.dtype.names or ()}
