"""What the colours on the canvas mean, as HTML for the page and for files."""

from __future__ import annotations

import html

from ido_viz.core import palette
from ido_viz.core.frame import Frame


def legend_html(frame: Frame) -> str:
    """What the colours on the canvas mean."""
    dark = frame.state.dark
    scene = "".join(_dot(palette.method_color(side.run.method, dark)) for side in frame.sides)
    trail = f'<span style="color:{palette.css(palette.method_color(frame.sides[0].run.method, dark))}">╱</span>'
    parts = _of_looking(frame)
    if len(parts) < 2:  # or there is no room
        parts.append(f"{_dot(palette.surface(dark))} model")
    parts.append(f"{scene} scene")
    if "scores" not in frame.state.hidden:
        parts.append(f"{_dot(palette.ARRIVED)} arrived")
    if len(parts) < 4:
        parts.append(f"{_dot(palette.OUTLIER)} outliers")
    if frame.asked is None:
        parts.append(f"{trail} its way")
        if frame.state.ghost:
            parts.append(f'<span style="color:{palette.css(palette.GHOST)}">◇</span> where it belongs')
        if frame.state.error_vectors:
            parts.append(f'<span style="color:{palette.css(palette.GHOST)}">╱</span> to its place')
    if any(side.run.race is not None for side in frame.sides):
        parts.append("▸ a start of the race")
    ink, page = palette.css(palette.ink(dark)), palette.css(palette.PAGES[dark], 0.7)  # where it lies over a cloud
    return (
        f'<div style="font-size:min(0.75rem,0.95vw);white-space:nowrap;color:{ink};background:{page}">'
        + " &nbsp;".join(f"<span>{part}</span>" for part in parts)
        + "</div>"
    )


def _of_looking(frame: Frame) -> list[str]:
    """What the colours of the side that is looked into mean: of the scene for a model point, of the model points."""
    parts = []
    if frame.asked is not None:
        point, question = frame.asked
        color = palette.block_color(question, frame.inspected.run.histogram.blocks.index(question))
        of_sides = zip(question.sides, (color, palette.ink(frame.state.dark)), strict=True)
        sides = " &nbsp;".join(f"{_dot(its_color)} {html.escape(side)}" for side, its_color in of_sides)
        parts.append(f"<b>{sides}</b> for model point {point}")
    if frame.inspected.inspection is not None and frame.inside is None and frame.state.coloring != "height":
        less, more = _dot(_color_of(0.2)), _dot(_color_of(0.8))  # most points are paler than the ends, which are dark
        away, towards = ("astray", "right way") if frame.inspected.inspection.misleading else ("takes away", "adds")
        parts.append(f"{less} {away} &nbsp;{more} {towards}")
    return parts


def _color_of(share: float) -> palette.Color:
    r, g, b = (int(value) for value in palette.DIVERGING[round(share * (len(palette.DIVERGING) - 1))])
    return r, g, b


def _dot(color: palette.Color) -> str:
    return f'<span style="color:{palette.css(color)}">●</span>'
