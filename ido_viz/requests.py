"""What a person asks of a page: every widget, key and gesture, as a change of its state.

All of it is called on threads of the server, returns at once, and wakes whoever draws.
"""

from __future__ import annotations

import random
import threading
import time
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any, get_args

import viser

from ido import Perturbation
from ido.types import FloatArray
from ido_viz.canvas.canvas import point_at
from ido_viz.core.actions import Actions
from ido_viz.core.basin import STARTS, Basin, start_of
from ido_viz.core.clock import Clock
from ido_viz.core.comparison import Comparison
from ido_viz.core.frame import Frame, shown_iteration
from ido_viz.core.hand import Hand
from ido_viz.core.history import History
from ido_viz.core.inside import STEP, strongest_point
from ido_viz.core.inspection import inspect, inspected_number
from ido_viz.core.library import Library
from ido_viz.core.live_run import LiveRun
from ido_viz.core.run import Run, scene_inputs
from ido_viz.core.state import (
    BEATS,
    LAST,
    NO_CAMERA,
    NO_POINT,
    NO_START,
    OF_SCENE,
    Pane,
    State,
    StateError,
    decode,
    with_values,
)
from ido_viz.core.sweep_results import Choice
from ido_viz.page import Page

FIRST_LOOK = 2.0
"""Seconds that a new page stands still before it plays."""

AFTER_A_CHANGE = 0.7
"""Seconds without another change of the scene, after which it is played."""

IN_HAND = 60.0
"""The same while the handles are held."""

AFTER_LETTING_GO = 0.3
"""The same once they were let go."""

_LARGEST_NEW_SEED = 9_999  # short enough to be told across a room


class Requests:
    """A page's state, and what can be asked of it.

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
        self._arrive(client, state, address)

    def _arrive(self, client: viser.ClientHandle, state: State, address: str) -> None:
        """Begin with a page that is yet to be built."""
        self._client = client
        self._address = address
        self._state = state
        self._read_controls = False
        self._dirty = True
        self._closed = False
        self._page: Page | None = None  # built by the thread
        self._drawn: Frame | None = None
        self._clock = Clock(max(state.iteration, 0))
        self._first_look = False  # whether a page that plays has yet to be seen
        self._charts_are_old = False  # those of a page that had no size yet
        self._in_hand = False  # whether what is waited for is the end of a change
        self._hand = Hand()

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
            look=self._look,
            look_inside=self._look_inside,
            to_beat=self._to_beat,
            seen=self._seen,
            reset_view=lambda: self._change(lambda state: replace(state, camera=NO_CAMERA), show=True),
            undo=self._undo,
            redo=self._redo,
            redraw=self._wake,
            shown=lambda: self._drawn,
        )

    # How anything is asked

    def _change(
        self, change: Callable[[State], State], *, show: bool = False, replays_after: float | None = None
    ) -> None:
        with self._awake:
            if self._read_controls:  # what was asked before comes first
                self._read()
            try:
                self._state = change(self._state)
            except StateError as error:
                self._tell("This cannot be shown", str(error))
                return
            if replays_after is not None and self._state.replay:
                self._replay(replays_after)
            if show and self._page is not None:
                self._page.show(self._state)
            self._dirty = True
            self._awake.notify()

    def _changed(self) -> None:
        with self._awake:
            self._read_controls = True
            self._dirty = True
            self._awake.notify()

    def _wake(self) -> None:
        with self._awake:
            self._dirty = True
            self._awake.notify()

    def _read(self) -> bool:
        """Take over the controls' values; whether the controls must be shown what became of them."""
        if self._page is None:  # still being built
            return False
        self._read_controls = False
        before = self._state
        self._state, usable = self._page.read(before)
        if self._state.shape != before.shape:
            self._state = self._library.at_shape(self._state, self._state.shape)
        if self._state.replay and scene_inputs(self._state) != scene_inputs(before):
            self._replay(AFTER_A_CHANGE)
        return not usable or self._state.shape != before.shape

    def _leave_deleted(self) -> bool:
        """Go to the first shape when the page's own was deleted, also when undo leads there; whether it was."""
        gone = self._state.shape
        if gone in self._library.subjects:
            return False
        first = next(iter(self._library.subjects))
        self._state = self._library.at_shape(self._state, first)
        self._tell("This cloud is gone", f"{gone} is not kept on this server any more; the page shows {first}.")
        return True

    def _replay(self, wait: float) -> None:
        """Show the start, and play after so many seconds without another change; called with the lock held."""
        self._state = replace(self._state, iteration=0, inside=0.0, playing=True)
        self._clock.start(0.0, wait)
        self._first_look, self._in_hand = False, True

    def _shown(self, state: State) -> int:
        """The iteration that a state shows."""
        return shown_iteration(self._run, state) if self._run else 0

    def _at(self, state: State, iteration: int) -> State:
        """The state at an iteration; at the end it stays at the end when the run changes."""
        length = self._run.iterations if self._run and not self._live.waiting else 0  # 0: nothing to be at the end of
        at_end = iteration == LAST or 0 < length <= iteration
        return replace(state, iteration=LAST if at_end else max(0, iteration))

    def _tell(self, title: str, body: str) -> None:
        self._client.add_notification(title, body, color="red", auto_close_seconds=8.0)

    # The scene and the methods

    def _set_values(self, values: Mapping[str, Any]) -> None:
        if values.keys() & {"rotation", "translation"}:
            values = {**values, "start": NO_START}
        wait = AFTER_A_CHANGE if values.keys() & (OF_SCENE | {"shape"}) else None
        self._change(lambda state: with_values(state, values), show=True, replays_after=wait)

    def _new_seed(self) -> None:
        seed = random.randint(0, _LARGEST_NEW_SEED)
        self._change(
            lambda s: replace(s, perturbation=replace(s.perturbation, seed=seed), start=NO_START),
            show=True,
            replays_after=AFTER_A_CHANGE,
        )

    def _paper_defaults(self) -> None:
        def reset(state: State) -> State:
            kind = self._library.subject(state.shape).outlier_kind
            perturbation = Perturbation(outlier_kind=kind, seed=state.perturbation.seed)
            return replace(state, perturbation=perturbation, start=NO_START)

        self._change(reset, show=True, replays_after=AFTER_A_CHANGE)

    def _show_method(self, method: str, pane: str) -> None:
        def placed(state: State) -> State:
            if method not in self._library.methods(state.shape):  # of a shape shown before
                self._tell("This method is not there", f"{method} cannot register {state.shape}.")
                return state
            return replace(state, left=method) if pane == "left" else replace(state, right=method)

        self._change(placed, show=True)

    def _show_shape(self, shape: str) -> None:
        self._change(lambda state: self._library.at_shape(state, shape), show=True, replays_after=AFTER_A_CHANGE)

    def _open_scene(self, choice: Choice) -> None:
        self._change(lambda state: self._library.checked(choice.at(state)), show=True)

    def _begin(self, begin: Callable[[State], None]) -> None:
        """Begin work in the background for the newest state."""
        with self._awake:
            if self._closed:
                return
            if self._read_controls:
                self._read()
            begin(self._state)
        self._wake()

    def _cancel_basin(self) -> None:
        self._basin.cancel()
        self._wake()

    def _open_start(self, number: int) -> None:
        def opened(state: State) -> State:
            up = self._library.subject(state.shape).up
            return replace(state, start=start_of(state, up, min(number, STARTS - 1)), inside=0.0)

        self._change(opened, show=True, replays_after=AFTER_A_CHANGE)

    # Playing

    def _play(self) -> None:
        def toggled(state: State) -> State:
            if state.playing:
                return replace(state, playing=False)
            if state.inside > 0:  # once it is over, that of the next iteration
                self._clock.start(0.0)
                if state.inside < BEATS:
                    return replace(state, playing=True)
                return replace(state, playing=True, inside=STEP, iteration=self._shown(state) + 1)
            at_end = self._shown(state) >= (self._run.iterations if self._run else 0)
            position = 0 if at_end else self._shown(state)
            self._clock.start(position)
            return replace(state, playing=True, iteration=position)

        self._change(toggled)

    def _step(self, by: int) -> None:
        self._change(lambda state: self._at(_still(state), max(0, self._shown(state) + by)))

    def _jump(self, iteration: int) -> None:
        self._change(lambda state: self._at(_still(state), iteration))

    def _look_inside(self) -> None:
        def toggled(state: State) -> State:
            return _still(state) if state.inside > 0 else self._inside(state, STEP, playing=True)

        self._change(toggled)

    def _to_beat(self, beat: float) -> None:
        self._change(lambda state: self._inside(state, beat, playing=False) if beat > 0 else _still(state))

    def _inside(self, state: State, position: float, *, playing: bool) -> State:
        """The state in the slow motion of an iteration, of a method with maps and a model point of it."""
        run = self._run
        if run is None or all(side.maps is None for side in run.sides):
            self._tell("There is nothing to look into", "Show a method that learns maps, such as DO or Improved DO.")
            return state
        pane = inspected_number(state)
        pane = pane if run.sides[pane].maps is not None else 1 - pane
        k = max(0, min(self._shown(state), run.sides[pane].trajectory.iterations - 1))
        state = replace(state, inspected_pane=get_args(Pane)[pane], iteration=k, inside=position, playing=playing)
        inspection = inspect(run, state, k, pane)
        if inspection is not None and inspection.point is None:
            state = replace(state, inspected=strongest_point(inspection))
        self._clock.start(k)
        return state

    def _seen(self) -> None:
        with self._awake:
            if self._first_look and self._clock.waits:  # nobody has stepped or changed anything yet
                self._clock.start(0.0, FIRST_LOOK)
            self._first_look = False
            self._charts_are_old = True
        self._wake()

    # The 3D view, and what is looked into

    def _look(self, camera: tuple[float, ...]) -> None:
        with self._awake:  # asks for no frame: nothing but the address has to be written anew
            self._state = replace(self._state, camera=camera)
            self._awake.notify()

    def _grab(self, pane: int, phase: str, T_handles: FloatArray) -> None:
        start = None if self._drawn is None else self._hand.start_pose(self._drawn, pane, phase, T_handles)
        if start is not None:
            wait = AFTER_LETTING_GO if phase == "end" else IN_HAND
            at_start = {"iteration": 0, "playing": False, "inside": 0.0}  # where it is in the hand
            self._change(lambda state: replace(state, start=start, **at_start), show=True, replays_after=wait)

    def _click(self, origin: FloatArray, direction: FloatArray) -> None:
        run = self._run
        found = point_at(run, origin, direction) if run else None
        if found:
            self._change(lambda state: replace(state, inspected_pane=found[0], inspected=found[1]))
            self._open_inspect()
        else:
            self._clear()

    def _pick(self, kind: str, pane: int, place: float) -> None:
        if kind == "start":
            self._open_start(int(place))
            return
        drawn = self._drawn
        if drawn is None:
            return
        side = drawn.sides[pane]
        count = side.run.histogram.n_bins
        order = side.order if kind == "shown" else side.map_order
        number = min(int(place), count - 1) if kind == "bin" else int(order[min(int(place * count), count - 1)])
        block, point = divmod(number, 2 * len(side.run.histogram.model.points))
        question = side.run.histogram.blocks[block].name
        picked = {"inspected_pane": get_args(Pane)[pane], "inspected": point % len(side.run.histogram.model.points)}
        self._change(lambda state: replace(state, **picked, question=question))
        if kind != "bin":
            self._open_inspect()

    def _clear(self) -> None:
        if self._state.inspected != NO_POINT or self._state.scene_point != NO_POINT:
            self._change(lambda state: replace(state, inspected=NO_POINT, scene_point=NO_POINT))

    def _inspect(self, changes: dict[str, Any]) -> None:
        run = self._run
        if run is not None:
            counts = {"inspected": len(run.sides[0].histogram.model.points), "scene_point": len(run.scene.points)}
            for name in counts.keys() & changes.keys():
                changes = {**changes, name: int(min(max(changes[name] or 0, NO_POINT), counts[name] - 1))}
        self._change(lambda state: replace(state, **changes))

    def _open_inspect(self) -> None:
        if self._page is not None:
            self._page.open_tab("Inspect")

    # Whole pages

    def _undo(self) -> None:
        self._go_to(History.undone)

    def _redo(self) -> None:
        self._go_to(History.redone)

    def _go_to(self, there: Callable[[History], History]) -> None:
        def gone(state: State) -> State:
            self._history = there(self._history.with_state(state, time.perf_counter()))
            return self._history.now

        self._change(gone, show=True)

    def _apply_code(self, code: str) -> None:
        if not code.strip():  # cleared, to paste another
            return
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
            self._in_hand = False
            self._clock.start(max(state.iteration, 0), FIRST_LOOK if state.iteration == 0 else 0.0)
            if whole:
                return state
            return replace(state, dark=now.dark, large_text=now.large_text, hidden=now.hidden)

        self._change(begin, show=True)

    def _link(self) -> str:
        with self._awake:
            if self._page is None:
                return self._address
            self._read()  # a tick may be told of later than the click
            return f"{self._address}#{self._page.fragment(self._state)}"

    def _copy_link(self) -> None:
        if self._page is not None:
            link = self._link()
            self._page.copy(link)
            self._client.add_notification("Link copied", link, auto_close_seconds=8.0)


def _still(state: State) -> State:
    """Neither playing nor in slow motion."""
    return replace(state, playing=False, inside=0.0)
