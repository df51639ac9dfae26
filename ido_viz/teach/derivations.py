"""The derivations: plain words first, then equations with what they say, then where to look."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from ido.shipped import asset
from ido_viz.teach.content import check_name, check_unlike, checked, joined, numbered, read


@dataclass(frozen=True, slots=True)
class Equation:
    """An equation that ships as a drawing.

    Args:
        name: of its file, without the ending.
        tex: LaTeX that the drawing is made from.
        alt: how it is read aloud.
    """

    name: str
    tex: str
    alt: str


@dataclass(frozen=True, slots=True)
class Derivation:
    """One thing, derived. Texts are HTML.

    Args:
        title: as it is offered on the page.
        plain: what it says in plain words.
        steps: sentences and equations, in the order in which they are read.
        look: where to see it in the page and in the code.
    """

    title: str
    plain: str
    steps: tuple[str | Equation, ...]
    look: str


def load_derivations(folder: Path) -> tuple[Derivation, ...]:
    """The derivations of a folder, in the order of the numbers that their files begin with.

    Raises:
        ContentError: a file cannot be used.
    """
    loaded = tuple(_derivation(file) for _, file in numbered(folder))
    check_unlike(folder.name, "title", (each.title for each in loaded))
    check_unlike(folder.name, "equation", (each.name for each in equations_of(loaded)))
    return loaded


def equations_of(derivations: Iterable[Derivation]) -> tuple[Equation, ...]:
    """All equations of some derivations, in the order in which they are read."""
    return tuple(step for derivation in derivations for step in derivation.steps if isinstance(step, Equation))


def _derivation(file: Path) -> Derivation:
    table = checked(read(file), file.name, {"title": str, "plain": str, "look": str, "steps": list})
    steps = tuple(_step(step, f"{file.name}, step {number}") for number, step in enumerate(table["steps"], start=1))
    return Derivation(table["title"], joined(table["plain"]), steps, joined(table["look"]))


def _step(table: object, where: str) -> str | Equation:
    if isinstance(table, dict) and "equation" not in table:
        return joined(checked(table, where, {"text": str})["text"])
    values = checked(table, where, {"equation": str, "tex": str, "alt": str})
    check_name(where, "equation", values["equation"])
    return Equation(values["equation"], joined(values["tex"]), joined(values["alt"]))


@cache
def derivations() -> tuple[Derivation, ...]:
    """The shipped derivations, in the order of the menu."""
    return load_derivations(asset("derivations"))
