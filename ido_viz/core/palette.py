"""Colours that people with any colour vision tell apart (after Okabe and Ito), for a light and a dark page."""

from __future__ import annotations

import numpy as np

from ido import Block
from ido.types import FloatArray

Color = tuple[int, int, int]

METHOD_COLORS: tuple[Color, Color] = ((0, 114, 178), (213, 94, 0))
"""Left and right pane: blue and vermilion."""

_SPARE: tuple[Color, ...] = ((230, 159, 0), (0, 158, 115), (204, 121, 167), (86, 180, 233))
"""For blocks that bring no colour: orange, green, purple, sky blue, and again."""

MARK: Color = (240, 228, 66)
"""What a person has picked: yellow."""

OUTLIER: Color = (190, 140, 182)
GHOST: Color = (0, 158, 115)
GUIDE: Color = (128, 128, 128)
"""Lines that explain a picture."""

LEGEND: dict[str, tuple[Color, ...]] = {
    "model": (GUIDE,),
    "scene": METHOD_COLORS,
    "outliers": (OUTLIER,),
    "where it belongs": (GHOST,),
}
"""What the colours of points mean."""


def block_color(block: Block, number: int) -> Color:
    """What the block of a histogram is drawn in; `number` counts the blocks from 0."""
    return block.color or _SPARE[number % len(_SPARE)]


def ink(dark: bool) -> Color:
    """Colour of reference lines and of the model."""
    return (215, 215, 215) if dark else (60, 60, 60)


def model_greys(dark: bool) -> tuple[int, int]:
    """The greys of the model's lowest and highest points."""
    return (110, 235) if dark else (90, 185)


def css(color: Color, alpha: float = 1.0) -> str:
    """A colour as CSS."""
    return f"rgba({color[0]}, {color[1]}, {color[2]}, {alpha:g})"


def hexadecimal(color: Color) -> str:
    """A colour as Matplotlib takes it."""
    return "#{:02x}{:02x}{:02x}".format(*color)


def lighter(color: Color, dark: bool, share: float = 0.55) -> Color:
    """A colour moved towards the page's own by a share."""
    page = 30 if dark else 255
    r, g, b = (round(value + (page - value) * share) for value in color)
    return r, g, b


def _diverging() -> np.ndarray:
    """256 colours from blue over white to red, even for people with a colour vision deficiency; shape (256, 3)."""
    stops = np.array([[5, 48, 97], [67, 147, 195], [247, 247, 247], [214, 96, 77], [103, 0, 31]], dtype=np.float64)
    at = np.linspace(0, len(stops) - 1, 256)
    channels = [np.interp(at, np.arange(len(stops)), stops[:, c]) for c in range(3)]
    return np.rint(np.stack(channels, axis=1)).astype(np.uint8)


DIVERGING = _diverging()
"""Blue for negative, white for none, red for positive values; shape (256, 3)."""


def diverging_levels(values: FloatArray, scale: float) -> np.ndarray:
    """Which of the `DIVERGING` colours each value has, -scale the first and scale the last; uint8."""
    return np.clip(np.rint((values / scale + 1) * 127.5), 0, 255).astype(np.uint8)


def diverging_colors(values: FloatArray) -> np.ndarray:
    """The `DIVERGING` colours of values (n,), the largest ones at their ends; shape (n, 3)."""
    scale = float(np.quantile(np.abs(values), 0.99)) or 1.0
    return DIVERGING[diverging_levels(values, scale)]
