"""Lessons on the page: choosing one, its steps, trying things, guessing, and coming back."""

from __future__ import annotations

from typing import get_args

import numpy as np
from any_explorer import SETTLING
from explorer import Explorer
from numpy.typing import NDArray
from playwright.sync_api import Locator

from ido_viz.teach.lessons import Tab, lesson


def test_keys_and_a_clicker_turn_pages_where_nothing_else_needs_them(explorer: Explorer):
    chosen = lesson("maps")
    explorer.choose("Lesson", chosen.title)
    explorer.expect_step(1, len(chosen.steps))
    for key, number in (("PageDown", 2), ("ArrowRight", 3), ("PageUp", 2), ("ArrowLeft", 1), ("ArrowLeft", 1)):
        explorer.type_key(key)
        explorer.expect_step(number, len(chosen.steps))
    explorer.row("Rotation").get_by_role("slider").first.focus()
    explorer.page.keyboard.press("ArrowRight")
    explorer.wait_until("one degree more", lambda: explorer.state().perturbation.rotation == 61.0)
    explorer.page.get_by_role("tab", name="Maps", exact=True).focus()
    explorer.page.keyboard.press("ArrowRight")
    explorer.page.get_by_role("tab", name="Errors", exact=True, selected=True).wait_for()
    explorer.expect_step(1, len(chosen.steps))


def test_the_tab_that_a_step_talks_about_is_open_and_the_one_before_comes_back(explorer: Explorer):
    explorer.open_tab("Compare")
    explorer.open_tab("Help")
    for name in get_args(Tab):
        explorer.page.get_by_role("tab", name=name, exact=True).wait_for()
    chosen = lesson("failure")
    explorer.choose("Lesson", chosen.title)
    for number, step in enumerate(chosen.steps, start=1):
        explorer.expect_step(number, len(chosen.steps))
        if step.tab is not None:
            explorer.page.get_by_role("tab", name=step.tab, exact=True, selected=True).wait_for()
        if step.guess is not None:
            explorer.press("Next")
            explorer.page.get_by_text(step.guess.text.split("*")[0]).wait_for()
        explorer.press("Next")
    explorer.press("Leave")
    for name in ("Compare", "Help"):
        explorer.page.get_by_role("tab", name=name, exact=True, selected=True).wait_for()


def test_what_a_step_shows_at_the_end_of_a_tab_is_in_view_when_it_is_opened_by_its_address(explorer: Explorer):
    explorer.page.goto("about:blank")
    explorer.page.goto(f"{explorer.app.url}/?lesson=failure/6")
    explorer.wait_ready()
    explorer.wait_until("the table in view", lambda: in_view(explorer.page.get_by_text("next update, by blocks")))


def in_view(what: Locator) -> bool:
    """Whether something is in the window, with what it lies in scrolled to it."""
    return what.count() == 1 and what.evaluate(
        "element => { const box = element.getBoundingClientRect();"
        " return element.contains(document.elementFromPoint(box.x + box.width / 2, box.y + box.height / 2)); }"
    )


def test_a_step_at_the_end_of_a_tab_shows_that_end_even_if_more_comes_late(explorer: Explorer):
    explorer.choose("Lesson", lesson("histogram").title)
    go_to_the_end_of_a_tab(explorer)
    below = explorer.page.evaluate_handle(LATE_CONTENT)
    try:
        explorer.wait_until("its end in sight", lambda: below.evaluate(IS_IN_SIGHT))
    finally:
        below.evaluate("late => late.remove()")


LATE_CONTENT = """async () => {
  const group = [...document.querySelectorAll('[role=tab]')].find(tab => tab.innerText === 'Inspect')
    .closest('[data-dock-group]');
  const shown = () => [...group.querySelectorAll('.mantine-ScrollArea-viewport')].find(area => area.scrollTop > 0);
  while (!shown()) await new Promise(resolve => setTimeout(resolve, 10));
  const late = document.createElement('div');
  late.style.height = '300px';
  shown().firstElementChild.append(late);
  return late;
}"""
IS_IN_SIGHT = "late => late.getBoundingClientRect().bottom <= innerHeight + 1"


def go_to_the_end_of_a_tab(explorer: Explorer) -> None:
    """Go on in the lesson of histograms to the step that talks about the end of Inspect."""
    for number, step in enumerate(lesson("histogram").steps, start=1):
        explorer.expect_step(number, 12)
        if step.end:
            break
        explorer.press("Next")
    explorer.page.get_by_role("tab", name="Inspect", exact=True, selected=True).wait_for()


def test_a_tab_opened_right_after_the_lesson_opened_another_is_not_scrolled(explorer: Explorer):
    top = explorer.heatmaps().first.bounding_box()
    explorer.choose("Lesson", lesson("histogram").title)
    go_to_the_end_of_a_tab(explorer)
    explorer.open_tab("Maps")
    explorer.pause(2 * SETTLING)
    assert explorer.heatmaps().first.bounding_box() == top


def test_the_control_beside_the_text_is_the_one_of_the_panel(explorer: Explorer):
    chosen = lesson("settings")
    explorer.choose("Lesson", chosen.title)
    for number in (1, 1, 1, 2, 3):  # its guess, and its answer told early
        explorer.expect_step(number, len(chosen.steps))
        explorer.press("Next")
        explorer.pause(200)
    explorer.expect_step(4, len(chosen.steps))
    step = explorer.presenter()
    slider = step.get_by_role("slider")
    slider.focus()
    slider.press("Home")
    explorer.wait_until("no outliers", lambda: explorer.state().perturbation.outliers == 0)
    of_panel = explorer.page.get_by_role("slider").filter(visible=True)
    values = [each.get_attribute("aria-valuenow") for each in of_panel.all()]
    assert "300" not in values
    explorer.press("Paper defaults")
    explorer.wait_until("the step's slider follows", lambda: slider.get_attribute("aria-valuenow") == "300")


def test_the_arrows_leave_the_camera_alone_during_a_lesson_only(explorer: Explorer):
    assert camera_turns(explorer)
    explorer.choose("Lesson", lesson("maps").title)
    explorer.expect_step(1, len(lesson("maps").steps))
    assert not camera_turns(explorer)
    explorer.press("Leave")
    explorer.wait_until("the lesson gone", lambda: not explorer.page.locator(".lesson").count())
    assert camera_turns(explorer)


def test_the_arrows_move_the_slider_that_has_the_focus_and_not_the_camera(explorer: Explorer):
    explorer.type_into("Beat", "1")  # which lifts the view
    explorer.wait_until("the beat", lambda: explorer.state().inside == 1)
    explorer.row("Beat").get_by_role("slider").focus()
    assert not camera_turns(explorer, blurred=False)
    assert explorer.state().inside > 1


def camera_turns(explorer: Explorer, *, blurred: bool = True) -> bool:
    """Whether holding an arrow turns the camera; the server is told of each of its moves."""
    before = camera_at_rest(explorer)
    if blurred:
        explorer.page.evaluate("document.activeElement.blur()")
    explorer.page.keyboard.down("ArrowRight")
    explorer.pause(400)
    explorer.page.keyboard.up("ArrowRight")
    return bool(abs(camera_at_rest(explorer) - before).max() > 0.01)


def camera_at_rest(explorer: Explorer) -> NDArray[np.float64]:
    """Where the camera is once eight frames of the page have not moved it: a lesson brings its own."""
    (client,) = explorer.app.server.get_clients().values()
    while True:
        before = client.camera.position
        explorer.page.evaluate(AFTER_FRAMES, 8)
        explorer.pause()
        if np.array_equal(client.camera.position, before):
            return before


AFTER_FRAMES = """count => new Promise(resolve => {
  const next = () => count-- > 0 ? requestAnimationFrame(next) : resolve();
  next();
})"""
