"""Colours that people with any colour vision tell apart (after Okabe and Ito), for a light and a dark page."""

from __future__ import annotations

Color = tuple[int, int, int]

METHODS: tuple[Color, Color] = ((0, 114, 178), (213, 94, 0))
"""Left and right pane: blue and vermilion."""

BLOCKS: tuple[Color, ...] = ((230, 159, 0), (0, 158, 115), (204, 121, 167))
"""Blocks of a histogram: orange, green, purple."""

MARK: Color = (240, 228, 66)
"""What a person has picked: yellow."""

OUTLIER: Color = (190, 140, 182)
GHOST: Color = (0, 158, 115)


def ink(dark: bool) -> Color:
    """Colour of reference lines and of the model."""
    return (215, 215, 215) if dark else (60, 60, 60)


def css(color: Color, alpha: float = 1.0) -> str:
    """A colour as CSS."""
    return f"rgba({color[0]}, {color[1]}, {color[2]}, {alpha:g})"


def lighter(color: Color, dark: bool, share: float = 0.55) -> Color:
    """A colour moved towards the page's own by a share."""
    page = 30 if dark else 255
    r, g, b = (round(value + (page - value) * share) for value in color)
    return r, g, b
