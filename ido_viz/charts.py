"""Charts of the docked panels: histograms against the reference line, and errors over iterations."""

from __future__ import annotations

import html
from typing import Any

import numpy as np
import viser

from ido.types import DoubleArray, FloatArray
from ido_viz import palette
from ido_viz.microscope import Inspection
from ido_viz.overlay import overlaid
from ido_viz.run import MethodRun, Run, bin_order, norms
from ido_viz.state import LONGEST_RUN, State

_LARGER_TEXT_TAKES = 22  # pixels of a chart's height, so that both charts stay in sight
_MOST_POWERS = 4  # of ten, that are all marked along an axis
_TOP = 1.8  # of the histograms' y axis; the reference line of each block peaks at 1


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


class HistogramChart:
    """A side's histogram against the reference line, block by block.

    Each block is drawn relative to its largest reference bin, so that all blocks fill the height.
    """

    def __init__(self, gui: viser.GuiApi, side: int, height: int) -> None:
        self._side = side
        self._caption = gui.add_html("")
        self._height = height
        self._plot = Plot(gui, height)
        self._look: tuple[object, ...] | None = None

    def draw(self, run: Run, state: State, iteration: int, inspection: Inspection | None) -> None:
        """Draw the histogram after so many iterations, with what is laid over it and the inspected point's bins."""
        side = run.sides[self._side]
        seen = run.histogram(self._side, iteration) if inspection is None else inspection.seen
        over = overlaid(run, state, iteration, self._side)
        also = None if over is None else side.histogram(run.scene.points, over.x)
        order = bin_order(side.histogram, state.order, None if inspection is None else inspection.values)
        data = histogram_data(side, state, order, seen, also)
        look = (id(side.histogram), side.method, state.order, state.difference, state.dark, state.large_text)
        look += (also is None, state.overlay)
        if look == self._look:
            self._plot.draw(data)
            return
        self._look = look
        self._plot.height = self._height - (_LARGER_TEXT_TAKES if state.large_text else 0)
        self._plot.restyle(data, *_histogram_style(side, state))
        what = "minus the reference line" if state.difference else "against the reference line"
        seen_by = "histogram" if side.maps else f"as {html.escape(side.histogram.name)} sees it,"
        self._caption.content = caption(f"<b>{method_span(side.method, self._side)}</b> {seen_by} {what}")


def histogram_data(
    side: MethodRun, state: State, order: np.ndarray, seen: FloatArray, also: FloatArray | None
) -> tuple[DoubleArray, ...]:
    """What is drawn of a histogram, each of shape (n_bins,): places, a second histogram, the blocks, the line, marks.

    Each block has an array of its own, with gaps elsewhere; all values are relative to the block's largest reference.

    Args:
        side: whose histogram.
        state: of the page: whether the reference is taken off, and which model point's bins are marked.
        order: of the bins, from `bin_order`.
        seen: the histogram, shape (n_bins,).
        also: a second one that is laid over it; None for none.
    """
    reference = relative_blocks(side.histogram.reference, side)
    base = reference if state.difference else np.zeros_like(reference)
    values = (relative_blocks(seen, side) - base).reshape(-1)[order]
    second = np.full(values.size, np.nan) if also is None else (relative_blocks(also, side) - base).reshape(-1)[order]
    n_model, n_blocks = len(side.histogram.model.points), len(reference)
    block_of = np.arange(values.size) * n_blocks // values.size
    separate = [np.where(block_of == b, values, np.nan) for b in range(n_blocks)]
    marked = np.where(order % n_model == state.inspected, values, np.nan)
    line = (reference - base).reshape(-1)[order]
    columns = (np.arange(values.size), second, *separate, line, marked)
    return tuple(column.astype(np.float64) for column in columns)


def _histogram_style(side: MethodRun, state: State) -> tuple[list[Any], dict[str, Any], list[Any]]:
    histogram = side.histogram
    n_model, names = len(histogram.model.points), [name for block in histogram.blocks for name in block]
    ink = palette.css(palette.ink(state.dark))
    low, high = (-1.1, 1.1) if state.difference else (0.0, _TOP)
    series: list[Any] = [{"label": "bin"}, _dots("overlaid", palette.css(palette.ink(state.dark), 0.45), size=2)]
    for b, block in enumerate(histogram.blocks):
        series.append(_dots(" / ".join(block), palette.css(palette.BLOCKS[b % len(palette.BLOCKS)]), size=2))
    if state.order == "reference value":
        series.append({"label": "reference", "stroke": ink, "width": 1.5, "points": {"show": False}})
    else:  # a line would fill the chart
        series.append(_dots("reference", ink, size=2))
    series.append(_dots("marked", palette.css(palette.MARK), size=9, edge=ink))
    edges = [float(i * n_model) for i in range(len(names) + 1)]
    levels = [-1.0, 0.0, 1.0] if state.difference else [0.0, 1.0]
    faint = palette.css(palette.ink(state.dark), 0.25)
    nameless: dict[str, Any] = {"splits": edges, "values": ["" for _ in edges], "size": 4, "ticks": {"show": False}}
    axes: list[Any] = [
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
            "values": [_SHORT.get(name, name) for name in names],
            "grid": {"show": False},
            "ticks": {"show": False},
            "size": 22 if state.large_text else 18,
            "gap": 0,
            "font": axis_font(state),
            "stroke": ink,
        },
    ]
    scales = {
        "x": {"time": False, "auto": False, "range": (0.0, float(histogram.n_bins))},
        "y": {"auto": False, "range": (low, high)},
    }
    return series, scales, axes


def _dots(label: str, color: str, *, size: int, edge: str = "") -> dict[str, Any]:
    """A series of dots, with an edge of another colour if one is given."""
    points = {"show": True, "size": size, "fill": color, "stroke": edge or color, "width": 1 if edge else 0}
    return {"label": label, "stroke": color, "width": 0, "points": points}


_SHORT = {"clockwise": "clockw.", "anticlockwise": "anticl."}


def relative_blocks(histogram: FloatArray, side: MethodRun) -> FloatArray:
    """A histogram by blocks, each relative to the block's largest reference bin; shape (blocks, 2 M)."""
    n_blocks = len(side.histogram.blocks)
    largest = side.histogram.reference.reshape(n_blocks, -1).max(axis=1, keepdims=True)
    return histogram.reshape(n_blocks, -1) / np.where(largest > 0, largest, 1.0)


CURVES = {
    "PointRMSE": "PointRMSE",
    "PointAcc": "PointAcc",
    "update norm": "update norm, with the threshold ε dashed",
    "histogram distance": "distance of the histogram from the reference line, as a share of the line's length",
}
"""What is drawn over the iterations, and its title."""


class ErrorCharts:
    """Scores, update norm and distance to the reference over the iterations, with the shown one marked."""

    def __init__(self, gui: viser.GuiApi) -> None:
        self._caption = gui.add_html("")
        self._plots = {}
        for name, title in CURVES.items():
            gui.add_html(caption(title))
            self._plots[name] = Plot(gui, height=92)
        self._look: tuple[object, ...] | None = None

    def draw(self, run: Run, state: State, iteration: int) -> None:
        """Draw the curves of a run and mark an iteration."""
        look = (*_error_scales(run), *(side.method for side in run.sides), state.dark, state.large_text)
        for name, plot in self._plots.items():
            data = _error_data(run, name, state.epsilon, iteration)
            if look == self._look:
                plot.draw(data)
            else:
                plot.restyle(data, *_error_style(run, name, state))
        if look != self._look:
            self._caption.content = caption(both_methods(run))
        self._look = look


def _error_data(run: Run, name: str, epsilon: float, iteration: int) -> tuple[DoubleArray, ...]:
    """Iterations, both curves, both marks, and the threshold where it belongs."""
    iterations = np.arange(run.iterations + 1, dtype=np.float64)
    curves = [padded(curve(side, name), len(iterations)) for side in run.sides]
    marks = [
        np.where(iterations == side.clipped(iteration), values, np.nan)
        for side, values in zip(run.sides, curves, strict=True)
    ]
    threshold = (np.full(len(iterations), np.log10(epsilon)),) if name == "update norm" else ()
    return (iterations, *curves, *marks, *threshold)


def _error_scales(run: Run) -> tuple[float, float, float]:
    """Ends of the axes of iterations, PointRMSE and distance, in steps: they stand still while a slider is dragged."""
    last = next(step for step in (40, 60, 100, 200, 400, 700, 1000, 2000, LONGEST_RUN) if step >= run.iterations)
    rmse = max(side.scores.rmse.max() for side in run.sides)
    distance = max(side.distances.max() for side in run.sides)
    return float(last), _above(rmse), _above(distance)


def _above(value: float) -> float:
    """The next half."""
    return float(np.ceil(2 * max(value, 0.1)) / 2)


def _error_style(run: Run, name: str, state: State) -> tuple[list[Any], dict[str, Any], list[Any]]:
    series: list[Any] = [{"label": "iteration"}]
    colors = [palette.css(color) for color in palette.METHODS]
    series += [{"stroke": color, "width": 1.5, "points": {"show": False}} for color in colors]
    series += [
        {"stroke": color, "width": 0, "points": {"show": True, "size": 9, "fill": color, "stroke": color}}
        for color in colors
    ]
    y: dict[str, Any] = {"auto": False, "range": (0.0, 1.05)}
    if name == "update norm":
        ink = palette.css(palette.ink(state.dark))
        series.append({"stroke": ink, "width": 1, "dash": [4, 4], "points": {"show": False}})
        y["range"] = (-4.5, 0.5)
    elif name == "PointRMSE":
        y["range"] = (0.0, _error_scales(run)[1])
    elif name == "histogram distance":
        y["range"] = (0.0, _error_scales(run)[2])
    x = {"time": False, "auto": False, "range": (0.0, _error_scales(run)[0])}
    return series, {"x": x, "y": y}, plain_axes(state, powers=(-4, 0) if name == "update norm" else None)


def curve(side: MethodRun, name: str) -> FloatArray:
    """A curve of a run over its iterations, shape (n + 1,); of the norm of the next update, its logarithm."""
    if name == "update norm":
        return np.log10(np.maximum(norms(side), 1e-12))
    return {"PointRMSE": side.scores.rmse, "PointAcc": side.scores.accuracy, "histogram distance": side.distances}[name]


def padded(values: FloatArray, length: int) -> DoubleArray:
    """Values followed by gaps, to a length."""
    return np.concatenate([values, np.full(length - len(values), np.nan)]).astype(np.float64)


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


def caption(content: str) -> str:
    """A small line of text above a chart; `content` is HTML."""
    return f'<div style="font-size:0.75rem;line-height:1.3;margin:2px 8px 0 8px">{content}</div>'


def method_span(method: str, side: int) -> str:
    """A method's name in its pane's colour, as HTML."""
    return f'<span style="color:{palette.css(palette.METHODS[side])}">● {html.escape(method)}</span>'


def both_methods(run: Run) -> str:
    """Both methods' names in their colours, as HTML."""
    return " &nbsp; ".join(method_span(side.method, i) for i, side in enumerate(run.sides))
