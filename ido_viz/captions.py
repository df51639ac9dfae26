"""What scene it is, in a line below a picture that leaves the page."""

from __future__ import annotations

from ido_viz.run import Run
from ido_viz.state import LAST, State


def scene_line(state: State) -> str:
    """Shape, seed and sliders of a state's scene, as plain text."""
    p = state.perturbation
    return (
        f"{state.shape}, seed {p.seed}: rotation {p.rotation:g}°, translation {p.translation:g}, noise {p.noise:g}, "
        f"{p.points} points, {p.incomplete:.0%} of them removed, {p.outliers} outliers"
    )


def shown_iteration(run: Run, state: State) -> int:
    """The iteration of a run that a state shows."""
    return run.iterations if state.iteration == LAST else min(state.iteration, run.iterations)
