"""What the script of the page tells the server, `ido_viz/serving/page.js`: through text fields that nobody sees."""

from __future__ import annotations

from collections.abc import Callable

import viser

from ido_viz.core.actions import at_once

PICKED = "Picked bin"
"""Label of the field that tells of a click."""

OPEN_TABS = "Open tabs"
"""Label of the field that tells which tabs are open."""

GESTURE = "Gesture"
"""Label of the field that tells the number of what the hand does, from a button or key that goes down to the next, and
whether it holds a slider."""

# The keyboard passes the fields by, too; they must be in the page for the script to find them.
_STYLE = """<style>
div:has(> .ido-unseen) + div, div:has(> div > .ido-unseen) + div { display: none; }
</style><span class="ido-unseen"></span>"""


def unseen_field(gui: viser.GuiApi, label: str, told: Callable[[str], None]) -> None:
    """A field into which the script writes.

    Args:
        gui: whose page it is.
        label: by which the script finds it.
        told: called with what is written there, in the order in which it was; it must return at once.
    """
    gui.add_html(_STYLE)
    field = gui.add_text(label, "", hint="The script of the page writes here.")
    field.on_update(at_once(told))


def read_gesture(text: str) -> tuple[int, bool]:
    """The number of what the hand does, 0 for nonsense, and whether it holds a slider."""
    number, _, holds = text.partition(" ")
    return (int(number) if number.isdecimal() and len(number) < 9 else 0), holds == "held"
