"""The tab Basin: small maps of the turns from which each pane's method registers the scene; a click begins there."""

from __future__ import annotations

import html

import numpy as np
import viser

from ido.types import DoubleArray
from ido_viz.core import palette
from ido_viz.core.actions import Actions, plain
from ido_viz.core.basin import ANGLES, AXES, STARTS, Basin, axes, turn_of
from ido_viz.core.frame import Frame
from ido_viz.core.state import State
from ido_viz.core.verdict import Verdict
from ido_viz.panels.markup import caption, method_span

_WIDTH, _HEIGHT, _RADIUS = 60.0, 72.0, 25.0  # of a map with its text, and of its disc without the dots at the rim
_LOOK = {  # radius, and how much of it is filled: colours are not all that tells them apart
    Verdict.IN_PLACE: (3.8, 1.0),
    Verdict.NEARLY_IN_PLACE: (2.8, 0.6),
    Verdict.WRONG_POSE: (2.6, 0.0),
}
_HINT = (
    "How far is the scene turned (each disc), and about which axis (each dot; in the middle upright, at the rim "
    "upside down), for the method to bring it in place? A click on a dot begins there."
)


class BasinTab:
    """The maps and their buttons."""

    def __init__(self, gui: viser.GuiApi, actions: Actions) -> None:
        gui.add_html(caption(_HINT))
        start = gui.add_button("Map the basin", hint="Register the scene from many turns with both panes' methods.")
        start.on_click(plain(actions.map_basin))
        self._cancel = gui.add_button("Cancel", color="gray", disabled=True, hint="Keep what is there and stop.")
        self._cancel.on_click(plain(actions.cancel_basin))
        self._maps = gui.add_html("")

    def draw(self, frame: Frame, basin: Basin) -> None:
        """Draw what is known so far for both panes' methods."""
        if self._cancel.disabled == basin.running:
            self._cancel.disabled = not basin.running
        content = basin_html(frame, basin) if basin.begun else ""
        if self._maps.content != content:
            self._maps.content = content


def basin_html(frame: Frame, basin: Basin) -> str:
    """The maps of both panes' methods, one below the other, with what the dots mean."""
    state = frame.state
    old = "" if basin.fits(state) else caption("<b>The scene has changed since: map it again.</b>")
    turn = turn_of(state, frame.run.subject.up)
    methods = dict.fromkeys(side.run.method for side in frame.sides)
    parts = [_method_html(name, basin, turn, state) for name in methods]
    meaning = " &nbsp;".join(f"{_sign(verdict, state)} {verdict}" for verdict in _LOOK)
    return old + "".join(parts) + caption(f"{meaning} &nbsp;◯ where it begins now")


def _method_html(name: str, basin: Basin, turn: DoubleArray, state: State) -> str:
    accuracies = basin.accuracies(name)
    known = int(np.isfinite(accuracies).sum())
    in_place = sum(verdict is Verdict.IN_PLACE for verdict in verdicts(accuracies))
    said = html.escape(basin.failure(name)) or f"{in_place} of {known} starts in place"
    if known < STARTS and not basin.failure(name):
        said += "…" if basin.running else f", {STARTS - known} not tried"
    maps = "".join(_disc(number, accuracies, turn, state) for number in range(len(ANGLES)))
    label = html.escape(f"{name}: {in_place} of {known} starts in place")
    return (
        caption(f"<b>{method_span(name, state.dark)}</b> {said}")
        + f'<svg class="basin" role="img" aria-label="{label}" viewBox="0 0 {_WIDTH * len(ANGLES):g} {_HEIGHT:g}" '
        f'style="width:calc(100% - 26px);margin:3px 18px 6px 8px;display:block">{maps}</svg>'
    )


def _disc(number: int, accuracies: DoubleArray, turn: DoubleArray, state: State) -> str:
    """The map of one angle, with the share that ends in place, and a ring where the scene begins now."""
    first = number * AXES
    found = verdicts(accuracies[first : first + AXES])
    x, y = places(axes(), number)
    ink = palette.css(palette.ink(state.dark))
    groups = []
    for verdict in (None, *_LOOK):
        dots = [i for i in range(AXES) if found[i] is verdict]
        radius, filled = (1.2, 0.5) if verdict is None else _LOOK[verdict]
        color = ink if verdict is None else palette.css(palette.verdict_color(verdict))
        circles = "".join(
            f'<circle cx="{x[i]:.1f}" cy="{y[i]:.1f}" r="{radius}" data-start="{first + i}"/>' for i in dots
        )
        if circles:
            groups.append(f'<g fill="{color}" fill-opacity="{filled}" stroke="{color}">{circles}</g>')
    known = [verdict for verdict in found if verdict is not None]
    share = f" {np.mean([verdict is Verdict.IN_PLACE for verdict in known]):.0%}" if known else ""
    middle = (number + 0.5) * _WIDTH
    return (
        f'<circle cx="{middle:g}" cy="{_WIDTH / 2:g}" r="{_WIDTH / 2 - 0.5:g}" fill="none" stroke="{ink}" '
        f'stroke-opacity="0.25"/><g style="cursor:pointer">{"".join(groups)}</g>{_ring(number, turn, ink)}'
        f'<text x="{middle:g}" y="{_HEIGHT - 1:g}" text-anchor="middle" font-size="10.5" fill="{ink}">'
        f"{ANGLES[number]}°{share}</text>"
    )


def _ring(number: int, turn: DoubleArray, ink: str) -> str:
    """Where the scene begins now, in the map of the nearest angle."""
    degrees = float(np.linalg.norm(turn))
    if degrees < ANGLES[0] / 2 or int(np.argmin(np.abs(np.array(ANGLES) - degrees))) != number:
        return ""
    x, y = places(turn[None] / degrees, number)
    return f'<circle cx="{x[0]:.1f}" cy="{y[0]:.1f}" r="5.2" fill="none" stroke="{ink}" pointer-events="none"/>'


def places(directions: DoubleArray, number: int) -> tuple[DoubleArray, DoubleArray]:
    """x and y of axes (n, 3) of an upright model in the map of an angle: Lambert's, true to area, seen from above."""
    x, y, z = directions.T
    across = np.hypot(x, y)
    away = np.sqrt((1 - z) / 2) / np.where(across > 0, across, 1.0)
    return (number + 0.5) * _WIDTH + _RADIUS * away * x, _WIDTH / 2 - _RADIUS * away * y


def verdicts(accuracies: DoubleArray) -> list[Verdict | None]:
    """Where registrations of some PointAcc ended; None where it is not known."""
    return [None if np.isnan(each) else Verdict.at_the_end(float(each)) for each in accuracies]


def _sign(verdict: Verdict, state: State) -> str:
    radius, filled = _LOOK[verdict]
    color = palette.css(palette.verdict_color(verdict))
    return (
        f'<svg width="9" height="9" viewBox="-4.5 -4.5 9 9" style="vertical-align:-1px"><circle r="{radius}" '
        f'fill="{color}" fill-opacity="{filled}" stroke="{color}"/></svg>'
    )
