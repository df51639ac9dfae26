"""A second pose drawn into a pane and its histogram: the other method's, or its own at another iteration."""

from __future__ import annotations

from dataclasses import dataclass

from ido.types import FloatArray
from ido_viz.core import palette
from ido_viz.core.run import Run
from ido_viz.core.state import State


@dataclass(frozen=True, slots=True, eq=False)
class Overlay:
    """Where else the scene is drawn.

    Args:
        title: what it is.
        x: the pose's exponential coordinates, shape (6,).
        T_model_scene: the pose, shape (4, 4).
        seen: the pane's histogram there, shape (n_bins,).
        color: of its points.
    """

    title: str
    x: FloatArray
    T_model_scene: FloatArray
    seen: FloatArray
    color: palette.Color


def overlay_of(run: Run, state: State, iteration: int, pane: int) -> Overlay | None:
    """What is laid over a pane (0 or 1) after so many iterations; None for nothing.

    The other method is shown at the same iteration, or at its end if it stopped before.
    """
    if state.overlay == "nothing":
        return None
    if state.overlay == "other method":
        other = run.sides[1 - pane]
        k, color, title = other.clipped(iteration), palette.method_color(other.method, state.dark), other.method
    else:
        other = run.sides[pane]
        k, color = (
            other.clipped(state.overlaid_iteration),
            palette.lighter(palette.method_color(other.method, state.dark), state.dark),
        )
        title = f"iteration {k}"
    x = other.trajectory.x[k]
    return Overlay(title, x, other.T_model_scene[k], run.sides[pane].histogram(run.scene.points, x), color)
