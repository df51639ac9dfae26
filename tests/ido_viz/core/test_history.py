"""Undo and redo, as values."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ido import Perturbation
from ido_viz.core.history import AT_ONCE, LONGEST, OF_ONE_HAND, History
from ido_viz.core.state import LAST, NO_CAMERA, State

BEGUN = State(playing=False)
APART = 2 * OF_ONE_HAND


def noisy(noise: float) -> State:
    return replace(BEGUN, perturbation=Perturbation(noise=noise))


def after(changes: list[State], apart: float = APART) -> History:
    """A history of changes so many seconds apart."""
    history = History(BEGUN)
    for number, state in enumerate(changes, start=1):
        history = history.with_state(state, number * apart)
    return history


changes = st.sampled_from(
    [
        {"dark": True},
        {"left": "Improved DO"},
        {"start": (0.1, 0.2, 0.3, 0.0, 1.0, 0.0)},
        {"perturbation": Perturbation(seed=4)},
        {"hidden": ("scores",)},
        {"replay": False},
        {"speed": 60},
    ]
)


@given(changes)
def test_undo_takes_back_exactly_one_change_and_redo_makes_it_again(change: dict[str, Any]):
    begun = History(BEGUN)
    changed = begun.with_state(replace(BEGUN, **change), APART)
    assert changed.undone().now == BEGUN
    assert changed.undone().redone().now == changed.now
    assert changed.undone().redone().undone().now == BEGUN


def test_what_one_gesture_does_is_one_change_however_long_it_takes():
    history = History(BEGUN)
    for number, gesture in enumerate((1, 1, 1, 2, 2, 0), start=1):
        history = history.with_state(noisy(number / 100), number * APART, gesture)
    back = []
    while history.before:
        history = history.undone()
        back.append(history.now)
    assert back == [noisy(0.05), noisy(0.03), BEGUN]


def test_many_changes_are_taken_back_and_made_again_in_their_order():
    states = [noisy(n / 100) for n in range(1, 6)]
    history = after(states)
    back = []
    for _ in states:
        history = history.undone()
        back.append(history.now)
    assert back == [*states[-2::-1], BEGUN]
    assert history.undone() == history
    forth = []
    for _ in states:
        history = history.redone()
        forth.append(history.now)
    assert forth == states
    assert history.redone() == history


@pytest.mark.parametrize("apart", [AT_ONCE / 2, 2 * AT_ONCE])
def test_changes_of_a_dragged_slider_are_one_also_if_it_rests_for_a_moment(apart: float):
    dragged = after([noisy(n / 100) for n in range(1, 6)], apart)
    assert dragged.now == noisy(0.05)
    assert dragged.undone().now == BEGUN
    rested = dragged.with_state(noisy(0.06), 100.0)
    assert rested.undone().now == noisy(0.05)


def test_changes_of_different_things_are_one_only_at_once():
    turned = replace(BEGUN, perturbation=Perturbation(noise=0.01, rotation=10.0))
    for apart, expected in ((AT_ONCE / 2, BEGUN), (2 * AT_ONCE, noisy(0.01))):
        assert after([noisy(0.01), turned], apart).undone().now == expected


def test_a_view_turned_since_is_kept_but_one_that_a_change_brought_is_taken_back():
    view, brought = (0.0, -1.0, 0.3, 0.0, 0.0, 0.0), (1.0, 0.0, 0.3, 0.0, 0.0, 0.0)
    turned = replace(noisy(0.01), camera=view)
    history = after([noisy(0.01)]).with_state(turned, 50.0)
    assert history.undone().now == replace(BEGUN, camera=view)
    assert history.undone().redone().now == turned
    opened = history.with_state(replace(noisy(0.02), camera=brought), 100.0)
    assert opened.undone().now == turned


def test_a_change_right_after_undo_is_a_change_of_its_own():
    undone = after([noisy(0.01), noisy(0.02)], APART).undone()
    changed = undone.with_state(noisy(0.03), 2 * APART + AT_ONCE / 10)
    assert changed.undone().now == noisy(0.01)


def test_what_was_taken_back_is_lost_after_another_change():
    history = after([noisy(0.01), noisy(0.02)]).undone().with_state(noisy(0.03), 100.0)
    assert history.redone() == history
    assert history.undone().now == noisy(0.01)


@pytest.mark.parametrize(
    "moved",
    [
        {"iteration": 7},
        {"iteration": LAST, "playing": True},
        {"camera": (0.0, -1.0, 0.3, 0.0, 0.0, 0.0)},
        {"inside": 2.5},
    ],
)
def test_playing_stepping_and_looking_around_is_no_change(moved: dict[str, Any]):
    history = after([noisy(0.01)])
    went_on = history.with_state(replace(history.now, **moved), 100.0)
    assert went_on.now == replace(history.now, **moved)
    assert went_on.before == tuple(replace(s, camera=moved.get("camera", NO_CAMERA)) for s in history.before)
    taken_back = history.undone().with_state(replace(BEGUN, **moved), 100.0)
    assert taken_back.redone().now == replace(noisy(0.01), camera=moved.get("camera", NO_CAMERA))


def test_what_comes_back_does_not_play():
    playing = History(replace(BEGUN, playing=True)).with_state(replace(noisy(0.01), playing=True), APART)
    assert playing.undone().now == BEGUN
    assert playing.undone().redone().now == noisy(0.01)


def test_the_oldest_changes_are_forgotten():
    history = after([replace(BEGUN, perturbation=Perturbation(seed=n)) for n in range(1, LONGEST + 50)])
    assert len(history.before) == LONGEST
    for _ in range(LONGEST):
        history = history.undone()
    assert history.now.perturbation.seed == 49
    assert history.undone() == history
