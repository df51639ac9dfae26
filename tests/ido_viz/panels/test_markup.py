"""What goes into the page as HTML: names are escaped, numbers are those of the run."""

from __future__ import annotations

import base64
import io
import re
from dataclasses import replace
from html.parser import HTMLParser

import numpy as np
import pytest
from PIL import Image

from ido import Block, shipped_maps
from ido.bin_order import bin_order
from ido_viz.core.frame import frame_of
from ido_viz.core.library import shipped_library
from ido_viz.core.run import Run, compute
from ido_viz.core.state import State
from ido_viz.panels.maps_tab import heatmap_html
from ido_viz.panels.markup import both_methods, caption, method_span, signed
from ido_viz.panels.readout import readout_html

EVIL = [
    "<img src=x onerror=alert(1)>",
    '"><script>alert(1)</script>',
    "' onmouseover='alert(1)",
    "</table><iframe srcdoc=x>",
    "<b>bold</b> & co",
]
HARMLESS = {"div", "span", "table", "tbody", "tr", "td", "th", "b", "br"}


class Page(HTMLParser):
    """Tags, attributes and text of a piece of HTML."""

    def __init__(self, source: str) -> None:
        super().__init__()
        self.tags: list[str] = []
        self.attributes: list[str] = []
        self.images: list[str] = []
        self.open: list[str] = []
        self.text = ""
        self.feed(source)
        self.close()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        self.attributes += [name for name, _ in attrs]
        if tag == "img":
            self.images += [value or "" for name, value in attrs if name == "src"]
        else:
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.text += data


@pytest.fixture(scope="module")
def run() -> Run:
    return compute(State(max_iterations=12), shipped_library())


def readout_of(run: Run, iteration: int) -> str:
    return readout_html(frame_of(run, State(iteration=iteration)))


def named(run: Run, left: str, right: str) -> Run:
    sides = tuple(replace(side, method=name) for side, name in zip(run.sides, (left, right), strict=True))
    return replace(run, sides=sides)


def assert_only_text(source: str, name: str) -> None:
    page = Page(source)
    assert set(page.tags) <= HARMLESS
    assert set(page.attributes) <= {"class", "style"}
    assert page.open == []
    assert name in page.text


@pytest.mark.parametrize("name", EVIL)
def test_the_readout_shows_a_name_as_it_is(run: Run, name: str):
    assert_only_text(readout_of(named(run, name, "DO"), 3), name)
    assert_only_text(readout_of(named(run, "DO", name), 3), name)


@pytest.mark.parametrize("name", EVIL)
def test_captions_show_a_name_as_it_is(run: Run, name: str):
    assert_only_text(method_span(name, False), name)
    assert_only_text(caption(both_methods(named(run, "DO", name), False)), name)


@pytest.mark.parametrize("name", EVIL)
def test_a_heatmap_shows_its_method_and_blocks_as_they_are(monkeypatch: pytest.MonkeyPatch, name: str):
    maps = shipped_maps("bunny", "front-back")
    monkeypatch.setattr(type(maps.histogram), "blocks", (Block(name, "back"),))
    page = Page(heatmap_html(maps, 1, bin_order(maps.histogram, "model index"), method_span(name, True)))
    assert set(page.tags) <= HARMLESS | {"img"}
    assert len(page.images) == 1
    assert set(page.attributes) <= {"style", "alt", "src", "data-heatmap", "data-pane"}
    assert page.open == []
    assert page.text.count(name) == 2


def test_the_readout_holds_the_numbers_of_each_side(run: Run):
    iteration = 7
    cells = [re.sub(r"<[^>]*>", "", cell) for cell in re.findall(r"<td.*?</td>", readout_of(run, iteration))]
    rows = {cells[i]: cells[i + 1 : i + 3] for i in range(0, len(cells), 3)}
    both = run.sides
    assert rows["Iteration"] == ["7 / 12", "7 / 12"]
    assert rows["Next update"] == [f"{side.trajectory.update_norms[iteration]:.4f}" for side in both]
    assert rows["PointAcc"] == [f"{side.scores.accuracy[iteration]:.3f}" for side in both]
    assert rows["PointRMSE"] == [f"{side.scores.rmse[iteration]:.4f}" for side in both]
    assert rows["Rotation error"] == [f"{side.scores.rotation[iteration]:.2f}°" for side in both]
    assert rows["Translation error"] == [f"{side.scores.translation[iteration]:.4f}" for side in both]
    assert rows["Stops"] == ["not yet", "not yet"]


def test_at_the_iteration_limit_there_is_no_next_update(run: Run):
    text = Page(readout_of(run, 12)).text
    assert text.count("–") == 2
    assert text.count("iteration limit") == 2


def picture(source: str) -> np.ndarray:
    """Colours of a heatmap's picture, shape (height, width, 3)."""
    (address,) = Page(source).images
    kind, data = address.split(",", 1)
    assert kind == "data:image/png;base64"
    return np.asarray(Image.open(io.BytesIO(base64.b64decode(data))).convert("RGB")).astype(int)


def test_a_heatmap_has_a_row_for_each_coordinate_and_a_column_for_each_bin():
    maps = shipped_maps("bunny", "triple-binary")
    source = heatmap_html(maps, 15, bin_order(maps.histogram, "model index"), "title")
    pixels = picture(source)
    assert pixels.shape[0] % 6 == 0
    assert pixels.shape[1] == maps.histogram.n_bins
    rows = pixels.reshape(6, -1, *pixels.shape[1:])
    assert (rows == rows[:, :1]).all()
    text = Page(source).text
    for name in ("ρx", "ρy", "ρz", "φx", "φy", "φz", "front", "back", "up", "down", "clockw.", "anticl."):
        assert name in text


def test_a_heatmap_is_red_above_zero_and_blue_below():
    maps = shipped_maps("bunny", "front-back")
    pixels = picture(heatmap_html(maps, 1, bin_order(maps.histogram, "model index"), ""))
    rows = pixels.reshape(6, -1, *pixels.shape[1:])[:, 0]
    warmth = rows[..., 0] - rows[..., 2]
    values = maps.maps[0]
    strong = np.abs(values) > 0.2 * np.quantile(np.abs(values), 0.995)
    assert (np.sign(warmth[strong]) == np.sign(values[strong])).all()


def test_heatmaps_differ_by_map_and_by_order():
    maps = shipped_maps("bunny", "front-back")
    orders = [bin_order(maps.histogram, order) for order in ("model index", "azimuth")]
    sources = {heatmap_html(maps, n, order, "") for n in (1, 2, 30) for order in orders}
    assert len(sources) == 6


@pytest.mark.parametrize("order", ["model index", "azimuth"])
def test_a_picked_points_bins_are_marked_where_they_are_drawn(order: str):
    maps = shipped_maps("bunny", "triple-binary")
    bins, n_model = bin_order(maps.histogram, order), len(maps.histogram.model.points)
    source = heatmap_html(maps, 1, bins, "", 100)
    places = [float(left) for left in re.findall(r"left:([\d.]+)%", source)]
    expected = [100 * (list(bins).index(side * n_model + 100) + 0.5) / len(bins) for side in range(6)]
    assert places == pytest.approx(expected, abs=1e-3)
    assert "left:" not in heatmap_html(maps, 1, bins, "")


def test_a_number_that_is_rounded_to_nothing_has_no_sign():
    assert [signed(value, 3) for value in (-0.0004, 0.0004, -0.0, -0.0006, 12.3456)] == [
        "0.000",
        "0.000",
        "0.000",
        "-0.001",
        "+12.346",
    ]
