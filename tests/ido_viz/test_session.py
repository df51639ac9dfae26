"""A tab's session without a browser."""

from __future__ import annotations

import base64
import json
import time
import zlib
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from tab import LENGTH, PAUSED, QUIET, Computing, Drawn, PageOfTab, Tab

from ido import Perturbation
from ido_viz import session as session_module
from ido_viz.core.actions import Actions
from ido_viz.core.address import read_fragment
from ido_viz.core.clock import FRAME
from ido_viz.core.library import shipped_library
from ido_viz.core.pacing import SHORTEST
from ido_viz.core.run import compute
from ido_viz.core.state import LAST, State, decode, encode


def assert_shows_its_own_run(frame: Drawn) -> None:
    """The drawn run is the one of the drawn state."""
    expected = compute(frame.state, shipped_library())
    np.testing.assert_array_equal(frame.run.scene.points, expected.scene.points)
    for shown, side in zip(frame.run.sides, expected.sides, strict=True):
        assert shown.method == side.method
        np.testing.assert_array_equal(shown.trajectory.x, side.trajectory.x)


def test_a_tab_begins_with_its_state(tab: Tab):
    assert tab.shown.state == PAUSED
    assert tab.shown.iteration == 0
    assert_shows_its_own_run(tab.shown)


def handmade_code(values: dict[str, Any]) -> str:
    """A code that `encode` would not make."""
    return "ido1-" + base64.urlsafe_b64encode(zlib.compress(json.dumps(values).encode())).decode()


# The newest value wins


def test_of_fifty_quick_changes_the_newest_is_drawn_and_few_are_computed(tab: Tab, computing: Computing):
    computing.states.clear()
    computing.seconds = 0.03
    for i in range(50):
        tab.set(rotation=float(31 + i))
    assert tab.settle().state.perturbation.rotation == 80
    assert tab.widgets.perturbation.rotation == 80
    assert_shows_its_own_run(tab.shown)
    assert 1 <= len(computing.states) <= 5


def test_a_drag_slower_than_the_computation_follows_and_ends_at_its_last_value(tab: Tab, computing: Computing):
    computing.seconds = 0.02
    for i in range(30):
        tab.set(rotation=float(30 + i))
        time.sleep(0.007)
    assert tab.settle().state.perturbation.rotation == 59
    assert tab.widgets.perturbation.rotation == 59
    drawn = [frame.state.perturbation.rotation for frame in tab.frames]
    assert drawn == sorted(drawn)
    assert len(set(drawn)) > 3


def test_what_is_shared_is_the_newest_before_it_is_computed(tab: Tab, computing: Computing):
    computing.go.clear()
    tab.set(noise=0.02)
    tab.wait("its code", lambda: tab.shared == tab.widgets)
    tab.widgets = replace(tab.widgets, hidden=("scene",))  # ticked, and not yet told of
    assert decode(read_fragment(tab.actions.link().partition("#")[2]).code) == tab.widgets
    assert tab.shown.state.perturbation.noise != 0.02
    computing.go.set()


def test_a_value_moved_while_the_one_before_is_computed_is_not_lost(tab: Tab, computing: Computing):
    computing.go.clear()
    computing.states.clear()
    tab.set(noise=0.02)
    tab.wait("computing", lambda: len(computing.states) == 1)
    tab.set(noise=0.07)
    computing.go.set()
    assert tab.settle().state.perturbation.noise == 0.07
    assert tab.widgets.perturbation.noise == 0.07


def test_a_widget_moved_just_before_a_button_is_not_lost(tab: Tab, computing: Computing):
    computing.go.clear()
    computing.states.clear()
    tab.set(noise=0.02)
    tab.wait("computing", lambda: len(computing.states) == 1)
    tab.set(outliers=50)
    tab.actions.new_seed()
    computing.go.set()
    shown = tab.settle().state.perturbation
    assert shown.outliers == 50
    assert shown.seed != PAUSED.perturbation.seed
    assert tab.widgets.perturbation == shown


def test_a_widget_moved_just_after_a_button_is_not_lost(tab: Tab, computing: Computing):
    computing.go.clear()
    computing.states.clear()
    tab.set(noise=0.02)
    tab.wait("computing", lambda: len(computing.states) == 1)
    tab.actions.new_seed()
    tab.set(outliers=50)
    computing.go.set()
    shown = tab.settle().state.perturbation
    assert shown.outliers == 50
    assert shown.seed != PAUSED.perturbation.seed
    assert tab.widgets.perturbation == shown


def test_a_widget_moved_while_another_shape_is_computed_is_not_lost(tab: Tab, computing: Computing):
    computing.go.clear()
    computing.states.clear()
    tab.set(shape="urban")
    tab.wait("computing", lambda: len(computing.states) == 1)
    tab.set(outliers=50)
    computing.go.set()
    shown = tab.settle().state
    assert (shown.shape, shown.perturbation.outliers) == ("urban", 50)
    assert tab.widgets.perturbation == shown.perturbation


def test_a_widget_moved_and_not_yet_told_of_is_not_written_over_by_a_button(tab: Tab):
    tab.settle()
    tab.widgets = replace(tab.widgets, perturbation=replace(tab.widgets.perturbation, outliers=50))
    tab.actions.new_seed()
    shown = tab.settle().state.perturbation
    assert shown.outliers == 50
    assert tab.widgets.perturbation == shown


def test_what_does_not_change_the_run_is_drawn_without_computing(tab: Tab, computing: Computing):
    computing.states.clear()
    tab.set(dark=True, order="azimuth", difference=True, ghost=False, pinned_map=15, speed=60)
    shown = tab.settle().state
    assert (shown.dark, shown.order, shown.pinned_map) == (True, "azimuth", 15)
    tab.actions.step(1)
    assert tab.settle().iteration == 1
    assert computing.states == []


# Playing and stepping


def test_play_goes_through_to_the_end_and_stops(open_tab: Callable[..., Tab]):
    tab = open_tab(replace(PAUSED, playing=True, speed=60), calm=False)
    tab.wait("the end", lambda: bool(tab.frames) and not tab.shown.state.playing)
    shown = [frame.iteration for frame in tab.frames]
    assert shown == sorted(shown)
    assert shown[-1] == LENGTH
    assert shown[0] < LENGTH / 2
    assert len(set(shown)) > LENGTH / 4
    assert tab.settle() == tab.frames[len(shown) - 1]


def test_play_takes_its_time(tab: Tab):
    tab.set(speed=40)
    tab.settle()
    start = time.perf_counter()
    tab.actions.play()
    tab.wait("the end", lambda: tab.shown.iteration == LENGTH)
    assert time.perf_counter() - start > 0.9 * (SHORTEST + 0.1 * LENGTH) * 15 / 40


def test_play_starts_where_the_state_says(open_tab: Callable[..., Tab]):
    tab = open_tab(replace(PAUSED, playing=True, speed=20, iteration=8), calm=False)
    tab.wait("the end", lambda: bool(tab.frames) and not tab.shown.state.playing)
    assert min(frame.iteration for frame in tab.frames) == 8


def test_play_of_a_pasted_code_starts_where_it_says(tab: Tab):
    before = len(tab.frames)
    tab.actions.apply_code(encode(replace(PAUSED, playing=True, speed=20, iteration=8)))
    tab.wait("the end", lambda: tab.shown.iteration == LENGTH)
    assert min(frame.iteration for frame in tab.frames[before:]) == 8


def test_play_at_the_end_starts_again(tab: Tab):
    tab.actions.jump(LAST)
    assert tab.settle().iteration == LENGTH
    tab.set(speed=60)
    tab.settle()
    seen = len(tab.frames)
    tab.actions.play()
    tab.wait("the end", lambda: len(tab.frames) > seen and not tab.shown.state.playing)
    assert tab.frames[seen].iteration < LENGTH / 2
    assert tab.shown.iteration == LENGTH


def test_pausing_holds_the_iteration(tab: Tab):
    tab.set(speed=20)
    tab.actions.play()
    tab.wait("some progress", lambda: tab.shown.iteration >= 2)
    tab.actions.play()
    held = tab.settle()
    assert not held.state.playing
    assert 2 <= held.iteration < LENGTH
    tab.actions.play()
    tab.wait("more progress", lambda: tab.shown.iteration > held.iteration)
    assert tab.shown.iteration <= held.iteration + 3


def test_playing_anew_while_the_way_to_an_iteration_is_drawn_does_no_harm(tab: Tab, monkeypatch: pytest.MonkeyPatch):
    share, again = PageOfTab.share, []

    def plays_again(page: PageOfTab, state: State) -> None:
        share(page, state)
        if state.playing and state.iteration >= 2 and state == tab.shown.state and not again:
            again.append(state)
            tab.actions.jump(0)
            tab.actions.play()

    monkeypatch.setattr(PageOfTab, "share", plays_again)
    tab.set(speed=20)
    tab.actions.play()
    tab.wait("the start again", lambda: bool(again) and tab.shown.iteration == 0)
    tab.wait("the end", lambda: tab.shown.iteration == LENGTH)
    assert tab.notes == []


@pytest.mark.parametrize(
    "act", [lambda a: a.step(1), lambda a: a.step(-1), lambda a: a.jump(0), lambda a: a.jump(LAST)]
)
def test_stepping_pauses(tab: Tab, act: Callable[[Actions], None]):
    tab.set(speed=1)
    tab.actions.play()
    tab.wait("playing", lambda: tab.shown.state.playing)
    act(tab.actions)
    assert not tab.settle().state.playing


def test_steps_move_by_one_and_stay_within_the_run(tab: Tab):
    moves: list[tuple[Callable[[], None], int]] = [
        (lambda: tab.actions.step(-1), 0),
        (lambda: tab.actions.step(1), 1),
        (lambda: tab.actions.step(1), 2),
        (lambda: tab.actions.step(-1), 1),
        (lambda: tab.actions.jump(LAST), LENGTH),
        (lambda: tab.actions.step(1), LENGTH),
        (lambda: tab.actions.step(-1), LENGTH - 1),
        (lambda: tab.actions.jump(0), 0),
        (lambda: tab.actions.jump(7), 7),
        (lambda: tab.actions.jump(10_000), LENGTH),
        (lambda: tab.actions.step(-10_000), 0),
    ]
    for number, (move, expected) in enumerate(moves):
        move()
        assert tab.settle().iteration == expected, f"move {number}"


def test_many_quick_steps_all_count(tab: Tab):
    for _ in range(9):
        tab.actions.step(1)
    for _ in range(2):
        tab.actions.step(-1)
    assert tab.settle().iteration == 7


@pytest.mark.parametrize(("name", "expected"), [("restart", 0), ("next", 1), ("last", LENGTH)])
def test_steps_before_the_first_run_is_ready(
    open_tab: Callable[..., Tab], computing: Computing, name: str, expected: int
):
    computing.go.clear()
    tab = open_tab(calm=False)
    tab.wait("computing", lambda: len(computing.states) == 1)
    moves = {"restart": tab.actions.jump, "next": tab.actions.step, "last": tab.actions.jump}
    moves[name]({"restart": 0, "next": 1, "last": LAST}[name])
    computing.go.set()
    assert tab.settle().iteration == expected


def test_at_the_end_a_new_scene_is_shown_at_its_end(tab: Tab):
    tab.actions.jump(LAST)
    tab.set(max_iterations=20)
    assert tab.settle().iteration == 20


def test_in_between_a_new_scene_is_shown_at_the_same_iteration(tab: Tab):
    tab.actions.jump(5)
    tab.actions.new_seed()
    assert tab.settle().iteration == 5
    tab.set(max_iterations=3)
    assert tab.settle().iteration == 3


# Buttons


def test_a_new_seed_makes_a_new_scene(tab: Tab):
    before = tab.shown
    tab.actions.new_seed()
    after = tab.settle()
    assert after.state.perturbation == replace(PAUSED.perturbation, seed=after.state.perturbation.seed)
    assert not np.array_equal(before.run.scene.points, after.run.scene.points)
    assert tab.widgets.perturbation.seed == after.state.perturbation.seed
    assert_shows_its_own_run(after)


def test_paper_defaults_keep_the_draw(tab: Tab):
    tab.set(seed=77, noise=0.0, rotation=170.0, outlier_kind="structured")
    tab.settle()
    tab.actions.paper_defaults()
    assert tab.settle().state.perturbation == Perturbation(seed=77)
    assert tab.widgets.perturbation == Perturbation(seed=77)


def test_another_shape_brings_what_suits_it(tab: Tab):
    tab.set(left="Improved DO (as printed)")
    tab.settle()
    tab.set(shape="urban")
    shown = tab.settle()
    assert shown.state.shape == "urban"
    assert shown.state.perturbation.outlier_kind == "structured"
    assert shown.run.sides[0].method in shipped_library().methods("urban")
    tab.wait("the widgets", lambda: tab.widgets == shown.state)
    assert tab.notes == []


# Codes


def test_a_code_gives_its_page(tab: Tab):
    wanted = replace(PAUSED, perturbation=Perturbation(seed=5, points=120), iteration=4, dark=True, pinned_map=9)
    tab.actions.apply_code(encode(wanted))
    shown = tab.settle()
    assert shown.state == wanted
    assert shown.iteration == 4
    assert tab.widgets == wanted
    assert tab.notes == []


@pytest.mark.parametrize(
    "code",
    [
        "hello",
        encode(replace(PAUSED, dark=True))[:-8],
        encode(State(left="ICP")),
        encode(State(shape="teapot")),
        encode(State(shape="urban", left="Improved DO (as printed)")),
        handmade_code({"shape": ["bunny"]}),
        handmade_code({"iteration": 1.5}),
        handmade_code({"pinned_map": 1.5}),
        handmade_code({"perturbation": {"seed": 10**30}}),
    ],
    ids=["word", "cut", "method", "shape", "unfit method", "list", "half iteration", "half map", "huge seed"],
)
def test_a_bad_code_changes_nothing_and_says_so(tab: Tab, code: str):
    tab.actions.jump(3)
    before = tab.settle()
    try:
        tab.actions.apply_code(code)
    except Exception as error:
        pytest.fail(f"the server's thread got {error!r}, the person nothing")
    tab.settle()
    tab.actions.step(1)
    after = tab.settle()
    assert len(tab.notes) == 1, tab.notes
    assert after.state == replace(before.state, iteration=4)
    assert after.iteration == 4


# Errors


@pytest.mark.parametrize("error", [RuntimeError("boom"), ValueError("odd"), FileNotFoundError("no such asset")])
def test_an_error_in_a_frame_is_told_and_the_next_frame_is_drawn(tab: Tab, computing: Computing, error: Exception):
    computing.failure = error
    tab.set(noise=0.03)
    tab.wait("a note", lambda: bool(tab.notes))
    assert str(error) in tab.notes[0]
    computing.failure = None
    tab.set(noise=0.04)
    assert tab.settle().state.perturbation.noise == 0.04
    assert len(tab.notes) == 1


def test_an_error_while_reading_the_widgets_does_not_end_the_session(tab: Tab, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(PageOfTab, "fail_reading", True)
    tab.set(noise=0.03)
    tab.wait("a note or the end", lambda: bool(tab.notes) or not tab.is_served)
    assert tab.is_served
    monkeypatch.setattr(PageOfTab, "fail_reading", False)
    tab.set(noise=0.04)
    assert tab.settle().state.perturbation.noise == 0.04


def test_errors_while_playing_do_not_flood_the_page(tab: Tab, computing: Computing):
    tab.set(speed=1)
    tab.actions.play()
    tab.wait("playing", lambda: tab.shown.state.playing)
    computing.failure = RuntimeError("boom")
    tab.set(noise=0.03)
    tab.wait("a note", lambda: bool(tab.notes))
    time.sleep(10 * FRAME)
    assert len(tab.notes) <= 2


def test_a_page_that_cannot_be_built_says_why_and_the_tab_can_be_closed(
    computing: Computing, monkeypatch: pytest.MonkeyPatch
):
    def broken(*_: object) -> None:
        raise ValueError("no <b>room</b> for it")

    monkeypatch.setattr(session_module, "Page", broken)
    tab = Tab(PAUSED)
    tab.wait("a note", lambda: bool(tab.notes))
    assert tab.notes == ["This page cannot be shown: ValueError: no <b>room</b> for it"]
    (told,) = tab.gui.written
    assert "ValueError: no &lt;b&gt;room&lt;/b&gt; for it" in told
    tab.session.close()


# The end


def test_after_closing_nothing_is_drawn_and_the_thread_ends(tab: Tab):
    tab.actions.play()
    tab.session.close()
    tab.wait("the end of the thread", lambda: not tab.is_served)
    drawn = len(tab.frames)
    tab.set(noise=0.09)
    tab.actions.step(1)
    tab.actions.new_seed()
    tab.session.close()
    time.sleep(QUIET)
    assert len(tab.frames) == drawn


def test_what_is_computed_when_the_tab_closes_is_not_drawn(tab: Tab, computing: Computing):
    computing.go.clear()
    computing.states.clear()
    tab.set(noise=0.02)
    tab.wait("computing", lambda: len(computing.states) == 1)
    drawn = len(tab.frames)
    tab.session.close()
    computing.go.set()
    tab.wait("the end of the thread", lambda: not tab.is_served)
    assert len(tab.frames) == drawn
    assert tab.notes == []


def test_a_tab_closed_before_it_is_ready_ends_too(open_tab: Callable[..., Tab]):
    tab = open_tab(calm=False)
    tab.session.close()
    tab.wait("the end of the thread", lambda: not tab.is_served)
    assert tab.notes == []


def test_two_tabs_are_apart(open_tab: Callable[..., Tab]):
    one, other = open_tab(), open_tab()
    one.set(noise=0.09)
    other.actions.step(1)
    assert one.settle().state == replace(PAUSED, perturbation=replace(PAUSED.perturbation, noise=0.09))
    assert other.settle().state == replace(PAUSED, iteration=1)
