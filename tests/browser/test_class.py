"""In front of a class: parts hidden by a code, larger text, and everything by keyboard alone."""

from __future__ import annotations

from dataclasses import replace

from explorer import Explorer, OpenExplorer, box_of
from playwright.sync_api import Locator

from ido_viz.core.state import encode


def test_parts_hidden_by_a_lecturer_are_hidden_by_the_code_and_come_back(
    explorer: Explorer, open_explorer: OpenExplorer
):
    lecturer, student = explorer, open_explorer()
    for part in ("scores", "methods"):
        lecturer.tick(f"Hide {part}")
    lecturer.row("Left pane").wait_for(state="hidden")
    lecturer.page.locator("table.readout").wait_for(state="hidden")
    lecturer.wait_until("the code", lambda: lecturer.state().hidden == ("scores", "methods"))
    student.paste(lecturer.code())
    student.row("Left pane").wait_for(state="hidden")
    student.page.locator("table.readout").wait_for(state="hidden")
    assert student.row("Rotation").is_visible()
    student.open_tab("Errors")
    student.pause(300)
    assert student.page.get_by_text("PointRMSE", exact=True).count() == 0
    student.tick("Hide scores")
    student.page.locator("table.readout").wait_for()
    student.page.get_by_text("PointRMSE", exact=True).first.wait_for()
    student.expect_to_agree()


def test_hidden_panels_of_charts_come_back_by_the_menu_of_commands(explorer: Explorer):
    explorer.paste(encode(replace(explorer.state(), hidden=("share", "upper charts", "lower charts"))))
    explorer.wait_until("no charts", lambda: explorer.charts().count() == 0)
    explorer.field("State").wait_for(state="hidden")
    explorer.page.keyboard.press("Control+k")
    explorer.page.get_by_placeholder("Search commands...").fill("Show all")
    explorer.page.get_by_role("button", name="Show all parts").wait_for()
    explorer.page.keyboard.press("Enter")
    explorer.wait_until("charts", lambda: explorer.charts().count() >= 2)
    explorer.field("State").wait_for()
    assert explorer.state().hidden == ()


def test_large_text_is_larger_everywhere_and_goes_back(explorer: Explorer):
    table, label = explorer.page.locator("table.readout"), explorer.row("Rotation").locator("label")
    before = box_of(table)["height"], box_of(label)["height"]
    explorer.tick("Large text")
    explorer.wait_until("larger numbers", lambda: box_of(table)["height"] > 1.15 * before[0])
    assert box_of(label)["height"] > 1.15 * before[1]
    assert explorer.state().large_text
    explorer.tick("Large text")
    explorer.wait_until("the size before", lambda: box_of(table)["height"] == before[0])


def test_a_page_is_used_by_keyboard_alone(explorer: Explorer):
    """From the top of the page, with Tab, arrows, Enter and Space: turn the scene, step, open a tab, tick a box."""
    keyboard = explorer.page.keyboard
    explorer.page.evaluate("document.activeElement.blur()")

    def tab_to(what: Locator) -> None:
        what.evaluate("element => element.dataset.wanted = 'yes'")
        for _ in range(110):
            keyboard.press("Tab")
            if explorer.page.evaluate("document.activeElement.dataset.wanted === 'yes'"):
                what.evaluate("element => delete element.dataset.wanted")
                return
        raise AssertionError(f"the keyboard does not reach {what}")

    tab_to(explorer.page.get_by_role("button", name="First (R)"))
    keyboard.press("Enter")
    explorer.wait_until("the start", lambda: explorer.iteration() == 0)
    tab_to(explorer.page.get_by_role("button", name="Next (N)"))
    keyboard.press("Space")
    explorer.wait_until("the next iteration", lambda: explorer.iteration() == 1)
    rotation = explorer.slider_value("Rotation")
    tab_to(explorer.row("Rotation").get_by_role("slider"))
    for _ in range(5):
        keyboard.press("ArrowRight")
    explorer.wait_until("five degrees more", lambda: explorer.slider_value("Rotation") == rotation + 5)
    for tab, label in (("Methods", "Left pane"), ("Share", "State")):
        tab_to(explorer.page.get_by_role("tab", name=tab, exact=True))
        keyboard.press("Enter")
        explorer.page.get_by_text(label, exact=True).wait_for()
        tab_to(explorer.field(label))
    for name in ("Errors", "Inspect"):
        tab_to(explorer.page.get_by_role("tab", name=name, exact=True))
        keyboard.press("Enter")
    tab_to(explorer.field("Model point"))
    keyboard.press("Control+a")
    keyboard.type("7")
    keyboard.press("Enter")
    explorer.page.get_by_text("model point 7", exact=True).wait_for()
    assert explorer.expect_to_agree().inspected == 7
