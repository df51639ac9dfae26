"""The equations of the derivations: the code does what they say, and each is checked."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from scipy.linalg import expm

import ido
from ido import poses, shipped_cloud, shipped_maps
from ido.attribution import Attribution
from ido.blocks import SIGMA2, SMALLEST_WEIGHT, azimuth, elevation
from ido.histograms import AsPrinted, SceneBatch
from ido.training import solve, training_scenes
from ido.types import DoubleArray, FloatArray
from ido_viz.core.inspection import inspect
from ido_viz.core.library import shipped_library
from ido_viz.core.run import compute
from ido_viz.core.state import State
from ido_viz.teach.derivations import derivations, equations_of
from ido_viz.teach.lessons import lessons


def test_a_registration_is_what_the_formulas_say():
    maps, scene = shipped_maps("bunny", "front-back"), ido.perturb(shipped_cloud("bunny"), ido.Perturbation())
    epsilon = 0.001
    its = ido.register(maps, scene.points, epsilon=epsilon)
    np.testing.assert_array_equal(its.x[0], np.zeros(6))

    def update(k: int) -> FloatArray:
        return maps.maps[min(k, len(maps.maps) - 1)] @ maps.histogram(scene.points, its.x[k])

    for k in range(its.iterations):
        np.testing.assert_allclose(its.x[k + 1], its.x[k] - update(k), atol=1e-6)
    lengths = np.array([np.linalg.norm(update(k)) for k in range(its.iterations + 1)])
    assert its.converged and its.iterations >= len(maps.maps)
    assert lengths[-1] < epsilon and np.all(lengths[len(maps.maps) : -1] >= epsilon)


def test_a_map_tells_roughly_what_is_wrong_with_a_pose():
    maps, cloud = shipped_maps("bunny", "front-back"), shipped_cloud("bunny")
    scenes = [ido.perturb(cloud, ido.Perturbation(seed=seed)) for seed in range(100)]
    wrong = np.stack([-poses.log(scene.T_model_scene) for scene in scenes])  # x - x*, at x = 0
    told = np.stack([maps.maps[0] @ maps.histogram(scene.points, np.zeros(6)) for scene in scenes])
    assert ((told - wrong) ** 2).sum() < 0.7 * (wrong**2).sum()


def slope(cost: Callable[[DoubleArray], float], x: DoubleArray) -> DoubleArray:
    """Gradient of a cost, by differences."""
    return np.array([(cost(x + step) - cost(x - step)) / 2e-6 for step in 1e-6 * np.eye(len(x))])


def test_a_perfect_map_needs_one_step_and_stands_in_for_the_slope_of_a_cost():
    x_true = np.array([0.1, -0.2, 0.3, 0.4, -0.5, 0.6])

    class Perfect:
        def update(self, points: FloatArray, x: FloatArray) -> FloatArray:
            return -(x - x_true)

    its = ido.register_updates(Perfect(), np.zeros((5, 3)))
    assert its.iterations == 1
    np.testing.assert_allclose(its.x[1], x_true)

    def cost(x: DoubleArray) -> float:
        return 0.5 * float(((x - x_true) ** 2).sum())

    np.testing.assert_allclose(slope(cost, np.zeros(6)), -x_true, atol=1e-8)  # so is gradient descent with μ = 1
    assert cost(-0.1 * slope(cost, np.zeros(6))) < cost(np.zeros(6))


def hat(v: FloatArray) -> DoubleArray:
    return np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]], dtype=np.float64)


@pytest.mark.parametrize("angle", [0.1, 1.0, 3.0])
def test_poses_are_what_the_formulas_say(angle: float):
    rng = np.random.default_rng(0)
    u, rho, p = rng.normal(size=(3, 3))
    u /= np.linalg.norm(u)
    U, eye = hat(u), np.eye(3)
    np.testing.assert_allclose(hat(u) @ p, np.cross(u, p))
    np.testing.assert_allclose(U @ U @ U, -U, atol=1e-12)
    T = poses.exp(np.concatenate([rho, angle * u]))
    R, t = T[:3, :3], T[:3, 3]
    np.testing.assert_allclose(T[3], [0, 0, 0, 1])
    np.testing.assert_allclose(poses.transform(T, p[None])[0], R @ p + t)
    np.testing.assert_allclose(R.T @ R, eye, atol=1e-12)
    np.testing.assert_allclose(np.linalg.det(R), 1)
    twist = np.zeros((4, 4))
    twist[:3, :3], twist[:3, 3] = angle * U, rho
    np.testing.assert_allclose(expm(twist), T, atol=1e-12)
    before, now, after = (poses.transform(expm(tau * twist), p[None])[0] for tau in (0.5 - 1e-5, 0.5, 0.5 + 1e-5))
    np.testing.assert_allclose((after - before) / 2e-5, np.cross(angle * u, now) + rho, atol=1e-6)
    np.testing.assert_allclose(eye + np.sin(angle) * U + (1 - np.cos(angle)) * U @ U, R, atol=1e-12)
    V = eye + (1 - np.cos(angle)) / angle * U + (1 - np.sin(angle) / angle) * U @ U
    np.testing.assert_allclose(V @ rho, t, atol=1e-12)
    turns = [expm(tau * angle * U) for tau in (np.arange(400) + 0.5) / 400]
    np.testing.assert_allclose(np.mean(turns, axis=0), V, atol=1e-5)
    np.testing.assert_allclose((np.trace(R) - 1) / 2, np.cos(angle))
    np.testing.assert_allclose((R - R.T) / (2 * np.sin(angle)), U, atol=1e-10)
    np.testing.assert_allclose(poses.log(T), np.concatenate([np.linalg.inv(V) @ t, angle * u]), atol=1e-10)


def drawn_scenes(count: int) -> tuple[FloatArray, FloatArray]:
    """What is wrong with the first poses of training scenes, and their histograms."""
    cloud = shipped_cloud("bunny")
    scenes, x_true = training_scenes(cloud, ido.TrainingSettings(samples=count))
    histogram = ido.FrontBack(ido.Model.of(cloud, n_points=60))
    x = np.zeros_like(x_true)
    return x - x_true, histogram.batch(SceneBatch.of([scenes[i] for i in range(count)]), x).astype(np.float64)


def objective(D: FloatArray, e: FloatArray, h: FloatArray, ridge: float) -> float:
    return float(((e - h @ D.T) ** 2).sum(axis=1).mean() + ridge * (D**2).sum())


def as_printed(e: FloatArray, h: FloatArray, ridge: float) -> DoubleArray:
    return np.mean([np.outer(-e_i, h_i) / (ridge + h_i @ h_i) for e_i, h_i in zip(e, h, strict=True)], axis=0)


def test_the_learned_map_is_where_the_gradient_is_zero_and_the_error_falls():
    e, h = drawn_scenes(200)
    ridge = 0.01
    D = solve(h.astype(np.float32), e, ridge).astype(np.float64)
    closed = (e.T @ h / len(e)) @ np.linalg.inv(h.T @ h / len(e) + ridge * np.eye(h.shape[1]))
    np.testing.assert_allclose(D, closed, atol=1e-3)
    gradient = -2 / len(e) * (e - h @ D.T).T @ h + 2 * ridge * D
    assert np.abs(gradient).max() < 1e-4
    assert objective(D, e, h, ridge) <= (e**2).sum(axis=1).mean()
    rng = np.random.default_rng(0)
    assert all(
        objective(D + 0.1 * rng.normal(size=D.shape), e, h, ridge) > objective(D, e, h, ridge) for _ in range(20)
    )


def test_the_printed_map_is_right_for_one_scene_but_for_the_sign_and_wrong_for_more():
    e, h = drawn_scenes(200)
    ridge = 0.01
    one = solve(h[:1].astype(np.float32), e[:1], ridge)
    np.testing.assert_allclose(-as_printed(e[:1], h[:1], ridge), one, atol=1e-5)
    best = objective(solve(h.astype(np.float32), e, ridge), e, h, ridge)
    printed = as_printed(e, h, ridge)
    assert objective(-printed, e, h, ridge) > 1.1 * best
    assert objective(printed, e, h, 0.0) > objective(np.zeros_like(printed), e, h, 0.0)  # it leads away


def test_the_weight_has_the_told_values():
    assert SIGMA2 == 0.03
    assert [round(float(np.exp(-(d**2) / SIGMA2)), 4) for d in (0.1732, 0.5)] == [0.3679, 0.0002]
    assert SMALLEST_WEIGHT == 1e-6


def test_the_bins_are_what_the_formulas_say():
    rng = np.random.default_rng(0)
    model = ido.Model.of(shipped_cloud("bunny"), n_points=40)
    xs, ys, zs = model.points.T
    np.testing.assert_allclose(elevation(model.points), np.arctan2(zs, np.sqrt(xs**2 + ys**2)), atol=1e-6)
    np.testing.assert_allclose(azimuth(model.points), np.arctan2(ys, xs), atol=1e-6)
    scene, x = rng.normal(0, 0.5, (30, 3)).astype(np.float32), rng.normal(0, 0.3, 6)
    T = poses.exp(x)
    moved = np.array([T[:3, :3] @ s + T[:3, 3] for s in scene])
    bins = np.zeros((6, 40))
    for a, (m, n) in enumerate(zip(model.points.astype(float), model.normals.astype(float), strict=True)):
        for s in moved:
            weight = np.exp(-((s - m) @ (s - m)) / 0.03)
            bins[0 if n @ (s - m) > 0 else 1, a] += weight
            bins[2 if elevation(s[None])[0] > elevation(m[None])[0] else 3, a] += 1
            bins[4 if azimuth(s[None])[0] > azimuth(m[None])[0] else 5, a] += 1
    blocks = bins.reshape(3, -1)
    expected = (blocks / np.linalg.norm(blocks, axis=1, keepdims=True)).reshape(-1)
    np.testing.assert_allclose(ido.TripleBinary(model)(scene, x), expected, atol=1e-4)


def test_the_bin_weights_are_what_the_formulas_say():
    model = ido.Model.of(shipped_cloud("bunny"), n_points=40)
    points, normals = model.points.astype(float), model.normals.astype(float)
    shares = np.zeros((3, 40))
    for a, (m_a, n_a) in enumerate(zip(points, normals, strict=True)):
        shares[0, a] = np.mean([n_a @ (m - m_a) > 0 for m in points])
        shares[1, a] = np.mean(elevation(points) > elevation(m_a[None])[0])
        shares[2, a] = np.mean(azimuth(points) > azimuth(m_a[None])[0])
    expected = np.stack([shares, 1 - shares], axis=1).reshape(6, 40)
    np.testing.assert_allclose(AsPrinted(model).weights, expected, atol=1e-6)


def test_a_greater_azimuth_lies_anticlockwise_from_the_tip_of_z():
    x_axis, y_axis = np.array([[1.0, 0, 0]]), np.array([[0, 1.0, 0]])
    assert azimuth(y_axis)[0] > azimuth(x_axis)[0]
    assert np.cross(x_axis[0], y_axis[0])[2] > 0


def test_most_points_of_the_bunny_have_less_than_a_tenth_of_it_in_front():
    histogram = shipped_maps("bunny", "as-printed").histogram
    assert isinstance(histogram, AsPrinted)
    assert (histogram.weights[0] < 0.1).mean() > 0.5


def test_shares_add_up_as_told():
    maps = shipped_maps("bunny", "front-back")
    histogram, D = maps.histogram, maps.maps[3].astype(np.float64)
    h = histogram(ido.perturb(shipped_cloud("bunny"), ido.Perturbation()).points, np.zeros(6))
    shares = Attribution.of(D, histogram, h)
    np.testing.assert_allclose(shares.update, -D @ h)
    np.testing.assert_allclose(shares.of_bins[:, 5], -D[:, 5] * h[5])
    d = np.ones(6) / np.sqrt(6)
    np.testing.assert_allclose(shares.along(d), d @ shares.of_bins)
    np.testing.assert_allclose(shares.along().sum(), np.linalg.norm(D @ h))
    against = Attribution.of(D, histogram, h, against_reference=True)
    np.testing.assert_allclose(against.update, shares.update + D @ histogram.reference, atol=1e-9)
    at_the_line = [round(float(np.linalg.norm(D @ histogram.reference)), 3) for D in maps.maps]
    assert (round(at_the_line[0], 2), at_the_line[-1]) == (0.12, 0.004)


def test_shares_towards_the_truth_are_those_along_the_way_to_it():
    state = State(coloring="towards the truth", inspected_pane="left")
    run = compute(state, shipped_library())
    look = inspect(run, state, 3, 0)
    assert look is not None
    x, x_true = run.sides[0].trajectory.x[3], poses.log(run.scene.T_model_scene)
    d = (x_true - x) / np.linalg.norm(x_true - x)
    np.testing.assert_allclose(look.values, d @ look.shares.of_bins, atol=1e-9)


def test_there_are_as_many_maps_as_told_and_a_lesson_by_that_name():
    assert len(shipped_maps("bunny", "front-back").maps) == 30
    assert any(lesson.title.startswith("Learned by heart") for lesson in lessons())


CHECKED_BY: dict[str, Callable[..., None]] = {
    "pose-vector": test_a_registration_is_what_the_formulas_say,
    "map-predicts-error": test_a_map_tells_roughly_what_is_wrong_with_a_pose,
    "update-rule": test_a_registration_is_what_the_formulas_say,
    "perfect-map": test_a_perfect_map_needs_one_step_and_stands_in_for_the_slope_of_a_cost,
    "gradient-descent": test_a_perfect_map_needs_one_step_and_stands_in_for_the_slope_of_a_cost,
    "stopping-rule": test_a_registration_is_what_the_formulas_say,
    "scene-point-weight": test_the_bins_are_what_the_formulas_say,
    "front-back-bins": test_the_bins_are_what_the_formulas_say,
    "elevation-azimuth": test_the_bins_are_what_the_formulas_say,
    "angle-bins": test_the_bins_are_what_the_formulas_say,
    "block-normalisation": test_the_bins_are_what_the_formulas_say,
    "bin-weights": test_the_bin_weights_are_what_the_formulas_say,
    "training-pair": test_the_learned_map_is_where_the_gradient_is_zero_and_the_error_falls,
    "ridge-objective": test_the_learned_map_is_where_the_gradient_is_zero_and_the_error_falls,
    "ridge-gradient": test_the_learned_map_is_where_the_gradient_is_zero_and_the_error_falls,
    "ridge-solution": test_the_learned_map_is_where_the_gradient_is_zero_and_the_error_falls,
    "error-falls": test_the_learned_map_is_where_the_gradient_is_zero_and_the_error_falls,
    "ridge-as-printed": test_the_printed_map_is_right_for_one_scene_but_for_the_sign_and_wrong_for_more,
    "pose-matrix": test_poses_are_what_the_formulas_say,
    "rotation-conditions": test_poses_are_what_the_formulas_say,
    "hat-matrix": test_poses_are_what_the_formulas_say,
    "twist-motion": test_poses_are_what_the_formulas_say,
    "pose-exponential": test_poses_are_what_the_formulas_say,
    "rodrigues-formula": test_poses_are_what_the_formulas_say,
    "translation-matrix": test_poses_are_what_the_formulas_say,
    "pose-logarithm": test_poses_are_what_the_formulas_say,
    "update-as-sum": test_shares_add_up_as_told,
    "share-along-direction": test_shares_add_up_as_told,
    "shares-add-up": test_shares_add_up_as_told,
    "direction-to-truth": test_shares_towards_the_truth_are_those_along_the_way_to_it,
    "shares-against-reference": test_shares_add_up_as_told,
}
"""Which test checks what an equation says, by the equation's name."""


def test_every_equation_is_checked_and_every_check_has_its_equation():
    names = {equation.name for equation in equations_of(derivations())}
    assert sorted(names - CHECKED_BY.keys()) == [], "equations without a check"
    assert sorted(CHECKED_BY.keys() - names) == [], "checks without an equation"
