"""Clicks into pictures: into heatmaps, histograms and lists of bins, which pick a bin, and into the maps of a basin."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import viser

from ido_viz.panels.from_browser import PICKED, unseen_field


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


def add_picking(gui: viser.GuiApi, picked: Callable[[Click], None]) -> None:
    """Have a page tell where a person clicks.

    Args:
        gui: whose page it is.
        picked: called with it.
    """

    def tell(text: str) -> None:
        click = read_click(text)
        if click is not None:
            picked(click)

    unseen_field(gui, PICKED, tell)


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
