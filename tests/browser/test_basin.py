"""The basin, mapped and clicked, and the method that registers from wherever a click begins."""

from __future__ import annotations

import re
from dataclasses import replace

from explorer import AT_THE_END, OpenExplorer

from ido import Perturbation
from ido_viz.core.basin import start_of
from ido_viz.core.library import shipped_library

SMALL_SCENE = Perturbation(points=100, outliers=0, seed=3)
STATE = replace(AT_THE_END, perturbation=SMALL_SCENE, left="DO", right="Global", max_iterations=40)
NUMBER = 140  # turned by 150°


def test_a_basin_fills_and_a_click_begins_there(open_explorer: OpenExplorer):
    explorer = open_explorer(STATE)
    explorer.wait_until("how sure it is", lambda: re.search(r"\d+% sure", explorer.page.inner_text("body")))
    explorer.open_tab("Basin")
    explorer.press("Map the basin")
    first, second = (explorer.page.locator("svg.basin").nth(number) for number in (0, 1))
    explorer.wait_until("DO's whole basin", lambda: "of 192" in (first.get_attribute("aria-label") or ""))
    explorer.wait_until("a first dot of the other", lambda: "of 0" not in (second.get_attribute("aria-label") or ""))
    explorer.press("Cancel")
    explorer.page.get_by_role("button", name="Cancel", exact=True).wait_for(state="hidden")
    second.locator(f"[data-start='{NUMBER}']").click()
    there = start_of(STATE, shipped_library().subject("bunny").up, NUMBER)
    explorer.wait_until("the start", lambda: explorer.state().start == there)
    explorer.wait_until("Global's end", lambda: explorer.verdicts()[1].startswith("✓ in place"))
