"""What the loaders of lessons, presets and derivations share: TOML files, and what is said of a mistake in one."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from ido_viz.core.library import shipped_library
from ido_viz.core.state import VALUES, State, StateError, with_values

Table = Mapping[str, Any]

NAME = "[a-z0-9]+(-[a-z0-9]+)*"
"""Pattern of names and ids: small letters, digits, and dashes between words."""

_KINDS = {str: "text in quotes", bool: "true or false", list: "an array", dict: "a table"}
_FILE = re.compile(rf"(?P<number>\d+)-(?P<name>{NAME})\.toml")


class ContentError(ValueError):
    """A lesson, preset or derivation cannot be read; the message says where, and what to do."""


def read(file: Path) -> dict[str, Any]:
    """What a TOML file holds.

    Raises:
        ContentError: it is not in UTF-8, or not TOML.
    """
    try:
        return tomllib.loads(file.read_text("utf-8-sig"))
    except UnicodeDecodeError as error:
        raise ContentError(f"{file.name}: save the file in UTF-8") from error
    except tomllib.TOMLDecodeError as error:
        raise ContentError(f"{file.name}: not TOML: {error}") from error


def numbered(folder: Path) -> list[tuple[str, Path]]:
    """Names and TOML files of a folder, in the order of the numbers that the files begin with.

    Raises:
        ContentError: a file has no number, or two files have the same name.
    """
    found = []
    for file in folder.glob("*.toml"):
        match = _FILE.fullmatch(file.name)
        if match is None:
            raise ContentError(f"{file.name}: name the file after its place and its content, such as 07-half.toml")
        found.append((int(match["number"]), match["name"], file))
    found.sort()
    check_unlike(folder.name, "name", [name for _, name, _ in found])
    return [(name, file) for _, name, file in found]


def checked(table: object, where: str, kinds: Mapping[str, type], optional: Mapping[str, type] | None = None) -> Table:
    """The table itself, when it has these keys, maybe optional ones, no others, and values of these kinds.

    An optional value of the kind `object` may be anything.

    Raises:
        ContentError: it has not.
    """
    if not isinstance(table, dict):
        raise ContentError(f"{where}: must be a table, not {table!r}")
    allowed = {**kinds, **(optional or {})}
    check_known(table, where, allowed)
    for key in kinds:
        if key not in table:
            raise ContentError(f"{where}: {key!r} is missing; give {_KINDS[kinds[key]]}")
    for key, kind in allowed.items():
        if key in table and kind is not object and type(table[key]) is not kind:
            raise ContentError(f"{where}: {key!r} must be {_KINDS[kind]}, not {table[key]!r}")
    return table


def check_known(table: Table, where: str, known: Iterable[str]) -> None:
    """Refuse other keys than the known ones.

    Raises:
        ContentError: there are some.
    """
    known = sorted(known)
    for key in table:
        if key not in known:
            raise ContentError(f"{where}: unknown key {key!r}; known: {', '.join(known)}")


def check_unlike(where: str, what: str, values: Iterable[str]) -> None:
    """Refuse the same value twice.

    Raises:
        ContentError: there is one.
    """
    seen: set[str] = set()
    for value in values:
        if value in seen:
            raise ContentError(f"{where}: the {what} {value!r} is there twice; change one")
        seen.add(value)


def check_name(where: str, what: str, name: str) -> None:
    """Refuse a name or an id that others cannot refer to.

    Raises:
        ContentError: it is one.
    """
    if re.fullmatch(NAME, name) is None:
        raise ContentError(
            f"{where}: the {what} {name!r} must be of small letters, digits and dashes, as in both-wrong"
        )


def joined(text: str) -> str:
    """A text on one line, as it is shown: a line's end in a file is a space."""
    return " ".join(text.split())


def page(table: Table, where: str, base: State | None = None) -> State:
    """The state of a table of what differs from another one, by default from the page that opens first.

    Raises:
        ContentError: a value is unknown or out of range, or a method cannot register the shape.
    """
    check_known(table, where, VALUES)
    values = {name: tuple(value) if isinstance(value, list) else value for name, value in table.items()}
    try:
        return shipped_library().checked(with_values(base or State(), values))
    except StateError as error:
        raise ContentError(f"{where}: {error}") from error
