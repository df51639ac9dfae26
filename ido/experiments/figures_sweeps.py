"""Figures of the sweeps: the scores at each level, with 95% confidence bands."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator

from ido.experiments.estimates import level_estimates
from ido.experiments.families import FAMILIES, LEARNED_FAMILIES, NOTHING, Family
from ido.experiments.figures import FAINT, INK, grid_of_axes, lettered, styled
from ido.experiments.paper import ROW_NAMES, SCORE_TITLES
from ido.experiments.sweeps import LEVELS
from ido.results import Results

AXIS_LABELS: dict[str, str] = {
    "noise": "noise, standard deviation",
    "outliers": "outliers",
    "points": "scene points",
    "incomplete": "share removed",
    "rotation": "rotation, degrees",
    "translation": "translation, model units",
}
"""What each sweep varies."""


@styled
def sweeps_figure(results: Results, dataset: str, score: str) -> Figure:
    """All methods over the six sweeps of a dataset, baselines as tuned. What was not run is not drawn."""
    of_dataset = results.where(dataset=dataset)
    figure, axes = grid_of_axes(2, 3, 7.6)
    panels = [ax for row in axes for ax in row]
    runs = [(family, of_dataset.where(method=family.main)) for family in reversed(FAMILIES)]  # ours on top
    for i, (ax, sweep) in enumerate(zip(panels, ROW_NAMES, strict=True)):
        for family, run in runs:
            _draw_line(ax, run, sweep, score, family, "solid")
        _set_levels(ax, sweep)
        ax.set_title(lettered(i, ROW_NAMES[sweep]))
    _set_scores(axes, score, ticks=6)
    for row in axes:
        row[0].set_ylabel(SCORE_TITLES[score])
    handles = [_handle(family, "solid", family.main, bool(len(run))) for family, run in reversed(runs)]
    figure.legend(handles=handles, loc="outside lower center", ncols=4, handlelength=3)
    return figure


@styled
def settings_figure(results: Results, dataset: str, score: str) -> Figure | None:
    """The first two variants of each method that has more than one, side by side over the six sweeps of a dataset.

    Each method of which one was run has a row; None where there is none.
    """
    of_dataset = results.where(dataset=dataset)
    in_pairs = [family for family in FAMILIES if len(family.variants) > 1]
    families = [each for each in in_pairs if len(of_dataset.among(method=[name for _, name in each.variants[:2]]))]
    if not families:
        return None
    height = max(1.56 * len(families), 1.5 + 1.3 * len(families))  # a few rows have room for the legend, too
    figure, axes = grid_of_axes(len(families), len(LEVELS), height)
    nothing, do = (of_dataset.where(method=family.main) for family in (NOTHING, LEARNED_FAMILIES[0]))
    for row, family in zip(axes, families, strict=True):
        runs = [(name, of_dataset.where(method=method)) for name, method in family.variants[:2]]
        for ax, sweep in zip(row, ROW_NAMES, strict=True):
            _draw_line(ax, nothing, sweep, score, NOTHING, "solid")
            _draw_line(ax, do, sweep, score, LEARNED_FAMILIES[0], "thin")
            for (_, run), look in zip(runs, ("solid", "dashed"), strict=True):
                _draw_line(ax, run, sweep, score, family, look)
            _set_levels(ax, sweep)
            missing = [name for name, run in runs if not len(run.where(sweep=sweep))]
            if missing:
                ax.set_title(f"{', '.join(missing)}: not run", fontsize=9.5, color=INK, style="italic", pad=3)
        row[0].set_ylabel(f"{family.title.replace(' (', chr(10) + '(')}\n{SCORE_TITLES[score]}")
    _set_scores(axes, score, ticks=4)
    for ax in (ax for row in axes[:-1] for ax in row):
        ax.set_xlabel("")
        ax.tick_params(labelbottom=False)
    for ax in axes[-1]:
        ax.set_xlabel(ax.get_xlabel().replace(", ", "\n"))
    for ax, sweep in zip(axes[0], ROW_NAMES, strict=True):
        ax.annotate(ROW_NAMES[sweep], (0, 1), (0, 17), "axes fraction", "offset points", fontsize=12.5)
    figure.legend(handles=_pair_handles(), loc="outside lower center", ncols=4, handlelength=3.5)
    return figure


def _draw_line(ax: Axes, run: Results, sweep: str, score: str, family: Family, look: str) -> None:
    """One method's means at the levels that were run, and their intervals where there are some."""
    if not len(run):
        return
    levels = np.array(LEVELS[sweep])
    estimates = level_estimates(run, sweep, score)
    mean = np.array([each.mean for each in estimates])
    half = np.array([each.half for each in estimates])
    ax.plot(levels, mean, **_line_style(family, look))
    if look != "thin":
        ax.fill_between(levels, mean - half, mean + half, color=family.color, alpha=0.16, linewidth=0)


def _line_style(family: Family, look: str) -> dict[str, Any]:
    if family is NOTHING:
        return {"color": family.color, "linestyle": (0, (1, 1.4)), "linewidth": 2}
    if look == "thin":
        return {"color": family.color, "linewidth": 1, "linestyle": "dashdot"}
    hollow = look == "dashed"
    return {
        "color": family.color,
        "linestyle": (0, (4, 1.8)) if hollow else "solid",
        "linewidth": 1.8,
        "marker": family.marker,
        "markersize": 6.5,
        "markerfacecolor": "white" if hollow else family.color,
        "markeredgecolor": family.color if hollow else "white",
        "markeredgewidth": 1.3 if hollow else 0.7,
    }


def _set_levels(ax: Axes, sweep: str) -> None:
    levels = LEVELS[sweep]
    margin = 0.04 * (levels[-1] - levels[0])
    ax.set_xlim(levels[0] - margin, levels[-1] + margin)
    ax.set_xlabel(AXIS_LABELS[sweep])
    if sweep == "rotation":
        ax.set_xticks(range(0, 181, 60))


def _set_scores(axes: Sequence[Sequence[Axes]], score: str, ticks: int) -> None:
    """The same range in all panels: all that an accuracy can be, or up to the largest mean.

    Matplotlib's shared axes would do this, too, but slowly when there are many.
    """
    panels = [ax for row in axes for ax in row]
    means = np.concatenate([np.asarray(line.get_ydata()) for ax in panels for line in ax.lines] or [np.zeros(1)])
    top = 1.0 if score == "accuracy" else np.nanmax(means, initial=0.1)
    for ax in panels:
        ax.set_ylim(-0.04 * top, 1.05 * top)
        ax.yaxis.set_major_locator(MaxNLocator(ticks, steps=[1, 2, 5, 10]))
    for ax in (ax for row in axes for ax in row[1:]):
        ax.tick_params(labelleft=False)


def _handle(family: Family, look: str, label: str, was_run: bool = True) -> Line2D:
    style = _line_style(family, look)
    return Line2D([], [], label=label if was_run else f"{label}: not run", **style)


def _pair_handles() -> list[Line2D]:
    grey = Family("", None, (), FAINT, "o")
    return [
        _handle(grey, "solid", "tuned (Improved DO: here)"),
        _handle(grey, "dashed", "default (Improved DO: as printed)"),
        _handle(LEARNED_FAMILIES[0], "thin", "DO, to compare"),
        _handle(NOTHING, "solid", "Did nothing"),
    ]
