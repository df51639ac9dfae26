"""The charts of a page as figures for a paper: both columns wide, on white, drawn with Matplotlib."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, MaxNLocator, NullFormatter

from ido import Histogram
from ido.experiments.figures import draw_map
from ido_viz.core import palette
from ido_viz.core.chart_data import CURVES, curve, histogram_data
from ido_viz.core.frame import Frame, SideFrame
from ido_viz.core.palette import hexadecimal
from ido_viz.core.state import State
from ido_viz.core.wording import one_line

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


def histograms_figure(frame: Frame) -> Figure:
    """Both methods' histograms at the shown iteration, against the reference line, as the page draws them."""
    state = frame.state
    figure = Figure(figsize=(WIDTH, 4.0), layout="constrained")
    for ax, side in zip(figure.subplots(2, 1, sharey=True), frame.sides, strict=True):
        _draw_histogram(ax, side, state)
        shown = f"iteration {side.k} of {side.run.trajectory.iterations}"
        seen = "" if side.run.maps else f", seen through the histogram {side.run.histogram.name}"
        _head(ax, side, shown + seen + ("" if side.overlay is None else f"; grey: {side.overlay.title}"))
        ax.set_ylabel(("difference, " if state.difference else "") + "relative to the\nlargest reference bin")
        _name_sides(ax, side.run.histogram)
    return figure


def _draw_histogram(ax: Axes, side: SideFrame, state: State) -> None:
    places, second, *blocks, line, marked = histogram_data(side, state)
    dots: dict[str, Any] = {"linestyle": "none", "marker": "o", "markeredgewidth": 0}
    ax.plot(places, second, color=_FAINT, markersize=1.3, **dots)
    for number, (block, values) in enumerate(zip(side.run.histogram.blocks, blocks, strict=True)):
        ax.plot(places, values, color=hexadecimal(palette.block_color(block, number)), markersize=1.9, **dots)
    if state.order == "reference value":
        for part in np.split(np.arange(len(places)), 2 * len(blocks)):
            ax.plot(places[part], line[part], color=_INK, linewidth=1)
    else:  # a line would fill the chart
        ax.plot(places, line, color=_INK, markersize=1.3, **dots)
    picked = {"color": hexadecimal(palette.MARK), "markersize": 4.5, "markeredgewidth": 0.6, "markeredgecolor": _INK}
    ax.plot(places, marked, **{**dots, **picked})
    ax.set_xlim(-0.5, len(places) - 0.5)
    ax.margins(y=0.03)


def maps_figure(frame: Frame) -> Figure:
    """The learned maps that the page shows: those of the next update, or the pinned ones; a row for each method.

    Six rows for the coordinates of x and a column for each bin, in the page's order.
    """
    learned = [(side, side.run.maps) for side in frame.sides if side.run.maps]
    figure = Figure(figsize=(WIDTH, 1.65 * len(learned)), layout="constrained")
    panels = figure.subplots(len(learned), 1, squeeze=False)[:, 0]
    for ax, (side, maps) in zip(panels, learned, strict=True):
        bar = draw_map(ax, maps.maps[side.shown_map - 1][:, side.order], pad=0.012, aspect=10, extend="both")
        bar.outline.set_linewidth(0.4)  # pyright: ignore[reportCallIssue]
        ax.tick_params(axis="y", length=0)
        pinned = " (pinned)" if frame.state.pinned_map else ""
        _head(ax, side, f"map {side.shown_map} of {len(maps.maps)}{pinned}", letters=len(learned) > 1)
        _name_sides(ax, side.run.histogram)
    return figure


def curves_figure(frame: Frame) -> Figure:
    """Scores, update norm and distance to the reference line over the iterations; dots at the shown iteration."""
    figure = Figure(figsize=(WIDTH, 3.9), layout="constrained")
    panels = figure.subplots(2, 2, sharex=True)
    for letter, ax, name in zip("abcd", panels.flat, CURVES, strict=True):
        ax.set_title(f"({letter}) {_CURVE_TITLES[name]}")
        for side in frame.sides:
            values = 10 ** curve(side.run, name) if name == "update norm" else curve(side.run, name)
            color = hexadecimal(palette.method_color(side.run.method))
            ax.plot(values, color=color, linestyle=_DASHES[side.pane], linewidth=1.2, label=str(side.pane))
            dot: dict[str, Any] = {"marker": "o", "markersize": 4, "markeredgewidth": 0, "clip_on": False, "zorder": 3}
            ax.plot(side.k, values[side.k], color=color, **dot)
        ax.grid()
        ax.set_ylim(bottom=0)
        ax.xaxis.set_major_locator(MaxNLocator(6, integer=True))
    panels[0, 1].set_ylim(0, 1.05)
    _draw_threshold(panels[1, 0], frame.state.epsilon)
    panels[0, 0].set_xlim(0, max(frame.run.iterations, 1))
    for ax in panels[1]:
        ax.set_xlabel("iteration")
    handles = [line for line in panels[0, 0].lines if line.get_label() in ("0", "1")]
    names = figure.legend(handles=handles, loc="outside upper center", ncols=2, handlelength=3).get_texts()
    for text, side in zip(names, frame.sides, strict=True):
        text.set_text(one_line(side.run.method))  # as a label, a name that begins with _ would be left out
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


def _head(ax: Axes, side: SideFrame, rest: str, *, letters: bool = True) -> None:
    """Write a letter and a method's name in its colour, and what is shown of it, above a chart."""
    letter = f"({'ab'[side.pane]}) " if letters else ""
    name = ax.annotate(f"{letter}{one_line(side.run.method)}", (0, 1), (0, 4), "axes fraction", "offset points")
    name.set(color=hexadecimal(palette.method_color(side.run.method)), fontweight="bold", fontsize=8.5)
    ax.annotate(rest, (1, 0), (6, 0), name, "offset points", va="bottom")


def _name_sides(ax: Axes, histogram: Histogram) -> None:
    """Name the sides of each block below a chart whose x axis is the bins, and separate them by lines."""
    names = histogram.side_names
    n_model = histogram.n_bins // len(names)
    slant = {"rotation": 30, "ha": "right"} if len(names) > _CROWDED else {}
    ax.set_xticks([(i + 0.5) * n_model - 0.5 for i in range(len(names))], names, **slant)
    ax.tick_params(axis="x", length=0)
    for i in range(1, len(names)):
        ax.axvline(i * n_model - 0.5, color=_INK, linewidth=0.8 if i % 2 == 0 else 0.3)
