"""What all figures of the report share: their size, type and lines, and how they are written."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.colorbar import Colorbar
from matplotlib.figure import Figure

from ido.disk import write_whole
from ido.poses import PARAMETERS
from ido.types import FloatArray

INK = "#333333"
FAINT = "#9a9a9a"

WIDTH = 12.0
"""Of every figure, inches; type is set so that it reads well on a screen and when printed at two thirds."""

_DOTS_PER_INCH = 170
_ROW = 40  # pixels that each row of a map is drawn from

_STYLE: dict[Any, Any] = {
    "font.family": "DejaVu Sans",  # ships with Matplotlib: the same picture on every machine
    "font.size": 12,
    "axes.titlesize": 12.5,
    "axes.titlelocation": "left",
    "axes.labelsize": 12,
    "axes.edgecolor": INK,
    "axes.labelcolor": INK,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": "#e4e4e4",
    "grid.linewidth": 0.8,
    "xtick.color": INK,
    "ytick.color": INK,
    "text.color": INK,
    "legend.frameon": False,
    "figure.facecolor": "white",
    "svg.hashsalt": "ido",  # the same figure gives the same file
}

styled = matplotlib.rc_context(_STYLE)
"""Decorates a function that draws or writes a figure."""


@styled
def grid_of_axes(rows: int, columns: int, height: float, **options: Any) -> tuple[Figure, list[list[Axes]]]:
    """A figure as wide as the page, so many inches high, and its axes, row by row."""
    figure = Figure(figsize=(WIDTH, height), layout="constrained")
    axes = figure.subplots(rows, columns, squeeze=False, **options)
    return figure, axes.tolist()


def lettered(index: int, title: str) -> str:
    """The title of a figure's panel: (a), (b), ..."""
    return f"({'abcdefghijklmnopqrstuvwxyz'[index]}) {title}"


def draw_map(ax: Axes, values: FloatArray, **of_bar: Any) -> Colorbar:
    """A map (6, n_bins) as a heatmap, six rows for the coordinates of x; its colour bar, made with these options.

    The largest 0.5% of the numbers share the last colour.
    """
    scale = float(np.quantile(np.abs(values), 0.995)) or 1.0
    tall = np.repeat(values, _ROW, axis=0)  # so that drawing averages neighbouring bins, but not rows
    corners = (-0.5, values.shape[1] - 0.5, 5.5, -0.5)
    picture = ax.imshow(tall, cmap="RdBu_r", vmin=-scale, vmax=scale, aspect="auto", extent=corners)
    bar = ax.figure.colorbar(picture, ax=ax, ticks=[-scale, 0, scale], **of_bar)
    bar.ax.set_yticklabels([f"−{scale:.2g}", "0", f"{scale:.2g}"])
    ax.set_yticks(range(6), PARAMETERS)
    return bar


@styled
def write_figure(figure: Figure, path: Path) -> bytes:
    """Write a figure as .svg and .png, `path` being without either; returns the SVG.

    It has no date. Its text is outlines, so that no font needs to be there.
    """
    svg, png = as_svg_and_png(figure, _DOTS_PER_INCH, {"Date": None})
    write_whole(path.with_suffix(".svg"), svg)
    write_whole(path.with_suffix(".png"), png)
    return svg


def as_svg_and_png(
    figure: Figure, dots_per_inch: int, of_svg: dict[str, Any], of_png: dict[str, Any] | None = None
) -> tuple[bytes, bytes]:
    """Both files, with their metadata. The figure is laid out once and drawn once for each; `savefig` does it twice."""
    if layout := figure.get_layout_engine():
        layout.execute(figure)
    figure.set_layout_engine("none")
    svg, png = io.BytesIO(), io.BytesIO()
    figure.set_dpi(dots_per_inch)
    FigureCanvasSVG(figure).print_svg(svg, metadata=of_svg)
    figure.set_dpi(dots_per_inch)
    FigureCanvasAgg(figure).print_png(png, metadata=of_png)
    return svg.getvalue(), png.getvalue()
