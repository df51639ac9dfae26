"""Charts of the docked panels: histograms against the reference line, errors over iterations, training errors."""

from __future__ import annotations

from typing import Any

import numpy as np
import viser

from ido.types import FloatArray
from ido_viz import palette
from ido_viz.run import MethodRun, Run, bin_order
from ido_viz.state import State

_TOP = 1.8  # of the histograms' y axis; the reference line of each block peaks at 1
_NONE = np.array([0.0, 1.0])


class HistogramChart:
    """A side's histogram against the reference line, block by block.

    Each block is drawn relative to its largest reference bin, so that all blocks fill the height.
    """

    def __init__(self, gui: viser.GuiApi, side: int) -> None:
        self._side = side
        self._caption = gui.add_html("")
        self._chart = gui.add_uplot((_NONE, _NONE), ({}, {}), height=122, padding=(4, 10, 0, 0))
        self._look: tuple[object, ...] | None = None

    def draw(self, run: Run, state: State, iteration: int) -> None:
        """Draw the histogram after so many iterations."""
        maps = run.sides[self._side].maps
        method = run.sides[self._side].method
        look = (id(maps), state.order, state.difference, state.dark)
        if look != self._look:
            self._restyle(method, run.sides[self._side], state)
            self._look = look
        blocks = relative_blocks(run.histogram(self._side, iteration), run.sides[self._side])
        reference = relative_blocks(maps.histogram.reference, run.sides[self._side])
        if state.difference:
            blocks, reference = blocks - reference, np.zeros_like(reference)
        n_blocks, n_bins = len(blocks), blocks.size
        order = bin_order(maps, state.order)
        in_blocks = np.full((n_blocks, n_bins), np.nan)
        ordered = blocks.reshape(-1)[order].reshape(n_blocks, -1)
        for b in range(n_blocks):
            in_blocks[b, b * ordered.shape[1] : (b + 1) * ordered.shape[1]] = ordered[b]
        bins = np.arange(n_bins, dtype=np.float64)
        line = reference.reshape(-1)[order].astype(np.float64)
        self._chart.data = (bins, *np.clip(in_blocks, -_TOP, _TOP), line)

    def _restyle(self, method: str, side: MethodRun, state: State) -> None:
        histogram = side.maps.histogram
        n_model, names = len(histogram.model.points), [name for block in histogram.blocks for name in block]
        ink = palette.css(palette.ink(state.dark))
        low = -1.0 if state.difference else 0.0
        middles = [float((i + 0.5) * n_model) for i in range(len(names))]
        edges = [float(i * n_model) for i in range(len(names) + 1)]
        n_blocks = len(histogram.blocks)
        empty = np.zeros(2)
        series: list[Any] = [{"label": "bin"}]
        for b, block in enumerate(histogram.blocks):
            series.append({"label": " / ".join(block), "stroke": palette.css(palette.BLOCKS[b % 3]), "width": 1})
        series.append({"label": "reference", "stroke": ink, "width": 1.5})
        for one in series[1:]:
            one["points"] = {"show": False}
        axes: list[Any] = [
            {
                "splits": edges,
                "values": ["" for _ in edges],
                "size": 4,
                "grid": {"stroke": palette.css(palette.ink(state.dark), 0.25), "width": 1},
            },
            {"splits": [low, 0.0, 1.0], "values": [f"{v:g}" for v in (low, 0.0, 1.0)], "size": 24, "stroke": ink},
            {
                "scale": "x",
                "side": 2,
                "splits": middles,
                "values": [_SHORT.get(name, name) for name in names],
                "grid": {"show": False},
                "ticks": {"show": False},
                "size": 18,
                "gap": 0,
                "font": "11px sans-serif",
                "stroke": ink,
            },
        ]
        with_self = self._chart
        with_self.data = (empty, *([empty] * (n_blocks + 1)))
        with_self.series = tuple(series)
        with_self.scales = {
            "x": {"time": False, "auto": False, "range": (0.0, float(histogram.n_bins))},
            "y": {"auto": False, "range": (low, 1.0 if state.difference else _TOP)},
        }
        with_self.axes = tuple(axes)
        with_self.legend = {"show": False}
        with_self.cursor = {"show": False}
        what = "minus reference" if state.difference else "against the reference line"
        self._caption.content = caption(f"<b>{method_span(method, self._side)}</b> histogram {what}")


_SHORT = {"clockwise": "clockw.", "anticlockwise": "anticl."}


def relative_blocks(histogram: FloatArray, side: MethodRun) -> FloatArray:
    """A histogram by blocks, each relative to the block's largest reference bin; shape (blocks, 2 M)."""
    n_blocks = len(side.maps.histogram.blocks)
    largest = side.maps.histogram.reference.reshape(n_blocks, -1).max(axis=1, keepdims=True)
    return histogram.reshape(n_blocks, -1) / np.where(largest > 0, largest, 1.0)


class ErrorCharts:
    """PointRMSE, PointAcc and update norm of both sides over the iterations, with the shown one marked."""

    def __init__(self, gui: viser.GuiApi) -> None:
        self._caption = gui.add_html("")
        self._charts = {}
        for name in ("PointRMSE", "PointAcc", "update norm"):
            gui.add_html(caption(name + (" (log), with the threshold ε" if name == "update norm" else "")))
            self._charts[name] = gui.add_uplot((_NONE, _NONE), ({}, {}), height=92, padding=(4, 10, 0, 0))
        self._drawn: tuple[object, ...] | None = None

    def draw(self, run: Run, state: State, iteration: int) -> None:
        """Draw the curves of a run and mark an iteration."""
        iterations = np.arange(run.iterations + 1, dtype=np.float64)
        if (id(run), state.dark) != self._drawn:
            self._restyle(run, state)
            self._drawn = (id(run), state.dark)
        for name, chart in self._charts.items():
            curves = [padded(curve(side, name), len(iterations)) for side in run.sides]
            marks = [np.full(len(iterations), np.nan) for _ in run.sides]
            for side, values, mark in zip(run.sides, curves, marks, strict=True):
                k = side.clipped(iteration)
                mark[k] = values[k]
            extra = (np.full(len(iterations), state.epsilon),) if name == "update norm" else ()
            chart.data = (iterations, *curves, *marks, *extra)

    def _restyle(self, run: Run, state: State) -> None:
        ink = palette.css(palette.ink(state.dark))
        self._caption.content = caption(" &nbsp; ".join(method_span(s.method, i) for i, s in enumerate(run.sides)))
        empty = np.zeros(2)
        for name, chart in self._charts.items():
            log = name == "update norm"
            lines: list[Any] = [{"label": "iteration"}]
            for color in palette.METHODS:
                lines.append({"stroke": palette.css(color), "width": 1.5, "points": {"show": False}})
            for color in palette.METHODS:
                point = {"show": True, "size": 9, "fill": palette.css(color), "stroke": palette.css(color)}
                lines.append({"stroke": palette.css(color), "width": 0, "points": point})
            if log:
                lines.append({"stroke": ink, "width": 1, "dash": [4, 4], "points": {"show": False}})
            if name == "PointAcc":
                y: Any = {"auto": False, "range": (0.0, 1.05)}
            elif log:
                y = {"distr": 3, "auto": False, "range": (1e-4, 10.0)}
            else:
                top = max(float(side.scores.rmse.max()) for side in run.sides)
                y = {"auto": False, "range": (0.0, 1.05 * max(top, 1e-3))}
            axis = {"stroke": ink, "grid": {"stroke": palette.css(palette.ink(state.dark), 0.12), "width": 1}}
            chart.data = (empty, *([empty] * (len(lines) - 1)))
            chart.series = tuple(lines)
            chart.scales = {"x": {"time": False, "auto": False, "range": (0.0, float(max(run.iterations, 1)))}, "y": y}
            chart.axes = ({**axis, "size": 24}, {**axis, "size": 44})  # type: ignore[assignment]
            chart.legend = {"show": False}
            chart.cursor = {"show": False}


def curve(side: MethodRun, name: str) -> FloatArray:
    """A curve of a run over its iterations, shape (n + 1,); the update norm is that of the update that led there."""
    if name == "update norm":
        return np.concatenate([[np.nan], side.trajectory.update_norms])
    return side.scores.rmse if name == "PointRMSE" else side.scores.accuracy


def padded(values: FloatArray, length: int) -> FloatArray:
    """Values followed by gaps, to a length."""
    return np.concatenate([values, np.full(length - len(values), np.nan)]).astype(np.float64)


class TrainingCharts:
    """Mean training error of both sides' maps: all of it, the rotation part and the translation part."""

    def __init__(self, gui: viser.GuiApi) -> None:
        self._caption = gui.add_html("")
        self._charts = {}
        for name, title in (
            ("mean", "mean training error ‖x* - x‖² after each map"),
            ("deviation", "its standard deviation over the samples"),
            ("rotation", "rotation part, rad²"),
            ("translation", "translation part"),
        ):
            gui.add_html(caption(title))
            self._charts[name] = gui.add_uplot((_NONE, _NONE), ({}, {}), height=88, padding=(4, 10, 0, 0))
        self._drawn: tuple[object, ...] | None = None

    def draw(self, run: Run, state: State) -> None:
        """Draw the training curves of the shown methods."""
        look = (id(run.sides[0].maps), id(run.sides[1].maps), state.dark)
        if look == self._drawn:
            return
        self._drawn = look
        ink = palette.css(palette.ink(state.dark))
        self._caption.content = caption(" &nbsp; ".join(method_span(s.method, i) for i, s in enumerate(run.sides)))
        axis: Any = {"stroke": ink, "grid": {"stroke": palette.css(palette.ink(state.dark), 0.12), "width": 1}}
        for name, chart in self._charts.items():
            curves = [getattr(side.maps.curves, name) for side in run.sides]
            length = max(len(values) for values in curves)
            series: list[Any] = [{"label": "maps"}]
            for color in palette.METHODS:
                point = {"show": True, "size": 4, "fill": palette.css(color), "stroke": palette.css(color)}
                series.append({"stroke": palette.css(color), "width": 1.5, "points": point})
            top = 1.05 * max(float(values.max()) for values in curves)
            chart.series = tuple(series)
            chart.scales = {
                "x": {"time": False, "auto": False, "range": (0.0, float(length - 1))},
                "y": {"auto": False, "range": (0.0, top)},
            }
            chart.axes = ({**axis, "size": 24}, {**axis, "size": 44})
            chart.legend = {"show": False}
            chart.cursor = {"show": False}
            chart.data = (np.arange(length, dtype=np.float64), *(padded(values, length) for values in curves))


def caption(content: str) -> str:
    """A small line of text above a chart; `content` is HTML."""
    return f'<div style="font-size:12px;line-height:1.3;margin:2px 8px 0 8px">{content}</div>'


def method_span(method: str, side: int) -> str:
    """A method's name in its pane's colour, as HTML."""
    import html

    return f'<span style="color:{palette.css(palette.METHODS[side])}">● {html.escape(method)}</span>'
