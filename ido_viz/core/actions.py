"""What a person can ask of a page, as functions that widgets call."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from ido.types import FloatArray
from ido_viz.core.frame import Frame
from ido_viz.core.state import State
from ido_viz.core.sweep_results import Choice


@dataclass(frozen=True, slots=True)
class Actions:
    """What the buttons do; each is called on a thread of the server and returns at once."""

    changed: Callable[[], None]
    play: Callable[[], None]
    step: Callable[[int], None]
    jump: Callable[[int], None]
    new_seed: Callable[[], None]
    paper_defaults: Callable[[], None]
    apply_code: Callable[[str], None]
    cancel: Callable[[], None]
    compare: Callable[[], None]
    cancel_comparison: Callable[[], None]
    show_method: Callable[[str, str], None]
    open_scene: Callable[[Choice], None]
    open_page: Callable[[State], None]
    show_all: Callable[[], None]
    inspect: Callable[[dict[str, Any]], None]
    set_values: Callable[[Mapping[str, Any]], None]
    """Called with values by their names in `VALUES`."""
    click: Callable[[FloatArray, FloatArray], None]
    """Called with origin and direction of the ray of a click in the 3D view."""
    redraw: Callable[[], None]
    shown: Callable[[], Frame | None]
    """Gives the frame that the page shows; None before there is one."""


def plain(act: Callable[[], None]) -> Callable[[Any], None]:
    """An event callback that does without the event."""
    return lambda _: act()
