"""The reliability diagram: how often poses were right, against how probable they were said to be."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ido.experiments.families import FAMILIES
from ido.experiments.figures import FAINT, INK, grid_of_axes, lettered, styled
from ido.experiments.reliability import EDGES, Reliability, wilson

_COLUMNS = 4


@styled
def reliability_figure(found: Mapping[str, Reliability]) -> Figure:
    """A panel for each method: dots with their intervals above, the numbers of registrations below."""
    columns = min(_COLUMNS, len(found))
    blocks = -(-len(found) // columns)
    figure, axes = grid_of_axes(
        2 * blocks, columns, 4.6 * blocks, sharex=True, sharey="row", height_ratios=[3, 1] * blocks
    )
    for i, (method, its) in enumerate(found.items()):
        row, column = 2 * (i // columns), i % columns
        above, below = axes[row][column], axes[row + 1][column]
        color = next(family.color for family in FAMILIES if method in dict(family.variants).values())
        _draw_shares(above, its, color)
        above.set_title(f"{lettered(i, method)}\n")
        said = f"{its.total:,} poses, {its.share_right:.1%} right, ECE {its.error:.3f}"
        above.text(0, 1.02, said, transform=above.transAxes, va="bottom", color=INK, fontsize=10.5)
        below.bar(EDGES[:-1], its.counts, np.diff(EDGES), align="edge", color=color, edgecolor="white", linewidth=0.7)
        below.set_yscale("symlog", linthresh=1)
        below.set_yticks([0, 1, 10, 100, 1000], ["0", "1", "10", "100", "1000"])
        below.set_ylim(0, 1.6 * max(each.counts.max() for each in found.values()))
        below.set_xlabel("probability told")
        if column == 0:
            above.set_ylabel("share right")
            below.set_ylabel("poses")
    for i in range(len(found), blocks * columns):
        for part in (0, 1):
            axes[2 * (i // columns) + part][i % columns].set_axis_off()
    return figure


def _draw_shares(ax: Axes, its: Reliability, color: str) -> None:
    filled = its.counts > 0
    told, right, counts = its.told[filled], its.right[filled], its.counts[filled]
    low, high = wilson(right, counts.astype(np.float64))
    ax.plot([0, 1], [0, 1], color=FAINT, linewidth=1, linestyle=(0, (4, 2)))
    ax.vlines(told, low, high, color=color, linewidth=1.6, alpha=0.6)
    ax.plot(told, right, "o", color=color, markersize=6.5, markeredgecolor="white", markeredgewidth=0.7)
    ax.set_xlim(-0.02, 1.02)
    ax.set_ylim(-0.04, 1.04)
