"""What a person can ask of a page, as functions that widgets call."""

from __future__ import annotations

from collections.abc import Callable, Coroutine, Mapping
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
    look_inside: Callable[[], None]
    to_beat: Callable[[float], None]
    jump: Callable[[int], None]
    new_seed: Callable[[], None]
    paper_defaults: Callable[[], None]
    apply_code: Callable[[str], None]
    link: Callable[[], str]
    """Gives the address that opens the page as it is now."""
    copy_link: Callable[[], None]
    cancel: Callable[[], None]
    compare: Callable[[], None]
    cancel_comparison: Callable[[], None]
    map_basin: Callable[[], None]
    cancel_basin: Callable[[], None]
    show_method: Callable[[str, str], None]
    show_shape: Callable[[str], None]
    """Called with a shape's name; methods that cannot register it give way to others."""
    open_scene: Callable[[Choice], None]
    open_page: Callable[[State], None]
    show_all: Callable[[], None]
    inspect: Callable[[dict[str, Any]], None]
    set_values: Callable[[Mapping[str, Any]], None]
    """Called with values by their names in `VALUES`."""
    click: Callable[[FloatArray, FloatArray, FloatArray], None]
    """Called with origin and direction of the ray of a click in the 3D view, and where both panes are, (2, 3)."""
    pick: Callable[[str, int, float], None]
    """Called with the kind, the pane and the place of a click into a picture, as `panels.picking` has them."""
    clear: Callable[[], None]
    grab: Callable[[int, str, FloatArray], None]
    """Called with a pane's number, the phase of a gesture (start, update, end) and where its handles are, (4, 4)."""
    gesture: Callable[[int, bool], None]
    """Called with a new number when a hand begins to do something, as a button or key goes down, and with whether it
    holds a slider; with the same number when it lets go of that."""
    look: Callable[[tuple[float, ...]], None]
    """Called with where a person looks from, as the state's camera has it."""
    seen: Callable[[], None]
    """Called when the page can be seen."""
    reset_view: Callable[[], None]
    undo: Callable[[], None]
    redo: Callable[[], None]
    redraw: Callable[[], None]
    shown: Callable[[], Frame | None]
    """Gives the frame that the page shows; None before there is one."""


def at_once(act: Callable[[Any], None]) -> Callable[[Any], Coroutine[Any, Any, None]]:
    """An event callback with the value that a browser sent, in the moment when it comes, on the server's own thread.

    On another one it may find what the page has written there since.
    """

    async def told(event: Any) -> None:
        if event.client is not None:
            act(event.target.value)

    return told


def plain(act: Callable[[], None]) -> Callable[[Any], None]:
    """An event callback that does without the event."""
    return lambda _: act()
