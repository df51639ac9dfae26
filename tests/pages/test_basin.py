"""The basin, mapped, and the method that registers from wherever a click begins."""

from __future__ import annotations

import re
from dataclasses import replace

from any_explorer import AT_THE_END
from unseen_explorer import OpenUnseen, UnseenExplorer

from ido import Perturbation
from ido_viz.core.basin import start_of
from ido_viz.core.library import shipped_library

SMALL_SCENE = Perturbation(points=100, outliers=0, seed=3)
STATE = replace(AT_THE_END, perturbation=SMALL_SCENE, left="DO", right="Global", max_iterations=40)
NUMBER = 140  # turned by 150°


def test_a_basin_fills_and_a_click_begins_there(open_unseen: OpenUnseen):
    explorer = open_unseen(STATE)
    explorer.wait_until("how sure it is", lambda: re.search(r"\d+% sure", " ".join(explorer.texts())))
    explorer.open_tab("Basin")
    explorer.press("Map the basin")
    explorer.wait_until("DO's whole basin", lambda: "of 192" in said(explorer, 0))
    explorer.wait_until("a first dot of the other", lambda: "of 0" not in said(explorer, 1))
    explorer.press("Cancel")
    explorer.wait_until("the end of it", lambda: "Cancel" not in explorer.buttons())
    explorer.set("Picked bin", f"start 0 {NUMBER} 1")
    there = start_of(STATE, shipped_library().subject("bunny").up, NUMBER)
    explorer.wait_until("the start", lambda: explorer.state().start == there)
    explorer.wait_until("Global's end", lambda: explorer.verdicts()[1].startswith("✓ in place"))


def said(explorer: UnseenExplorer, number: int) -> str:
    """What is said of a map, from top to bottom."""
    maps = explorer.elements("svg.basin", "basin")
    return str(maps[number]["aria-label"]) if len(maps) > number else "of 0"
