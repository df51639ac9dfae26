"""What all pages of a server share of people's own clouds: the shelf, the queue, and the ways between them."""

from __future__ import annotations

import logging
import secrets
import tempfile
import threading
from collections.abc import Callable, Hashable
from dataclasses import replace
from functools import cached_property, partial
from pathlib import Path

from ido import SHAPES, Cloud, CloudError, MapsError, TrainingSettings
from ido.files.cloud_file import CloudFile, UsedPoints
from ido_viz.core.library import Library
from ido_viz.own.card import Card
from ido_viz.own.draft import UNITS, Draft, draft_of, open_upload, shown_name
from ido_viz.own.kept import KeptCloud
from ido_viz.own.learning import Order, learn, measure, measure_maps
from ido_viz.own.plans import Cost, measured_cost
from ido_viz.own.shelf import LEARNING, Shelf, ShelfError
from ido_viz.own.training_queue import QueuedJob, Told, TrainingQueue

_log = logging.getLogger(__name__)


class Workshop:
    """Clouds of one's own on one server.

    Args:
        library: what the server offers besides.
        folder: where clouds are kept.
        draft: that each new page begins with; None for none.
    """

    def __init__(self, library: Library, folder: Path, draft: Draft | None = None) -> None:
        self.draft = draft
        self.shelf = Shelf(library.subjects, folder)
        self.library = Library(self.shelf)
        """What pages offer: it changes with the shelf."""
        self._lock = threading.Lock()
        self._cards: dict[str, Path] = {}  # of shapes that the server began with
        self._reading = threading.Lock()  # one upload at a time takes memory
        self._watchers: list[Callable[[], None]] = []
        self._visitors: dict[Hashable, Callable[[], str]] = {}
        self.queue = TrainingQueue(self._tell)
        for name in self.shelf.kept:
            if self.shelf.card(name) is None:
                self._measure(name)

    def close(self) -> None:
        """End what is being learned."""
        self.queue.close()

    # Who is there

    def enter(self, visitor: Hashable, shape: Callable[[], str], changed: Callable[[], None]) -> None:
        """Take note of a page.

        Args:
            visitor: stands for it.
            shape: gives the name of the shape that it shows.
            changed: called on any thread when the shapes have changed.
        """
        self._visitors[visitor] = shape
        self.shelf.watch(changed)

    def leave(self, visitor: Hashable, changed: Callable[[], None]) -> None:
        """Undo `enter`; the page's training goes on."""
        if self._visitors.pop(visitor, None) is not None:
            self.shelf.unwatch(changed)
            self.queue.leave(visitor)

    def unit_of(self, name: str) -> str:
        """The unit of a shape; of those that the server began with it is not known."""
        return self.shelf.place(name).unit if name in self.shelf.kept else UNITS[0]

    def others_at(self, name: str, visitor: Hashable) -> int:
        """How many other pages show a shape."""
        return sum(shape() == name for other, shape in tuple(self._visitors.items()) if other != visitor)

    def watch(self, changed: Callable[[], None]) -> None:
        """Have a function called, on any thread, when trainings, cards or the shelf have changed."""
        self._watchers.append(changed)

    def unwatch(self, changed: Callable[[], None]) -> None:
        """Undo `watch`, if it was done."""
        if changed in self._watchers:
            self._watchers.remove(changed)

    def _tell(self) -> None:
        for changed in tuple(self._watchers):
            try:
                changed()
            except Exception:  # one page's trouble is none of the training's, nor of other pages
                _log.exception("a page could not show a training")

    # Files

    def open(self, name: str, content: bytes) -> tuple[CloudFile, UsedPoints]:
        """What an uploaded file holds.

        Raises:
            CloudError: it cannot be used.
        """
        with self._reading:
            try:
                return open_upload(name, content, self.shelf.folder)
            except MemoryError as error:
                raise CloudError(f"{shown_name(name)}: there is not enough memory for it; thin it") from error

    def drafted(self, name: str, content: bytes) -> tuple[Draft, Cost]:
        """The draft of an uploaded file, and what a training on it costs.

        Raises:
            CloudError: it cannot be used.
        """
        draft = draft_of(*self.open(name, content), name=shown_name(Path(name).stem))
        return draft, measured_cost(draft.cloud, draft.model)

    @cached_property
    def draft_cost(self) -> Cost | None:
        """What training on the draft that pages begin with costs, measured once; None where there is none."""
        return measured_cost(self.draft.cloud, self.draft.model) if self.draft else None

    # Learning

    def train(
        self, draft: Draft, settings: TrainingSettings, expected: float, limit: float | None, owner: Hashable
    ) -> QueuedJob:
        """Have maps learned; the cloud is offered from its first map on, and kept at the end.

        Args:
            draft: of the cloud.
            settings: of the training.
            expected: seconds that it should take.
            limit: seconds after which it ends with the maps that it has; None for none.
            owner: stands for the page that wants it.

        Raises:
            QueueError: it is not this person's turn.
            ShelfError: there is no room.
        """
        with self._lock:
            self.shelf.check_room()
            name = self._free_name(draft.name)
            file = self.shelf.folder / f"{secrets.token_hex(8)}{LEARNING}"
            order = Order(name, draft.unit, draft.up, draft.cloud, draft.model, settings, limit)
            job = QueuedJob(
                name,
                partial(learn, order, file),
                settings.maps,
                expected,
                told=partial(self._show, file, order.cloud),
                ended=partial(self._keep, file, order.cloud),
                owner=owner,
            )
            self.queue.submit(job)
        return job

    def _free_name(self, wanted: str) -> str:
        """A name that neither a shape nor a training has."""
        name, taken = self.shelf.free_name(shown_name(wanted)), {job.title for job in self.queue.trainings}
        number = 2
        while name in taken:
            name, number = self.shelf.free_name(f"{shown_name(wanted)} ({number})"), number + 1
        return name

    def _show(self, file: Path, cloud: Cloud, told: Told) -> None:
        if told.written:
            self.shelf.show(replace(KeptCloud.load(file), cloud=cloud))  # one cloud for all, which has one picture

    def _keep(self, file: Path, cloud: Cloud, job: QueuedJob) -> None:
        """At a training's end: keep what was learned, or nothing of it."""
        try:
            if job.cancelled or job.failure or not file.exists():
                self.shelf.withdraw(job.title)
            else:
                self.shelf.keep(replace(KeptCloud.load(file), cloud=cloud))
                self._measure(job.title)
        except BaseException:
            self.shelf.withdraw(job.title)
            raise
        finally:
            file.unlink(missing_ok=True)

    def _measure(self, name: str) -> None:
        """Have a kept cloud's card made when nobody waits for a training."""
        place = self.shelf.place(name)

        def ended(_: QueuedJob) -> None:
            if name not in self.shelf.kept:  # it was deleted meanwhile
                place.card.unlink(missing_ok=True)

        self.queue.submit(QueuedJob(name, partial(measure, place.maps, place.card), ended=ended))

    def is_given(self, name: str) -> bool:
        """Whether the server began with a shape of one's own, which has learned maps."""
        return name in self.shelf.given and name not in SHAPES and bool(self.shelf[name].maps)

    def judge(self, name: str) -> None:
        """Have the quality card of given maps made, once, unless it lies in the folder."""
        if not self.is_given(name):
            return
        with self._lock:
            if name in self._cards:
                return
            subject = self.shelf[name]
            maps = {method: load() for method, load in subject.maps.items()}
            path = self._cards[name] = self.shelf.folder / Card.name_of(maps)
        if Card.load(path) is None:  # submitted without the lock: pages are told, and may ask
            self.queue.submit(QueuedJob(name, partial(measure_maps, subject.cloud(), maps, path)))

    def card(self, name: str) -> Card | None:
        """The quality card of a kept cloud, or of given maps; None as long as there is none."""
        return Card.load(self._cards[name]) if name in self._cards else self.shelf.card(name)

    # What is kept

    def take_in(self, name: str, content: bytes) -> str:
        """Keep an uploaded maps file; the name that its cloud got.

        Raises:
            MapsError: it cannot be used.
            ShelfError: there is no room.
        """
        self.shelf.check_room()
        with self._reading, tempfile.TemporaryDirectory(dir=self.shelf.folder, prefix="upload-") as place:
            path = Path(place) / "file.npz"
            path.write_bytes(content)
            try:
                kept = KeptCloud.load(path, shown_name(Path(name).stem))
            except MapsError as error:
                raise MapsError(f"{shown_name(name)}: {str(error).removeprefix('file.npz: ')}") from error
        with self._lock:
            kept = replace(kept, name=self._free_name(kept.name))
            self.shelf.keep(kept)
        self._measure(kept.name)
        self._tell()
        return kept.name

    def given_away(self, name: str) -> bytes:
        """The file of a kept cloud, as it is downloaded.

        Raises:
            ShelfError: there is none of this name.
        """
        try:
            return self.shelf.place(name).maps.read_bytes()
        except OSError as error:
            raise ShelfError(f"the file of {name!r} cannot be read: {error.strerror}") from error

    def delete(self, name: str) -> None:
        """Delete a kept cloud; pages that show it go to another shape, and say so.

        Raises:
            ShelfError: there is none of this name.
            OSError: its files cannot be deleted.
        """
        self.shelf.place(name)
        self.shelf.withdraw(name)
        self._tell()
