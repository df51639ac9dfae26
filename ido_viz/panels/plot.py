"""A live chart, of which what changes is sent, and the axes that charts share."""

from __future__ import annotations

from typing import Any

import numpy as np
import viser

from ido.types import DoubleArray, FloatArray
from ido_viz.core import palette
from ido_viz.core.state import State

_MOST_POWERS = 4  # of ten, that are all marked along an axis
_STEPS = [digit * 10**power for power in range(1, 9) for digit in (1, 2, 5)]
_MOST_STEPS = 5  # between the marks of an axis


class Plot:
    """A chart whose style is set whole: a new style makes a new chart in the same place, new data only moves it.

    Of new data, what differs from those that the chart was made with is sent; see `changed`.
    """

    def __init__(self, gui: viser.GuiApi, height: int) -> None:
        self._gui = gui
        self.height = height
        self._folder = gui.add_folder(None)
        self._chart: viser.GuiUplotHandle | None = None
        self._left: viser.GuiUplotHandle | None = None
        self._made: tuple[DoubleArray, ...] = ()

    def restyle(
        self, data: tuple[DoubleArray, ...], series: list[Any], scales: dict[str, Any], axes: list[Any]
    ) -> None:
        """Draw with a new style."""
        old = self._chart
        self._made = data
        with self._folder:
            self._chart = self._gui.add_uplot(
                data,
                tuple(series),
                scales=scales,
                axes=tuple(axes),
                legend={"show": False},
                cursor={"show": False},
                height=self.height,
                padding=(7, 18, 0, 0),
            )
        if self._left is not None:
            self._left.remove()
        if old is not None:
            old.visible = False
        self._left = old  # not removed yet: the page may still have to take its newest data, and would find it gone

    def draw(self, data: tuple[DoubleArray, ...]) -> None:
        """Draw new data in the style that was set."""
        assert self._chart is not None
        # not as its data: these belong to the message that makes it, which may not have been sent yet
        self._chart._queue_update("data", changed(self._made, data))


def changed(made: tuple[DoubleArray, ...], data: tuple[DoubleArray, ...]) -> tuple[FloatArray, ...]:
    """What `ido_viz/serving/charts.js` needs to put new data together; the data themselves where the lengths differ.

    Args:
        made: what the chart was made with: columns, each of shape (n,).
        data: the new columns.

    Returns:
        A head: NaN, then the first place of what differs of each column; and for each column that part, in
        single precision.
    """
    if [len(column) for column in made] != [len(column) for column in data]:
        return data
    head, parts = [np.nan], []
    for old, new in zip(made, data, strict=True):
        places = np.flatnonzero(old.view(np.int64) != new.view(np.int64))  # NaN is equal to NaN
        start, end = (int(places[0]), int(places[-1]) + 1) if len(places) else (0, 0)
        head.append(start)
        parts.append(new[start:end].astype(np.float32))
    return (np.array(head), *parts)


def dots(label: str, color: str, *, size: int, edge: str = "") -> dict[str, Any]:
    """A series of dots, with an edge of another colour if one is given."""
    points = {"show": True, "size": size, "fill": color, "stroke": edge or color, "width": 1 if edge else 0}
    return {"label": label, "stroke": color, "width": 0, "points": points}


def axis_font(state: State) -> str:
    """Of the numbers and names along axes, which a style sheet does not reach."""
    return f"{14 if state.large_text else 11}px sans-serif"


def marked_up_to(last: float) -> dict[str, Any]:
    """Marks of an axis of whole numbers, written without the separators that a browser's language has."""
    step = next(step for step in _STEPS if last <= _MOST_STEPS * step)
    marks = np.arange(0.0, last + 1, step).tolist()
    return {"splits": marks, "values": [f"{mark:.0f}" for mark in marks]}


def plain_axes(state: State, powers: tuple[int, int] | None = None) -> list[Any]:
    """Axes with a faint grid, in the page's ink; for logarithms, y is marked at these powers of ten."""
    ink = palette.ink(state.dark)
    axis: dict[str, Any] = {"stroke": palette.css(ink), "grid": {"stroke": palette.css(ink, 0.12), "width": 1}}
    axis["font"] = axis_font(state)
    marks: dict[str, Any] = {}
    if powers:
        marked = range(powers[0], powers[1] + 1, 1 if powers[1] - powers[0] <= _MOST_POWERS else 2)
        marks["splits"] = [float(power) for power in marked]
        marks["values"] = [f"{10.0**power:g}" for power in marked]
    return [{**axis, "size": 30 if state.large_text else 24}, {**axis, **marks, "size": 60}]
