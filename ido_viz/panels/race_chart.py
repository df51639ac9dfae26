"""The likelihoods of the starts that got to the end of a race, over the iterations."""

from __future__ import annotations

from typing import Any

import numpy as np
import viser

from ido.types import DoubleArray
from ido_viz.core import palette
from ido_viz.core.frame import Frame
from ido_viz.panels.markup import caption
from ido_viz.panels.plot import Plot, plain_axes

_MOST = 6  # curves of a side
_ROOM = 0.05  # above and below the curves, as a share of their range


class RaceChart:
    """A chart that is there as long as a pane's method races from many starts."""

    def __init__(self, gui: viser.GuiApi) -> None:
        self._folder = gui.add_folder(None, visible=False)
        with self._folder:
            gui.add_html(caption("log-likelihood per point of the starts that got to the end"))
            self._plot = Plot(gui, height=92)
        self._look: tuple[object, ...] | None = None

    def draw(self, frame: Frame) -> None:
        """Draw the curves of a run and mark the iteration."""
        raced = any(side.run.race is not None for side in frame.sides)
        if self._folder.visible != raced:
            self._folder.visible = raced
        if not raced:
            return
        data = chart_data(frame)
        look = (*(side.run.race for side in frame.sides), frame.state.dark, frame.state.large_text)
        if look == self._look:
            self._plot.draw(data)
        else:
            self._plot.restyle(data, *_style(frame, data))
        self._look = look


def chart_data(frame: Frame) -> tuple[DoubleArray, ...]:
    """What is drawn of the races: their iterations; for each side its curves, the best one first; for each its mark.

    There are gaps where a side has fewer curves or none.
    """
    longest = max(side.run.race.steps + 1 for side in frame.sides if side.run.race is not None)
    iterations = np.arange(longest + 1, dtype=np.float64)
    curves, marks = [], []
    for side in frame.sides:
        its = np.full((_MOST, len(iterations)), np.nan)
        if side.run.race is not None:
            found = side.run.race.survivors(_MOST)
            its[: len(found), 1 : found.shape[1] + 1] = found
        shown = 0 if side.run.race is None or side.k == 0 else side.run.race.step(side.k) + 1
        curves += [*its]
        marks.append(np.where(iterations == shown, its[0], np.nan))
    return (iterations, *curves, *marks)


def _style(frame: Frame, data: tuple[DoubleArray, ...]) -> tuple[list[Any], dict[str, Any], list[Any]]:
    colors = [palette.method_color(side.run.method, frame.state.dark) for side in frame.sides]
    series: list[Any] = [{"label": "iteration"}]
    for color in colors:
        others = {"stroke": palette.css(color, 0.45), "width": 1, "points": {"show": False}}
        series += [{**others, "stroke": palette.css(color), "width": 2}, *([others] * (_MOST - 1))]
    series += [
        {"stroke": css, "width": 0, "points": {"show": True, "size": 9, "fill": css, "stroke": css}}
        for css in map(palette.css, colors)
    ]
    drawn = np.stack(data[1:])
    low, high = float(np.nanmin(drawn)), float(np.nanmax(drawn))
    room = _ROOM * max(high - low, 0.1)
    scales = {
        "x": {"time": False, "auto": False, "range": (0.0, float(len(data[0]) - 1))},
        "y": {"auto": False, "range": (low - room, high + room)},
    }
    return series, scales, plain_axes(frame.state)
