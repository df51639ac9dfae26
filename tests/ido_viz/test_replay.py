"""A tab's session without a browser: when it plays by itself, a scene in the hand, undo and redo."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform, Rotation
from tab import LENGTH, PAUSED, Drawn, PageOfTab, Tab

from ido import Perturbation
from ido.types import FloatArray
from ido_viz import live_state, requests, session
from ido_viz.core.state import LAST, NO_CAMERA, NO_START

REPLAYING = replace(PAUSED, replay=True, iteration=LAST, speed=60)
PLAYING = replace(PAUSED, playing=True, speed=60)
ELSEWHERE = (0.1, -1.0, 0.4, 0.0, 0.2, 0.0)
"""A camera."""

OpenTab = Callable[..., Tab]


def played(tab: Tab) -> Drawn:
    """Wait until it has played to the end."""
    tab.wait("the end", lambda: bool(tab.frames) and not tab.shown.state.playing and tab.shown.state.iteration == LAST)
    return tab.settle()


def handles(x: float, turn: float = 0.0) -> FloatArray:
    return RigidTransform.from_components([x, 0.0, 0.0], Rotation.from_rotvec([0, turn, 0])).as_matrix()


def since(tab: Tab, frame: int) -> list[Drawn]:
    return tab.frames[frame:]


# A new page


def test_a_new_page_stands_still_before_it_plays(open_tab: OpenTab, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(requests, "FIRST_LOOK", 0.5)
    tab = open_tab(PLAYING, calm=False)
    played(tab)
    moved = next(frame for frame in tab.frames if frame.iteration > 0)
    assert tab.frames[0].iteration == 0
    assert moved.at - tab.frames[0].at > 0.5
    assert not any(frame.held for frame in tab.frames)


def test_a_page_that_is_never_seen_plays_all_the_same(open_tab: OpenTab, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(session, "UNSEEN", 0.5)
    monkeypatch.setattr(session.Session, "_seen", lambda _: None)
    tab = open_tab(PLAYING, calm=False)
    played(tab)
    assert next(frame for frame in tab.frames if frame.iteration > 0).at - tab.frames[0].at > 0.4


def test_a_page_that_is_seen_before_its_first_frame_plays_no_later(open_tab: OpenTab, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(session, "FIRST_LOOK", 0.3)
    built = PageOfTab.__init__

    def seen_at_once(page: PageOfTab, tab: Tab, *rest: Any) -> None:
        built(page, tab, *rest)
        tab.actions.seen()

    monkeypatch.setattr(PageOfTab, "__init__", seen_at_once)
    tab = open_tab(PLAYING, calm=False)
    played(tab)
    waited = next(frame for frame in tab.frames if frame.iteration > 0).at - tab.frames[0].at
    assert 0.2 < waited < session.UNSEEN / 2


def test_a_page_that_is_seen_late_does_not_start_what_a_person_has_stopped(
    open_tab: OpenTab, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(requests, "FIRST_LOOK", 30.0)
    tab = open_tab(PLAYING)
    tab.actions.step(1)
    tab.actions.seen()
    shown = tab.settle()
    assert (shown.iteration, shown.state.playing) == (1, False)


def test_scenes_move_between_the_iterations_while_it_plays(open_tab: OpenTab):
    tab = open_tab(replace(PLAYING, speed=15), calm=False)
    played(tab)
    assert len(tab.moves) > LENGTH
    for frame in tab.moves:
        for side in frame.sides:
            start, end = side.run.T_model_scene[side.k : side.k + 2]
            step, done = (np.linalg.norm(T[:3, 3] - start[:3, 3]) for T in (end, side.T_model_scene))
            assert done <= step + 1e-9
    assert {frame.k for frame in tab.moves} <= set(range(LENGTH))
    assert len({frame.k for frame in tab.moves}) > 0.5 * LENGTH


# A change of the scene


@pytest.mark.parametrize(
    "change",
    [
        lambda tab: tab.set(rotation=50.0),
        lambda tab: tab.set(seed=77),
        lambda tab: tab.set(shape="urban"),
        lambda tab: tab.actions.new_seed(),
        lambda tab: [tab.actions.grab(0, phase, handles(x)) for phase, x in (("start", 0.0), ("end", 0.3))],
    ],
    ids=["slider", "typed seed", "shape", "new seed", "handles"],
)
def test_another_scene_is_held_and_then_played_from_its_start(open_tab: OpenTab, change: Callable[[Tab], None]):
    tab = open_tab(REPLAYING)
    before = len(tab.frames)
    change(tab)
    tab.wait("the start", lambda: tab.shown.held)
    played(tab)
    shown = since(tab, before)
    held = [frame for frame in shown if frame.held]
    assert {frame.iteration for frame in held} == {0}
    moved = next(frame for frame in shown if frame.iteration > 0)
    shortest = min(requests.AFTER_A_CHANGE, requests.AFTER_LETTING_GO)
    assert moved.at - held[0].at > 0.9 * shortest
    iterations = [frame.iteration for frame in shown]
    assert iterations == sorted(iterations)
    assert not any(frame.held for frame in shown[shown.index(moved) :])


def test_it_waits_until_nothing_changes_any_more(open_tab: OpenTab):
    tab = open_tab(REPLAYING)
    before = len(tab.frames)
    for rotation in range(40, 60):
        tab.set(rotation=float(rotation))
        time.sleep(0.06)
    played(tab)
    newest = next(frame for frame in since(tab, before) if frame.state.perturbation.rotation == 59)
    assert all(frame.held for frame in since(tab, before) if frame.at < newest.at)
    moved = next(frame for frame in since(tab, before) if frame.iteration > 0)
    assert moved.at - newest.at > 0.9 * requests.AFTER_A_CHANGE


def test_a_slider_that_is_held_still_keeps_the_scene_in_the_hand_until_it_is_let_go(open_tab: OpenTab):
    tab = open_tab(REPLAYING)
    tab.set(rotation=40.0)
    tab.actions.gesture(1, True)
    tab.wait("the start", lambda: tab.shown.held)
    time.sleep(2 * requests.AFTER_A_CHANGE)
    assert tab.shown.held
    tab.set(rotation=50.0)  # the hand goes on
    tab.wait("the new start", lambda: tab.shown.state.perturbation.rotation == 50)
    time.sleep(2 * requests.AFTER_A_CHANGE)
    assert tab.shown.held
    let_go = time.perf_counter()
    tab.actions.gesture(1, False)
    played(tab)
    moved = next(frame for frame in tab.frames if frame.at > let_go and frame.iteration > 0)
    assert moved.at - let_go > 0.9 * requests.AFTER_LETTING_GO


def test_a_hand_that_holds_nothing_that_waits_changes_nothing(open_tab: OpenTab):
    tab = open_tab(REPLAYING)
    for held in (True, False, True):
        tab.actions.gesture(1, held)
    shown = tab.settle()
    assert (shown.state.playing, shown.state.iteration, shown.held) == (False, LAST, False)
    tab.actions.gesture(2, False)
    tab.set(rotation=50.0)
    played(tab)


@pytest.mark.parametrize(
    "change",
    [
        lambda tab: tab.set(dark=True),
        lambda tab: tab.set(max_iterations=LENGTH - 2),
        lambda tab: tab.set(right="DO"),
        lambda tab: tab.actions.look(ELSEWHERE),
        lambda tab: tab.actions.reset_view(),
    ],
    ids=["look", "limit", "method", "camera", "reset view"],
)
def test_what_leaves_the_scene_as_it_is_does_not_play(open_tab: OpenTab, change: Callable[[Tab], None]):
    tab = open_tab(REPLAYING)
    change(tab)
    shown = tab.settle()
    assert (shown.state.playing, shown.state.iteration) == (False, LAST)
    assert not any(frame.held for frame in tab.frames)


def test_a_person_who_steps_or_pauses_while_it_waits_is_obeyed(open_tab: OpenTab, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(live_state, "AFTER_A_CHANGE", wait := 2.0)
    for act, expected in ((lambda tab: tab.actions.step(1), 1), (lambda tab: tab.actions.play(), 0)):
        tab = open_tab(REPLAYING)
        tab.set(rotation=50.0)
        tab.wait("the start", lambda tab=tab: tab.shown.held)
        act(tab)
        time.sleep(wait)
        shown = tab.settle()
        assert (shown.iteration, shown.state.playing, shown.held) == (expected, False, False)


def test_without_replay_a_change_is_shown_where_the_page_stands(tab: Tab):
    tab.actions.jump(LAST)
    tab.set(rotation=50.0)
    shown = tab.settle()
    assert (shown.iteration, shown.state.playing, shown.held) == (LENGTH, False, False)


# A scene in the hand


def test_a_scene_is_carried_played_and_undone(open_tab: OpenTab):
    tab = open_tab(REPLAYING)
    lay = tab.shown.run.sides[1].T_model_scene[-1]
    points = RigidTransform.from_matrix(lay).apply(tab.shown.run.scene.points)
    for phase, at in (("start", handles(0.1)), ("update", handles(0.3)), ("end", handles(0.3, 1.0))):
        tab.actions.grab(1, phase, at)
    tab.wait("the carried scene", lambda: tab.shown.held and tab.shown.state.start == tab.widgets.start)
    motion = RigidTransform.from_matrix(handles(0.3, 1.0)) * RigidTransform.from_matrix(handles(0.1)).inv()
    np.testing.assert_allclose(tab.shown.run.scene.points, motion.apply(points), atol=4e-4)
    assert tab.widgets.start == tab.shown.state.start != NO_START
    carried = played(tab)
    assert carried.state.perturbation == REPLAYING.perturbation
    tab.actions.undo()
    assert tab.settle().state == REPLAYING
    tab.actions.redo()
    shown = tab.settle().state
    assert (shown.start, shown.playing) == (carried.state.start, False)


def test_a_carried_scene_is_shown_in_the_hand_even_where_nothing_is_replayed(tab: Tab):
    tab.actions.jump(LAST)
    tab.settle()
    tab.actions.grab(0, "start", handles(0.0))
    tab.actions.grab(0, "update", handles(0.5))
    tab.wait("the scene in the hand", lambda: tab.shown.state.start != NO_START)
    assert (tab.settle().iteration, tab.shown.state.playing) == (0, False)


def test_gestures_that_are_no_good_change_nothing(tab: Tab):
    before = tab.settle()
    tab.actions.grab(0, "update", handles(0.5))
    tab.actions.grab(0, "end", handles(0.5))
    assert tab.settle().state == before.state
    assert tab.notes == []


@pytest.mark.parametrize(
    "act",
    [lambda tab: tab.actions.new_seed(), lambda tab: tab.actions.paper_defaults()],
    ids=["new seed", "paper defaults"],
)
def test_another_draw_lets_go_of_the_scene(tab: Tab, act: Callable[[Tab], None]):
    tab.actions.grab(0, "start", handles(0.3))
    tab.wait("the scene in the hand", lambda: tab.shown.state.start != NO_START)
    act(tab)
    tab.wait("another draw", lambda: tab.shown.state.start == NO_START)


# Undo and redo


def test_a_change_is_taken_back_and_made_again(tab: Tab):
    tab.set(noise=0.08)
    changed = tab.settle().state
    tab.actions.undo()
    assert tab.settle().state == PAUSED
    assert tab.widgets == PAUSED
    tab.actions.redo()
    assert tab.settle().state == changed
    assert tab.widgets == changed


def test_a_drag_is_one_change_and_a_change_long_after_another(tab: Tab):
    for i in range(10):
        tab.set(rotation=40.0 + i)
        time.sleep(0.03)
    tab.settle()
    time.sleep(1.0)
    tab.set(noise=0.01)
    tab.settle()
    tab.actions.undo()
    assert tab.settle().state.perturbation == replace(PAUSED.perturbation, rotation=49.0)
    tab.actions.undo()
    assert tab.settle().state == PAUSED


def test_where_nothing_was_changed_nothing_is_taken_back_and_it_is_said(tab: Tab):
    tab.actions.step(3)
    tab.settle()
    tab.actions.undo()
    tab.actions.redo()
    assert tab.settle().state == replace(PAUSED, iteration=3)
    assert [note.partition(":")[0] for note in tab.notes] == ["There is nothing to undo", "There is nothing to redo"]
    tab.set(rotation=50.0)
    tab.settle()
    tab.actions.undo()
    tab.actions.redo()
    assert len(tab.notes) == 2
    assert tab.settle().state.perturbation.rotation == 50


def test_undo_does_not_play(open_tab: OpenTab):
    tab = open_tab(REPLAYING)
    tab.actions.new_seed()
    played(tab)
    tab.actions.undo()
    shown = tab.settle()
    assert shown.state == REPLAYING
    time.sleep(requests.AFTER_A_CHANGE)
    assert tab.settle() is shown


def test_a_page_that_was_opened_is_taken_back_as_a_whole(tab: Tab):
    other = replace(PAUSED, left="Improved DO", perturbation=Perturbation(seed=9, points=150), iteration=2)
    tab.actions.open_page(other)
    assert tab.settle().state == other
    tab.actions.undo()
    assert tab.settle().state == PAUSED


# The camera


def test_looking_from_elsewhere_is_kept_and_reset(tab: Tab):
    tab.actions.look(ELSEWHERE)
    tab.actions.step(1)
    assert tab.settle().state == replace(PAUSED, iteration=1, camera=ELSEWHERE)
    tab.actions.reset_view()
    assert tab.settle().state.camera == NO_CAMERA
