"""The menu of lessons, and the way through the chosen one."""

from __future__ import annotations

import threading
from collections.abc import Callable
from functools import partial

import viser

from ido_viz.core.actions import Actions
from ido_viz.core.frame import Frame
from ido_viz.core.state import State
from ido_viz.teach.lessons import lessons, step_named, step_of
from ido_viz.teach.presenter import Buttons, Presenter
from ido_viz.teach.presets import presets
from ido_viz.teach.walk import Place, is_still

NONE = "Choose a lesson"


class LessonFolder:
    """The menu of lessons; what a step says stands on the canvas, in a panel of its own.

    Args:
        client: where its widgets are placed.
        actions: opens pages, and does what a step's control does.
        show_sweep: chooses what the tab Sweeps shows.
        bring_tabs_back: opens the tabs again that were open before a lesson.
        state: what the page begins with; if it is a step's, that step is shown.
        step: that is shown, whatever the state; as ``histogram/3``, empty for none.

    Raises:
        StateError: there is no such step.
    """

    def __init__(
        self,
        client: viser.ClientHandle,
        actions: Actions,
        show_sweep: Callable[[str], None],
        bring_tabs_back: Callable[[], None],
        state: State,
        step: str = "",
    ) -> None:
        gui = client.gui
        self._actions = actions
        self._by_title = {lesson.title: lesson for lesson in lessons()}
        begun = step_named(step) if step else step_of(state)
        self._place = None if begun is None else Place(*begun)
        self._before = State() if self._place is not None else state
        self._lock = threading.RLock()  # clicks may come on several threads
        self.folder = gui.add_folder("Lessons", order=-1)  # above the presets
        with self.folder:
            self._menu = gui.add_dropdown(
                "Lesson",
                (NONE, *self._by_title),
                initial_value=NONE if self._place is None else self._place.lesson.title,
                hint="A few prepared pages about one thing, with what to look at and to try. The arrows or a clicker "
                "go on and back; Again puts back what you tried; Leave brings back what was there before.",
            )
        self._menu.on_update(lambda event: self._choose(event.target.value) if event.client else None)
        moves = {"Back": self._back, "Next": self._on, "Again": self._again, "Leave": self._leave}
        self._presenter = Presenter(client, actions, show_sweep, bring_tabs_back, moves)
        on = gui.add_command("Lesson: next step", hotkey="pagedown")
        back = gui.add_command("Lesson: step back", hotkey="pageup")
        on.on_trigger(lambda _: self._on())
        back.on_trigger(lambda _: self._back())
        self._keys = (on, back)
        self._show()

    @property
    def step(self) -> str:
        """The step that is shown, as ``histogram/3``; empty for none."""
        place = self._place
        return "" if place is None else f"{place.lesson.name}/{min(place.number + 1, len(place.lesson.steps))}"

    @property
    def is_open(self) -> bool:
        """Whether a lesson is shown."""
        return self._place is not None

    def draw(self, frame: Frame) -> None:
        """Draw what the step marks."""
        with self._lock:
            self._presenter.draw(frame)

    def follow(self, frame: Frame) -> None:
        """Let the step's control show what the page shows."""
        with self._lock:
            self._presenter.follow(frame)

    # Ways through a lesson, on threads of the server

    def _choose(self, title: str) -> None:
        with self._lock:
            if title not in self._by_title:
                self._leave()
                return
            if self._place is None:
                shown = self._actions.shown()
                self._before = shown.state if shown is not None else self._before
            self._go(Place(self._by_title[title], 0), again=True)

    def _on(self) -> None:
        with self._lock:
            if self._place is not None and not self._presenter.tell():
                self._go(self._place.on())

    def _back(self) -> None:
        with self._lock:
            if self._place is not None:
                self._go(self._place.back())

    def _again(self) -> None:
        with self._lock:
            if self._place is not None:
                self._go(self._place, again=True)

    def _answer(self, answer: str) -> None:
        with self._lock:
            if self._place is not None:
                self._go(self._place.answered(answer))

    def _leave(self) -> None:
        """Close the lesson, and bring back what was there before."""
        with self._lock:
            if self._place is not None:
                self._close(self._before)

    def _close(self, state: State | None) -> None:
        """Close the lesson and open a page; for None, what is shown stays."""
        with self._lock:
            self._place = None
            self._show()
            if state is not None:
                self._actions.open_page(state)

    def _go(self, place: Place, *, again: bool = False) -> None:
        """Go to a place; its page is opened unless it goes on from what is shown."""
        if place == self._place and not again:
            return
        before, self._place = self._place, place
        self._show()
        if place.state is None:
            return
        shown = self._actions.shown()
        goes_on = before is not None and before.state == place.state
        if again or not goes_on or shown is None or not is_still(shown.state, place.state):
            self._actions.open_page(place.state)

    def _show(self) -> None:
        place = self._place
        title = NONE if place is None else place.lesson.title
        if self._menu.value != title:
            self._menu.value = title
        for command in self._keys:
            command.disabled = place is None
        state = place.state if place is not None and place.state is not None else State()
        self._presenter.show(place, self._choices(place), state)
        self._actions.redraw()

    def _choices(self, place: Place | None) -> Buttons:
        """What is offered below the text: answers, or after the last step what comes next."""
        if place is None:
            return {}
        if place.step is not None:
            return {answer: partial(self._answer, answer) for answer in place.asking}
        choices: dict[str, Callable[[], None]] = {}
        titles = list(self._by_title)
        following = titles[titles.index(place.lesson.title) + 1 :][:1]
        for title in following:
            choices[f"Next lesson: {title}"] = partial(self._choose, title)
        for preset in presets():
            if preset.id == place.lesson.preset:
                choices[f"Preset: {preset.label}"] = partial(self._close, preset.state)
        choices["Try it yourself: keep this page"] = partial(self._close, None)
        return choices
