"""The tab Errors: scores, update norm and distance to the reference line over the iterations, and a race of starts."""

from __future__ import annotations

from typing import Any

import numpy as np
import viser

from ido.types import DoubleArray
from ido_viz.core import palette
from ido_viz.core.chart_data import CURVES, curve, padded
from ido_viz.core.frame import Frame
from ido_viz.core.run import Run
from ido_viz.core.state import LONGEST_RUN, State
from ido_viz.panels.markup import both_methods, caption
from ido_viz.panels.plot import Plot, marked_up_to, plain_axes
from ido_viz.panels.race_chart import RaceChart

_TITLES = {
    "update norm": "update norm, with the threshold ε dashed",
    "histogram distance": "distance of the histogram from the reference line, as a share of the line's length",
}


class ErrorsTab:
    """A chart for each of the `CURVES`, with the shown iteration marked."""

    def __init__(self, gui: viser.GuiApi) -> None:
        self._caption = gui.add_html("")
        self._race = RaceChart(gui)
        self._plots = {}
        for name in CURVES:
            gui.add_html(caption(_TITLES.get(name, name)))
            self._plots[name] = Plot(gui, height=92)
        self._look: tuple[object, ...] | None = None

    def draw(self, frame: Frame) -> None:
        """Draw the curves of a run and mark the iteration."""
        run, state = frame.run, frame.state
        look = (*_scales(run), *(side.method for side in run.sides), state.dark, state.large_text)
        for name, plot in self._plots.items():
            data = _data(frame, name)
            if look == self._look:
                plot.draw(data)
            else:
                plot.restyle(data, *_style(run, name, state))
        if look != self._look:
            self._caption.content = caption(f"{both_methods(run, state.dark)} &nbsp; over the iterations")
        self._look = look
        self._race.draw(frame)


def _data(frame: Frame, name: str) -> tuple[DoubleArray, ...]:
    """Iterations, both curves, both marks, and the threshold where it belongs."""
    iterations = np.arange(frame.run.iterations + 1, dtype=np.float64)
    curves = [padded(curve(side, name), len(iterations)) for side in frame.run.sides]
    marks = [np.where(iterations == side.k, values, np.nan) for side, values in zip(frame.sides, curves, strict=True)]
    threshold = (np.full(len(iterations), np.log10(frame.state.epsilon)),) if name == "update norm" else ()
    return (iterations, *curves, *marks, *threshold)


def _scales(run: Run) -> tuple[float, float, float]:
    """Ends of the axes of iterations, PointRMSE and distance, in steps: they stand still while a slider is dragged."""
    last = next(step for step in (40, 60, 100, 200, 400, 700, 1000, 2000, LONGEST_RUN) if step >= run.iterations)
    rmse = max(side.scores.rmse.max() for side in run.sides)
    distance = max(side.distances.max() for side in run.sides)
    return float(last), _above(rmse), _above(distance)


def _above(value: float) -> float:
    """The next half."""
    return float(np.ceil(2 * max(value, 0.1)) / 2)


def _style(run: Run, name: str, state: State) -> tuple[list[Any], dict[str, Any], list[Any]]:
    series: list[Any] = [{"label": "iteration"}]
    colors = [palette.css(palette.method_color(side.method, state.dark)) for side in run.sides]
    series += [{"stroke": color, "width": 1.5, "points": {"show": False}} for color in colors]
    series += [
        {"stroke": color, "width": 0, "points": {"show": True, "size": 9, "fill": color, "stroke": color}}
        for color in colors
    ]
    last, rmse, distance = _scales(run)
    y: dict[str, Any] = {"auto": False, "range": (0.0, 1.05)}
    if name == "update norm":
        ink = palette.css(palette.ink(state.dark))
        series.append({"stroke": ink, "width": 1, "dash": [4, 4], "points": {"show": False}})
        y["range"] = (-4.5, 0.5)
    elif name == "PointRMSE":
        y["range"] = (0.0, rmse)
    elif name == "histogram distance":
        y["range"] = (0.0, distance)
    x = {"time": False, "auto": False, "range": (0.0, last)}
    axes = plain_axes(state, powers=(-4, 0) if name == "update norm" else None)
    axes[0] |= marked_up_to(last)
    return series, {"x": x, "y": y}, axes
