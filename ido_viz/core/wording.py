"""What is shown, in words: plain text that pages, panes and files share."""

from __future__ import annotations

from ido_viz.core.frame import SideFrame
from ido_viz.core.state import State

_LONGEST_NAME = 40  # characters
_SHORT_SIDES = {"clockwise": "clockw.", "anticlockwise": "anticl."}


def short_side(name: str) -> str:
    """The name of a block's side, short enough to stand below a sixth of a chart."""
    return _SHORT_SIDES.get(name, name)


def scene_line(state: State) -> str:
    """Shape, seed and sliders of a state's scene."""
    p = state.perturbation
    return (
        f"{state.shape}, seed {p.seed}: rotation {p.rotation:g}°, translation {p.translation:g}, noise {p.noise:g}, "
        f"{p.points} points, {p.incomplete:.0%} of them removed, {p.outliers} outliers"
    )


def progress_line(side: SideFrame) -> str:
    """How far a method is, with how many of its starts, or why it is not there yet."""
    if side.run.waiting:
        return side.run.waiting
    starts = "" if side.run.race is None else f", {side.run.race.left(side.k)} starts"
    return f"iteration {side.k} of {side.run.trajectory.iterations}{starts}"


def stop_line(side: SideFrame) -> str:
    """Why a method stopped; nothing of it before the end."""
    if side.run.waiting:
        return side.run.waiting
    return "not yet" if side.verdict.is_open else str(side.run.trajectory.stop)


def one_line(name: str) -> str:
    """A name without line breaks, cut where two of them would not fit beside each other."""
    name = " ".join(name.split())
    return name if len(name) <= _LONGEST_NAME else f"{name[: _LONGEST_NAME - 1]}…"
