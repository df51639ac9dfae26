"""Results on disk: one SQLite file, one row for each registration.

The file is in WAL mode: what was appended survives a kill, and others may read while a run writes. A run keeps a
transaction open all the time, so that no second run can write to the same file.
"""

from __future__ import annotations

import json
import math
import sqlite3
from collections.abc import Iterable, Iterator, Mapping
from contextlib import closing, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple, get_type_hints

import numpy as np

from ido.results import Results

Settings = Mapping[str, object]
"""Settings by name, plain values."""

Key = tuple[str, str, str, float, int]
"""Which registration: dataset, method, sweep, level, trial."""

VERSION = 2
"""Of the tables; a file of another version is refused."""


class StoreError(ValueError):
    """A results file that is missing, foreign, damaged, in use, or holds what must not be mixed with the new rows."""


class Row(NamedTuple):
    """One registration, the fields of `Results` in their order. What is not known is NaN."""

    dataset: str
    method: str
    sweep: str
    level: float
    trial: int
    seed: int
    accuracy: float
    rmse: float
    rotation: float
    translation: float
    seconds: float
    iterations: int
    stop: str
    probability: float


_KEY = "dataset, method, sweep, level, trial"
_COLUMNS = ", ".join(Row._fields)
_INSERT = (
    f"INSERT INTO registrations ({_COLUMNS}) VALUES ({', '.join('?' * len(Row._fields))}) "
    f"ON CONFLICT ({_KEY}) DO NOTHING"
)
_APPLICATION_ID = int.from_bytes(b"IDOx")  # in the head of the file, for `file` and for us
_WAIT = 2.0  # seconds for another's lock; a reader that closes holds one for an instant
_SCHEMA = (
    "CREATE TABLE datasets (name TEXT PRIMARY KEY, settings TEXT NOT NULL)",
    """CREATE TABLE methods (
        dataset TEXT NOT NULL REFERENCES datasets (name),
        name TEXT NOT NULL,
        settings TEXT NOT NULL,
        PRIMARY KEY (dataset, name)
    )""",
    f"""CREATE TABLE registrations (
        dataset TEXT NOT NULL,
        method TEXT NOT NULL,
        sweep TEXT NOT NULL,
        level REAL NOT NULL,
        trial INTEGER NOT NULL,
        seed INTEGER NOT NULL,
        accuracy REAL NOT NULL,
        rmse REAL,
        rotation REAL,
        translation REAL,
        seconds REAL NOT NULL,
        iterations INTEGER NOT NULL,
        stop TEXT NOT NULL,
        probability REAL,
        UNIQUE ({_KEY}),
        FOREIGN KEY (dataset, method) REFERENCES methods (dataset, name)
    )""",  # SQLite stores NaN as NULL
    f"PRAGMA application_id = {_APPLICATION_ID}",
    f"PRAGMA user_version = {VERSION}",
)


@dataclass(frozen=True, slots=True)
class Store:
    """An open results file; made by `open` or `view`."""

    _connection: sqlite3.Connection

    @classmethod
    @contextmanager
    def open(
        cls, path: Path, datasets: Mapping[str, Settings], methods: Mapping[tuple[str, str], Settings]
    ) -> Iterator[Store]:
        """Open a file to append to, or make it.

        Args:
            path: the file.
            datasets: how the scenes of each dataset are made.
            methods: the settings of each (dataset, method) that rows will be appended for.

        Raises:
            StoreError: the file is foreign, damaged, of another version or in use by another run; or it holds rows of
                the same dataset or method with other settings.
        """
        check_folder(path)
        with _clear_errors(path), closing(_connect(path, "rwc")) as connection:
            _check(connection, path)
            connection.execute("PRAGMA journal_mode = WAL")
            connection.execute("PRAGMA foreign_keys = ON")
            store = cls(connection)
            store._begin()
            if _is_empty(connection):
                for statement in _SCHEMA:
                    connection.execute(statement)
            store._add_settings(path, datasets, methods)
            store.append(())
            yield store

    @classmethod
    @contextmanager
    def view(cls, path: Path) -> Iterator[Store]:
        """Open a file to read, also while a run writes to it.

        Raises:
            StoreError: the file is missing, foreign, damaged or of another version.
        """
        if not path.is_file():
            raise StoreError(f"{path}: no such file; make one with `ido experiment run`")
        with _clear_errors(path), closing(_connect(path, "ro")) as connection:
            _check(connection, path)
            if _is_empty(connection):
                raise StoreError(f"{path}: holds no results; make some with `ido experiment run`")
            yield cls(connection)

    def append(self, rows: Iterable[Row]) -> None:
        """Write rows, all or none. A registration that is there already stays as it is.

        Raises:
            StoreError: the file cannot be written.
        """
        self._begin()
        self._connection.executemany(_INSERT, rows)
        self._connection.execute("COMMIT")
        self._begin()

    def recorded(self) -> set[Key]:
        """Which registrations are there."""
        return set(self._connection.execute(f"SELECT {_KEY} FROM registrations"))

    def results(self) -> Results:
        """All registrations, ordered by dataset, method, sweep, level and trial."""
        rows = self._connection.execute(f"SELECT {_COLUMNS} FROM registrations ORDER BY {_KEY}").fetchall()
        columns = zip(*rows, strict=True) if rows else [()] * len(Row._fields)
        kinds = get_type_hints(Row).values()
        return Results(*(np.array(column, dtype=kind) for column, kind in zip(columns, kinds, strict=True)))

    def methods(self) -> dict[tuple[str, str], dict[str, Any]]:
        """Settings of each (dataset, method). An infinite number is the text "inf"."""
        rows = self._connection.execute("SELECT dataset, name, settings FROM methods")
        return {(dataset, name): json.loads(settings) for dataset, name, settings in rows}

    def _begin(self) -> None:
        if not self._connection.in_transaction:
            self._connection.execute("BEGIN IMMEDIATE")

    def _add_settings(
        self, path: Path, datasets: Mapping[str, Settings], methods: Mapping[tuple[str, str], Settings]
    ) -> None:
        scenes = dict(self._connection.execute("SELECT name, settings FROM datasets"))
        for name in datasets.keys() & scenes.keys():
            _refuse_change(path, f"the scenes of {name}", json.loads(scenes[name]), datasets[name])
        recorded = self.methods()
        for dataset, name in methods.keys() & recorded.keys():
            _refuse_change(path, f"{name} on {dataset}", recorded[dataset, name], methods[dataset, name])
        self._connection.executemany(
            "INSERT OR IGNORE INTO datasets VALUES (?, ?)",
            [(name, _as_json(settings)) for name, settings in datasets.items()],
        )
        self._connection.executemany(
            "INSERT OR IGNORE INTO methods VALUES (?, ?, ?)",
            [(*key, _as_json(settings)) for key, settings in methods.items()],
        )


def check_folder(path: Path) -> None:
    """Whether a file can be there at all, which is known before any work.

    Raises:
        StoreError: there is no such folder.
    """
    if not path.parent.is_dir():
        raise StoreError(f"{path.parent}: no such folder")


def _connect(path: Path, mode: str) -> sqlite3.Connection:
    return sqlite3.connect(f"{path.resolve().as_uri()}?mode={mode}", uri=True, timeout=_WAIT, isolation_level=None)


def _is_empty(connection: sqlite3.Connection) -> bool:
    """Whether nothing was ever written, as when a run is killed before its first."""
    return connection.execute("SELECT 1 FROM sqlite_master").fetchone() is None


def _check(connection: sqlite3.Connection, path: Path) -> None:
    (application,) = connection.execute("PRAGMA application_id").fetchone()
    (version,) = connection.execute("PRAGMA user_version").fetchone()
    if _is_empty(connection) and not application:
        return
    if application != _APPLICATION_ID:
        raise StoreError(f"{path}: not a results file of `ido experiment run`; choose another one")
    if version != VERSION:
        raise StoreError(
            f"{path}: its version is {version}, this program writes version {VERSION}; choose another file, or use "
            "the program that made it"
        )
    if connection.execute("PRAGMA quick_check").fetchone() != ("ok",):
        raise StoreError(_damaged(path))


def _refuse_change(path: Path, what: str, old: Settings, settings: Settings) -> None:
    new = json.loads(_as_json(settings))
    changes = [
        f"{name} {old.get(name)} there, {new.get(name)} here"
        for name in sorted(old.keys() | new.keys())
        if old.get(name) != new.get(name)
    ]
    if changes:
        raise StoreError(
            f"{path}: {what} was recorded with other settings ({'; '.join(changes)}); rows of both would falsify the "
            "table. Choose another file, or set the settings back"
        )


def _as_json(settings: Settings) -> str:
    """Standard JSON, which knows no infinity."""
    plain = {
        name: str(value) if isinstance(value, float) and not math.isfinite(value) else value
        for name, value in settings.items()
    }
    return json.dumps(plain, sort_keys=True, allow_nan=False)


def _damaged(path: Path) -> str:
    return f"{path}: damaged, or not a results file of `ido experiment run`; choose another one"


@contextmanager
def _clear_errors(path: Path) -> Iterator[None]:
    try:
        yield
    except sqlite3.Error as error:
        kind = getattr(error, "sqlite_errorname", "")  # absent where Python itself complains
        if kind.startswith(("SQLITE_BUSY", "SQLITE_LOCKED")):
            raise StoreError(
                f"{path}: another run is writing to it; wait for its end or choose another file"
            ) from error
        if kind.startswith(("SQLITE_CORRUPT", "SQLITE_NOTADB")):
            raise StoreError(_damaged(path)) from error
        raise StoreError(f"{path}: {error}") from error
