"""What the charts draw: values of the run, in the order asked for, with the picked bins marked."""

from __future__ import annotations

from dataclasses import replace
from typing import get_args

import numpy as np
import pytest

from ido import Perturbation, poses
from ido_viz.core.chart_data import curve, histogram_data
from ido_viz.core.frame import SideFrame, frame_of
from ido_viz.core.geometry import error_vectors
from ido_viz.core.library import shipped_library
from ido_viz.core.overlay import overlay_of
from ido_viz.core.run import MOST_DISTANCES, Run, compute
from ido_viz.core.state import BinOrder, State

STATE = State(perturbation=Perturbation(seed=5), inspected=42)


@pytest.fixture(scope="module")
def run() -> Run:
    return compute(STATE, shipped_library())


def side_at(run: Run, state: State, iteration: int, pane: int) -> SideFrame:
    return frame_of(run, replace(state, iteration=iteration)).sides[pane]


def drawn(run: Run, state: State, iteration: int, pane: int) -> tuple[np.ndarray, tuple[np.ndarray, ...]]:
    """The order of the bins and the columns that are drawn."""
    side = side_at(run, state, iteration, pane)
    return side.order, histogram_data(side, state)


@pytest.mark.parametrize("order", get_args(BinOrder))
@pytest.mark.parametrize("pane", [0, 1])
def test_the_marked_dots_are_the_picked_points_bins(run: Run, order: BinOrder, pane: int):
    bins, (_, second, *blocks, _, marked) = drawn(run, replace(STATE, order=order), 3, pane)
    n_model = len(run.sides[pane].histogram.model.points)
    at = np.flatnonzero(~np.isnan(marked))
    assert len(at) == 2 * len(blocks)
    assert (bins[at] % n_model == 42).all()
    np.testing.assert_array_equal(marked[at], np.nansum(blocks, axis=0)[at])
    assert np.isnan(second).all()


def test_no_dot_is_marked_when_no_point_is_picked(run: Run):
    *_, marked = drawn(run, replace(STATE, inspected=-1), 3, 1)[1]
    assert np.isnan(marked).all()


def test_bins_run_from_the_smallest_to_the_largest_contribution(run: Run):
    state = replace(STATE, order="contribution", coloring="φy")
    side = side_at(run, state, 3, 1)
    assert side.inspection is not None
    sides = side.inspection.values[side.order].reshape(6, -1)
    assert (np.diff(sides, axis=1) >= 0).all()
    assert not np.array_equal(np.sort(sides[0]), np.sort(sides[1]))


@pytest.mark.parametrize("difference", [False, True])
def test_a_histogram_laid_over_is_drawn_as_the_first_one_is(run: Run, difference: bool):
    state = replace(STATE, difference=difference)
    laid_over = replace(state, overlay="another iteration", overlaid_iteration=5)
    _, second, *_ = drawn(run, laid_over, 0, 1)[1]
    _, _, *blocks, _, _ = drawn(run, state, 5, 1)[1]
    np.testing.assert_array_equal(second, np.nansum(blocks, axis=0))


def test_distances_are_those_of_the_histograms(run: Run):
    for number, side in enumerate(run.sides):
        reference = side.histogram.reference.astype(np.float64)
        expected = [
            np.linalg.norm(run.histogram(number, k) - reference) / np.linalg.norm(reference)
            for k in range(side.trajectory.iterations + 1)
        ]
        np.testing.assert_allclose(curve(side, "histogram distance"), expected, rtol=1e-5)
        assert expected[-1] < expected[0]


def test_distances_of_a_long_run_are_measured_where_it_matters():
    state = State(perturbation=Perturbation(rotation=120.0, seed=1), epsilon=1e-5, max_iterations=300)
    run = compute(state, shipped_library())
    side = run.sides[0]
    assert side.trajectory.iterations > MOST_DISTANCES
    reference = side.histogram.reference.astype(np.float64)
    for k in (0, 1, MOST_DISTANCES // 2 - 1, side.trajectory.iterations):
        expected = np.linalg.norm(run.histogram(0, k) - reference) / np.linalg.norm(reference)
        assert side.distances[k] == pytest.approx(expected, rel=1e-5)
    assert len(side.distances) == side.trajectory.iterations + 1


def test_the_other_method_is_laid_over_at_its_own_pose(run: Run):
    state = replace(STATE, overlay="other method")
    for pane in (0, 1):
        over = overlay_of(run, state, 4, pane)
        assert over is not None and over.title == run.sides[1 - pane].method
        np.testing.assert_array_equal(over.T_model_scene, run.sides[1 - pane].T_model_scene[4])
        np.testing.assert_allclose(poses.exp(over.x), over.T_model_scene)


def test_another_iteration_is_laid_over_no_further_than_the_last(run: Run):
    state = replace(STATE, overlay="another iteration", overlaid_iteration=2)
    over, last = overlay_of(run, state, 9, 0), overlay_of(run, replace(state, overlaid_iteration=5000), 9, 0)
    assert over is not None and last is not None
    np.testing.assert_array_equal(over.x, run.sides[0].trajectory.x[2])
    np.testing.assert_array_equal(last.x, run.sides[0].trajectory.x[-1])
    assert last.title == f"iteration {run.sides[0].trajectory.iterations}"
    assert overlay_of(run, STATE, 9, 0) is None


def test_error_vectors_are_as_long_as_the_scores_say(run: Run):
    for side in run.sides:
        for k in (0, 3, side.trajectory.iterations):
            lines = error_vectors(run.scene, side.T_model_scene[k])
            lengths = np.linalg.norm(lines[:, 1] - lines[:, 0], axis=1)
            assert np.sqrt((lengths**2).mean()) == pytest.approx(side.scores.rmse[k], rel=1e-4)
            assert (lengths <= 0.1).mean() == pytest.approx(side.scores.accuracy[k], abs=1e-9)
    whole = error_vectors(run.scene, run.sides[0].T_model_scene[3])
    np.testing.assert_array_equal(error_vectors(run.scene, run.sides[0].T_model_scene[3], 17), whole[17:18])
    assert run.scene.is_outlier[-1]
    assert len(error_vectors(run.scene, run.sides[0].T_model_scene[3], len(run.scene.points) - 1)) == 0
    belongs = error_vectors(run.scene, run.scene.T_model_scene)
    np.testing.assert_array_equal(belongs[:, 0], belongs[:, 1])
