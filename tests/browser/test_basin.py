"""A click into the map of a basin."""

from __future__ import annotations

from dataclasses import replace

from any_explorer import AT_THE_END
from explorer import OpenExplorer

from ido import Perturbation
from ido_viz.core.basin import start_of
from ido_viz.core.library import shipped_library

SMALL_SCENE = Perturbation(points=100, outliers=0, seed=3)
STATE = replace(AT_THE_END, perturbation=SMALL_SCENE, left="DO", right="Improved DO", max_iterations=40)
NUMBER = 140  # turned by 150°


def test_a_click_begins_there(open_explorer: OpenExplorer):
    explorer = open_explorer(STATE)
    explorer.open_tab("Compare")
    explorer.press("Compare all methods")
    explorer.page.locator(".ido-rows").wait_for()
    explorer.press("Cancel")
    explorer.open_tab("Basin")
    faces = [explorer.page.get_by_role("button", name=name, exact=True) for name in ("Map the basin", "Play (P)")]
    one, other = (
        face.evaluate("each => [getComputedStyle(each).backgroundColor, getComputedStyle(each).fontFamily]")
        for face in faces
    )
    assert one == other, "it looks like a row of the table"
    explorer.press("Map the basin")
    shown = explorer.page.locator("svg.basin").first
    explorer.wait_until("a first dot", lambda: "of 0" not in (shown.get_attribute("aria-label") or "of 0"))
    explorer.press("Cancel")
    explorer.wait_until("the end of it", explorer.page.get_by_role("button", name="Cancel", exact=True).is_disabled)
    shown.locator(f"[data-start='{NUMBER}']").click()
    there = start_of(STATE, shipped_library().subject("bunny").up, NUMBER)
    explorer.wait_until("the start", lambda: explorer.state().start == there)
