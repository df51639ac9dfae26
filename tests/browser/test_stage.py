"""The stage: handles, the camera, undo, and that nothing on it moves by itself."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from any_explorer import SETTLING, independent_run
from explorer import Explorer, box_of
from scipy.spatial.transform import Rotation

from ido.types import FloatArray
from ido_viz.canvas.pane import PANE_OFFSETS
from ido_viz.core import history
from ido_viz.core.geometry import VIEW_DIRECTION, upright
from ido_viz.core.state import NO_CAMERA, NO_START
from ido_viz.live_state import AFTER_A_CHANGE

pytestmark = pytest.mark.filterwarnings("error::pytest.PytestUnhandledThreadExceptionWarning")

PLACES = """() => {
    const edge = document.querySelector("canvas[data-engine]").getBoundingClientRect().left + 2;
    const kinds = "label, button, table, tr, input, [role=tab], .mantine-Slider-track, .verdict";
    return [...document.querySelectorAll(kinds)]
        .map(element => [element, element.getBoundingClientRect()])
        .filter(([element, box]) => box.width && (box.right <= edge || element.matches(".verdict")))
        .map(([element, box]) => [element.tagName, box.x, box.y, box.width, box.height].join(" "));
}"""
"""Where everything in the control panel is, and the verdicts over the canvas."""


ARROW = np.array([0.5, 0.0, 0.0])  # beyond the rings


def on_screen(explorer: Explorer, point: FloatArray) -> tuple[float, float]:
    """Where a point of the 3D view is in the window, pixels."""
    (client,) = explorer.app.server.get_clients().values()
    camera, canvas = client.camera, box_of(explorer.canvas())
    x, y, depth = Rotation.from_quat(camera.wxyz, scalar_first=True).inv().apply(point - np.asarray(camera.position))
    scale = canvas["height"] / 2 / np.tan(camera.fov / 2) / depth
    return canvas["x"] + canvas["width"] / 2 + scale * x, canvas["y"] + canvas["height"] / 2 + scale * y


def both_panes_fit(explorer: Explorer) -> bool:
    """Whether both panes are seen whole and from their front."""
    (client,) = explorer.app.server.get_clients().values()
    way = np.asarray(client.camera.position) - np.asarray(client.camera.look_at)
    corners = [np.array([offset + x, 0, z]) for offset in PANE_OFFSETS for x in (-1, 1) for z in (-1, 1)]
    places, canvas = np.array([on_screen(explorer, corner) for corner in corners]), box_of(explorer.canvas())
    low = np.array([canvas["x"], canvas["y"]])
    high = low + np.array([canvas["width"], canvas["height"]])
    inside = ((places > low) & (places < high)).all()
    return bool(inside and way @ VIEW_DIRECTION > 0.999 * np.linalg.norm(way) * np.linalg.norm(VIEW_DIRECTION))


def handle(explorer: Explorer, pane: int, along: FloatArray) -> tuple[float, float]:
    """Where a handle of a pane is in the window: so far from the middle of the scene before its first iteration."""
    run = independent_run(replace(explorer.state(), iteration=0, playing=False))
    middle = run.scene.points[~run.scene.is_outlier].mean(axis=0)
    return on_screen(explorer, upright(run.subject.up).apply(middle + along) + np.array([PANE_OFFSETS[pane], 0, 0]))


def test_a_drag_is_one_change_however_slow(at_the_start: Explorer, monkeypatch: pytest.MonkeyPatch):
    for limit in ("AT_ONCE", "OF_ONE_HAND"):
        monkeypatch.setattr(history, limit, 0.0)  # without the hand, every value is a change
    explorer = at_the_start
    before = explorer.state().perturbation
    dragged = explorer.drag("Noise", 0.9, 0.1, 0.7, steps=3)
    explorer.wait_until("the noise", lambda: explorer.state().perturbation.noise == dragged != before.noise)
    explorer.page.keyboard.press("Control+z")
    explorer.wait_until("what was before", lambda: explorer.state().perturbation == before)


def test_a_slider_that_is_held_still_keeps_its_scene_at_the_start_until_it_is_let_go(explorer: Explorer):
    explorer.tick("Play a change")
    thumb = box_of(explorer.row("Rotation").get_by_role("slider"))
    mouse = explorer.page.mouse
    mouse.move(thumb["x"] + thumb["width"] / 2, thumb["y"] + thumb["height"] / 2)
    mouse.down()
    mouse.move(thumb["x"] + 30, thumb["y"] + thumb["height"] / 2, steps=4)

    def is_foretold() -> bool:
        return all("will end" in verdict for verdict in explorer.verdicts())

    explorer.wait_until("what will come of it", is_foretold)
    explorer.pause(int(3000 * AFTER_A_CHANGE))
    assert explorer.iteration() == 0 and is_foretold()
    mouse.up()
    explorer.wait_until("it to play", lambda: explorer.iteration() > 0)


def test_a_scene_is_dragged_by_its_handle_and_brought_back(at_the_start: Explorer):
    explorer = at_the_start
    explorer.pause(int(1000 * history.AT_ONCE))  # or what led here would be taken back, too
    before = explorer.state()
    at = handle(explorer, 0, ARROW)
    explorer.drag_on_canvas(at, (60.0, 0.0))
    explorer.wait_until("the dragged scene", lambda: explorer.state().start != NO_START)
    state = explorer.expect_to_agree()
    ρ, φ = np.split(np.array(state.start), 2)
    assert ρ[0] > 0.1
    np.testing.assert_allclose([*ρ[1:], *φ], 0, atol=1e-3)
    moved = handle(explorer, 0, ARROW)
    assert moved[0] - at[0] == pytest.approx(60, abs=6)
    assert replace(state, start=NO_START) == before
    explorer.type_key("Control+z")
    explorer.wait_until("the scene before", lambda: explorer.state() == before)
    explorer.expect_to_agree()
    explorer.type_key("Control+Shift+Z")
    explorer.wait_until("the dragged scene again", lambda: explorer.state() == state)
    explorer.expect_to_agree()


def test_a_view_turned_by_the_mouse_is_kept_and_reset_by_button_and_key(explorer: Explorer):
    explorer.wait_until("the first view", lambda: both_panes_fit(explorer))
    canvas = box_of(explorer.canvas())
    for reset in (lambda: explorer.type_key("v"), lambda: explorer.press("Reset view (V)")):
        explorer.drag_on_canvas((canvas["x"] + 20, canvas["y"] + canvas["height"] / 2), (120.0, 30.0))
        explorer.wait_until("another view", lambda: explorer.state().camera != NO_CAMERA)
        explorer.pause(SETTLING)
        assert not both_panes_fit(explorer)
        reset()
        explorer.wait_until("the first view again", lambda: both_panes_fit(explorer))
        explorer.wait_until("its state", lambda: explorer.state().camera == NO_CAMERA)
        explorer.expect_to_agree()


def test_nothing_moves_on_the_page_when_the_playing_ends(at_the_start: Explorer):
    explorer = at_the_start
    explorer.type_into("Speed", "30")
    explorer.press("Play (P)")
    explorer.wait_until("some iterations", lambda: explorer.iteration() > 2)
    playing, places = explorer.is_playing(), explorer.page.evaluate(PLACES)
    assert playing and len(places) > 40
    explorer.wait_until("the end", lambda: explorer.iteration() == explorer.last_iteration())
    explorer.wait_until("the end of playing", lambda: not explorer.is_playing())
    assert explorer.page.evaluate(PLACES) == places
    assert len(explorer.verdicts()) == 2


def test_an_iteration_is_looked_into_beat_by_beat(explorer: Explorer):
    explorer.press("First (R)")
    explorer.wait_until("the start", lambda: explorer.iteration() == 0)
    explorer.press("Look inside (I)")
    explorer.page.get_by_label("beat 1 of 5").first.wait_for()
    explorer.press("Pause (P)")
    for beat, share in ((2, 0.3), (3, 0.5), (4, 0.7), (5, 0.95)):
        explorer.drag("Beat", share, steps=2)
        explorer.page.get_by_label(f"beat {beat} of 5").first.wait_for()
    explorer.press("Leave the slow motion (I)")
    explorer.page.get_by_label("beat 5 of 5").first.wait_for(state="hidden")
    explorer.expect_alive()


def test_a_click_picks_also_where_the_picture_is_replaced_during_it(explorer: Explorer):
    explorer.press("First (R)")
    explorer.wait_until("the start", lambda: explorer.iteration() == 0)
    explorer.pause(SETTLING)
    before = explorer.heatmap_pictures()[1]
    box = box_of(explorer.page.locator("[data-heatmap=shown]").nth(1))
    explorer.page.mouse.move(box["x"] + 0.3 * box["width"], box["y"] + 20)
    explorer.page.mouse.down()
    explorer.type_key("n")
    explorer.wait_until("another picture", lambda: explorer.heatmap_pictures()[1] != before)
    explorer.page.mouse.up()
    explorer.wait_until("a picked point", lambda: explorer.state().inspected >= 0)


NOTE_CLICKED_BIN = """() => addEventListener("pointerup", event => {
  window.clickedBin = event.target.closest("[data-bin]").dataset.bin;
}, {capture: true, once: true})"""
"""The list may be another one between a look and a click."""


def test_a_click_into_a_heatmap_or_the_list_picks_its_bin_and_escape_lets_go(explorer: Explorer):
    heatmap = explorer.page.locator("[data-heatmap=shown]").nth(1)
    box = box_of(heatmap)
    explorer.page.mouse.click(box["x"] + 0.3 * box["width"], box["y"] + 20)
    explorer.wait_until("a picked point", lambda: explorer.state().inspected >= 0)
    assert explorer.state().inspected_pane == "right"
    row = explorer.page.locator("tr[data-bin]").nth(3)
    row.wait_for()  # the tab Inspect came up by itself
    explorer.page.evaluate(NOTE_CLICKED_BIN)
    row.click()
    number = int(explorer.page.evaluate("clickedBin"))
    explorer.wait_until("the row's point", lambda: explorer.state().inspected == number % 514)
    explorer.page.keyboard.press("Escape")
    explorer.wait_until("no point", lambda: explorer.state().inspected == -1)


def test_an_open_menu_stays_open_and_has_its_new_options_once_it_is_closed(explorer: Explorer):
    explorer.inspect()
    before = explorer.options("Strongest bins")
    explorer.field("Strongest bins").click()
    options = explorer.page.get_by_role("option")
    options.first.wait_for()
    first = explorer.page.get_by_role("button", name="First (R)")
    first.evaluate("button => button.click()")  # as a key of another frame would, without leaving the menu
    explorer.wait_until("the first iteration", lambda: explorer.iteration() == 0)
    explorer.pause(SETTLING)
    assert options.all_inner_texts() == before
    explorer.field("Strongest bins").press("Escape")
    options.first.wait_for(state="hidden")
    explorer.pause(SETTLING)
    assert explorer.options("Strongest bins")[1:] != before[1:]
