"""Colours: every method has its own, and what is written in one can be read."""

from __future__ import annotations

from itertools import combinations, product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ido import HISTOGRAMS, Block
from ido.experiments.families import COMPARED_METHODS, FAMILIES
from ido_viz.core import palette
from ido_viz.core.library import shipped_library
from ido_viz.core.palette import Color
from ido_viz.core.verdict import Verdict

LIBRARY = shipped_library()
READABLE = 4.5  # WCAG 2.2, AA
NAMES = {name for shape in LIBRARY.subjects for name in LIBRARY.methods(shape)} | {"Point to plane", "<b>", "我的", ""}
colors = st.tuples(*[st.integers(0, 255)] * 3)


def lab(color: Color) -> np.ndarray:
    """L*, a*, b* of an sRGB colour, white as on screens (IEC 61966-2-1 and CIE 15)."""
    share = np.array(color) / 255
    linear = np.where(share > 0.04045, ((share + 0.055) / 1.055) ** 2.4, share / 12.92)
    to_xyz = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]])
    xyz = to_xyz @ linear / [0.9505, 1.0, 1.089]
    x, y, z = np.where(xyz > 0.008856, np.cbrt(xyz), 7.787 * xyz + 16 / 116)
    return np.array([116 * y - 16, 500 * (x - y), 200 * (y - z)])


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


def test_no_block_looks_like_the_true_place_or_what_has_arrived():
    blocks = {block for histogram in HISTOGRAMS.values() for block in histogram.blocks} | {Block("one", "other")}
    colors = {palette.block_color(block, number) for block in blocks for number in range(4)}
    for one, reserved in product(colors, (palette.GHOST, palette.ARRIVED, palette.MARK)):
        assert np.linalg.norm(lab(one) - lab(reserved)) > 20, one


def test_a_method_keeps_its_colour_and_own_ones_get_one_too():
    own = {palette.method_color(f"Method {n}") for n in range(40)}
    assert len(own) == 4
    assert palette.method_color("Method 1") == palette.method_color("Method 1")
    for one in own:
        for other in {palette.method_color(family.main) for family in FAMILIES} | own - {one}:
            assert np.linalg.norm(lab(one) - lab(other)) > 20, (one, other)  # 2.3 can just be told apart
