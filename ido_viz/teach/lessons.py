"""The lessons that the page offers: steps, each a saved page and a few words, some of them claims."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any, Literal, get_args

import numpy as np

from ido import RANGES
from ido.shipped import asset
from ido_viz.core.run import inputs
from ido_viz.core.state import NO_CAMERA, State, StateError
from ido_viz.teach.content import (
    ContentError,
    Table,
    check_name,
    check_unlike,
    checked,
    joined,
    numbered,
    page,
    read,
)
from ido_viz.teach.marks import Mark
from ido_viz.teach.presets import presets
from ido_viz.teach.step_control import StepControl, control_of

Tab = Literal[
    "Histograms", "Training", "Derivations", "Help", "Maps", "Errors", "Compare", "Basin", "Sweeps", "Inspect"
]

_CLAIM = re.compile(r"\[(?P<text>[^\[\]]+)\]\(#(?P<id>[^()]*)\)")
_OF_LOOK = {"tab": str, "end": bool, "sweep": str, "marks": list, "camera": list}


@dataclass(frozen=True, slots=True)
class Claim:
    """A sentence about a result, and what it is called within its lesson; a test checks it by that name."""

    id: str
    text: str


@dataclass(frozen=True, slots=True)
class Guess:
    """What a step asks before anything plays.

    Args:
        answers: to choose from.
        right: the one that is true.
        text: what is said after the choice, markdown.
        state: the whole page from then on.
    """

    answers: tuple[str, ...]
    right: str
    text: str
    state: State


@dataclass(frozen=True, slots=True)
class Step:
    """A saved page and what to look at and to try on it.

    Args:
        text: all that is said at first, markdown.
        claims: the sentences about results, those that follow a guess among them.
        state: the whole page; of a step that asks for a guess, at the start and not playing.
        control: the one control beside the text; None for none.
        tab: the tab that it opens; None for none.
        end: whether that tab is shown from its end.
        sweep: what the tab Sweeps shows; None as it is.
        marks: what is pointed at in the 3D view.
        guess: what is asked; None for nothing.
    """

    text: str
    claims: tuple[Claim, ...]
    state: State
    control: StepControl | None = None
    tab: Tab | None = None
    end: bool = False
    sweep: str | None = None
    marks: tuple[Mark, ...] = ()
    guess: Guess | None = None

    @property
    def shown(self) -> State:
        """The page that the step ends with."""
        return self.state if self.guess is None else self.guess.state


@dataclass(frozen=True, slots=True)
class Lesson:
    """A few steps about one thing.

    Args:
        name: short, for ``ido-viz --lesson NAME``.
        title: as it is offered on the page.
        steps: in the order in which they are taken.
        preset: id of the preset that goes on from here; None for none.
    """

    name: str
    title: str
    steps: tuple[Step, ...]
    preset: str | None = None


def load_lessons(folder: Path) -> tuple[Lesson, ...]:
    """The lessons of a folder, in the order of the numbers that their files begin with.

    Raises:
        ContentError: a file cannot be used.
    """
    loaded = tuple(_lesson(name, file) for name, file in numbered(folder))
    check_unlike(folder.name, "title", (each.title for each in loaded))
    return loaded


def _lesson(name: str, file: Path) -> Lesson:
    table = checked(read(file), file.name, {"title": str, "steps": list}, {"preset": str})
    steps: list[Step] = []
    for number, each in enumerate(table["steps"], start=1):
        steps.append(_step(each, f"{file.name}, step {number}", steps[-1].shown if steps else None))
    if not steps:
        raise ContentError(f"{file.name}: there is no step; begin one with [[steps]]")
    check_unlike(file.name, "id", (claim.id for step in steps for claim in step.claims))
    preset = table.get("preset")
    _check_choice(file.name, "preset", preset, [each.id for each in presets()])
    return Lesson(name, table["title"], tuple(steps), preset)


def _step(table: object, where: str, before: State | None) -> Step:
    optional = {"page": dict, "change": dict, "guess": dict, "control": object, **_OF_LOOK}
    values = checked(table, where, {"text": str}, optional)
    state = replace(_state(values, where, before), camera=_camera(values, where), handles=False)
    text, claims = read_claims(values["text"], where)
    guess = None
    if "guess" in values:
        guess, more = _guess(values["guess"], where, state)
        claims, state = claims + more, replace(state, playing=False, iteration=0)
    _check_choice(where, "tab", values.get("tab"), get_args(Tab))
    _check_choice(where, "sweep", values.get("sweep"), RANGES)
    for mark in values.get("marks", ()):
        _check_choice(where, "mark", mark, get_args(Mark))
    return Step(
        text=text,
        claims=claims,
        state=state,
        control=control_of(values["control"], where) if "control" in values else None,
        tab=values.get("tab"),
        end=values.get("end", False),
        sweep=values.get("sweep"),
        marks=tuple(values.get("marks", ())),
        guess=guess,
    )


def _state(values: Table, where: str, before: State | None) -> State:
    """The page of a step: a whole one, or the page of the step before with its changes."""
    if "page" in values:
        if "change" in values:
            raise ContentError(f"{where}: give [steps.page] or 'change', not both")
        return page(values["page"], where)
    if before is None:
        raise ContentError(f"{where}: 'page' is missing; the first step needs [steps.page]")
    return page(values.get("change", {}), where, before)


def _guess(table: object, where: str, state: State) -> tuple[Guess, tuple[Claim, ...]]:
    values = checked(table, f"{where}, guess", {"answers": list, "right": str, "text": str})
    answers = tuple(values["answers"])
    if len(answers) < 2 or not all(isinstance(answer, str) for answer in answers):
        raise ContentError(f"{where}, guess: 'answers' must be two or more texts in quotes")
    check_unlike(f"{where}, guess", "answer", answers)
    _check_choice(f"{where}, guess", "right", values["right"], answers)
    text, claims = read_claims(values["text"], where)
    return Guess(answers, values["right"], text, state), claims


def _camera(values: Table, where: str) -> tuple[float, ...]:
    """The state's camera for a direction, from where both panes fit."""
    if "camera" not in values:
        return NO_CAMERA
    numbers = [float(each) for each in values["camera"] if type(each) in (int, float)]
    if len(numbers) != 3 or len(values["camera"]) != 3 or not any(numbers):
        raise ContentError(f"{where}: 'camera' must be a direction of three numbers, not {values['camera']!r}")
    direction = np.array(numbers) / np.linalg.norm(numbers)
    return (*np.round(direction, 3).tolist(), 0.0, 0.0, 0.0)


def _check_choice(where: str, what: str, value: object, known: Any) -> None:
    if value is not None and value not in known:
        raise ContentError(f"{where}: unknown {what} {value!r}; known: {', '.join(known)}")


def read_claims(marked: str, where: str) -> tuple[str, tuple[Claim, ...]]:
    """A text without the marks of its claims, and the claims that were marked, as ``[a sentence](#its-id)``.

    Raises:
        ContentError: a mark cannot be understood.
    """
    marked = joined(marked)
    claims = tuple(Claim(match["id"], match["text"]) for match in _CLAIM.finditer(marked))
    for claim in claims:
        check_name(where, "id", claim.id)
    text = _CLAIM.sub(lambda match: match["text"], marked)
    if "](#" in text:
        raise ContentError(f"{where}: write a claim as [a sentence](#its-id), without brackets in the sentence")
    return text, claims


@cache
def lessons() -> tuple[Lesson, ...]:
    """The shipped lessons, in the order of the menu."""
    return load_lessons(asset("lessons"))


def lesson(name: str) -> Lesson:
    """A lesson by its name.

    Raises:
        StateError: there is none of this name.
    """
    for each in lessons():
        if each.name == name:
            return each
    raise StateError(f"unknown lesson {name!r}; known: {', '.join(each.name for each in lessons())}")


def step_named(name: str) -> tuple[Lesson, int]:
    """A lesson, and the number from 0 of its step, by a name as ``histogram`` or ``histogram/3``, which counts from 1.

    Raises:
        StateError: there is no such lesson, or no such step of it.
    """
    its_name, _, number = name.partition("/")
    found = lesson(its_name)
    steps = {"": 0} | {str(index + 1): index for index in range(len(found.steps))}
    if number not in steps:
        raise StateError(f"lesson {its_name!r} has steps 1 to {len(found.steps)}, not {number!r}")
    return found, steps[number]


def step_of(state: State) -> tuple[Lesson, int] | None:
    """The lesson, and the number from 0 of its first step, that a state is the page of.

    The scene that every page begins with is of none, whatever lesson shows it.
    """
    if inputs(state) == inputs(State()):
        return None
    for each in lessons():
        for number, step in enumerate(each.steps):
            if step.state == state:
                return each, number
    return None
