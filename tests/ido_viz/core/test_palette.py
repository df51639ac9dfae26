"""Colours: every method has its own, and what is written in one can be read."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ido.experiments.families import COMPARED_METHODS
from ido_viz.core import palette
from ido_viz.core.library import shipped_library
from ido_viz.core.palette import Color
from ido_viz.core.verdict import Verdict

LIBRARY = shipped_library()
READABLE = 4.5  # WCAG 2.2, AA
NAMES = {name for shape in LIBRARY.subjects for name in LIBRARY.methods(shape)} | {"Point to plane", "<b>", "我的", ""}
colors = st.tuples(*[st.integers(0, 255)] * 3)


def wcag_contrast(one: Color, other: Color) -> float:
    """The contrast ratio, after the text of WCAG 2.2."""

    def luminance(color: Color) -> float:
        share = np.array(color) / 255
        r, g, b = np.where(share <= 0.04045, share / 12.92, ((share + 0.055) / 1.055) ** 2.4)
        return 0.2126 * r + 0.7152 * g + 0.0722 * b

    light, dark = max(luminance(one), luminance(other)), min(luminance(one), luminance(other))
    return (light + 0.05) / (dark + 0.05)


@given(colors, colors)
def test_contrast_is_that_of_the_standard(one: Color, other: Color):
    assert palette.contrast(one, other) == pytest.approx(wcag_contrast(one, other))
    assert palette.contrast((0, 0, 0), (255, 255, 255)) == pytest.approx(21)


@given(colors, st.booleans())
def test_any_colour_becomes_one_that_can_be_read(color: Color, dark: bool):
    assert wcag_contrast(palette.text(color, dark), palette.PAGES[dark]) >= READABLE


@given(colors, st.booleans())
def test_a_colour_that_can_be_read_stays(color: Color, dark: bool):
    readable = palette.text(color, dark)
    assert palette.text(readable, dark) == readable


@pytest.mark.parametrize("dark", [False, True])
def test_names_and_verdicts_can_be_read(dark: bool):
    written = [palette.method_color(name, dark) for name in sorted(NAMES)]
    written += [palette.verdict_color(verdict) for verdict in Verdict]
    for color in written:
        assert wcag_contrast(palette.text(color, dark), palette.PAGES[dark]) >= READABLE


@pytest.mark.parametrize("dark", [False, True])
@pytest.mark.parametrize("shape", LIBRARY.subjects)
def test_methods_on_offer_differ(shape: str, dark: bool):
    for one, other in combinations(LIBRARY.methods(shape), 2):
        assert palette.method_color(one, dark) != palette.method_color(other, dark), (one, other)


def test_the_methods_of_a_new_page_are_blue_and_vermilion():
    assert (palette.method_color("DO"), palette.method_color("Improved DO")) == ((0, 114, 178), (213, 94, 0))


@pytest.mark.parametrize("dark", [False, True])
@pytest.mark.parametrize("name", [*COMPARED_METHODS, "Point to plane"])
def test_no_method_looks_like_the_true_place_or_what_is_picked(name: str, dark: bool):
    for reserved in (palette.GHOST, palette.ARRIVED, palette.MARK):
        assert np.abs(np.subtract(palette.method_color(name, dark), reserved)).max() > 25


def test_a_method_keeps_its_colour_and_own_ones_get_one_too():
    own = {palette.method_color(f"Method {n}") for n in range(40)}
    assert len(own) == 4
    assert palette.method_color("Method 1") == palette.method_color("Method 1")
    assert not own & {palette.method_color(name) for name in COMPARED_METHODS}
