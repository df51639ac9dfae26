"""Clicks into pictures: into heatmaps, histograms and lists of bins, which pick a bin, and into the maps of a basin."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import viser

FIELD = "Picked bin"
"""Label of the field through which `ido_viz/serving/page.js` tells of a click."""

# Beside a field that nobody sees, and that the keyboard passes by; it must be in the page for the script to find it.
_STYLE = """<style>
div:has(> .ido-picking) + div, div:has(> div > .ido-picking) + div { display: none; }
</style><span class="ido-picking"></span>"""


@dataclass(frozen=True, slots=True)
class Click:
    """Where a person clicked.

    Args:
        kind: ``bin`` for a number of a bin, ``shown`` for a place among the bins as the pane orders them, ``compared``
            for one among the bins of a map that belongs to several iterations, ``start`` for a number of a start in the
            map of a basin.
        pane: number of the pane, 0 for the left one.
        place: the number, or the share of the bins to the left.
    """

    kind: str
    pane: int
    place: float


class Picking:
    """The way from a click in the browser to the server.

    Args:
        gui: whose page it is.
        picked: called with where a person clicked.
    """

    def __init__(self, gui: viser.GuiApi, picked: Callable[[Click], None]) -> None:
        gui.add_html(_STYLE)
        self._field = gui.add_text(FIELD, "", hint="The script of the page writes here what was clicked.")
        self._field.on_update(lambda event: self._tell(event.target.value, picked) if event.client else None)

    def _tell(self, text: str, picked: Callable[[Click], None]) -> None:
        click = read_click(text)
        if click is not None:
            picked(click)


_KINDS = ("bin", "shown", "compared", "start")


def read_click(text: str) -> Click | None:
    """What the script wrote, with the number of the click at the end; None for anything else."""
    parts = text.split()
    if len(parts) != 4 or parts[0] not in _KINDS or parts[1] not in ("0", "1"):
        return None
    try:
        place = float(parts[2])
    except ValueError:
        return None
    return Click(parts[0], int(parts[1]), place) if 0 <= place < 1e7 else None
