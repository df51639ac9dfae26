"""How long each iteration is played: longer the more the cloud moves, and never too long in all."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import RigidTransform

from ido import Perturbation, StopReason, Trajectory, poses
from ido.types import FloatArray
from ido_viz.core.library import shipped_library
from ido_viz.core.pacing import LONGEST, SHORTEST, Pacing
from ido_viz.core.run import Run, compute
from ido_viz.core.state import NORMAL_SPEED, State

LIBRARY = shipped_library()
FEW = Perturbation(points=100, outliers=0)  # so few that all of them are looked at
FIRST = 5  # iterations that a viewer must be able to follow


def with_poses(run: Run, T_model_scene: FloatArray) -> Run:
    """A run whose both sides go through given poses."""
    n = len(T_model_scene) - 1
    trajectory = Trajectory(np.zeros((n + 1, 6)), np.zeros(n), StopReason.MAX_ITERATIONS, np.nan)
    left, right = (replace(side, trajectory=trajectory, T_model_scene=T_model_scene) for side in run.sides)
    return replace(run, sides=(left, right))


@pytest.fixture(scope="module")
def run() -> Run:
    return compute(State(), LIBRARY)


@pytest.fixture(scope="module")
def pacing(run: Run) -> Pacing:
    return Pacing(run)


def test_times_rise_from_zero_one_for_each_iteration(run: Run, pacing: Pacing):
    assert len(pacing.times) == run.iterations + 1
    assert pacing.times[0] == 0
    assert (np.diff(pacing.times) > 0).all()


def test_the_first_five_iterations_of_a_typical_run_take_about_as_long_as_all_others(pacing: Pacing):
    first, others = pacing.times[FIRST], pacing.times[-1] - pacing.times[FIRST]
    assert 0.9 * others < first < 1.1 * others


@pytest.mark.parametrize("seed", range(1, 5))
def test_an_early_iteration_can_be_followed_in_any_scene(seed: int):
    times = Pacing(compute(State(perturbation=Perturbation(seed=seed)), LIBRARY)).times
    early, late = times[FIRST] / FIRST, (times[-1] - times[FIRST]) / (len(times) - 1 - FIRST)
    assert early > 3 * late


def test_the_time_of_an_iteration_grows_evenly_with_how_far_the_points_move():
    run = compute(State(perturbation=FEW, left="DO", right="DO"), LIBRARY)
    points = run.scene.points.astype(np.float64)
    places = [RigidTransform.from_matrix(T).apply(points) for T in run.sides[0].T_model_scene]
    moved = np.array([np.sqrt(((b - a) ** 2).sum(axis=1).mean()) for a, b in pairwise(places)])
    seconds = np.diff(Pacing(run).times)
    slope, shortest = np.polyfit(moved, seconds, 1)
    np.testing.assert_allclose(seconds, shortest + slope * moved, atol=1e-9)
    assert slope > 0
    assert shortest == pytest.approx(seconds.mean() / 2)  # what one that does not move at all would take


def test_of_two_methods_the_one_that_moves_farther_sets_the_pace():
    one = compute(State(perturbation=FEW, left="DO", right="Did nothing"), LIBRARY)
    both = compute(State(perturbation=FEW, left="DO", right="DO"), LIBRARY)
    np.testing.assert_allclose(Pacing(one).times, Pacing(both).times)


@pytest.mark.parametrize("n", [1, 10, 40, 1000, 5000])
def test_a_run_takes_neither_too_short_nor_too_long(run: Run, n: int):
    x = np.linspace([1.0, 0, 0, 0, 0, 2.0], np.zeros(6), n + 1)
    seconds = Pacing(with_poses(run, poses.exp(x))).times[-1]
    assert SHORTEST <= seconds <= LONGEST + 1e-9
    assert seconds <= 10


@pytest.mark.parametrize("n", [0, 4])
def test_what_does_not_move_is_played_evenly(run: Run, n: int):
    still = Pacing(with_poses(run, np.tile(np.eye(4), (n + 1, 1, 1))))
    assert len(still.times) == n + 1
    np.testing.assert_allclose(np.diff(still.times), [still.times[-1] / max(n, 1)] * n)
    assert still.after(0.0, 100.0, NORMAL_SPEED) == n


def test_poses_that_are_no_numbers_do_not_stop_the_others(run: Run):
    T = np.tile(np.eye(4), (6, 1, 1))
    T[3] = np.nan
    np.testing.assert_allclose(np.diff(Pacing(with_poses(run, T)).times), Pacing(with_poses(run, T)).times[-1] / 5)


@given(share=st.floats(0, 1), wait=st.floats(0, 10), speed=st.integers(1, 60))
def test_after_inverts_times(pacing: Pacing, share: float, wait: float, speed: int):
    iterations = np.arange(len(pacing.times))
    position = share * iterations[-1]
    begun, played = np.interp(position, iterations, pacing.times), wait * speed / 15
    later = pacing.after(position, wait, speed)
    assert np.interp(later, iterations, pacing.times) == pytest.approx(min(begun + played, pacing.times[-1]))
    assert later >= position - 1e-9


def test_two_waits_are_one_long_one(pacing: Pacing):
    for first, second in ((0.3, 0.4), (1.0, 2.5), (3.0, 30.0)):
        at_once = pacing.after(1.25, first + second, 20)
        assert pacing.after(pacing.after(1.25, first, 20), second, 20) == pytest.approx(at_once)


@pytest.mark.parametrize(("speed", "most"), [(15, 1000), (60, 1000), (15, 7), (1, 50)])
def test_moments_are_evenly_spaced_in_time_from_start_to_end(pacing: Pacing, speed: int, most: int):
    positions, apart = pacing.moments(speed, 0.1, most)
    assert len(positions) <= most
    assert (positions[0], positions[-1]) == (0, len(pacing.times) - 1)
    assert apart >= 0.095
    for before, after in pairwise(positions.tolist()):
        assert pacing.after(before, apart, speed) == pytest.approx(after, abs=1e-6)
