"""Playing a registration: buttons, the iteration, and the live numbers."""

from __future__ import annotations

from collections.abc import Callable

import viser

from ido_viz.core.actions import Actions, at_once, plain
from ido_viz.core.frame import Frame
from ido_viz.core.inside import STEP
from ido_viz.core.state import BEATS, NORMAL_SPEED, State

PREPARING = (
    '<div style="margin:0 8px;font-size:0.75rem">Preparing. On the very first start the numerical loops are '
    "compiled, which takes some seconds.</div>"
)


class Playback:
    """The widgets above all folders.

    Args:
        gui: where they are placed.
        state: what the page begins with.
        actions: what the buttons do.
    """

    def __init__(self, gui: viser.GuiApi, state: State, actions: Actions) -> None:
        self._play = gui.add_button("Play (P)", icon=viser.Icon.PLAYER_PLAY, hint="Play or pause, also with the key P.")
        self._play.on_click(plain(actions.play))
        moves: dict[str, Callable[[], None]] = {
            "First (R)": lambda: actions.jump(0),
            "Back (B)": lambda: actions.step(-1),
            "Next (N)": lambda: actions.step(1),
            "Last": lambda: actions.jump(-1),
        }
        buttons = gui.add_button_group(
            "", tuple(moves), hint="To the start, one iteration back or on, to the end. Keys: R, B, N."
        )
        buttons.on_click(at_once(lambda move: moves[move]()))
        self._look = gui.add_button(
            "Look inside (I)",
            color="gray",
            hint="The next iteration in slow motion, in five beats: what it sees, and how that becomes a step.",
        )
        self._look.on_click(plain(actions.look_inside))
        self._beat = gui.add_slider("Beat", 0.0, BEATS, STEP, 0.0, hint="Drag through the five beats.")
        self._beat.on_update(at_once(lambda beat: actions.to_beat(float(beat))))
        self._scrub = gui.add_slider("Iteration", 0, 1, 1, 0, hint="Drag through the registration.")
        self._scrub.on_update(at_once(lambda iteration: actions.jump(int(iteration))))
        self.speed = gui.add_slider(
            "Speed",
            1,
            60,
            1,
            state.speed,
            marks=((NORMAL_SPEED, "normal"),),
            hint="How fast it is played. The more the cloud moves in an iteration, the longer that is to be seen.",
        )
        changes = {"Undo": actions.undo, "Redo": actions.redo}
        gui.add_button_group(
            "Change", tuple(changes), hint="Take back what was changed last, and do it again: Ctrl-Z and Ctrl-Shift-Z."
        ).on_click(at_once(lambda change: changes[change]()))
        self._cancel = gui.add_button(
            "Cancel what is computed", color="gray", visible=False, hint="Give up the methods that are still computing."
        )
        self._cancel.on_click(plain(actions.cancel))

    def draw(self, frame: Frame) -> None:
        """Write the label of the button."""
        playing = frame.state.playing
        label = "Pause (P)" if playing else "Play (P)"
        if self._play.label != label:
            self._play.label = label
            self._play.icon = viser.Icon.PLAYER_PAUSE if playing else viser.Icon.PLAYER_PLAY

    def show_cancel(self, shown: bool) -> None:
        """Show or hide the button that cancels slow methods."""
        if self._cancel.visible != shown:
            self._cancel.visible = shown

    def show_iteration(self, frame: Frame) -> None:
        """Write the iteration, and the beat of its slow motion."""
        inside = frame.state.inside
        label = "Look inside (I)" if inside == 0 else "Leave the slow motion (I)"
        if self._look.label != label:
            self._look.label = label
        if self._beat.value != inside:
            self._beat.value = inside
        last = max(1, frame.run.iterations)
        if self._scrub.max != last:
            if self._scrub.value > last:
                self._scrub.value = last
            self._scrub.max = last
        if self._scrub.value != frame.k:
            self._scrub.value = frame.k
