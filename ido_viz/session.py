"""One browser tab: controls -> state -> run -> frame, on one thread of its own.

Callbacks only record what was asked and wake the thread. It takes the newest state, computes the run when its inputs
changed, and draws one frame; whatever was asked meanwhile is drawn next, and what was overtaken never is.
"""

from __future__ import annotations

import html
import logging
import os
import threading
import time
from dataclasses import replace

import viser

from ido_viz.core.address import shared
from ido_viz.core.frame import frame_of
from ido_viz.core.inside import BEAT_SECONDS
from ido_viz.core.library import Library
from ido_viz.core.state import (
    BEATS,
    LAST,
    NO_POINT,
    NORMAL_SPEED,
    State,
    StateError,
)
from ido_viz.core.turns import Turns
from ido_viz.own.own_scan import LastScan
from ido_viz.own.workshop import Workshop
from ido_viz.page import Page
from ido_viz.requests import FIRST_LOOK, Requests

_TURNS = Turns(os.cpu_count() or 1)
"""Pages are drawn so many at once: more would take the processors from each other, and all be later."""

UNSEEN = 20.0
"""Seconds after which it plays even if the page never told that it shows anything."""

_log = logging.getLogger(__name__)


class Session(Requests):
    """Serves one tab from `start` until `close`.

    Args:
        client: the tab.
        library: shapes and methods on offer.
        state: what it begins with.
        address: of its page, without the fragment.
        step: of a lesson, that it begins with; empty for none.
        workshop: where clouds of one's own are trained and kept, whose library it is; None for no such tab.
    """

    def __init__(
        self,
        client: viser.ClientHandle,
        library: Library,
        state: State,
        address: str = "",
        step: str = "",
        workshop: Workshop | None = None,
    ) -> None:
        super().__init__(client, library, state, address)
        self._lesson_step = step
        self._workshop = workshop
        self._last_scan = LastScan()
        self._thread = self._new_thread()

    def start(self) -> None:
        """Build the page and begin to serve it."""
        if self._workshop is not None:
            self._workshop.enter(self._visit.client.client_id, lambda: self._state.shape, self._wake)
        self._thread.start()

    def close(self) -> None:
        """Stop for good; the thread ends by itself after the frame at work."""
        self.leave()
        with self._awake:
            self._live.close()
            self._comparison.cancel()
            self._basin.cancel()

    def leave(self) -> None:
        """Stop; what is computed goes on, for the page may come back."""
        if self._workshop is not None:
            self._workshop.leave(self._visit.client.client_id, self._wake)
        with self._awake:
            self._visit.closed = True  # from here on it can come back, as another client
            if self._visit.page is not None:
                self._visit.page.close()
            self._awake.notify()

    @property
    def can_come_back(self) -> bool:
        """Whether the thread has ended after `leave`."""
        return not self._thread.is_alive()

    def ends_within(self, seconds: float) -> bool:
        """Whether the thread has ended after `leave`, so that the page can come back; waited for so long."""
        self._thread.join(seconds)
        return self.can_come_back

    def come_back(self, client: viser.ClientHandle, state: State, address: str = "", step: str = "") -> None:
        """Serve a page again, of another connection: with what was computed, and what can be undone.

        Args:
            client: the page.
            state: that its address tells.
            address: of the page, without the fragment.
            step: of a lesson, that its address tells; empty for none.
        """
        state = self._state if shared(self._state) == shared(state) else state
        self._visited_by(client, state, address)
        self._lesson_step = step
        self._thread = self._new_thread()

    def _new_thread(self) -> threading.Thread:
        return threading.Thread(target=self._serve, name=f"session-{self._visit.client.client_id}", daemon=True)

    # The thread

    def _serve(self) -> None:
        visit = self._visit
        try:
            with _TURNS.turn(), visit.client.atomic():
                page = Page(
                    visit.client,
                    self._library,
                    self._state,
                    self._actions(),
                    self._lesson_step,
                    self._workshop,
                    self._last_scan,
                )
        except Exception as error:  # without a page there is nothing to serve, but a person must hear of it
            _log.exception("page failed")
            self._give_up(error)
            return
        visit.page = page
        if visit.closed:  # while it was built
            page.close()
        while True:
            with self._awake:
                wait = visit.clock.next_frame if self._state.playing else None
                if not self._dirty and not visit.closed:
                    self._awake.wait(wait)
                if visit.closed:
                    return
            try:
                with _TURNS.turn():
                    with self._awake:
                        if visit.closed:
                            return
                        state, share, asked = self._take()
                    page.share(state)  # before what may take long to compute
                    self._frame(page, state, share, asked)
            except StateError as error:
                self._fail("This cannot be shown", str(error))
            except Exception as error:  # the page must outlive whatever goes wrong in one frame
                _log.exception("frame failed")
                self._fail("Something went wrong", f"{type(error).__name__}: {error}")

    def _give_up(self, error: Exception) -> None:
        """Say on the page why there is none."""
        reason = f"{type(error).__name__}: {error}"
        self._visit.client.gui.reset()
        self._visit.client.gui.add_html(
            '<div data-no-page style="margin:8px;font-size:0.875rem"><b>This page cannot be shown.</b><br>'
            f"{html.escape(reason)}<br>Start the explorer without a code, or with another one.</div>"
        )
        self._tell("This page cannot be shown", reason)

    def _take(self) -> tuple[State, float, bool]:
        """The newest state, with the controls read and the playing moved on; called with the lock held.

        Also the share of the way to the next iteration, and whether anything but the playing asks for a frame.
        """
        asked, self._dirty = self._dirty, False
        share = 0.0
        self._leave_deleted()
        if self._visit.read_controls:
            self._read()
        state = self._state
        if state.playing and state.inside > 0:
            beats = self._visit.clock.passed() / BEAT_SECONDS * state.speed / NORMAL_SPEED
            inside = min(state.inside + beats, float(BEATS))
            state = replace(state, inside=inside, playing=inside < BEATS)
        elif state.playing and self._run is not None:
            self._visit.clock.tick(state.speed, moves=not self._live.waiting)  # both panes set out together
            state = self._at(state, int(self._visit.clock.position))
            share = self._visit.clock.position % 1.0
            if state.iteration == LAST or (self._run.iterations == 0 and not self._live.waiting):
                state = replace(state, playing=False)
        if state.inside == 0:
            state, self._lent = self._returned(state), NO_POINT
        self._state = state
        self._history = self._history.with_state(self._returned(state), time.perf_counter(), self._gesture)
        return state, share, asked

    def _frame(self, page: Page, state: State, share: float, asked: bool) -> None:
        visit = self._visit
        first = self._run is None
        begun = self._live.begin(state)
        with self._awake:
            if visit.closed:
                self._live.close()
                return
            run = self._live.collect()
            assert run is not None
            self._run = run
            visit.clock.follow(run)
            if first and begun and state.playing and state.iteration == 0:
                visit.clock.start(0.0, FIRST_LOOK if visit.is_seen else UNSEEN)
                visit.first_look = not visit.is_seen
        held = visit.in_hand and state.playing and visit.clock.waits
        drawn = visit.drawn
        if drawn and not asked and drawn.run is run and replace(drawn.state, camera=state.camera) == state:
            visit.drawn = drawn = replace(drawn, state=state)  # a person looks from elsewhere, which the page knows
        if drawn and not asked and (drawn.run, drawn.state, drawn.held) == (run, state, held):
            if state.playing and not held:  # nothing but the poses moves, on the way to the next iteration
                with visit.client.atomic():
                    page.move(drawn.on_the_way(share))
            return
        frame = frame_of(run, state, held=held)
        if drawn and not asked and drawn.run is run and replace(drawn.state, inside=state.inside) == state:
            with visit.client.atomic():
                page.draw_inside(frame)
                visit.drawn = frame
            return
        with visit.client.atomic():
            page.draw(frame, self._comparison, self._basin, may_cancel=self._live.slow)
            visit.drawn = frame
            if not self._dirty:  # the slider may have been dragged on meanwhile
                page.show_iteration(frame)

    def _fail(self, title: str, body: str) -> None:
        with self._awake:
            self._state = replace(self._state, playing=False)  # or it would fail again at once
        self._tell(title, body)
