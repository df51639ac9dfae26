"""Where a person is in a lesson, as a value: which step, and what was guessed there."""

from __future__ import annotations

from dataclasses import dataclass, replace

from ido_viz.core.state import State
from ido_viz.teach.lessons import Lesson, Step

UNASKED = ""
"""Stands for a guess that was passed over."""


@dataclass(frozen=True, slots=True)
class Place:
    """A place in a lesson.

    Args:
        lesson: which one.
        number: of the step, from 0; as many as there are steps for the page after the last one.
        guessed: what was answered, `UNASKED` when the answer is shown without; None before.
    """

    lesson: Lesson
    number: int
    guessed: str | None = None

    @property
    def step(self) -> Step | None:
        """The step; None after the last one."""
        return self.lesson.steps[self.number] if self.number < len(self.lesson.steps) else None

    @property
    def asking(self) -> tuple[str, ...]:
        """The answers to choose from; none when nothing is asked, or not any more."""
        step = self.step
        return step.guess.answers if step is not None and step.guess is not None and self.guessed is None else ()

    @property
    def state(self) -> State | None:
        """The page that belongs here; None after the last step, where any may stay."""
        step = self.step
        if step is None:
            return None
        return step.state if step.guess is None or self.guessed is None else step.guess.state

    @property
    def text(self) -> str:
        """What is said here, markdown."""
        step = self.step
        if step is None:
            return f"That was *{self.lesson.title}*. What next?"
        if step.guess is None or self.guessed is None:
            return step.text
        verdict = "" if self.guessed == UNASKED else "**Yes.** " if self.guessed == step.guess.right else "**No.** "
        return verdict + step.guess.text

    @property
    def caption(self) -> str:
        """Where this is in the lesson, in words."""
        if self.step is None:
            return "The end"
        return f"Step {self.number + 1} of {len(self.lesson.steps)}"

    def on(self) -> Place:
        """One step on; where something is asked, to the answer; at the end, the same place."""
        if self.asking:
            return replace(self, guessed=UNASKED)
        return Place(self.lesson, min(self.number + 1, len(self.lesson.steps)))

    def back(self) -> Place:
        """One step back; at the start, the same place."""
        return self if self.number == 0 else Place(self.lesson, self.number - 1)

    def answered(self, answer: str) -> Place:
        """The same step with an answer, where it is among those to choose from."""
        return replace(self, guessed=answer) if answer in self.asking else self


def is_still(shown: State, page: State) -> bool:
    """Whether what is shown is this page, or became it by playing on; the look chosen for the room is no difference."""
    same = replace(page, camera=shown.camera, dark=shown.dark, large_text=shown.large_text, hidden=shown.hidden)
    if page.playing:
        same = replace(same, playing=shown.playing, iteration=shown.iteration)
    return same == shown
