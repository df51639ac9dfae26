"""From a state to a run: the same inputs give the same run, and it holds what an independent computation gives."""

from __future__ import annotations

from dataclasses import fields, replace
from typing import Any, get_args

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.spatial.transform import Rotation

from ido import Perturbation, perturb, poses, shipped_cloud, shipped_maps
from ido.bin_order import bin_order
from ido.methods import BASELINES, LEARNED
from ido.types import FloatArray
from ido_viz.core.library import shipped_library
from ido_viz.core.run import Run, compute, inputs, start_size
from ido_viz.core.state import LAST, BinOrder, State, StateError

LIBRARY = shipped_library()
SMALL = Perturbation(points=150, outliers=60, rotation=40.0, seed=3)
STATE = State(perturbation=SMALL)

MATTERS: dict[str, Any] = {
    "shape": "urban",
    "perturbation": replace(SMALL, seed=4),
    "start": (0.1, 0.0, -0.2, 0.0, 0.5, 0.0),
    "left": "Improved DO",
    "right": "DO",
    "epsilon": 0.02,
    "max_iterations": 7,
}
DOES_NOT_MATTER: dict[str, Any] = {
    "inside": 1.5,
    "iteration": LAST,
    "playing": False,
    "speed": 60,
    "replay": False,
    "order": "azimuth",
    "difference": True,
    "pinned_map": 15,
    "ghost": False,
    "handles": False,
    "error_vectors": True,
    "overlay": "another iteration",
    "overlaid_iteration": 3,
    "inspected": 7,
    "scene_point": 5,
    "inspected_pane": "left",
    "question": "up / down",
    "coloring": "ρx",
    "against_reference": True,
    "camera": (0.0, -1.0, 0.5, 0.1, 0.0, 0.0),
    "dark": True,
    "large_text": True,
    "hidden": ("scores", "scene"),
}


@pytest.fixture(scope="module")
def run() -> Run:
    return compute(STATE, LIBRARY)


def assert_same_run(a: Run, b: Run) -> None:
    np.testing.assert_array_equal(a.scene.points, b.scene.points)
    np.testing.assert_array_equal(a.scene.is_outlier, b.scene.is_outlier)
    for one, other in zip(a.sides, b.sides, strict=True):
        assert one.method == other.method
        assert one.trajectory.stop == other.trajectory.stop
        np.testing.assert_array_equal(one.trajectory.x, other.trajectory.x)
        for score in fields(one.scores):
            np.testing.assert_array_equal(getattr(one.scores, score.name), getattr(other.scores, score.name))


def test_every_field_of_a_state_is_known_to_matter_or_not():
    assert {field.name for field in fields(State)} == MATTERS.keys() | DOES_NOT_MATTER.keys()


@pytest.mark.parametrize("name", MATTERS)
def test_inputs_follow_what_matters(name: str):
    assert inputs(replace(STATE, **{name: MATTERS[name]})) != inputs(STATE)


@pytest.mark.parametrize("name", DOES_NOT_MATTER)
def test_inputs_ignore_what_does_not_matter(name: str):
    assert inputs(replace(STATE, **{name: DOES_NOT_MATTER[name]})) == inputs(STATE)


def test_equal_inputs_give_equal_runs(run: Run):
    assert_same_run(run, compute(replace(STATE, **DOES_NOT_MATTER), LIBRARY))


def test_another_seed_gives_another_scene(run: Run):
    other = compute(replace(STATE, perturbation=replace(SMALL, seed=4)), LIBRARY)
    assert not np.array_equal(run.scene.points, other.scene.points)


def test_exchanging_the_panes_exchanges_the_runs(run: Run):
    exchanged = compute(replace(STATE, left=STATE.right, right=STATE.left), LIBRARY)
    assert_same_run(run, Run(exchanged.subject, exchanged.scene, (exchanged.sides[1], exchanged.sides[0])))


@pytest.mark.parametrize(("shape", "method"), [(s, m) for s in LIBRARY.subjects for m in LIBRARY.methods(s)])
def test_every_method_on_offer_registers_its_shape(shape: str, method: str):
    run = compute(State(shape=shape, perturbation=SMALL, left=method, right=method, max_iterations=40), LIBRARY)
    for side in run.sides:
        assert side.method == method
        assert side.histogram.name == LEARNED.get(method, "front-back")
        assert (side.maps is None) == (method in BASELINES or side.race is not None)
        assert len(run.histogram(0, 3)) == side.histogram.n_bins
        if side.maps is not None:
            assert side.scores.rmse[-1] < side.scores.rmse[0]


@pytest.mark.parametrize(
    "state",
    [State(shape="urban", left="Improved DO (as printed)"), State(right="RANSAC"), State(shape="teapot")],
    ids=str,
)
def test_what_is_not_on_offer_is_refused(state: State):
    with pytest.raises(StateError, match=r"cannot register|there is no shape"):
        compute(state, LIBRARY)


def test_a_run_is_as_long_as_its_longer_side(run: Run):
    assert run.iterations == max(side.trajectory.iterations for side in run.sides)
    for side in run.sides:
        n = side.trajectory.iterations
        assert [side.clipped(k) for k in (0, n - 1, n, n + 50)] == [0, n - 1, n, n]
        assert len(side.T_model_scene) == n + 1


def test_the_limit_of_iterations_is_kept():
    run = compute(replace(STATE, max_iterations=4), LIBRARY)
    assert [side.trajectory.iterations for side in run.sides] == [4, 4]
    assert {str(side.trajectory.stop) for side in run.sides} == {"iteration limit"}


def test_each_update_is_the_map_times_the_histogram(run: Run):
    for number, side in enumerate(run.sides):
        for k in (0, 1, 10, side.trajectory.iterations - 1):
            assert side.maps is not None
            update = side.maps.maps[side.map_number(k) - 1].astype(np.float64) @ run.histogram(number, k)
            x = side.trajectory.x
            np.testing.assert_allclose(x[k] - x[k + 1], update, atol=1e-6)


def test_scores_equal_an_independent_computation(run: Run):
    scene = perturb(shipped_cloud("bunny"), SMALL)
    points = scene.points[~scene.is_outlier].astype(np.float64)
    true = scene.T_model_scene
    for side in run.sides:
        for k in range(0, side.trajectory.iterations + 1, 6):
            x = side.trajectory.x[k]
            R, t = Rotation.from_rotvec(x[3:]), poses.exp(x)[:3, 3]
            distance = np.linalg.norm(R.apply(points) + t - (points @ true[:3, :3].T + true[:3, 3]), axis=1)
            turned = R * Rotation.from_matrix(true[:3, :3]).inv()
            assert side.scores.accuracy[k] == pytest.approx((distance < 0.1).mean())
            assert side.scores.rmse[k] == pytest.approx(np.sqrt((distance**2).mean()))
            assert side.scores.rotation[k] == pytest.approx(np.rad2deg(turned.magnitude()))
            assert side.scores.translation[k] == pytest.approx(np.linalg.norm(t - true[:3, 3]))


def test_the_histogram_is_that_of_the_moved_points(run: Run):
    for number, side in enumerate(run.sides):
        last = side.trajectory.iterations
        for k in (0, 1, last // 2, last, last + 100):
            moved = poses.transform(side.T_model_scene[min(k, last)], run.scene.points.astype(np.float64))
            described = side.histogram.describe(moved)
            difference = np.linalg.norm(run.histogram(number, k) - described) / np.linalg.norm(described)
            assert difference <= 1e-5, (side.method, k)


@pytest.mark.parametrize("histogram", LEARNED.values())
@pytest.mark.parametrize("order", get_args(BinOrder))
def test_bins_are_reordered_within_their_side(histogram: str, order: str):
    maps = shipped_maps("bunny", histogram)
    sides = bin_order(maps.histogram, order).reshape(2 * len(maps.histogram.blocks), -1)
    n_model = len(maps.histogram.model.points)
    for number, side in enumerate(sides):
        np.testing.assert_array_equal(np.sort(side), np.arange(number * n_model, (number + 1) * n_model))


@pytest.mark.parametrize("histogram", LEARNED.values())
def test_the_reference_rises_along_its_own_order(histogram: str):
    maps = shipped_maps("bunny", histogram)
    reference = maps.histogram.reference[bin_order(maps.histogram, "reference value")]
    assert (np.diff(reference.reshape(2 * len(maps.histogram.blocks), -1), axis=1) >= 0).all()


@pytest.mark.parametrize("order", ["elevation", "azimuth"])
def test_angles_rise_along_their_order(order: str):
    maps = shipped_maps("bunny", "triple-binary")
    n_model = len(maps.histogram.model.points)
    for side in bin_order(maps.histogram, order).reshape(-1, n_model):
        x, y, z = maps.histogram.model.points[side % n_model].astype(np.float64).T
        angle = np.arctan2(z, np.hypot(x, y)) if order == "elevation" else np.arctan2(y, x)
        assert (np.diff(angle) >= 0).all()


def test_model_index_leaves_the_bins_where_they_are():
    maps = shipped_maps("bunny", "triple-binary")
    np.testing.assert_array_equal(bin_order(maps.histogram, "model index"), np.arange(maps.histogram.n_bins))


def test_an_unknown_order_is_an_error():
    with pytest.raises(KeyError):
        bin_order(shipped_maps("bunny", "front-back").histogram, "random")


# A scene moved by hand

BY_HAND = replace(STATE, start=(0.2, -0.1, 0.3, 0.5, -1.2, 0.7))


def test_a_scene_moved_by_hand_is_moved_after_it_was_drawn():
    drawn = perturb(shipped_cloud("bunny"), SMALL)
    moved = compute(BY_HAND, LIBRARY).scene
    T = expm(twist(np.array(BY_HAND.start)))
    np.testing.assert_allclose(moved.points, drawn.points @ T[:3, :3].T + T[:3, 3], atol=1e-6)
    np.testing.assert_array_equal(moved.is_outlier, drawn.is_outlier)


def test_a_registration_of_it_starts_where_it_was_put(run: Run):
    by_hand = compute(BY_HAND, LIBRARY)
    for side, other in zip(by_hand.sides, run.sides, strict=True):
        np.testing.assert_array_equal(side.T_model_scene[0], np.eye(4))
        assert side.scores.rmse[0] != pytest.approx(other.scores.rmse[0])


@pytest.mark.parametrize("start", [(), BY_HAND.start, (0.0, 0.0, 0.0, 0.0, 0.0, 3.0)])
def test_the_size_of_a_start_is_its_distance_from_the_true_place(start: tuple[float, ...]):
    state = replace(STATE, start=start)
    away = np.linalg.inv(compute(state, LIBRARY).scene.T_model_scene)
    degrees, distance = start_size(state)
    assert degrees == pytest.approx(np.rad2deg(Rotation.from_matrix(away[:3, :3]).magnitude()))
    assert distance == pytest.approx(np.linalg.norm(away[:3, 3]))


def twist(x: FloatArray) -> FloatArray:
    """ξ^ of x = [ρ, φ], shape (4, 4)."""
    (a, b, c), matrix = x[3:], np.zeros((4, 4))
    matrix[:3, :3] = [[0, -c, b], [c, 0, -a], [-b, a, 0]]
    matrix[:3, 3] = x[:3]
    return matrix
