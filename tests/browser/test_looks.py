"""What the canvas, the charts, the heatmaps and the page as a whole look like."""

from __future__ import annotations

import io
from dataclasses import replace

import numpy as np
import pytest
from any_explorer import AT_THE_END, AT_THE_START, SETTLING
from explorer import SMALL, Explorer, OpenExplorer, box_of, like
from PIL import Image

from ido import RANGES
from ido_viz.core import palette
from ido_viz.core.state import State, encode
from ido_viz.teach.lessons import lesson

pytestmark = pytest.mark.filterwarnings("error::pytest.PytestUnhandledThreadExceptionWarning")
COLORS = [palette.method_color(name) for name in (AT_THE_START.left, AT_THE_START.right)]
DESKTOPS = [(1280, 720), (1440, 900)]
PHONE = (390, 844)
VISIBLE = 60  # pixels of a pure colour; most are blended, the more the coarser a slow page draws
SLIP = 2.0  # pixels
SHORTEST_TRACK = 120  # of a slider, pixels: what one can aim with


def see_both_panes(explorer: Explorer) -> None:
    """Wait until each method's cloud is seen in its own half, on its way or arrived."""

    def seen() -> bool:
        clouds = zip(explorer.canvas_halves(), COLORS, strict=True)
        return all((like(half, color) | like(half, palette.ARRIVED)).sum() > VISIBLE for half, color in clouds)

    explorer.wait_until("both panes on the canvas", seen)


@pytest.mark.looks_at_canvas
def test_each_pane_shows_its_method_s_cloud_and_what_both_share(at_the_start: Explorer):
    explorer = at_the_start
    see_both_panes(explorer)
    left, right = explorer.canvas_halves()
    assert like(left, COLORS[1]).sum() == 0
    assert like(right, COLORS[0]).sum() == 0
    for half in (left, right):
        assert like(half, palette.OUTLIER).sum() > VISIBLE
        assert hollow_places(half).sum() > VISIBLE
        surface = (np.ptp(half, axis=2) < 8) & (half.max(axis=2) < 240)
        assert surface.sum() > 20 * VISIBLE
    arrived = [like(half, palette.ARRIVED).sum() for half in (left, right)]
    explorer.press("Last")
    explorer.wait_until("the end", lambda: explorer.iteration() == explorer.last_iteration())
    explorer.wait_until(
        "points that have arrived",
        lambda: all(
            like(half, palette.ARRIVED).sum() > before + VISIBLE
            for half, before in zip(explorer.canvas_halves(), arrived, strict=True)
        ),
    )


@pytest.mark.looks_at_canvas
def test_from_every_side_the_panes_stand_beside_each_other(at_the_start: Explorer):
    explorer = at_the_start
    see_both_panes(explorer)
    box = box_of(explorer.canvas())
    between_the_clouds = box["x"] + box["width"] / 2, box["y"] + 0.1 * box["height"]
    explorer.drag_on_canvas(between_the_clouds, (0.25 * box["height"], 0.0))
    explorer.wait_until("a view from the side", lambda: abs((explorer.state().camera or (0.0,))[0]) > 0.8)
    see_both_panes(explorer)
    left, right = explorer.canvas_halves()
    assert like(left, COLORS[1]).sum() == 0
    assert like(right, COLORS[0]).sum() == 0


def hollow_places(half: np.ndarray) -> np.ndarray:
    """Which pixels are of the edges of hollow places, shape (height, width): green, but blended with what is behind."""
    red, green, blue = np.moveaxis(half, 2, 0)
    return (green - red > 40) & (np.abs(green - blue) < 25)


@pytest.mark.looks_at_canvas
def test_what_is_switched_off_leaves_the_canvas(at_the_start: Explorer):
    explorer = at_the_start
    see_both_panes(explorer)

    def pixels_of(color: palette.Color) -> int:
        return sum(int(like(half, color).sum()) for half in explorer.canvas_halves())

    explorer.tick("Handles")  # one of them is green, too

    def hollow() -> list[int]:
        return [int(hollow_places(half).sum()) for half in explorer.canvas_halves()]

    before = hollow()
    explorer.tick("Where it belongs")  # some scene points behind the model are nearly of that colour
    explorer.wait_until(
        "the hollow places gone", lambda: all(n < 0.3 * m for n, m in zip(hollow(), before, strict=True))
    )
    explorer.drag("Outliers", -0.2)
    explorer.wait_until("the outliers gone", lambda: pixels_of(palette.OUTLIER) < 10)
    see_both_panes(explorer)


@pytest.mark.looks_at_canvas
def test_stepping_moves_both_clouds(at_the_start: Explorer):
    see_both_panes(at_the_start)
    before = at_the_start.canvas_halves()
    for _ in range(3):
        at_the_start.press("Next (N)")
        at_the_start.pause()

    def moved() -> bool:
        after = at_the_start.canvas_halves()
        changed = [like(a, c) ^ like(b, c) for a, b, c in zip(before, after, COLORS, strict=True)]
        return all(pixels.sum() > VISIBLE for pixels in changed)

    at_the_start.wait_until("both clouds elsewhere", moved)


def test_histograms_change_with_the_iteration(at_the_start: Explorer):
    explorer = at_the_start
    explorer.wait_until("both histograms", lambda: explorer.charts().count() == 2)
    explorer.wait_until("both histograms drawn", lambda: min(explorer.chart_ink(i) for i in range(2)) > 500)
    seen = [{explorer.chart_picture(i)} for i in range(2)]
    for _ in range(2):
        explorer.press("Next (N)")
        for i, pictures in enumerate(seen):
            explorer.wait_until(
                "another histogram", lambda i=i, pictures=pictures: explorer.chart_picture(i) not in pictures
            )
            pictures.add(explorer.chart_picture(i))
        explorer.pause()


def test_histograms_can_be_drawn_otherwise(explorer: Explorer):
    explorer.wait_until("both histograms drawn", lambda: min(explorer.chart_ink(i) for i in range(2)) > 500)
    seen = [{explorer.chart_picture(i)} for i in range(2)]
    for change in ("order", "difference"):
        if change == "order":
            explorer.choose("Order bins by", "azimuth")
        else:
            explorer.tick("Histogram minus reference")
            explorer.page.get_by_text("minus the reference line").first.wait_for()
        for i, pictures in enumerate(seen):
            explorer.wait_until(
                f"another histogram after another {change}",
                lambda i=i, pictures=pictures: (
                    explorer.charts().count() == 2
                    and explorer.chart_ink(i) > 500
                    and explorer.chart_picture(i) not in pictures
                ),
            )
            pictures.add(explorer.chart_picture(i))


def test_heatmaps_follow_the_iteration_until_one_is_pinned(at_the_start: Explorer):
    explorer = at_the_start
    first = explorer.heatmap_pictures()[:2]
    assert len(set(first)) == 2
    explorer.page.get_by_text("map 1 of 30").first.wait_for()
    explorer.press("Next (N)")
    explorer.page.get_by_text("map 2 of 30").first.wait_for()
    second = explorer.heatmap_pictures()[:2]
    assert not set(first) & set(second)
    explorer.tick("Maps follow the iteration")
    explorer.page.get_by_text("(pinned)").first.wait_for()
    explorer.drag("Map", 1.0)
    explorer.page.get_by_text("map 30 of 30").first.wait_for()
    pinned = explorer.heatmap_pictures()[:2]
    assert not set(pinned) & {*first, *second}
    explorer.press("Next (N)")
    explorer.wait_until("the next iteration", lambda: explorer.iteration() == 2)
    explorer.expect_to_agree()
    assert explorer.heatmap_pictures()[:2] == pinned
    explorer.tick("Maps follow the iteration")
    explorer.page.get_by_text("map 3 of 30").first.wait_for()
    assert explorer.heatmap_pictures()[:2] != pinned


def test_every_tab_of_the_charts_shows_something(at_the_start: Explorer):
    explorer = at_the_start
    explorer.open_tab("Errors")
    explorer.wait_until("histograms and error curves", lambda: explorer.charts().count() == 2 + 4)
    for number in range(6):
        explorer.wait_until(f"chart {number} drawn", lambda number=number: explorer.chart_ink(number) > 300)
    before = [explorer.chart_picture(number) for number in range(2, 6)]
    explorer.press("Last")
    for number, picture in zip(range(2, 6), before, strict=True):
        explorer.wait_until(
            "the mark elsewhere", lambda number=number, picture=picture: explorer.chart_picture(number) != picture
        )
    explorer.open_tab("Maps")
    explorer.wait_until("the maps of both and six to compare", lambda: explorer.heatmaps().count() == 2 + 6)
    assert len(set(explorer.heatmap_pictures()[2:])) == 6
    explorer.open_tab("Training")
    explorer.wait_until("training curves", lambda: explorer.charts().count() == 4)
    for number in range(4):
        explorer.wait_until(f"chart {number} drawn", lambda number=number: explorer.chart_ink(number) > 300)
    explorer.open_tab("Histograms")
    explorer.open_tab("Sweeps")
    explorer.wait_until("sweep curves", lambda: explorer.charts().count() == 2 + 1)
    explorer.wait_until("curves drawn", lambda: explorer.chart_ink(2) > 300)
    explorer.open_tab("Maps")
    explorer.wait_until("the heatmaps again", lambda: explorer.heatmaps().count() == 2 + 6)


def brightness(explorer: Explorer) -> float:
    """Median brightness of the whole page."""
    return float(np.median(np.asarray(Image.open(io.BytesIO(explorer.page.screenshot())).convert("L"))))


@pytest.mark.looks_at_canvas
def test_dark_and_light_again(explorer: Explorer):
    see_both_panes(explorer)
    assert brightness(explorer) > 200
    explorer.tick("Dark")
    explorer.wait_until("a dark page", lambda: brightness(explorer) < 60)
    see_both_panes(explorer)
    explorer.wait_until("histograms drawn", lambda: min(explorer.chart_ink(i) for i in range(2)) > 500)
    explorer.tick("Dark")
    explorer.wait_until("a light page", lambda: brightness(explorer) > 200)


def test_a_dark_system_gets_a_dark_page_until_a_person_chooses(fresh_explorer: Explorer):
    explorer = fresh_explorer
    explorer.page.emulate_media(color_scheme="dark")
    explorer.open()
    dark = explorer.page.locator("[data-mantine-color-scheme=dark]")
    dark.wait_for()
    assert explorer.state() == replace(AT_THE_END, dark=True)
    explorer.tick("Dark")
    explorer.wait_until("the light page's address", lambda: explorer.page.url.endswith(encode(AT_THE_END)))
    explorer.page.reload()
    explorer.wait_ready()
    explorer.wait_until("the chosen page", lambda: explorer.state() == AT_THE_END)
    assert dark.count() == 0


WATCH_FOR_THE_EMPTY_PAGE = """
window.uncovered = [];
setInterval(() => {
    for (const button of document.querySelectorAll("button")) {
        const {x, y, width, height} = button.getBoundingClientRect();
        if (button.textContent !== "Save Canvas" || !width) continue;
        uncovered.push(!document.elementFromPoint(x + width / 2, y + height / 2)?.closest("#ido-splash"));
    }
}, 5);
"""
"""Notes whether a button of viser's own page, which ours replaces, can be seen."""


def test_a_splash_stands_before_the_page_until_it_is_there(fresh_explorer: Explorer):
    explorer = fresh_explorer
    explorer.page.add_init_script(WATCH_FOR_THE_EMPTY_PAGE)
    explorer.page.emulate_media(color_scheme="dark")
    explorer.page.goto(f"{explorer.app.url}/?lesson=histogram/2", wait_until="commit")
    splash = explorer.page.locator("#ido-splash")
    splash.get_by_text("IDO Explorer").wait_for()
    explorer.expect_step(2, len(lesson("histogram").steps))
    splash.wait_for(state="detached")
    assert box_of(explorer.canvas())["x"] > 0
    assert not any(explorer.page.evaluate("uncovered"))
    assert explorer.state().dark, "a lesson is dark, too, where the browser prefers it"


DIVISIONS = """canvas => {
    const {width, height} = canvas, data = canvas.getContext("2d").getImageData(0, 0, width, height).data;
    const inked = (x, y) => data[4 * (y * width + x) + 3] > 0;
    const rows = [...Array(height).keys()], columns = [...Array(width).keys()];
    const full = columns.map(x => rows.filter(y => inked(x, y)).length > 0.6 * height);
    const below = rows.slice(Math.round(0.85 * height));
    return [full.filter((is, x) => is && !full[x - 1]).length, below.some(y => columns.some(x => inked(x, y)))];
}"""
"""How many lines go through a chart from below to above, and whether something is written below it."""


def see_names_and_dividers(explorer: Explorer, *counts: int) -> None:
    """Wait until each histogram has its names and the lines between so many sides."""
    for number, sides in enumerate(counts):
        explorer.wait_until(
            f"{sides - 1} lines between {sides} sides, and two at the ends",
            lambda number=number, sides=sides: explorer.charts().nth(number).evaluate(DIVISIONS) == [sides + 1, True],
        )


@pytest.mark.looks_at_canvas  # the drawing made the page slow enough for them to be missing
def test_a_fresh_page_s_histograms_have_their_names_and_dividers_beside_a_slow_method(open_explorer: OpenExplorer):
    see_names_and_dividers(open_explorer(replace(AT_THE_END, right="Global")), 2, 2)


@pytest.mark.looks_at_canvas  # the drawing made the page slow enough for them to be missing
def test_they_have_them_while_it_plays_too(open_explorer: OpenExplorer):
    see_names_and_dividers(open_explorer(State()), 2, 6)


def test_a_message_on_a_broken_code_leaves_the_methods_names_in_sight(explorer: Explorer):
    its_code = explorer.code()
    explorer.paste("<img src=x onerror=alert(1)>")
    explorer.wait_until("the page's own code again", lambda: explorer.code() == its_code)
    message, names = explorer.page.get_by_role("alert").last, explorer.page.locator(".names")
    message.wait_for()
    assert "This code cannot be used" in explorer.notifications()[0]
    explorer.wait_until(
        "the message below the names", lambda: box_of(message)["y"] >= box_of(names)["y"] + box_of(names)["height"]
    )


@pytest.mark.looks_at_canvas
@pytest.mark.parametrize("size", DESKTOPS, ids=lambda size: f"{size[0]}x{size[1]}")
def test_controls_canvas_and_charts_stand_side_by_side(open_explorer: OpenExplorer, size: tuple[int, int]):
    explorer = open_explorer(AT_THE_START, size)
    see_both_panes(explorer)
    width, height = size
    canvas = box_of(explorer.canvas())
    left_edge, right_edge = canvas["x"], canvas["x"] + canvas["width"]
    assert canvas["width"] > 0.35 * width
    assert canvas["height"] > 0.9 * height
    for name in RANGES:
        track, row = explorer.row(name.capitalize()).locator(".mantine-Slider-track"), explorer.row(name.capitalize())
        assert box_of(track)["width"] >= SHORTEST_TRACK, name
        assert 0 <= box_of(row)["y"] <= height - box_of(row)["height"], f"{name} is not seen without scrolling"
    for name in ("Play (P)", "First (R)", "Back (B)", "Next (N)", "Last", "New seed", "Paper defaults"):
        box = box_of(explorer.page.get_by_role("button", name=name, exact=True))
        assert box["x"] >= 0, name
        assert box["x"] + box["width"] <= left_edge + SLIP, name
    for table in (explorer.page.locator("table"), explorer.row("Rotation"), explorer.row("Most iterations")):
        box = box_of(table)
        assert box["x"] >= 0
        assert box["x"] + box["width"] <= left_edge + SLIP
    right_side = [explorer.charts().nth(i) for i in range(2)] + [explorer.heatmaps().nth(i) for i in range(2)]
    for item in right_side:
        box = box_of(item)
        assert box["x"] >= right_edge - SLIP
        assert box["x"] + box["width"] <= width + SLIP
        assert box["width"] > 250
        assert box["height"] > 50
        assert box["y"] + box["height"] <= height, "below the window's edge"
    maps_panel = box_of(explorer.page.get_by_role("tab", name="Maps", exact=True))
    lower_chart = box_of(explorer.charts().nth(1))
    assert lower_chart["y"] + lower_chart["height"] <= maps_panel["y"], "a histogram is cut off"
    assert explorer.page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    for number in range(2):
        explorer.wait_until("a histogram", lambda number=number: explorer.chart_ink(number) > 500)
    see_names_and_dividers(explorer, 2, 6)


ROWS_OF_TABS = """() => [...document.querySelectorAll("[data-dock-group]")].map(group => {
    const tabs = [...group.querySelectorAll("[role=tab]")];
    return new Set(tabs.map(tab => Math.round(tab.getBoundingClientRect().top))).size;
}).filter(rows => rows > 0)"""


def test_with_large_text_the_tabs_of_each_panel_stand_in_one_row(open_explorer: OpenExplorer):
    explorer = open_explorer(replace(AT_THE_END, large_text=True), (1280, 720))
    explorer.pause(SETTLING)
    rows = explorer.page.evaluate(ROWS_OF_TABS)
    assert len(rows) >= 2 and set(rows) == {1}


def test_a_tab_of_the_controls_brings_what_it_holds_into_view(explorer: Explorer):
    height = SMALL[1]
    last = explorer.page.get_by_role("button", name="A ball of outliers", exact=True)
    explorer.open_tab("Learn")
    explorer.wait_until("its last button in sight", lambda: box_of(last)["y"] + box_of(last)["height"] <= height)
    assert box_of(explorer.page.get_by_role("tab", name="Learn", exact=True))["y"] >= 0


@pytest.mark.looks_at_canvas
def test_on_a_phone_the_panes_are_seen_and_play_works(open_explorer: OpenExplorer):
    explorer = open_explorer(replace(AT_THE_END, speed=60), PHONE)
    see_both_panes(explorer)
    play = explorer.page.get_by_role("button", name="Play (P)", exact=True)
    box = box_of(play)
    assert box["x"] >= 0
    assert box["x"] + box["width"] <= PHONE[0]
    assert 0 <= box["y"] <= PHONE[1] - box["height"]
    assert explorer.page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    explorer.press("First (R)")
    explorer.wait_until("the start", lambda: explorer.iteration() == 0)
    explorer.pause()
    explorer.press("Play (P)")
    explorer.wait_until("the end", lambda: explorer.iteration() == explorer.last_iteration())
