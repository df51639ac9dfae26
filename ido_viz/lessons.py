"""The lessons that the page offers, in the order of the menu."""

from __future__ import annotations

from ido_viz.lesson import Lesson
from ido_viz.lessons_far import DARK, FAR_TURN
from ido_viz.lessons_learning import OVERFITTING
from ido_viz.lessons_limits import HALF, OUTLIERS
from ido_viz.lessons_moving import MAPS, STOPPING, TWO_MORE
from ido_viz.lessons_results import AS_PRINTED, FAILURE, SETTINGS
from ido_viz.lessons_seeing import BINARIES, HISTOGRAM
from ido_viz.lessons_tracing import MISLED
from ido_viz.run import inputs
from ido_viz.state import State, StateError

LESSONS: tuple[Lesson, ...] = (
    HISTOGRAM,
    BINARIES,
    TWO_MORE,
    MAPS,
    OVERFITTING,
    OUTLIERS,
    HALF,
    DARK,
    FAR_TURN,
    STOPPING,
    SETTINGS,
    FAILURE,
    MISLED,
    AS_PRINTED,
)


def lesson(name: str) -> Lesson:
    """A lesson by its name.

    Raises:
        StateError: there is none of this name.
    """
    for each in LESSONS:
        if each.name == name:
            return each
    raise StateError(f"unknown lesson {name!r}; known: {', '.join(each.name for each in LESSONS)}")


def step_of(state: State) -> tuple[Lesson, int] | None:
    """The lesson, and the number from 0 of its step, that a state is the page of.

    The scene that every page begins with is of none, whatever lesson shows it.
    """
    if inputs(state) == inputs(State()):
        return None
    for each in LESSONS:
        for number, step in enumerate(each.steps):
            if step.state == state:
                return each, number
    return None
