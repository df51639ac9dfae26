"""A live chart, and the axes that charts share."""

from __future__ import annotations

from typing import Any

import viser

from ido.types import DoubleArray
from ido_viz.core import palette
from ido_viz.core.state import State

_MOST_POWERS = 4  # of ten, that are all marked along an axis


class Plot:
    """A chart whose style is set whole: a new style makes a new chart in the same place, new data only moves it."""

    def __init__(self, gui: viser.GuiApi, height: int) -> None:
        self._gui = gui
        self.height = height
        self._folder = gui.add_folder(None)
        self._chart: viser.GuiUplotHandle | None = None

    def restyle(
        self, data: tuple[DoubleArray, ...], series: list[Any], scales: dict[str, Any], axes: list[Any]
    ) -> None:
        """Draw with a new style."""
        old = self._chart
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
        if old is not None:
            old.remove()

    def draw(self, data: tuple[DoubleArray, ...]) -> None:
        """Draw new data in the style that was set."""
        assert self._chart is not None
        self._chart.data = data


def dots(label: str, color: str, *, size: int, edge: str = "") -> dict[str, Any]:
    """A series of dots, with an edge of another colour if one is given."""
    points = {"show": True, "size": size, "fill": color, "stroke": edge or color, "width": 1 if edge else 0}
    return {"label": label, "stroke": color, "width": 0, "points": points}


def axis_font(state: State) -> str:
    """Of the numbers and names along axes, which a style sheet does not reach."""
    return f"{14 if state.large_text else 11}px sans-serif"


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
