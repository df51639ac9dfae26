"""A browser tab without a browser: its page only takes notes."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, replace
from typing import Any, cast

import viser

from ido import Perturbation, Scene
from ido_viz.core.actions import Actions
from ido_viz.core.address import fragment_of
from ido_viz.core.basin import Basin
from ido_viz.core.comparison import Comparison
from ido_viz.core.frame import Frame
from ido_viz.core.library import Library, Subject, shipped_library
from ido_viz.core.run import Run, make_scene
from ido_viz.core.state import State
from ido_viz.own.own_scan import LastScan
from ido_viz.own.workshop import Workshop
from ido_viz.session import Session

PATIENCE = 40.0  # seconds; only a failing test waits that long
QUIET = 0.2  # seconds without a frame after which nothing more is to come
LENGTH = 12
PAUSED = State(
    perturbation=Perturbation(points=100, outliers=0, rotation=30.0),
    max_iterations=LENGTH,
    iteration=0,
    playing=False,
    replay=False,
)
OF_INSPECT = ("inspected", "scene_point", "inspected_pane", "question", "coloring", "against_reference")
NOT_WIDGETS = ("iteration", "playing", "inside", "start", "camera", *OF_INSPECT)  # that are read


@dataclass(frozen=True)
class Drawn:
    """What was drawn."""

    state: State
    run: Run
    iteration: int
    held: bool
    """Whether the start is shown before it plays."""
    at: float
    """When, seconds."""


class Widgets:
    """Stands for a page's widgets where there is no page: what is written there."""

    def __init__(self) -> None:
        self.written: list[str] = []

    def reset(self) -> None:
        self.written.clear()

    def add_html(self, content: str) -> None:
        self.written.append(content)


class Noted(threading.Condition):
    """A condition that tells whether somebody waits for it."""

    is_awaited = False

    def wait(self, timeout: float | None = None) -> bool:
        self.is_awaited = True
        try:
            return super().wait(timeout)
        finally:
            self.is_awaited = False


class Tab:
    """A browser tab as its session knows it, with widgets that hold values, and a person who uses them."""

    def __init__(self, state: State = PAUSED, library: Library | None = None) -> None:
        self.client_id = id(self)
        self.frames: list[Drawn] = []
        self.moves: list[Frame] = []
        self.beats: list[Frame] = []  # of the slow motion of an iteration
        self.opened: list[str] = []  # tabs
        self.notes: list[str] = []
        self.gui = Widgets()
        self.widgets = state
        self.may_cancel = False
        self.basin = cast(Basin, None)
        self.shared: State | None = None
        self.actions = cast(Actions, None)
        self.last_sign_of_life = time.perf_counter()
        self.session = Session(cast(viser.ClientHandle, self), library or shipped_library(), state)
        self.session._awake = self._awake = Noted()
        self.session.start()

    def atomic(self) -> AbstractContextManager[None]:
        return nullcontext()

    def add_notification(self, title: str, body: str, **_: object) -> None:
        self.notes.append(f"{title}: {body}")

    @property
    def shown(self) -> Drawn:
        """The last frame."""
        return self.frames[-1]

    def set(self, **changes: Any) -> None:
        """Move widgets of the scene or of the page, as a person does."""
        values = {name: value for name, value in changes.items() if name in State.__slots__}
        rest = {name: value for name, value in changes.items() if name not in values}
        self.widgets = replace(self.widgets, perturbation=replace(self.widgets.perturbation, **rest), **values)
        self.actions.changed()

    def wait(self, what: str, until: Callable[[], bool]) -> None:
        """Wait until something is true."""
        deadline = time.perf_counter() + PATIENCE
        while not until():
            assert time.perf_counter() < deadline, f"waited in vain for {what}; notes: {self.notes}"
            assert self.is_served or until(), f"the session ended before {what}; notes: {self.notes}"
            time.sleep(0.002)

    def settle(self) -> Drawn:
        """Wait until nothing more is drawn; the last frame."""
        self.wait("a first frame", lambda: bool(self.frames))
        self.last_sign_of_life = time.perf_counter()
        self.wait("calm", lambda: time.perf_counter() - self.last_sign_of_life > QUIET and self.is_at_rest)
        return self.shown

    @property
    def is_at_rest(self) -> bool:
        """Whether all that was asked for is drawn, but for what is computed beside it."""
        with self._awake:
            return self._awake.is_awaited and not self.session._dirty

    @property
    def is_served(self) -> bool:
        """Whether the session's thread still runs."""
        return any(thread.name == f"session-{self.client_id}" for thread in threading.enumerate())


class PageOfTab:
    """Stands for the page: `read` takes the tab's widgets, `show` writes into them, `draw` and `move` are noted.

    Without a camera, it has seen its first frame as soon as that is drawn.
    """

    fail_reading = False

    def __init__(
        self,
        tab: Tab,
        library: Library,
        state: State,
        actions: Actions,
        step: str,
        workshop: Workshop | None,
        last_scan: LastScan,
    ) -> None:
        self.tab = tab
        tab.widgets, tab.actions = state, actions

    def close(self) -> None:
        pass

    def read(self, state: State) -> tuple[State, bool]:
        if self.fail_reading:
            raise RuntimeError("the widget is broken")
        return replace(self.tab.widgets, **{name: getattr(state, name) for name in NOT_WIDGETS}), True

    def show(self, state: State) -> None:
        self.tab.widgets = state

    def show_iteration(self, frame: Frame) -> None:
        pass

    def share(self, state: State) -> None:
        self.tab.shared = state

    def fragment(self, state: State) -> str:
        return fragment_of(state, "")

    def draw(self, frame: Frame, comparison: Comparison, basin: Basin, *, may_cancel: bool) -> None:
        self.tab.may_cancel, self.tab.basin = may_cancel, basin
        self.tab.frames.append(Drawn(frame.state, frame.run, frame.k, frame.held, time.perf_counter()))
        self.tab.last_sign_of_life = time.perf_counter()
        if len(self.tab.frames) == 1:
            self.tab.actions.seen()

    def open_tab(self, name: str) -> None:
        self.tab.opened.append(name)

    def draw_inside(self, frame: Frame) -> None:
        self.tab.beats.append(frame)
        self.tab.last_sign_of_life = time.perf_counter()

    def move(self, frame: Frame) -> None:
        self.tab.moves.append(frame)
        self.tab.last_sign_of_life = time.perf_counter()


class Computing:
    """The real computation, counted; it can be held, slowed and made to fail."""

    def __init__(self) -> None:
        self.states: list[State] = []
        self.go = threading.Event()
        self.go.set()
        self.seconds = 0.0
        self.failure: Exception | None = None

    def __call__(self, subject: Subject, state: State) -> Scene:
        self.states.append(state)
        assert self.go.wait(PATIENCE)
        time.sleep(self.seconds)
        if self.failure is not None:
            raise self.failure
        return make_scene(subject, state)
