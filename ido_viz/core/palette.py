"""Colours that people with any colour vision tell apart (after Okabe and Ito), for a light and a dark page."""

from __future__ import annotations

import zlib
from functools import cache

import numpy as np

from ido import Block
from ido.experiments.families import FAMILIES
from ido.types import FloatArray
from ido_viz.core.verdict import Verdict

Color = tuple[int, int, int]

_OF_OWN: tuple[Color, ...] = ((0, 128, 128), (200, 0, 140), (178, 24, 72), (110, 110, 20))
"""For methods that are in no family: teal, magenta, crimson, olive."""

_VARIANTS = (0.0, -0.4, 0.4, -0.6)
"""How far the colours of a family's variants are moved towards white, or towards black."""

_SPARE: tuple[Color, ...] = ((230, 159, 0), (86, 180, 233), (204, 121, 167), (170, 120, 60))
"""For blocks that bring no colour: orange, sky blue, purple, tan, and again."""

MARK: Color = (240, 228, 66)
"""What a person has picked: yellow."""

RIM: Color = (30, 30, 30)
"""Around what is picked: black, nearly."""

OUTLIER: Color = (163, 163, 120)
GHOST: Color = (0, 158, 115)
ARRIVED: Color = (0, 138, 102)
"""Scene points that are where they belong, and a method whose scene is: the green of their place, a little darker."""

GUIDE: Color = (128, 128, 128)
"""Lines that explain a picture."""

_VERDICTS = {
    Verdict.IN_PLACE: ARRIVED,
    Verdict.NEARLY_IN_PLACE: (190, 130, 0),
    Verdict.WRONG_POSE: (190, 30, 45),
    Verdict.FAILED: (190, 30, 45),
}

PAGES: tuple[Color, Color] = ((255, 255, 255), (36, 36, 36))
"""Background of a light and of a dark page, a little darker in places."""

CONTRAST = 4.6
"""Of all text against the page, at least; WCAG asks for 4.5."""


def method_color(method: str, dark: bool = False) -> Color:
    """What a method is drawn in wherever it appears: its family's colour, moved a little for another variant.

    A family's black is the ink of the page.
    """
    for family in FAMILIES:
        names = [name for _, name in family.variants]
        if method in names:
            r, g, b = (int(family.color[i : i + 2], 16) for i in (1, 3, 5))
            color = (r, g, b) if any((r, g, b)) else ink(dark)
            return _moved(color, _VARIANTS[names.index(method) % len(_VARIANTS)])
    if method.startswith("DO ("):  # a shape's own variant of it, in no experiment
        return _moved(method_color("DO"), 0.4)
    return _OF_OWN[zlib.crc32(method.encode()) % len(_OF_OWN)]


def _moved(color: Color, share: float) -> Color:
    end = 255 if share > 0 else 0
    r, g, b = (round(value + (end - value) * abs(share)) for value in color)
    return r, g, b


def block_color(block: Block, number: int) -> Color:
    """What the block of a histogram is drawn in; `number` counts the blocks from 0."""
    return block.color or _SPARE[number % len(_SPARE)]


def ink(dark: bool) -> Color:
    """Colour of reference lines and of the model."""
    return (215, 215, 215) if dark else (60, 60, 60)


def model_greys(dark: bool) -> tuple[int, int]:
    """The greys of the model's lowest and highest points."""
    return (110, 235) if dark else (90, 185)


def verdict_color(verdict: Verdict) -> Color:
    """What a verdict is written in."""
    return _VERDICTS.get(verdict, GUIDE)


@cache
def text(color: Color, dark: bool) -> Color:
    """A colour moved towards the page's ink until it can be read as text: a contrast of at least `CONTRAST`."""
    tries = (_moved(color, share if dark else -share) for share in np.linspace(0.0, 1.0, 21).tolist())
    return next((each for each in tries if contrast(each, PAGES[dark]) >= CONTRAST), ink(dark))


def contrast(one: Color, other: Color) -> float:
    """The ratio of two colours' luminances, 1 to 21 (WCAG 2)."""
    light, dark = sorted((_luminance(one), _luminance(other)), reverse=True)
    return (light + 0.05) / (dark + 0.05)


def _luminance(color: Color) -> float:
    linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in (value / 255 for value in color)]
    return float(np.dot(linear, (0.2126, 0.7152, 0.0722)))


def surface(dark: bool) -> Color:
    """Colour of the model's surface."""
    return (150, 150, 155) if dark else (200, 200, 205)


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
