"""A scene in the hand: it moves as the handles do, from wherever it lies."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform, Rotation

from ido import Perturbation
from ido.types import FloatArray
from ido_viz.core.frame import Frame, frame_of
from ido_viz.core.hand import Hand
from ido_viz.core.library import shipped_library
from ido_viz.core.run import compute, make_scene
from ido_viz.core.state import FARTHEST, NO_START, State

LIBRARY = shipped_library()
STATE = State(perturbation=Perturbation(points=100, outliers=30, rotation=40.0, seed=3), max_iterations=12)
MOVED = replace(STATE, start=(0.3, -0.2, 0.1, 1.0, 0.4, -0.8))
ROUNDING = 4e-4  # model units, of a start pose with four decimals


def frame(state: State) -> Frame:
    return frame_of(compute(state, LIBRARY), state)


def handles(x: float, y: float, z: float, turn: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> FloatArray:
    """A pose of the handles, (4, 4); the turn is a rotation vector."""
    return RigidTransform.from_components([x, y, z], Rotation.from_rotvec(turn)).as_matrix()


def lies(state: State) -> FloatArray:
    """Where a state's scene lies before the first iteration, shape (S, 3)."""
    return make_scene(LIBRARY.subject(state.shape), state).points


@pytest.mark.parametrize("pane", [0, 1])
@pytest.mark.parametrize("state", [STATE, MOVED], ids=["drawn", "moved before"])
@pytest.mark.parametrize("iteration", [0, 5])
def test_the_scene_moves_as_the_handles_do(state: State, iteration: int, pane: int):
    drawn = frame(replace(state, iteration=iteration))
    seen = RigidTransform.from_matrix(drawn.sides[pane].T_model_scene).apply(drawn.run.scene.points)
    begun, hand = handles(0.2, 0.1, -0.3), Hand()
    hand.start_pose(drawn, pane, "start", begun)
    for phase, now in (
        ("update", handles(0.3, 0.1, -0.3)),
        ("update", handles(0.3, 0.1, -0.3, (0.0, 0.0, 1.2))),
        ("end", handles(-0.4, 0.6, 0.1, (0.5, -2.0, 1.0))),
    ):
        start = hand.start_pose(drawn, pane, phase, now)
        assert start is not None
        motion = RigidTransform.from_matrix(now) * RigidTransform.from_matrix(begun).inv()
        np.testing.assert_allclose(lies(replace(state, start=start)), motion.apply(seen), atol=ROUNDING)


def test_what_is_shown_meanwhile_does_not_matter():
    """The scene is taken from where it lay at the start of the gesture, whatever has been drawn since."""
    hand, steady = Hand(), Hand()
    before, since = frame(replace(STATE, iteration=5)), frame(MOVED)
    for one in (hand, steady):
        one.start_pose(before, 0, "start", handles(0, 0, 0))
    moved = handles(0.1, 0.2, 0.3, (0.4, 0.0, 0.0))
    assert hand.start_pose(since, 0, "update", moved) == steady.start_pose(before, 0, "update", moved)


@pytest.mark.parametrize("iteration", [0, 7])
def test_nothing_jumps_when_it_is_taken(iteration: int):
    drawn = frame(replace(MOVED, iteration=iteration))
    start = Hand().start_pose(drawn, 1, "start", handles(0.5, 0.5, 0.5, (0.1, 0.2, 0.3)))
    assert start is not None
    seen = RigidTransform.from_matrix(drawn.sides[1].T_model_scene).apply(drawn.run.scene.points)
    np.testing.assert_allclose(lies(replace(MOVED, start=start)), seen, atol=ROUNDING)


def test_a_gesture_whose_start_was_missed_is_ignored():
    hand, drawn = Hand(), frame(STATE)
    assert hand.start_pose(drawn, 0, "update", handles(1, 0, 0)) is None
    assert hand.start_pose(drawn, 0, "end", handles(1, 0, 0)) is None
    assert hand.start_pose(drawn, 0, "start", handles(1, 0, 0)) is not None
    assert hand.start_pose(drawn, 0, "end", handles(2, 0, 0)) is not None
    assert hand.start_pose(drawn, 0, "update", handles(3, 0, 0)) is None


def test_a_scene_is_not_carried_farther_than_a_state_can_hold():
    hand, drawn = Hand(), frame(STATE)
    hand.start_pose(drawn, 0, "start", handles(0, 0, 0))
    assert hand.start_pose(drawn, 0, "update", handles(FARTHEST + 1, 0, 0)) is None
    start = hand.start_pose(drawn, 0, "end", handles(1, 0, 0))
    assert start is not None
    assert replace(STATE, start=start).start != NO_START
