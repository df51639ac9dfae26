"""The folder that takes a student through a lesson, step by step."""

from __future__ import annotations

import threading
from collections.abc import Callable

import viser

from ido_viz.core.state import State
from ido_viz.teach.lessons import Lesson, lessons, step_named, step_of

NONE = "Choose a lesson"
_INVITATION = "Each lesson opens a few prepared pages, one after the other, and says what to look at and to try there."


class LessonFolder:
    """The menu of lessons, the text of a step, and the ways to the others.

    Args:
        gui: where its widgets are placed.
        open_state: opens a page; called on a thread of the server.
        state: what the page begins with; if it is a step's, that step is shown.
        left: called when no lesson is shown any more.
        step: that is shown, whatever the state; as ``histogram/3``, empty for none.

    Raises:
        StateError: there is no such step.
    """

    def __init__(
        self,
        gui: viser.GuiApi,
        open_state: Callable[[State], None],
        state: State,
        left: Callable[[], None],
        step: str = "",
    ) -> None:
        self._open = open_state
        self._left = left
        self._by_title = {lesson.title: lesson for lesson in lessons()}
        self._at: tuple[Lesson, int] | None = step_named(step) if step else step_of(state)
        self._lock = threading.Lock()  # clicks may come on several threads
        self.folder = gui.add_folder("Lessons")
        with self.folder:
            self._menu = gui.add_dropdown(
                "Lesson",
                (NONE, *self._by_title),
                initial_value=self._at[0].title if self._at else NONE,
                hint="A few prepared pages about one thing, with what to look at.",
            )
            self._text = gui.add_markdown("")
            self._count = gui.add_markdown("")
            moves = {"Back": -1, "Next": 1, "Again": 0}
            self._buttons = gui.add_button_group(
                "Go", tuple(moves), hint="Again shows the step's page as it was, after you have tried things."
            )
        self._menu.on_update(lambda event: self._choose(event.target.value) if event.client else None)
        self._buttons.on_click(lambda event: self._move(moves[event.target.value]))
        self._show()

    @property
    def step(self) -> str:
        """The step that is shown, as ``histogram/3``; empty for none."""
        at = self._at
        return f"{at[0].name}/{at[1] + 1}" if at else ""

    def _choose(self, title: str) -> None:
        with self._lock:
            self._at = (self._by_title[title], 0) if title in self._by_title else None
            self._go()

    def _move(self, by: int) -> None:
        with self._lock:
            if self._at is None:
                return
            lesson, number = self._at
            if 0 <= number + by < len(lesson.steps):
                self._at = (lesson, number + by)
                self._go()

    def _go(self) -> None:
        self._show()
        if self._at is None:
            self._left()
        else:
            lesson, number = self._at
            self._open(lesson.steps[number].state)

    def _show(self) -> None:
        if self._at is None:
            self._text.content, self._count.content = _INVITATION, ""
        else:
            lesson, number = self._at
            self._text.content = lesson.steps[number].text
            self._count.content = f"*Step {number + 1} of {len(lesson.steps)}*"
        self._buttons.visible = self._at is not None
