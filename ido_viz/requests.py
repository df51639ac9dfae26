"""What a person asks of a page: every widget, key and gesture, as a change of its state."""

from __future__ import annotations

import random
import time
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

from ido.types import FloatArray
from ido_viz.canvas.canvas import point_at
from ido_viz.core.actions import Actions
from ido_viz.core.changes import (
    lent_by,
    looked_inside,
    played,
    still,
    with_bin,
    with_method,
    with_paper_defaults,
    with_seed,
    with_start,
    within_run,
)
from ido_viz.core.history import History
from ido_viz.core.inside import STEP
from ido_viz.core.state import NO_CAMERA, NO_POINT, NO_START, OF_SCENE, State, StateError, decode, with_values
from ido_viz.core.sweep_results import Choice
from ido_viz.live_state import AFTER_A_CHANGE, AFTER_LETTING_GO, IN_HAND, LiveState

FIRST_LOOK = 2.0
"""Seconds that a new page stands still before it plays."""

_LARGEST_NEW_SEED = 9_999  # short enough to be told across a room


class Requests(LiveState):
    """What can be asked of a page; as `LiveState`, called on threads of the server."""

    def _actions(self) -> Actions:
        """What the widgets call."""
        return Actions(
            changed=self._changed,
            play=self._play,
            step=self._step,
            jump=self._jump,
            new_seed=self._new_seed,
            paper_defaults=self._paper_defaults,
            apply_code=self._apply_code,
            link=self._link,
            copy_link=self._copy_link,
            cancel=self._live.cancel,
            compare=lambda: self._begin(self._comparison.begin),
            cancel_comparison=self._comparison.cancel,
            map_basin=lambda: self._begin(self._basin.begin),
            cancel_basin=self._cancel_basin,
            show_method=self._show_method,
            show_shape=self._show_shape,
            open_scene=self._open_scene,
            open_page=self._open_page,
            show_all=lambda: self._change(lambda state: replace(state, hidden=()), show=True),
            inspect=self._inspect,
            set_values=self._set_values,
            click=self._click,
            pick=self._pick,
            clear=self._clear,
            grab=self._grab,
            gesture=self._hand_does,
            look=self._look,
            look_inside=self._look_inside,
            to_beat=self._to_beat,
            seen=self._seen,
            reset_view=lambda: self._change(lambda state: replace(state, camera=NO_CAMERA), show=True),
            undo=self._undo,
            redo=self._redo,
            redraw=self._wake,
            shown=lambda: self._visit.drawn,
        )

    # The scene and the methods

    def _set_values(self, values: Mapping[str, Any]) -> None:
        if values.keys() & {"rotation", "translation"}:
            values = {**values, "start": NO_START}
        wait = AFTER_A_CHANGE if values.keys() & (OF_SCENE | {"shape"}) else None
        self._change(lambda state: with_values(state, values), show=True, replays_after=wait)

    def _new_seed(self) -> None:
        seed = random.randint(0, _LARGEST_NEW_SEED)
        self._change(lambda state: with_seed(state, seed), show=True, replays_after=AFTER_A_CHANGE)

    def _paper_defaults(self) -> None:
        self._change(
            lambda state: with_paper_defaults(state, self._library.subject(state.shape)),
            show=True,
            replays_after=AFTER_A_CHANGE,
        )

    def _show_method(self, method: str, pane: str) -> None:
        def placed(state: State) -> State:
            if method not in self._library.methods(state.shape):  # of a shape shown before
                self._tell("This method is not there", f"{method} cannot register {state.shape}.")
                return state
            return with_method(state, method, pane)

        self._change(placed, show=True)

    def _show_shape(self, shape: str) -> None:
        self._change(lambda state: self._library.at_shape(state, shape), show=True, replays_after=AFTER_A_CHANGE)

    def _open_scene(self, choice: Choice) -> None:
        self._change(lambda state: self._library.checked(choice.at(state)), show=True)

    def _cancel_basin(self) -> None:
        self._basin.cancel()
        self._wake()

    def _open_start(self, number: int) -> None:
        self._change(
            lambda state: with_start(state, self._library.subject(state.shape), number),
            show=True,
            replays_after=AFTER_A_CHANGE,
        )

    # Playing

    def _play(self) -> None:
        def toggled(state: State) -> State:
            if state.playing:
                return replace(state, playing=False)
            state = played(state, self._run)
            self._visit.clock.start(0.0 if state.inside > 0 else state.iteration)
            return state

        self._change(toggled)

    def _step(self, by: int) -> None:
        self._change(lambda state: self._at(still(state), max(0, self._shown(state) + by)))

    def _jump(self, iteration: int) -> None:
        self._change(lambda state: self._at(still(state), iteration))

    def _look_inside(self) -> None:
        def toggled(state: State) -> State:
            return still(state) if state.inside > 0 else self._inside(state, STEP, playing=True)

        self._change(toggled)

    def _to_beat(self, beat: float) -> None:
        self._change(lambda state: self._inside(state, beat, playing=False) if beat > 0 else still(state))

    def _inside(self, state: State, position: float, *, playing: bool) -> State:
        """The state in the slow motion of an iteration, of a method with maps and a model point of it."""
        inside = looked_inside(state, self._run, position, playing=playing)
        if inside is None:
            self._tell("There is nothing to look into", "Show a method that learns maps, such as DO or Improved DO.")
            return state
        if state.inspected == NO_POINT:
            self._lent = inside.inspected
        self._visit.clock.start(inside.iteration)
        return inside

    def _seen(self) -> None:
        with self._awake:
            visit = self._visit
            if visit.first_look and visit.clock.waits:  # nobody has stepped or changed anything yet
                visit.clock.start(0.0, FIRST_LOOK)
            visit.first_look, visit.is_seen = False, True
        self._wake()

    # The 3D view, and what is looked into

    def _look(self, camera: tuple[float, ...]) -> None:
        with self._awake:  # asks for no frame: nothing but the address has to be written anew
            self._state = replace(self._state, camera=camera)
            self._awake.notify()

    def _grab(self, pane: int, phase: str, T_handles: FloatArray) -> None:
        drawn = self._visit.drawn
        start = None if drawn is None else self._visit.hand.start_pose(drawn, pane, phase, T_handles)
        if start is not None:
            wait = AFTER_LETTING_GO if phase == "end" else IN_HAND
            at_start = {"iteration": 0, "playing": False, "inside": 0.0}  # where it is in the hand
            self._change(lambda state: replace(state, start=start, **at_start), show=True, replays_after=wait)

    def _hand_does(self, number: int, holds: bool) -> None:
        with self._awake:
            self._gesture, held, self._visit.holds = number, self._visit.holds, holds
            if holds != held and self._visit.in_hand and self._state.playing and self._visit.clock.waits:
                self._visit.clock.start(0.0, IN_HAND if holds else AFTER_LETTING_GO)
                self._awake.notify()

    def _click(self, origin: FloatArray, direction: FloatArray, places: FloatArray) -> None:
        run = self._run
        found = point_at(run, origin, direction, places) if run else None
        if found:
            self._change(lambda state: replace(state, inspected_pane=found[0], inspected=found[1]))
            self._open_inspect()
        else:
            self._clear()

    def _pick(self, kind: str, pane: int, place: float) -> None:
        if kind == "start":
            self._open_start(int(place))
            return
        drawn = self._visit.drawn
        if drawn is None:
            return
        self._change(lambda state: with_bin(state, drawn.sides[pane], kind, place))
        if kind != "bin":
            self._open_inspect()

    def _clear(self) -> None:
        if self._state.inside > 0:
            self._change(still)
        elif self._state.inspected != NO_POINT or self._state.scene_point != NO_POINT:
            self._change(lambda state: replace(state, inspected=NO_POINT, scene_point=NO_POINT))

    def _inspect(self, changes: dict[str, Any]) -> None:
        self._change(lambda state: replace(state, **within_run(changes, state, self._run)))

    def _open_inspect(self) -> None:
        if self._visit.page is not None:
            self._visit.page.open_tab("Inspect")

    # Whole pages

    def _undo(self) -> None:
        self._go_to(History.undone, "There is nothing to undo", "What you change on this page can be taken back here.")

    def _redo(self) -> None:
        self._go_to(History.redone, "There is nothing to redo", "What is taken back with Undo can be done again here.")

    def _go_to(self, there: Callable[[History], History], nowhere: str, why: str) -> None:
        def gone(state: State) -> State:
            here = self._history.with_state(self._returned(state), time.perf_counter(), self._gesture)
            self._history = there(here)
            if self._history is here:
                self._visit.client.add_notification(nowhere, why, auto_close_seconds=4.0)
                return state
            self._lent = NO_POINT
            return self._history.now

        self._change(gone, show=True)

    def _apply_code(self, code: str) -> None:
        try:
            state = self._library.checked(decode(code))
        except StateError as error:
            self._tell("This code cannot be used", str(error))
            self._wake()  # brings the page's own code back
            return

        self._open_page(state, whole=True)

    def _open_page(self, state: State, *, whole: bool = False) -> None:
        """Show a prepared page; unless the whole of it is wanted, it keeps the look that was chosen for the room."""

        def begin(now: State) -> State:
            self._visit.in_hand = False
            self._lent = lent_by(state)
            self._visit.clock.start(max(state.iteration, 0), FIRST_LOOK if state.iteration == 0 else 0.0)
            if whole:
                return state
            return replace(state, dark=now.dark, large_text=now.large_text, hidden=now.hidden)

        self._change(begin, show=True)

    def _link(self) -> str:
        with self._awake:
            if self._visit.page is None:
                return self._visit.address
            self._read()  # a tick may be told of later than the click
            return f"{self._visit.address}#{self._visit.page.fragment(self._state)}"

    def _copy_link(self) -> None:
        if self._visit.page is not None:
            link = self._link()
            self._visit.page.copy(link)
            self._visit.client.add_notification(
                "Link copied", "Opened in a browser, it shows this page.", auto_close_seconds=4.0
            )
