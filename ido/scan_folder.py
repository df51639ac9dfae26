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
from ido.scans import ScanSettings, as_json, register_scan

FORMAT = "ido-poses-1"

Row = dict[str, Any]
"""What was found of a scan: its file, its size and time, and what `as_json` has of it, or the error."""


_REMEDY = "name another file, or replace it with --force"


class RowsError(ValueError):
    """A file of rows cannot be gone on with; the message says why and what to do."""


@dataclass(frozen=True, slots=True)
class ScanTask:
    """A scan to register; what a worker gets."""

    file: str
    maps: str
    histogram: str | None
    settings: ScanSettings


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
        return row | as_json(register_scan(_maps(task.maps, task.histogram), task.file, task.settings))
    except CloudError as error:
        return row | {"error": str(error)}


@cache
def _maps(maps: str, histogram: str | None) -> Any:
    return maps_of(maps, histogram)


def _named(path: Path) -> Row:
    state = path.stat()
    return {"file": path.name, "bytes": state.st_size, "modified": state.st_mtime}


@dataclass(frozen=True, slots=True)
class Rows:
    """The rows of a file, and how to add one; made by `open_rows`."""

    found: list[Row]
    append: Callable[[Row], None]


@contextmanager
def open_rows(path: Path, maps: str, settings: ScanSettings) -> Iterator[Rows]:
    """A file of rows to go on with, or a new one: JSON lines, of which the first says how the scans are registered.

    A last line that was cut off by a kill is taken away.

    Args:
        path: the file.
        maps: the maps' file or shipped name.
        settings: how scans are registered.

    Raises:
        RowsError: it is no such file, or its rows come from other maps or settings.
    """
    fingerprint = hashlib.sha256(place_of(maps).read_bytes()).hexdigest()[:16]
    head = {"format": FORMAT, "maps": fingerprint, **asdict(settings)}
    found: list[Row] = []
    if path.exists() and path.stat().st_size:
        content = path.read_bytes()
        whole = content[: content.rfind(b"\n") + 1]
        first, *found = _parsed(path, whole)
        if first != head:
            raise RowsError(
                f"{path}: was made with other maps or settings; name another file, or replace it with --force"
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
