"""Registering all scans of a folder: a row for each, kept as soon as it is there, and gone on with after a stop."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Callable, Iterator
from concurrent.futures import Executor
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from functools import cache
from pathlib import Path
from typing import Any

from ido.arguments import maps_of, place_of
from ido.clouds import CloudError
from ido.experiments.workers import share_out
from ido.files import READERS
from ido.global_scans import SURE, global_target, register_globally
from ido.global_scans import as_json as global_json
from ido.scans import ScanSettings, as_json, register_scan

FORMAT = "ido-poses-1"

Row = dict[str, Any]
"""What was found of a scan: its file, its size and time, and what `as_json` has of it, or the error."""

_REMEDY = "name another file, or replace it with --force"


class RowsError(ValueError):
    """A file of rows cannot be gone on with; the message says why and what to do."""


@dataclass(frozen=True, slots=True)
class Walk:
    """Registration by maps: their file or shipped name, and how."""

    maps: str
    histogram: str | None
    settings: ScanSettings

    @property
    def head(self) -> Row:
        """What decides the rows, plain values."""
        return {"maps": _fingerprint(self.maps), **asdict(self.settings)}

    def prepare(self) -> None:
        """Read the maps; raises what is wrong with them."""
        _maps(self.maps, self.histogram)

    def row(self, file: str) -> Row:
        """What is found of a scan."""
        return as_json(register_scan(_maps(self.maps, self.histogram), file, self.settings))

    @staticmethod
    def doubts(row: Row) -> list[str]:
        """Why a row's pose may be wrong."""
        return row["warnings"] or ([] if row["converged"] else [f"it did not converge ({row['stop']})"])


@dataclass(frozen=True, slots=True)
class FromAnyStart:
    """Registration from any start: the file or shipped name of a cloud or maps, and how."""

    onto: str
    histogram: str | None
    drop_invalid: bool

    @property
    def head(self) -> Row:
        """What decides the rows, plain values."""
        return {"global": _fingerprint(self.onto), "drop_invalid": self.drop_invalid}

    def prepare(self) -> None:
        """Read the model and make its fields; raises what is wrong with it."""
        _target(self.onto, self.histogram)

    def row(self, file: str) -> Row:
        """What is found of a scan."""
        target = _target(self.onto, self.histogram)
        return global_json(register_globally(target, file, drop_invalid=self.drop_invalid))

    @staticmethod
    def doubts(row: Row) -> list[str]:
        """Why a row's pose may be wrong."""
        chance = row["confidence"]["probability"]
        return row["warnings"] or ([] if chance >= SURE else [f"it is only {chance:.0%} probable"])


@dataclass(frozen=True, slots=True)
class ScanTask:
    """A scan to register; what a worker gets."""

    file: str
    way: Walk | FromAnyStart


def scans_in(folder: Path) -> list[Path]:
    """The files of a folder that can be read, by name; not those of the folders in it.

    Raises:
        CloudError: there are none.
    """
    found = sorted(path for path in folder.iterdir() if path.is_file() and _kind(path) in READERS)
    if not found:
        raise CloudError(f"{folder}: holds no clouds; their names end in {', '.join(sorted(READERS))}")
    return found


def _kind(path: Path) -> str:
    return Path(path.stem if path.suffix.lower() == ".gz" else path.name).suffix.lower()


def register_file(task: ScanTask) -> Row:
    """The row of a scan; a file that cannot be used has the error in it."""
    row = _named(Path(task.file))
    try:
        return row | task.way.row(task.file)
    except CloudError as error:
        return row | {"error": str(error)}


@cache
def _maps(maps: str, histogram: str | None) -> Any:
    return maps_of(maps, histogram)


@cache
def _target(onto: str, histogram: str | None) -> Any:
    return global_target(onto, histogram)


def _fingerprint(name: str) -> str:
    """Of the file of a cloud or maps."""
    return hashlib.sha256(place_of(name).read_bytes()).hexdigest()[:16]


def _named(path: Path) -> Row:
    state = path.stat()
    return {"file": path.name, "bytes": state.st_size, "modified": state.st_mtime}


@dataclass(frozen=True, slots=True)
class Rows:
    """The rows of a file, and how to add one; made by `open_rows`."""

    found: list[Row]
    append: Callable[[Row], None]


@contextmanager
def open_rows(path: Path, way: Walk | FromAnyStart) -> Iterator[Rows]:
    """A file of rows to go on with, or a new one: JSON lines, of which the first says how the scans are registered.

    A last line that was cut off by a kill is taken away.

    Args:
        path: the file.
        way: how scans are registered.

    Raises:
        RowsError: it is no such file, or its rows come from another model, other maps or settings.
    """
    head = {"format": FORMAT, **way.head}
    found: list[Row] = []
    if path.exists() and path.stat().st_size:
        content = path.read_bytes()
        whole = content[: content.rfind(b"\n") + 1]
        first, *found = _parsed(path, whole)
        if first != head:
            raise RowsError(
                f"{path}: was made with {'other maps' if 'maps' in head else 'another model'} or settings; {_REMEDY}"
            )
    else:
        whole = b""
    with path.open("r+b" if path.exists() else "x+b") as file:
        file.truncate(len(whole))
        file.seek(len(whole))

        def append(row: Row) -> None:
            file.write(json.dumps(row, allow_nan=False).encode() + b"\n")
            file.flush()
            os.fsync(file.fileno())
            found.append(row)

        if not whole:
            append(head)
            found.clear()
        yield Rows(found, append)


def _parsed(path: Path, content: bytes) -> list[Row]:
    try:
        rows = [json.loads(line) for line in content.decode().splitlines()]
    except ValueError as error:
        raise RowsError(f"{path}: no file of poses ({error}); {_REMEDY}") from error
    if not rows or not all(isinstance(row, dict) for row in rows) or rows[0].get("format") != FORMAT:
        raise RowsError(f"{path}: no file of poses; {_REMEDY}")
    return rows


def missing(scans: list[Path], rows: list[Row]) -> list[Path]:
    """The scans that have no row.

    Raises:
        RowsError: one has changed since.
    """
    done = {row["file"]: row for row in rows}
    for path in scans:
        row = done.get(path.name)
        if row and any(row[name] != value for name, value in _named(path).items()):
            raise RowsError(
                f"{path} has changed since it was registered; name another file, or replace it with --force"
            )
    return [path for path in scans if path.name not in done]


def register_all(tasks: list[ScanTask], executor: Executor, in_flight: int, append: Callable[[Row], None]) -> None:
    """Register scans in any executor, and append each row as soon as it is there.

    Raises:
        BrokenExecutor: workers were lost.
    """
    share_out(register_file, tasks, executor, in_flight, append)
