"""What the colours on the canvas mean, as HTML for the page and for files."""

from __future__ import annotations

from ido_viz.core import palette
from ido_viz.core.frame import Frame


def legend_html(frame: Frame) -> str:
    """What the colours on the canvas mean."""
    dark = frame.state.dark
    scene = "".join(_dot(palette.method_color(side.run.method, dark)) for side in frame.sides)
    trail = f'<span style="color:{palette.css(palette.method_color(frame.sides[0].run.method, dark))}">╱</span>'
    parts = [f"{_dot(palette.surface(dark))} model", f"{scene} scene"]
    if "scores" not in frame.state.hidden:
        parts.append(f"{_dot(palette.ARRIVED)} arrived")
    parts += [f"{_dot(palette.OUTLIER)} outliers", f"{trail} its way"]
    if frame.state.ghost:
        parts.append(f'<span style="color:{palette.css(palette.GHOST)}">◇</span> where it belongs')
    if any(side.run.race is not None for side in frame.sides):
        parts.append("▸ a start, over its top")
    ink = palette.css(palette.ink(dark))
    return (
        f'<div style="font-size:min(0.75rem,0.95vw);white-space:nowrap;color:{ink}">'
        + " &nbsp;".join(f"<span>{part}</span>" for part in parts)
        + "</div>"
    )


def _dot(color: palette.Color) -> str:
    return f'<span style="color:{palette.css(color)}">●</span>'
