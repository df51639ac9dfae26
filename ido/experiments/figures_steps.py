"""Figures of one registration, step by step: histograms and clouds (paper, Figs. "Plots of Features" and following)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ido import poses
from ido.bin_order import bin_order
from ido.experiments.families import LEARNED_FAMILIES, Family
from ido.experiments.figures import INK, grid_of_axes, lettered, styled
from ido.experiments.figures_learning import WIDTHS, mark_sides
from ido.maps import Maps
from ido.perturbation import Scene
from ido.registration import Trajectory, register
from ido.scores import score
from ido.types import FloatArray

HISTOGRAM_STEPS = (1, 5, 10, None)
"""Iterations whose histograms are shown, None being the last; as many as in the paper's figure."""

CLOUD_STEPS = (0, 5, None)
"""Iterations whose clouds are shown."""

_OUTLIER_COLOR, _TRUE_COLOR, _MODEL_COLOR = "#be8cb6", "#009E73", "#b4b4b4"
_REACH = 2.1  # of the picture from its centre, model units
_TOP = 2.2  # of the histograms' axis; the reference line of each block peaks at 1


@styled
def histograms_figure(do: Maps, improved: Maps, scene: Scene) -> Figure:
    """Histograms closing in on the reference line: DO on the left, Improved DO on the right."""
    figure, axes = grid_of_axes(len(HISTOGRAM_STEPS), 2, 11.5, sharey=True, width_ratios=WIDTHS)
    for column, (maps, family) in enumerate(zip((do, improved), LEARNED_FAMILIES, strict=True)):
        track = register(maps, scene.points)
        for row, (k, step) in enumerate(_shown(track, HISTOGRAM_STEPS)):
            ax = axes[row][column]
            _draw_histogram(ax, maps, maps.histogram(scene.points, track.x[k]))
            ax.set_title(lettered(2 * row + column, f"{family.title}: {step}"))
    for row in axes:
        row[0].set_ylabel("relative to the\nlargest reference bin")
    return figure


@styled
def clouds_figure(do: Maps, improved: Maps, scene: Scene, up: tuple[float, float, float]) -> Figure:
    """The scene moving onto the model, from left to right: DO above, Improved DO below."""
    figure, axes = grid_of_axes(2, len(CLOUD_STEPS), 8.8)
    view = _view(up)
    for row, (maps, family) in enumerate(zip((do, improved), LEARNED_FAMILIES, strict=True)):
        track = register(maps, scene.points)
        for column, (k, step) in enumerate(_shown(track, CLOUD_STEPS)):
            ax, T = axes[row][column], track.T_model_scene[k]
            _draw_clouds(ax, maps.histogram.model.points, scene, T, view, family)
            its = score(scene, T)
            figures = f"PointAcc {float(its.accuracy):.2f}, PointRMSE {float(its.rmse):.3f}"
            ax.set_title(f"{lettered(3 * row + column, family.title)}: {step}\n{figures}")
    named = {str(line.get_label()): line for ax in (axes[0][0], axes[1][0]) for line in ax.lines}
    figure.legend(handles=list(named.values()), loc="outside lower center", ncols=len(named), markerscale=2)
    return figure


def _shown(track: Trajectory, steps: Sequence[int | None]) -> list[tuple[int, str]]:
    """The iterations to show, none beyond the last, and what to call each."""
    last = track.iterations
    shown = [last if step is None else min(step, last) for step in steps]
    return [(k, "start" if k == 0 else f"iteration {k}{' (last)' if k == last else ''}") for k in shown]


def _draw_histogram(ax: Axes, maps: Maps, histogram: FloatArray) -> None:
    """Each bin as a dot, in the order of the reference line; each block relative to its largest reference bin."""
    n_blocks = len(maps.histogram.blocks)
    reference = maps.histogram.reference.reshape(n_blocks, -1)
    tops = reference.max(axis=1, keepdims=True)
    order = bin_order(maps.histogram, "reference value")
    dots = (histogram.reshape(n_blocks, -1) / tops).reshape(-1)[order]
    line = (reference / tops).reshape(-1)[order]
    bins = np.arange(dots.size)
    for part, block in zip(np.split(bins, n_blocks), maps.histogram.blocks, strict=True):
        color = np.array(block.color) / 255 if block.color else INK
        ax.plot(part, np.minimum(dots[part], _TOP), ".", color=color, markersize=2.5, rasterized=True)
    for side in np.split(bins, 2 * n_blocks):
        ax.plot(side, line[side], color=INK, linewidth=2)
    ax.set_xlim(0, dots.size)
    ax.set_ylim(-0.05, _TOP)
    ax.grid(False, axis="x")
    mark_sides(ax, maps.histogram)


def _view(up: tuple[float, float, float]) -> FloatArray:
    """What maps points to a picture, shape (2, 3): a parallel view from a little above."""
    toward = np.roll(up, 1) + 0.3 * np.array(up)
    toward /= np.linalg.norm(toward)
    right = np.cross(up, toward)
    right /= np.linalg.norm(right)
    return np.stack([right, np.cross(toward, right)])


def _draw_clouds(ax: Axes, model: FloatArray, scene: Scene, T: FloatArray, view: FloatArray, family: Family) -> None:
    def dots(points: FloatArray, color: str, size: float, label: str) -> None:
        ax.plot(*(view @ points.T), ".", color=color, markersize=size, label=label, rasterized=True)

    moved = poses.transform(T, scene.points)
    true_points = scene.points[~scene.is_outlier]
    dots(model, _MODEL_COLOR, 5, "model")
    dots(moved[scene.is_outlier], _OUTLIER_COLOR, 3, "outliers")
    dots(poses.transform(scene.T_model_scene, true_points), _TRUE_COLOR, 3, "where the scene belongs")
    dots(moved[~scene.is_outlier], family.color, 5, f"scene ({family.title})")
    ax.set_aspect("equal")
    ax.set_xlim(-_REACH, _REACH)
    ax.set_ylim(-_REACH, _REACH)
    ax.set_axis_off()
