"""The charts for a paper hold the numbers that the page shows, and are files that a journal takes."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from typing import Any
from xml.etree import ElementTree

import matplotlib
import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from PIL import Image

from ido import Perturbation
from ido.bin_order import bin_order
from ido_viz.core.frame import frame_of
from ido_viz.core.inspection import inspect
from ido_viz.core.library import shipped_library
from ido_viz.core.run import Run, compute
from ido_viz.core.state import LAST, State, decode
from ido_viz.files.chart_archive import charts_zip
from ido_viz.files.chart_figures import DOTS_PER_INCH, WIDTH, curves_figure, histograms_figure, maps_figure

LIBRARY = shipped_library()
SMALL = Perturbation(points=120, outliers=40, rotation=40.0, seed=3)
STATE = State(perturbation=SMALL, iteration=4, max_iterations=12)
BASELINE = replace(STATE, right="GMMReg, tuned", dark=True)
EVIL = r"_<b> & $x_1$ \frac"


@pytest.fixture(scope="module")
def run() -> Run:
    return compute(STATE, LIBRARY)


@pytest.fixture(scope="module")
def with_baseline() -> Run:
    return compute(BASELINE, LIBRARY)


@pytest.fixture(scope="module")
def evil(with_baseline: Run) -> Run:
    return replace(with_baseline, sides=(replace(with_baseline.sides[0], method=EVIL), with_baseline.sides[1]))


@pytest.fixture(scope="module")
def files(evil: Run) -> dict[str, bytes]:
    return members(charts_zip(frame_of(evil, BASELINE)))


def members(archive: bytes) -> dict[str, bytes]:
    with zipfile.ZipFile(io.BytesIO(archive)) as opened:
        assert opened.testzip() is None
        return {name: opened.read(name) for name in opened.namelist()}


def panels(figure: Figure) -> list[Axes]:
    """All charts but the colour bars."""
    return [ax for ax in figure.axes if ax.get_label() != "<colorbar>"]


def texts(ax: Axes) -> str:
    return " ".join([ax.get_title(loc="left"), *(text.get_text() for text in ax.texts)])


def values(line: Any) -> np.ndarray:
    return np.asarray(line.get_ydata(), dtype=np.float64)


# The numbers


@pytest.mark.parametrize(
    "change",
    [
        {},
        {"difference": True},
        {"order": "azimuth", "iteration": LAST},
        {"order": "contribution", "difference": True, "iteration": 1},
    ],
)
def test_histograms_are_those_that_the_methods_see(run: Run, change: Mapping[str, Any]):
    state = replace(STATE, **change)
    iteration = run.iterations if state.iteration == LAST else state.iteration
    shares = [None if one is None else one.values for one in (inspect(run, state, iteration, pane) for pane in (0, 1))]
    for number, (ax, side) in enumerate(zip(panels(histograms_figure(frame_of(run, state))), run.sides, strict=True)):
        histogram = side.histogram
        n_blocks = len(histogram.blocks)
        tops = np.repeat(histogram.reference.reshape(n_blocks, -1).max(axis=1), histogram.n_bins // n_blocks)
        seen = run.histogram(number, iteration) - (histogram.reference if state.difference else 0)
        order = bin_order(histogram, state.order, shares[number])
        dots = np.nansum([values(line) for line in ax.lines[1 : 1 + n_blocks]], axis=0)
        np.testing.assert_allclose(dots, (seen / tops)[order], rtol=1e-5, atol=1e-6)
        low, high = ax.get_ylim()
        assert low <= dots.min() <= dots.max() <= high
        names = [name for block in histogram.blocks for name in block.sides]
        assert [label.get_text() for label in ax.get_xticklabels()] == names
        assert f"iteration {side.clipped(iteration)} of {side.trajectory.iterations}" in texts(ax)


def test_what_is_laid_over_and_what_is_picked_are_drawn(run: Run):
    state = replace(STATE, overlay="another iteration", overlaid_iteration=1, inspected=5)
    for ax, side in zip(panels(histograms_figure(frame_of(run, state))), run.sides, strict=True):
        plain, picked = (np.isfinite(values(line)) for line in (ax.lines[0], ax.lines[-1 - _borders(ax)]))
        assert plain.all()
        assert picked.sum() == 2 * len(side.histogram.blocks)
        assert "grey: iteration 1" in texts(ax)


def _borders(ax: Axes) -> int:
    return len(ax.get_xticklabels()) - 1


@pytest.mark.parametrize(("pinned", "expected"), [(0, 5), (2, 2), (1000, 30)])
def test_maps_are_those_of_the_next_update_or_the_pinned_one(run: Run, pinned: int, expected: int):
    state = replace(STATE, pinned_map=pinned)
    for ax, side in zip(panels(maps_figure(frame_of(run, state))), run.sides, strict=True):
        assert side.maps is not None
        drawn = np.asarray(ax.images[0].get_array())
        rows = drawn.reshape(6, -1, drawn.shape[1])
        assert (rows == rows[:, :1]).all()
        order = bin_order(side.histogram, state.order)
        np.testing.assert_array_equal(rows[:, 0], side.maps.maps[expected - 1][:, order])
        assert f"map {expected} of 30" in texts(ax)
        low, high = ax.images[0].get_clim()
        assert -low == high > 0
        assert ax.images[0].colorbar is not None
        assert [label.get_text() for label in ax.get_yticklabels()] == ["ρx", "ρy", "ρz", "φx", "φy", "φz"]


def test_a_method_without_maps_is_left_out_of_their_figure(with_baseline: Run, files: dict[str, bytes]):
    (ax,) = panels(maps_figure(frame_of(with_baseline, BASELINE)))
    assert texts(ax).split() == ["DO", "map", "5", "of", "30"]
    assert "none of GMMReg, tuned" in files["README.txt"].decode()


def test_curves_are_those_of_the_scores(with_baseline: Run):
    rmse, accuracy, update, distance = panels(curves_figure(frame_of(with_baseline, BASELINE)))
    for number, side in enumerate(with_baseline.sides):
        for ax, expected in (
            (rmse, side.scores.rmse),
            (accuracy, side.scores.accuracy),
            (update, side.norms),
            (distance, side.distances),
        ):
            curve, dot = (values(line) for line in ax.lines[2 * number : 2 * number + 2])
            np.testing.assert_allclose(curve, expected, rtol=1e-9)
            np.testing.assert_allclose(dot, expected[side.clipped(4)], rtol=1e-9)
    assert update.get_yscale() == "log"
    assert values(update.lines[-1])[0] == BASELINE.epsilon
    low, high = update.get_ylim()
    assert low < BASELINE.epsilon < np.nanmax(with_baseline.sides[0].norms) < high


def test_a_run_that_does_nothing_can_be_drawn():
    state = replace(STATE, left="Did nothing", right="Did nothing")
    files = members(charts_zip(frame_of(compute(state, LIBRARY), state)))
    assert sorted(files) == ["README.txt", "curves.png", "curves.svg", "histograms.png", "histograms.svg"]


# The files


def test_there_is_each_chart_as_svg_and_as_png(files: dict[str, bytes]):
    charts = [f"{name}.{kind}" for name in ("curves", "histograms", "maps") for kind in ("png", "svg")]
    assert sorted(files) == ["README.txt", *charts]


def test_pictures_are_as_wide_as_two_columns_and_white(files: dict[str, bytes]):
    for name in (name for name in files if name.endswith(".png")):
        picture = Image.open(io.BytesIO(files[name]))
        assert picture.width == round(WIDTH * DOTS_PER_INCH) == 2130
        assert picture.info["dpi"] == pytest.approx((DOTS_PER_INCH, DOTS_PER_INCH), abs=0.1)
        corners = np.asarray(picture.convert("RGB"))[[0, 0, -1, -1], [0, -1, 0, -1]]
        assert (corners == 255).all()


def test_vector_graphics_are_well_formed_and_need_nothing_else(files: dict[str, bytes]):
    for name in (name for name in files if name.endswith(".svg")):
        root = ElementTree.fromstring(files[name])
        assert root.get("width") == f"{WIDTH * 72:g}pt"
        for element in root.iter():
            for key, value in element.attrib.items():
                if key.endswith(("href", "src")):
                    assert value.startswith(("#", "data:image/png;base64,"))
                assert "url(" not in value.replace("url(#", "")
            assert not element.tag.endswith(("script", "foreignObject"))


def test_names_are_shown_as_they_are_and_as_text(files: dict[str, bytes]):
    for name in ("histograms", "maps", "curves"):
        root = ElementTree.fromstring(files[f"{name}.svg"])
        written = [element.text or "" for element in root.iter("{http://www.w3.org/2000/svg}text")]
        assert any(text.endswith(EVIL) for text in written), written
    assert EVIL in files["README.txt"].decode()


def test_a_long_name_leaves_room_for_the_charts(evil: Run):
    long = replace(evil, sides=(replace(evil.sides[0], method="W" * 300), replace(evil.sides[1], method="a\nb" * 90)))
    for draw in (histograms_figure, maps_figure, curves_figure):
        figure = draw(frame_of(long, BASELINE))
        figure.draw_without_rendering()
        assert all(ax.get_position().height > 0.15 and ax.get_position().width > 0.35 for ax in panels(figure))


def test_the_readme_leads_back_to_the_page(files: dict[str, bytes]):
    text = files["README.txt"].decode()
    code = next(word for word in text.split() if word.startswith("ido1-"))
    assert decode(code) == BASELINE
    assert "bunny, seed 3: rotation 40°" in text
    assert max(len(line) for line in text.splitlines()) < 200
    title = ElementTree.fromstring(files["curves.svg"]).findtext("{http://www.w3.org/2000/svg}title")
    assert title == f"curves: {EVIL} and GMMReg, tuned"


def test_tabs_may_export_at_once_and_leave_no_settings_behind(evil: Run, run: Run, files: dict[str, bytes]):
    before = dict(matplotlib.rcParams)
    with ThreadPoolExecutor() as pool:
        first, second = (pool.submit(charts_zip, frame_of(*asked)) for asked in ((run, STATE), (evil, BASELINE)))
        assert members(second.result()) == files
        assert "maps.svg" in members(first.result())
    assert dict(matplotlib.rcParams) == before
