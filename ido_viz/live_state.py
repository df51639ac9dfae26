"""The state of a page while it is served: read from its widgets, changed under a lock, and a wake-up for who draws."""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import replace

import viser

from ido_viz.core.basin import Basin
from ido_viz.core.changes import at_iteration, held_at_start, lent_by
from ido_viz.core.clock import Clock
from ido_viz.core.comparison import Comparison
from ido_viz.core.frame import Frame, shown_iteration
from ido_viz.core.hand import Hand
from ido_viz.core.history import History
from ido_viz.core.library import Library
from ido_viz.core.live_run import LiveRun
from ido_viz.core.run import Run, scene_inputs
from ido_viz.core.state import NO_POINT, State, StateError
from ido_viz.page import Page

AFTER_A_CHANGE = 0.7
"""Seconds without another change of the scene, after which it is played."""

IN_HAND = 60.0
"""The same while a slider or the handles are held."""

AFTER_LETTING_GO = 0.3
"""The same once they were let go."""


class Visit:
    """A page of one connection. When that ends, its session goes on for a while, and may have another.

    Args:
        client: the tab.
        state: what it begins with.
        address: of its page, without the fragment.
    """

    def __init__(self, client: viser.ClientHandle, state: State, address: str) -> None:
        self.client = client
        self.address = address
        self.page: Page | None = None  # built by the thread
        self.read_controls = False  # whether the controls may have other values than the state
        self.drawn: Frame | None = None
        self.closed = False
        self.clock = Clock(max(state.iteration, 0))
        self.is_seen = False  # whether the page has told that it can be seen
        self.first_look = False  # whether a page that plays has yet to be seen
        self.in_hand = False  # whether what is waited for is the end of a change
        self.hand = Hand()
        self.holds = False  # whether a slider is held


class LiveState:
    """A page's state, what is computed of it, and how both are changed.

    All of it is called on threads of the server, returns at once, and wakes whoever draws.

    Args:
        client: the tab.
        library: shapes and methods on offer.
        state: what it begins with.
        address: of its page, without the fragment.
    """

    def __init__(self, client: viser.ClientHandle, library: Library, state: State, address: str = "") -> None:
        self._library = library
        self._awake = threading.Condition()
        self._run: Run | None = None
        self._live = LiveRun(library, self._wake)
        self._comparison = Comparison(library, self._wake)
        self._basin = Basin(library, self._wake)
        self._history = History(state)
        self._gesture = 0  # number of what the hand does
        self._lent = lent_by(state)
        self._state = state
        self._dirty = True
        self._visit = Visit(client, state, address)

    def _visited_by(self, client: viser.ClientHandle, state: State, address: str) -> None:
        """Go on with another page, which is yet to be built."""
        self._state = state
        self._dirty = True
        self._visit = Visit(client, state, address)

    def _change(
        self, change: Callable[[State], State], *, show: bool = False, replays_after: float | None = None
    ) -> None:
        with self._awake:
            if show or self._visit.read_controls:  # what was asked before comes first, and must not be written over
                self._read()
            try:
                self._state = change(self._state)
            except StateError as error:
                self._tell("This cannot be shown", str(error))
                return
            if replays_after is not None and self._state.replay:
                self._replay(replays_after)
            if show and self._visit.page is not None:
                self._visit.page.show(self._state)
            self._dirty = True
            self._awake.notify()

    def _changed(self) -> None:
        with self._awake:
            self._visit.read_controls = True
            self._dirty = True
            self._awake.notify()

    def _wake(self) -> None:
        with self._awake:
            self._dirty = True
            self._awake.notify()

    def _read(self) -> None:
        """Take over the controls' values, and show at once what became of them: later, they may have others."""
        if self._visit.page is None:  # still being built
            return
        self._visit.read_controls = False
        before = self._state
        self._state, usable = self._visit.page.read(before)
        if self._state.shape != before.shape:
            self._state = self._library.at_shape(self._state, self._state.shape)
        if self._state.replay and scene_inputs(self._state) != scene_inputs(before):
            self._replay(AFTER_A_CHANGE)
        if not usable or self._state.shape != before.shape:
            self._visit.page.show(self._state)

    def _returned(self, state: State) -> State:
        """A state without the model point that the slow motion has chosen, for nobody had."""
        return replace(state, inspected=NO_POINT) if state.inspected == self._lent else state

    def _leave_deleted(self) -> None:
        """Go to the first shape when the page's own was deleted, also when undo leads there."""
        gone = self._state.shape
        if gone in self._library.subjects:
            return
        first = next(iter(self._library.subjects))
        self._state = self._library.at_shape(self._state, first)
        self._history = replace(self._history, now=self._state)  # no change to take back, or undo would end here
        self._tell("This cloud is gone", f"{gone} is not kept on this server any more; the page shows {first}.")
        if self._visit.page is not None:
            self._visit.page.show(self._state)

    def _replay(self, wait: float) -> None:
        """Show the start, and play after so many seconds without another change; called with the lock held."""
        self._state = held_at_start(self._state)
        self._visit.clock.start(0.0, IN_HAND if self._visit.holds else wait)
        self._visit.first_look, self._visit.in_hand = False, True

    def _shown(self, state: State) -> int:
        """The iteration that a state shows."""
        return shown_iteration(self._run, state) if self._run else 0

    def _at(self, state: State, iteration: int) -> State:
        """The state at an iteration; at the end it stays at the end when the run changes."""
        return at_iteration(state, iteration, self._run.iterations if self._run and not self._live.waiting else 0)

    def _tell(self, title: str, body: str) -> None:
        self._visit.client.add_notification(title, body, color="red", auto_close_seconds=8.0)

    def _begin(self, begin: Callable[[State], None]) -> None:
        """Begin work in the background for the newest state."""
        with self._awake:
            if self._visit.closed:
                return
            if self._visit.read_controls:
                self._read()
            begin(self._state)
        self._wake()
