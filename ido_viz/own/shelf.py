"""The shapes of a server: those that it began with, and clouds that people trained on it, kept in the app's folder."""

from __future__ import annotations

import secrets
import shutil
import threading
import time
from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from ido import MapsError
from ido.npz import MOST_BYTES, loaded, promises
from ido_viz.core.library import Subject
from ido_viz.own.card import Card
from ido_viz.own.draft import LONGEST_NAME, UPS
from ido_viz.own.kept import Head, KeptCloud, title_of

MOST_CLOUDS = 100
"""Clouds that are kept."""

LEARNING = ".learning"
"""Ending of the file of a cloud that is being learned."""

MOST_ON_DISK = MOST_BYTES
"""Bytes of all their files."""

_ABANDONED = 24 * 3600.0  # seconds without a change


class ShelfError(ValueError):
    """A cloud cannot be kept, found or deleted; the message says why and what to do."""


@dataclass(frozen=True, slots=True)
class Place:
    """Where a kept cloud lies, a file whose name says nothing, so that no cloud's name becomes a path; and its unit."""

    maps: Path
    unit: str

    @property
    def card(self) -> Path:
        """Its quality card."""
        return self.maps.with_suffix(".json")


class Shelf(Mapping[str, Subject]):
    """Shapes by name. It changes while the server runs, and tells those who watch; each shape is a value.

    Args:
        given: the shapes that it begins with; they are not in the folder, and stay.
        folder: where clouds are kept; made if it is not there.
    """

    def __init__(self, given: Mapping[str, Subject], folder: Path) -> None:
        folder.mkdir(parents=True, exist_ok=True)
        self.folder = folder
        self._unreadable: dict[Path, str] = {}
        self._lock = threading.RLock()
        self._watchers: list[Callable[[], None]] = []
        self._given = given
        self._kept: dict[str, Place] = {}
        self._subjects = dict(given)
        _tidy(folder)
        self.look_again()

    def __getitem__(self, name: str) -> Subject:
        return self._subjects[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._subjects)

    def __len__(self) -> int:
        return len(self._subjects)

    @property
    def unreadable(self) -> tuple[str, ...]:
        """What of the folder cannot be read, and why."""
        return tuple(f"{path.name}: {why}" for path, why in self._unreadable.items())

    @property
    def given(self) -> tuple[str, ...]:
        """Names of the shapes that it began with."""
        return tuple(self._given)

    @property
    def kept(self) -> tuple[str, ...]:
        """Names of the clouds in the folder."""
        return tuple(self._kept)

    def watch(self, changed: Callable[[], None]) -> None:
        """Have a function called, on any thread, whenever the shapes change; `unwatch` ends it."""
        self._watchers.append(changed)

    def unwatch(self, changed: Callable[[], None]) -> None:
        """Undo `watch`."""
        self._watchers.remove(changed)

    def look_again(self) -> None:
        """Take note of what other servers have kept in the folder, or deleted there."""
        with self._lock:
            kept = {place.maps: name for name, place in self._kept.items()}
            lying = set(self.folder.glob("[!.]*.npz"))  # one with a dot is being written
            self._unreadable = {path: why for path, why in self._unreadable.items() if path in lying}
            gone = [name for path, name in kept.items() if path not in lying]
            for name in gone:
                del self._kept[name]
            subjects = {name: subject for name, subject in self._subjects.items() if name not in gone}
            changed = bool(gone)
            for path in sorted(lying - kept.keys() - self._unreadable.keys()):
                try:
                    head = _head(path)
                except MapsError as error:
                    self._unreadable[path] = str(error)
                    continue
                name = free_name(head.name, subjects)
                self._kept[name] = Place(path, head.unit)
                subjects[name] = _subject(path, head)
                changed = True
            self._subjects = subjects
        if changed:
            self._tell()

    def free_name(self, wanted: str) -> str:
        """The name, or the name with a number, that no shape has."""
        return free_name(wanted, self._subjects)

    def check_room(self) -> None:
        """See that one cloud more can be kept.

        Raises:
            ShelfError: there are too many, or they take too much room.
        """
        self.look_again()
        if len(self._kept) >= MOST_CLOUDS:
            raise ShelfError(f"{MOST_CLOUDS} clouds are kept already; delete one first")
        if sum(path.stat().st_size for path in self.folder.glob("*.npz")) > MOST_ON_DISK:
            raise ShelfError(f"the kept clouds take {MOST_ON_DISK >> 30} GB already; delete one first")

    def show(self, kept: KeptCloud) -> None:
        """Offer a cloud, or what is newly learned on it, without keeping it."""
        with self._lock:
            self._put(kept.name, kept.subject())

    def keep(self, kept: KeptCloud) -> None:
        """Write a cloud to the folder, and offer it.

        Raises:
            ShelfError: there is no room, or it is given and cannot be replaced.
            OSError: it cannot be written.
        """
        with self._lock:
            self.check_room()
            if kept.name in self._given:
                raise ShelfError(f"there is a shape called {kept.name!r}; give the cloud another name")
            place = Place(self.folder / f"{secrets.token_hex(8)}.npz", kept.unit)
            kept.save(place.maps)
            self._kept[kept.name] = place
            self._put(kept.name, kept.subject())

    def withdraw(self, name: str) -> None:
        """Offer a cloud no more, and delete its files if it is kept.

        Raises:
            OSError: they cannot be deleted.
        """
        with self._lock:
            if name in self._given:
                return
            place = self._kept.get(name)
            if place is not None:
                place.maps.unlink(missing_ok=True)
                place.card.unlink(missing_ok=True)
                del self._kept[name]
            self._subjects = {other: subject for other, subject in self._subjects.items() if other != name}
        self._tell()

    def place(self, name: str) -> Place:
        """Where a kept cloud lies.

        Raises:
            ShelfError: there is none of this name.
        """
        if name not in self._kept:
            raise ShelfError(f"there is no kept cloud called {name!r} any more")
        return self._kept[name]

    def card(self, name: str) -> Card | None:
        """A kept cloud's quality card; None as long as there is none."""
        return Card.load(self._kept[name].card) if name in self._kept else None

    def _put(self, name: str, subject: Subject) -> None:
        self._subjects = {**self._subjects, name: subject}
        self._tell()

    def _tell(self) -> None:
        for changed in tuple(self._watchers):
            changed()


def free_name(wanted: str, taken: Collection[str]) -> str:
    """The name, or the name with a number, that is not taken."""
    name, number = wanted, 2
    while name in taken:
        end = f" ({number})"
        name, number = wanted[: LONGEST_NAME - len(end)] + end, number + 1
    return name


def _tidy(folder: Path) -> None:
    """Delete what servers that were killed left; what a running one writes is younger."""
    for path in (*folder.glob(f"*{LEARNING}"), *folder.glob("upload-*")):
        if time.time() - path.stat().st_mtime > _ABANDONED:
            shutil.rmtree(path) if path.is_dir() else path.unlink()


def _head(path: Path) -> Head:
    """What a file is, without reading its maps."""
    try:
        if promises(path)["kept"].size > 10_000:
            raise MapsError("its head is too long")
        return Head.of(loaded(path, ["kept"]))
    except MapsError:
        raise
    except Exception as error:  # zlib, zipfile and NumPy each raise their own
        raise MapsError(f"it is no kept cloud, or damaged ({error})") from error


def _subject(path: Path, head: Head) -> Subject:
    """A kept cloud as a shape; its file is read when it is first shown."""
    kept = cache(lambda: KeptCloud.load(path))
    return Subject(
        title_of(head.unit, complete=True),
        cloud=lambda: kept().cloud,
        maps={method: lambda method=method: kept().maps[method] for method in head.methods},
        up=UPS[head.up],
    )
