"""The panel on the canvas that says what a step says, with the one control that it names and the ways on."""

from __future__ import annotations

import html
from collections.abc import Callable, Mapping

import viser

from ido_viz.core.actions import Actions
from ido_viz.core.frame import Frame
from ido_viz.core.state import State
from ido_viz.panels.in_browser import arrows_turn_pages, note_tabs, open_tab
from ido_viz.teach.marks import Marks, pointers
from ido_viz.teach.step_control import ControlView
from ido_viz.teach.walk import Place

WIDTH = 450
"""Of the panel, pixels: on a window of 1280, with large text, the canvas between the other panels is 470 wide."""

WATCH = "Watch…"
"""Stands in the place of an answer while the page plays, which is the answer's better half."""

_GAP = 12  # from the canvas's edges, pixels
_STYLE = """<style>
.lesson{margin:0.4rem 0.75rem 0.7rem;font-size:0.75rem;opacity:0.75}
[data-dock-group]:has(.lesson) p[data-size]{font-size:1.0625rem;line-height:1.4;min-height:4.2em}
</style>"""
_NO_CONTROL = '<div style="height:1.875rem"></div>'
"""As high as a control, so that the panel stays as it is from step to step; the text has room for three lines."""

Buttons = Mapping[str, Callable[[], None]]
"""What buttons do, by the words on them."""


class Presenter:
    """The panel, and what a step does to the rest of the page.

    Args:
        client: the page.
        actions: what a step's control does.
        show_sweep: chooses what the tab Sweeps shows.
        bring_tabs_back: opens the tabs again that were open before the lesson.
        moves: the ways to other steps, and out.
    """

    def __init__(
        self,
        client: viser.ClientHandle,
        actions: Actions,
        show_sweep: Callable[[str], None],
        bring_tabs_back: Callable[[], None],
        moves: Buttons,
    ) -> None:
        self._gui = gui = client.gui
        self._actions = actions
        self._show_sweep = show_sweep
        self._bring_tabs_back = bring_tabs_back
        self._marks = Marks(client.scene)
        self._place: Place | None = None
        self._control: ControlView | None = None
        self._turn = 0
        self._untold = ""  # the answer, until the page has played
        self.panel = gui.add_panel(order=-1)  # on a phone, where panels are a list, the first
        self.panel.visible = False
        self._tab = self.panel.add_tab("Lesson")
        with self._tab:
            self._text = gui.add_markdown("", order=0)
            self._slot = gui.add_folder(None, order=1)
            self._head = gui.add_html("", order=2)  # between the text and the buttons, whose hint covers its end
            self._moves = gui.add_button_group("Go", tuple(moves), order=3, hint="Or the arrow keys, or a clicker.")
            self._script = gui.add_html("", order=4)
        self._moves.on_click(lambda event: moves[event.target.value]())

    def show(self, place: Place | None, choices: Buttons, state: State) -> None:
        """Show a place in a lesson; hide the panel for None.

        Args:
            place: where.
            choices: what is offered below the text: answers, or what comes next.
            state: the page that goes with it.
        """
        left, self._place = self._place is not None and place is None, place
        self._control = None
        self._slot.remove()
        with self._tab:
            self._slot = self._gui.add_folder(None, order=1)
        if place is None:
            self._head.content = self._script.content = ""  # without it, the arrows are the camera's again
            if left:
                self._bring_tabs_back()
            return
        step = place.step
        self._head.content = f'{_STYLE}<div class="lesson">{place.caption} · {html.escape(place.lesson.title)}</div>'
        plays = place.guessed is not None and place.state is not None and place.state.playing
        self._untold = place.text if plays else ""
        self._text.content = WATCH if plays else place.text
        self._turn += 1
        tab = open_tab(step.tab, self._turn, at_end=step.end) if step is not None and step.tab is not None else ""
        self._script.content = note_tabs() + arrows_turn_pages() + tab
        if step is not None and step.sweep is not None:
            self._show_sweep(step.sweep)
        with self._slot:
            if place.asking:
                answers = self._gui.add_button_group(
                    "Your guess", place.asking, hint="Nothing plays before you have one."
                )
                answers.on_click(lambda event: choices[event.target.value]())
            else:
                for label, act in choices.items():
                    button = self._gui.add_button(label, hint="This lesson is closed.")
                    button.on_click(lambda _, act=act: act())
            if step is not None and step.control is not None and not choices:
                self._control = ControlView(self._gui, step.control, state, self._actions)
            elif not place.asking and not choices:
                self._gui.add_html(_NO_CONTROL)

    def tell(self) -> bool:
        """Say the answer that waits for the page to have played; whether there was one."""
        if not self._untold:
            return False
        self._text.content, self._untold = self._untold, ""
        return True

    def draw(self, frame: Frame) -> None:
        """Point at what the step talks about, and keep the panel on the canvas while it is wanted."""
        if frame.k > 0 and not frame.state.playing:
            self.tell()
        step = self._place.step if self._place is not None else None
        found = pointers(frame, step.marks) if step is not None else ()
        self._marks.draw(found, dark=frame.state.dark, large=frame.state.large_text)
        wanted = self._place is not None and "lessons" not in frame.state.hidden
        if self.panel.visible != wanted:
            self.panel.visible = wanted
            if wanted:  # a panel that was hidden has lost its place
                self.panel.float(x=_GAP, y=-_GAP, width=WIDTH)
                self.panel.expand()

    def follow(self, frame: Frame) -> None:
        """Let the step's control show what the page shows."""
        if self._control is not None:
            self._control.follow(frame.state)
