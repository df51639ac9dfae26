"""The tab Histograms: both methods' histograms against the reference line."""

from __future__ import annotations

import html
from typing import Any

import viser

from ido_viz.core import palette
from ido_viz.core.chart_data import histogram_data
from ido_viz.core.frame import Frame, SideFrame
from ido_viz.core.state import State
from ido_viz.core.wording import short_side
from ido_viz.panels.markup import caption, method_span
from ido_viz.panels.plot import Plot, axis_font, dots

_LARGER_TEXT_TAKES = 22  # pixels of a chart's height, so that both charts stay in sight
_TOP = 1.8  # of the y axis; the reference line of each block peaks at 1


class HistogramsTab:
    """A chart for each pane.

    Args:
        gui: where they are placed.
        window: height of the browser's window, pixels.
    """

    def __init__(self, gui: viser.GuiApi, window: int) -> None:
        height = min(max(round(0.29 * window) - 112, 104), 200)  # so that both fill the upper half
        self._charts = [_HistogramChart(gui, height) for _ in range(2)]

    def draw(self, frame: Frame) -> None:
        """Draw both histograms."""
        for chart, side in zip(self._charts, frame.sides, strict=True):
            chart.draw(side, frame.state)


class _HistogramChart:
    """Each block is drawn relative to its largest reference bin, so that all blocks fill the height."""

    def __init__(self, gui: viser.GuiApi, height: int) -> None:
        self._caption = gui.add_html("")
        self._height = height
        self._plot = Plot(gui, height)
        self._look: tuple[object, ...] | None = None

    def draw(self, side: SideFrame, state: State) -> None:
        """Draw a histogram, with what is laid over it and the inspected point's bins."""
        run, data = side.run, histogram_data(side, state)
        look = (run.histogram, run.method, state.order, state.difference, state.dark, state.large_text)
        look += (side.overlay is None, state.overlay, bool(run.waiting))
        if look == self._look:
            self._plot.draw(data)
            return
        self._look = look
        self._plot.height = self._height - (_LARGER_TEXT_TAKES if state.large_text else 0)
        self._plot.restyle(data, *_style(side, state))
        what = "minus the reference line" if state.difference else "against the reference line"
        if state.order != "reference value" and not state.difference:
            what = "against the reference"  # in another order it is no line
        seen_by = "histogram" if run.maps else f"as {html.escape(run.histogram.name)} sees it,"
        if run.waiting:
            seen_by = f"is not there yet; until then {seen_by}"
        name = f'<b data-histogram="{side.pane}">{method_span(run.method, state.dark)}</b>'
        self._caption.content = caption(f"{name} {seen_by} {what}")


def _style(side: SideFrame, state: State) -> tuple[list[Any], dict[str, Any], list[Any]]:
    histogram = side.run.histogram
    low, high = (-1.1, 1.1) if state.difference else (0.0, _TOP)
    scales = {
        "x": {"time": False, "auto": False, "range": (0.0, float(histogram.n_bins))},
        "y": {"auto": False, "range": (low, high)},
    }
    return _series(side, state), scales, _axes(side, state)


def _series(side: SideFrame, state: State) -> list[Any]:
    ink = palette.css(palette.ink(state.dark))
    series: list[Any] = [{"label": "bin"}, dots("overlaid", palette.css(palette.ink(state.dark), 0.45), size=2)]
    for number, block in enumerate(side.run.histogram.blocks):
        series.append(dots(block.name, palette.css(palette.block_color(block, number)), size=2))
    if state.order == "reference value":
        series.append({"label": "reference", "stroke": ink, "width": 1.5, "points": {"show": False}})
    else:  # a line would fill the chart
        series.append(dots("reference", ink, size=2))
    return [*series, dots("marked", palette.css(palette.MARK), size=9, edge=ink)]


def _axes(side: SideFrame, state: State) -> list[Any]:
    """Lines between the sides, their names above, and the levels to the left."""
    histogram = side.run.histogram
    names, n_model = histogram.side_names, len(histogram.model.points)
    ink = palette.css(palette.ink(state.dark))
    edges = [float(i * n_model) for i in range(len(names) + 1)]
    levels = [-1.0, 0.0, 1.0] if state.difference else [0.0, 1.0]
    faint = palette.css(palette.ink(state.dark), 0.25)
    nameless: dict[str, Any] = {"splits": edges, "values": ["" for _ in edges], "size": 4, "ticks": {"show": False}}
    return [
        {**nameless, "grid": {"stroke": faint, "width": 1}},
        {
            "splits": levels,
            "values": [f"{v:g}" for v in levels],
            "size": 30,
            "stroke": ink,
            "font": axis_font(state),
        },
        {
            "scale": "x",
            "side": 2,
            "splits": [(i + 0.5) * n_model for i in range(len(names))],
            "values": [short_side(name) for name in names],
            "grid": {"show": False},
            "ticks": {"show": False},
            "size": 22 if state.large_text else 18,
            "gap": 0,
            "font": axis_font(state),
            "stroke": ink,
        },
    ]
