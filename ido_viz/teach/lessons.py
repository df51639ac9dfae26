"""The lessons that the page offers: steps, each a saved page and a few sentences, some of them claims."""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from ido.shipped import asset
from ido_viz.core.run import inputs
from ido_viz.core.state import State, StateError
from ido_viz.teach.content import ContentError, check_name, check_unlike, checked, joined, numbered, page, read

_CLAIM = re.compile(r"\[(?P<text>[^\[\]]+)\]\(#(?P<id>[^()]*)\)")


@dataclass(frozen=True, slots=True)
class Claim:
    """A sentence about a result, and what it is called within its lesson; a test checks it by that name."""

    id: str
    text: str


@dataclass(frozen=True, slots=True)
class Step:
    """A saved page and what to look at and to try on it.

    Args:
        text: all of it, markdown.
        claims: the sentences of the text that are about results.
        state: the whole page.
    """

    text: str
    claims: tuple[Claim, ...]
    state: State


@dataclass(frozen=True, slots=True)
class Lesson:
    """A few steps about one thing.

    Args:
        name: short, for ``ido-viz --lesson NAME``.
        title: as it is offered on the page.
        steps: in the order in which they are taken.
    """

    name: str
    title: str
    steps: tuple[Step, ...]


def load_lessons(folder: Path) -> tuple[Lesson, ...]:
    """The lessons of a folder, in the order of the numbers that their files begin with.

    Raises:
        ContentError: a file cannot be used.
    """
    loaded = tuple(_lesson(name, file) for name, file in numbered(folder))
    check_unlike(folder.name, "title", (each.title for each in loaded))
    return loaded


def _lesson(name: str, file: Path) -> Lesson:
    table = checked(read(file), file.name, {"title": str, "steps": list})
    steps = tuple(_step(step, f"{file.name}, step {number}") for number, step in enumerate(table["steps"], start=1))
    if not steps:
        raise ContentError(f"{file.name}: there is no step; begin one with [[steps]]")
    check_unlike(file.name, "id", (claim.id for step in steps for claim in step.claims))
    return Lesson(name, table["title"], steps)


def _step(table: object, where: str) -> Step:
    values = checked(table, where, {"text": str, "page": dict})
    text, claims = read_claims(values["text"], where)
    return Step(text, claims, page(values["page"], where))


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
    """The lesson, and the number from 0 of its step, that a state is the page of.

    The scene that every page begins with is of none, whatever lesson shows it.
    """
    if inputs(state) == inputs(State()):
        return None
    for each in lessons():
        for number, step in enumerate(each.steps):
            if step.state == state:
                return each, number
    return None
