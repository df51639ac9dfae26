"""Figures of what was learned: training curves and maps (paper, Figs. "Training Curves" and "Learned Maps")."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ido.bin_order import bin_order
from ido.experiments.families import LEARNED_FAMILIES
from ido.experiments.figures import INK, draw_map, grid_of_axes, lettered, styled
from ido.experiments.paper import COMPARED_MAPS
from ido.histograms import Histogram
from ido.maps import Maps, TrainingCurves

WIDTHS = (1.0, 1.8)
"""Of the columns of DO and Improved DO, which has three times as many bins."""

_ROTATION_COLOR, _TRANSLATION_COLOR = "#E69F00", "#CC79A7"


@styled
def training_figure(do: Maps, improved: Maps) -> Figure:
    """The paper's six panels, in its order: Improved DO on the left, DO on the right."""
    figure, axes = grid_of_axes(3, 2, 11.0, sharex=True, sharey="row")
    for column, (maps, family) in enumerate(zip((improved, do), reversed(LEARNED_FAMILIES), strict=True)):
        error, rotation, translation = (row[column] for row in axes)
        _draw_error(error, maps.curves, family.color)
        residuals = np.linalg.norm(maps.curves.residuals.reshape(len(maps.curves.mean), -1, 2, 3), axis=3)
        _draw_samples(rotation, np.rad2deg(residuals[:, :, 1]), family.color)
        _draw_samples(translation, residuals[:, :, 0], family.color)
        for row, title in enumerate(("training error", "rotation error", "translation error")):
            axes[row][column].set_title(lettered(2 * row + column, f"{family.title}: {title}"))
    axes[0][0].set_ylabel("‖x* − x‖²")
    axes[0][0].set_ylim(top=20)  # room for the legends
    axes[1][0].set_ylabel("‖φ* − φ‖, degrees")
    axes[2][0].set_ylabel("‖ρ* − ρ‖, model units")
    for ax in axes[2]:
        ax.set_xlabel("maps applied")
    return figure


def _draw_error(ax: Axes, curves: TrainingCurves, color: str) -> None:
    ax.semilogy(curves.mean, color=color, linewidth=2.2, marker="o", markersize=4, label="mean")
    ax.semilogy(curves.deviation, color=color, linewidth=1.6, linestyle="dashed", label="standard deviation")
    ax.semilogy(curves.rotation, color=_ROTATION_COLOR, linewidth=1.6, linestyle="dashdot", label="mean, rotation part")
    ax.semilogy(
        curves.translation, color=_TRANSLATION_COLOR, linewidth=1.6, linestyle="dotted", label="mean, translation part"
    )
    ax.legend(loc="upper right", ncols=2)


def _draw_samples(ax: Axes, errors: np.ndarray, color: str) -> None:
    """Each sample's error after each map, shape (K + 1, n), and their median and middle 90%."""
    low, middle, high = np.quantile(errors, (0.05, 0.5, 0.95), axis=1)
    lines = ax.plot(errors, color=color, alpha=0.09, linewidth=0.6)
    for line in lines:
        line.set_rasterized(True)
    ax.plot(middle, color=INK, linewidth=2.2, label="median")
    ax.plot(low, color=INK, linewidth=1.3, linestyle="dashed", label="5% and 95%")
    ax.plot(high, color=INK, linewidth=1.3, linestyle="dashed")
    ax.set_ylim(0, float(errors[0].max()) * 1.2)
    ax.legend(loc="upper right")


@styled
def maps_figure(do: Maps, improved: Maps, numbers: Sequence[int] = COMPARED_MAPS) -> Figure:
    """Maps as heatmaps, DO on the left, Improved DO on the right: six rows, a column for each bin."""
    figure, axes = grid_of_axes(len(numbers), 2, 2.6 * len(numbers), width_ratios=WIDTHS)
    for row, number in enumerate(numbers):
        for column, (maps, family) in enumerate(zip((do, improved), LEARNED_FAMILIES, strict=True)):
            _draw_map(axes[row][column], maps, number, lettered(2 * row + column, f"{family.title}: map {number}"))
    return figure


def _draw_map(ax: Axes, maps: Maps, number: int, title: str) -> None:
    draw_map(ax, maps.maps[number - 1][:, bin_order(maps.histogram, "reference value")], pad=0.015, aspect=14)
    ax.grid(False)
    ax.set_title(title)
    mark_sides(ax, maps.histogram)


def mark_sides(ax: Axes, histogram: Histogram) -> None:
    """Name the sides of each block below a chart whose x axis is the bins, and separate them by lines."""
    names = histogram.side_names
    n_model = histogram.n_bins // len(names)
    ax.set_xticks([(i + 0.5) * n_model for i in range(len(names))], names)
    ax.tick_params(axis="x", length=0, labelsize=11)
    for i in range(1, len(names)):
        ax.axvline(i * n_model - 0.5, color=INK, linewidth=1.6 if i % 2 == 0 else 0.6)
