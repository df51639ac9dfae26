"""What is shown, in words: plain text that pages, panes and files share."""

from __future__ import annotations

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


def one_line(name: str) -> str:
    """A name without line breaks, cut where two of them would not fit beside each other."""
    name = " ".join(name.split())
    return name if len(name) <= _LONGEST_NAME else f"{name[: _LONGEST_NAME - 1]}…"
