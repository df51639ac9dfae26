"""The slow motion of an iteration on a page: it plays, is held, dragged, left, and goes on with the next iteration."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import pytest
from tab import PAUSED, Tab

from ido_viz import session
from ido_viz.core.state import BEATS, LAST, NO_POINT

OpenTab = Callable[..., Tab]


@pytest.fixture(autouse=True)
def quick(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(session, "BEAT_SECONDS", 0.05)


def at_its_end(tab: Tab) -> None:
    tab.wait("the end of the last beat", lambda: tab.shown.state.inside == BEATS)


def test_it_plays_its_beats_and_stays_at_the_end(open_tab: OpenTab):
    tab = open_tab(replace(PAUSED, iteration=2))
    tab.actions.look_inside()
    at_its_end(tab)
    positions = [frame.state.inside for frame in tab.beats]
    assert positions == sorted(positions) and len(positions) > 1
    state = tab.shown.state
    assert (state.iteration, state.playing) == (2, False)
    assert state.inspected != NO_POINT
    assert tab.beats[-1].inside is not None


def test_play_goes_on_with_the_next_iteration_and_next_leaves(open_tab: OpenTab):
    tab = open_tab(replace(PAUSED, iteration=2))
    tab.actions.look_inside()
    at_its_end(tab)
    tab.actions.play()
    tab.wait("the next iteration", lambda: tab.shown.state.iteration == 3 or tab.beats[-1].state.iteration == 3)
    tab.actions.step(1)
    state = tab.settle().state
    assert (state.iteration, state.inside, state.playing) == (4, 0, False)


def test_after_the_last_iteration_it_plays_from_the_start(open_tab: OpenTab):
    tab = open_tab(replace(PAUSED, iteration=LAST, speed=60))
    tab.actions.look_inside()
    at_its_end(tab)
    tab.actions.play()
    tab.wait("the end of the run", lambda: tab.shown.state.iteration == LAST and not tab.shown.state.playing)
    assert tab.settle().state.inside == 0


@pytest.mark.parametrize(
    "leave",
    [
        lambda tab: tab.actions.look_inside(),
        lambda tab: tab.actions.jump(0),
        lambda tab: tab.actions.step(1),
        lambda tab: tab.actions.clear(),
        lambda tab: tab.actions.new_seed(),
        lambda tab: tab.actions.set_values({"noise": 0.05}),
        lambda tab: tab.actions.pick("start", 0, 3),
        lambda tab: (tab.actions.look_inside(), tab.actions.look_inside(), tab.actions.look_inside()),
    ],
)
@pytest.mark.parametrize("picked", [NO_POINT, 7])
def test_the_point_that_it_has_chosen_itself_goes_with_it(open_tab: OpenTab, leave: Callable[[Tab], None], picked: int):
    tab = open_tab(replace(PAUSED, iteration=1, inspected=picked, replay=True))
    tab.actions.to_beat(2.5)
    assert tab.settle().state.inspected != NO_POINT
    leave(tab)
    state = tab.settle().state
    assert (state.inside, state.inspected) == (0, picked)


def test_undo_and_redo_lead_out_of_it_without_its_point(open_tab: OpenTab):
    tab = open_tab(replace(PAUSED, iteration=1))
    tab.actions.to_beat(2.5)
    chosen = tab.settle().state.inspected
    tab.actions.undo()  # to look into an iteration is no change, so there is none
    assert tab.settle().state.inspected == chosen
    tab.actions.set_values({"difference": True})
    tab.settle()
    for way in (tab.actions.undo, tab.actions.redo, tab.actions.undo):
        way()
        state = tab.settle().state
        assert (state.inside, state.inspected) == (0, NO_POINT)


def test_the_point_of_a_page_that_is_opened_in_it_goes_with_it(open_tab: OpenTab):
    tab = open_tab(replace(PAUSED, iteration=1))
    tab.actions.open_page(replace(PAUSED, iteration=1, inside=2.5, inspected=7))
    assert tab.settle().state.inspected == 7
    tab.actions.clear()
    assert tab.settle().state.inspected == NO_POINT
    tab.actions.open_page(replace(PAUSED, iteration=1, inspected=7))
    assert tab.settle().state.inspected == 7


def test_a_beat_that_is_dragged_to_is_held(open_tab: OpenTab):
    tab = open_tab(replace(PAUSED, iteration=1))
    tab.actions.to_beat(2.5)
    state = tab.settle().state
    assert (state.inside, state.playing, state.iteration) == (2.5, False, 1)
    tab.actions.to_beat(0.0)
    assert tab.settle().state.inside == 0


def test_pressed_again_it_is_left(open_tab: OpenTab):
    tab = open_tab(replace(PAUSED, iteration=1))
    tab.actions.to_beat(2.5)
    tab.settle()
    tab.actions.look_inside()
    assert tab.settle().state.inside == 0


def test_at_the_end_the_last_iteration_is_looked_into(open_tab: OpenTab):
    tab = open_tab(replace(PAUSED, iteration=-1))
    tab.actions.to_beat(1.0)
    shown = tab.settle()
    assert shown.state.iteration == shown.run.sides[1].trajectory.iterations - 1


def test_a_method_without_maps_gives_the_place_to_the_other(open_tab: OpenTab):
    tab = open_tab(replace(PAUSED, right="Did nothing", inspected_pane="right"))
    tab.actions.to_beat(1.0)
    assert tab.settle().state.inspected_pane == "left"


def test_without_any_maps_it_is_told(open_tab: OpenTab):
    tab = open_tab(replace(PAUSED, left="Did nothing", right="Did nothing"))
    tab.actions.look_inside()
    assert tab.settle().state.inside == 0
    assert any("nothing to look into" in note for note in tab.notes)
