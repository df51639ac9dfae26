"""What the script of the page tells of a click, and which bin that is."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import pytest
from tab import PAUSED, Tab

from ido.bin_order import bin_order
from ido_viz.core.library import shipped_library
from ido_viz.core.state import NO_POINT, State
from ido_viz.panels.from_browser import read_gesture
from ido_viz.panels.picking import Click, read_click


def test_a_click_is_read():
    assert read_click("bin 1 430 7") == Click("bin", 1, 430.0)
    assert read_click("shown 0 0.25 8") == Click("shown", 0, 0.25)
    assert read_click("start 0 191 3") == Click("start", 0, 191.0)
    assert read_click("compared 1 0.99999 9") == Click("compared", 1, 0.99999)


@pytest.mark.parametrize(
    "text",
    ["", "bin", "bin 1 430", "bin 2 430 7", "other 0 0.5 1", "bin 0 many 1", "bin 0 nan 1", "bin 0 -1 1", "x" * 99],
)
def test_nonsense_is_no_click(text: str):
    assert read_click(text) is None


def picked(tab: Tab, kind: str, pane: int, place: float) -> State:
    tab.actions.pick(kind, pane, place)
    return tab.settle().state


@pytest.mark.parametrize(
    ("number", "point", "question"),
    [(0, 0, "front / back"), (513, 513, "front / back"), (514, 0, "front / back"), (1028, 0, "up / down")],
)
def test_a_bin_of_the_list_is_its_point_and_its_question(tab: Tab, number: int, point: int, question: str):
    state = picked(tab, "bin", 1, number)
    assert (state.inspected_pane, state.inspected, state.question) == ("right", point, question)


def test_a_place_in_a_picture_is_the_bin_that_is_drawn_there(tab: Tab):
    maps = shipped_library().subject("bunny").maps["DO"]()
    order = bin_order(maps.histogram, PAUSED.order)
    for share in (0.0, 0.3, 0.77, 0.99999):
        state = picked(tab, "shown", 0, share)
        assert state.inspected == order[int(share * len(order))] % len(maps.histogram.model.points)


def test_a_bin_beyond_the_last_is_the_last(tab: Tab):
    assert picked(tab, "bin", 0, 1e6).inspected == 513


def test_a_click_into_a_picture_opens_inspect_and_one_into_its_list_does_not(tab: Tab):
    picked(tab, "bin", 0, 3)
    assert tab.opened == []
    picked(tab, "shown", 0, 0.5)
    assert tab.opened == ["Inspect"]


def test_escape_lets_go_of_what_was_picked(open_tab: Callable[..., Tab]):
    tab = open_tab(replace(PAUSED, inspected=5, scene_point=3))
    tab.actions.clear()
    state = tab.settle().state
    assert state == replace(PAUSED, inspected=NO_POINT, scene_point=NO_POINT)


def test_what_a_hand_does_is_read_and_nonsense_holds_nothing():
    assert read_gesture("1234567") == (1234567, False)
    assert read_gesture("1234567 held") == (1234567, True)
    for text in ("", "held", "x" * 99, "-3", "1e9", "9" * 40, "12 holds"):
        number, holds = read_gesture(text)
        assert not holds and number in (0, 12)
