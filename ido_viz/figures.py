"""The charts of a page as figures for a paper: both columns wide, on white, drawn with Matplotlib."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, MaxNLocator, NullFormatter

from ido.histograms import Histogram
from ido.poses import PARAMETERS
from ido.types import DoubleArray, FloatArray
from ido_viz import palette
from ido_viz.captions import shown_iteration
from ido_viz.charts import CURVES, curve, histogram_data
from ido_viz.microscope import Inspection, inspect_both
from ido_viz.overlay import overlaid
from ido_viz.palette import Color
from ido_viz.run import MethodRun, Run, bin_order
from ido_viz.state import State

WIDTH = 7.1
"""Of every figure, inches: both columns of a page."""

DOTS_PER_INCH = 300
"""Of a PNG."""

STYLE: dict[Any, Any] = {
    "font.family": "sans-serif",
    # the first one ships with Matplotlib and is the widest: where another takes its place, the text still fits
    "font.sans-serif": ["DejaVu Sans", "Arial", "Helvetica"],
    "font.size": 8,
    "axes.titlesize": 8.5,
    "axes.titlelocation": "left",
    "axes.labelsize": 8,
    "xtick.labelsize": 8,
    "ytick.labelsize": 8,
    "axes.linewidth": 0.6,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.axisbelow": True,
    "grid.color": "#e4e4e4",
    "grid.linewidth": 0.5,
    "legend.frameon": False,
    "figure.facecolor": "white",
    "text.parse_math": False,  # a method's name is nobody's formula
    "axes.unicode_minus": True,
    "svg.fonttype": "none",  # text stays text
    "svg.hashsalt": "ido",  # the same figure gives the same file
}
"""Matplotlib's settings, to be in force while a figure is made and written."""

_INK, _FAINT = "#3c3c3c", "#9a9a9a"
_ROW = 40  # pixels that each row of a map is drawn from
_DASHES: tuple[Any, Any] = ("solid", (0, (5, 1.5)))  # of the methods, for print without colours
_CROWDED = 8  # more names of blocks than these stand aslant
_LONGEST_NAME = 40  # characters
_SMALLEST_NORM = 1e-9  # that is drawn
_CURVE_TITLES = {
    "PointRMSE": "PointRMSE, model units",
    "PointAcc": "PointAcc",
    "update norm": "update norm ‖Δx‖",
    "histogram distance": "relative distance from the reference line",
}


def histograms_figure(run: Run, state: State) -> Figure:
    """Both methods' histograms at the state's iteration, against the reference line, as the page draws them."""
    iteration = shown_iteration(run, state)
    figure = Figure(figsize=(WIDTH, 4.0), layout="constrained")
    inspections = inspect_both(run, state, iteration)
    for number, (ax, side) in enumerate(zip(figure.subplots(2, 1, sharey=True), run.sides, strict=True)):
        over = overlaid(run, state, iteration, number)
        also = None if over is None else side.histogram(run.scene.points, over.x)
        order = _order(side, state, inspections[number])
        _draw_histogram(ax, side, state, histogram_data(side, state, order, run.histogram(number, iteration), also))
        shown = f"iteration {side.clipped(iteration)} of {side.trajectory.iterations}"
        seen = "" if side.maps else f", seen through the histogram {side.histogram.name}"
        _head(ax, number, side, shown + seen + ("" if over is None else f"; grey: {over.title}"))
        ax.set_ylabel(("difference, " if state.difference else "") + "relative to the\nlargest reference bin")
        _name_sides(ax, side.histogram)
    return figure


def _draw_histogram(ax: Axes, side: MethodRun, state: State, data: tuple[DoubleArray, ...]) -> None:
    places, second, *blocks, line, marked = data
    dots: dict[str, Any] = {"linestyle": "none", "marker": "o", "markeredgewidth": 0}
    ax.plot(places, second, color=_FAINT, markersize=1.3, **dots)
    for number, block in enumerate(blocks):
        ax.plot(places, block, color=_hex(palette.BLOCKS[number % len(palette.BLOCKS)]), markersize=1.9, **dots)
    if state.order == "reference value":
        for part in np.split(np.arange(len(places)), 2 * len(blocks)):
            ax.plot(places[part], line[part], color=_INK, linewidth=1)
    else:  # a line would fill the chart
        ax.plot(places, line, color=_INK, markersize=1.3, **dots)
    picked = {"color": _hex(palette.MARK), "markersize": 4.5, "markeredgewidth": 0.6, "markeredgecolor": _INK}
    ax.plot(places, marked, **{**dots, **picked})
    ax.set_xlim(-0.5, len(places) - 0.5)
    ax.margins(y=0.03)


def maps_figure(run: Run, state: State) -> Figure:
    """The learned maps that the page shows: those of the next update, or the pinned ones; a row for each method.

    Six rows for the coordinates of x and a column for each bin, in the state's order.
    """
    iteration = shown_iteration(run, state)
    inspections = inspect_both(run, state, iteration)
    learned = [(number, side) for number, side in enumerate(run.sides) if side.maps]
    figure = Figure(figsize=(WIDTH, 1.65 * len(learned)), layout="constrained")
    panels = figure.subplots(len(learned), 1, squeeze=False)[:, 0]
    for ax, (number, side) in zip(panels, learned, strict=True):
        assert side.maps is not None
        shown = shown_map(side, state, iteration)
        values = side.maps.maps[shown - 1][:, _order(side, state, inspections[number])]
        _draw_map(ax, values)
        pinned = " (pinned)" if state.pinned_map else ""
        _head(ax, number, side, f"map {shown} of {len(side.maps.maps)}{pinned}", letters=len(learned) > 1)
        _name_sides(ax, side.histogram)
    return figure


def shown_map(side: MethodRun, state: State, iteration: int) -> int:
    """Number, from 1, of the map that the page shows of a learned method."""
    assert side.maps is not None
    return min(state.pinned_map, len(side.maps.maps)) if state.pinned_map else side.map_number(iteration)


def _draw_map(ax: Axes, values: FloatArray) -> None:
    scale = float(np.quantile(np.abs(values), 0.995)) or 1.0
    tall = np.repeat(values, _ROW, axis=0)  # so that drawing averages neighbouring bins, but not rows
    corners = (-0.5, values.shape[1] - 0.5, 5.5, -0.5)
    picture = ax.imshow(tall, cmap="RdBu_r", vmin=-scale, vmax=scale, aspect="auto", extent=corners)
    bar = ax.figure.colorbar(picture, ax=ax, pad=0.012, aspect=10, extend="both", ticks=[-scale, 0, scale])
    bar.ax.set_yticklabels([f"−{scale:.2g}", "0", f"{scale:.2g}"])
    bar.outline.set_linewidth(0.4)  # pyright: ignore[reportCallIssue]
    ax.set_yticks(range(6), PARAMETERS)
    ax.tick_params(axis="y", length=0)


def curves_figure(run: Run, state: State) -> Figure:
    """Scores, update norm and distance to the reference line over the iterations; dots at the state's iteration."""
    iteration = shown_iteration(run, state)
    figure = Figure(figsize=(WIDTH, 3.9), layout="constrained")
    panels = figure.subplots(2, 2, sharex=True)
    for letter, ax, name in zip("abcd", panels.flat, CURVES, strict=True):
        ax.set_title(f"({letter}) {_CURVE_TITLES[name]}")
        for number, side in enumerate(run.sides):
            values = 10 ** curve(side, name) if name == "update norm" else curve(side, name)
            color, k = _hex(palette.METHODS[number]), side.clipped(iteration)
            ax.plot(values, color=color, linestyle=_DASHES[number], linewidth=1.2, label=str(number))
            ax.plot(k, values[k], marker="o", color=color, markersize=4, markeredgewidth=0, clip_on=False, zorder=3)
        ax.grid()
        ax.set_ylim(bottom=0)
        ax.xaxis.set_major_locator(MaxNLocator(6, integer=True))
    panels[0, 1].set_ylim(0, 1.05)
    _draw_threshold(panels[1, 0], state.epsilon)
    panels[0, 0].set_xlim(0, max(run.iterations, 1))
    for ax in panels[1]:
        ax.set_xlabel("iteration")
    handles = [line for line in panels[0, 0].lines if line.get_label() in ("0", "1")]
    names = figure.legend(handles=handles, loc="outside upper center", ncols=2, handlelength=3).get_texts()
    for text, side in zip(names, run.sides, strict=True):
        text.set_text(one_line(side.method))  # as a label, a name that begins with _ would be left out
    return figure


def _draw_threshold(ax: Axes, epsilon: float) -> None:
    """Make the axis of update norms logarithmic and mark where learned methods stop."""
    norms = np.concatenate([np.asarray(line.get_ydata(), dtype=np.float64) for line in ax.lines])
    drawn = norms[norms > _SMALLEST_NORM]
    ax.axhline(epsilon, color=_INK, linewidth=0.8, linestyle=(0, (1, 1.5)))
    ax.set_yscale("log")
    ax.set_ylim(min([epsilon, *drawn]) / 4, max([epsilon, *drawn]) * 2)
    ax.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    ax.yaxis.set_minor_formatter(NullFormatter())
    ax.annotate(f"ε = {epsilon:g}", (0, epsilon), (4, -3), ("axes fraction", "data"), "offset points", va="top")


# What they share


def _order(side: MethodRun, state: State, inspection: Inspection | None) -> np.ndarray:
    """Of the bins; a baseline has no contributions to order them by."""
    return bin_order(side.histogram, state.order, None if inspection is None else inspection.values)


def _head(ax: Axes, number: int, side: MethodRun, rest: str, *, letters: bool = True) -> None:
    """Write a letter and a method's name in its colour, and what is shown of it, above a chart."""
    letter = f"({'ab'[number]}) " if letters else ""
    name = ax.annotate(f"{letter}{one_line(side.method)}", (0, 1), (0, 4), "axes fraction", "offset points")
    name.set(color=_hex(palette.METHODS[number]), fontweight="bold", fontsize=8.5)
    ax.annotate(rest, (1, 0), (6, 0), name, "offset points", va="bottom")


def _name_sides(ax: Axes, histogram: Histogram) -> None:
    """Name the sides of each block below a chart whose x axis is the bins, and separate them by lines."""
    names = [name for block in histogram.blocks for name in block]
    n_model = histogram.n_bins // len(names)
    slant = {"rotation": 30, "ha": "right"} if len(names) > _CROWDED else {}
    ax.set_xticks([(i + 0.5) * n_model - 0.5 for i in range(len(names))], names, **slant)
    ax.tick_params(axis="x", length=0)
    for i in range(1, len(names)):
        ax.axvline(i * n_model - 0.5, color=_INK, linewidth=0.8 if i % 2 == 0 else 0.3)


def one_line(name: str) -> str:
    """A name without line breaks, cut where two of them would not fit beside each other."""
    name = " ".join(name.split())
    return name if len(name) <= _LONGEST_NAME else f"{name[: _LONGEST_NAME - 1]}…"


def _hex(color: Color) -> str:
    return "#{:02x}{:02x}{:02x}".format(*color)
