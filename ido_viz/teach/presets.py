"""Pages on one click: scenes that are known to be registered, and scenes that are known to fail."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from pathlib import Path

from ido.shipped import asset
from ido_viz.core.state import State
from ido_viz.teach.content import check_name, check_unlike, checked, page, read


@dataclass(frozen=True, slots=True)
class Preset:
    """A page that is known to go well, or not to.

    Args:
        id: what it is called where its hint is checked.
        label: on its button.
        hint: what is known of it.
        state: the whole page.
        good: whether both methods end in place.
    """

    id: str
    label: str
    hint: str
    state: State
    good: bool


def load_presets(file: Path) -> tuple[Preset, ...]:
    """The presets of a file, in its order.

    Raises:
        ContentError: it cannot be used.
    """
    tables = checked(read(file), file.name, {"presets": list})["presets"]
    loaded = tuple(_preset(table, f"{file.name}, preset {number}") for number, table in enumerate(tables, start=1))
    check_unlike(file.name, "id", (each.id for each in loaded))
    check_unlike(file.name, "label", (each.label for each in loaded))
    return loaded


def _preset(table: object, where: str) -> Preset:
    values = checked(table, where, {"id": str, "label": str, "hint": str, "good": bool, "page": dict})
    check_name(where, "id", values["id"])
    return Preset(
        id=values["id"],
        label=values["label"],
        hint=values["hint"],
        state=page(values["page"], where),
        good=values["good"],
    )


@cache
def presets() -> tuple[Preset, ...]:
    """The shipped presets, in the order of their buttons."""
    return load_presets(asset("presets.toml"))
