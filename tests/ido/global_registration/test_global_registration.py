"""The global method: its fields, its likelihood, and what it finds from any start."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.optimize
from scipy.spatial.transform import Rotation

from ido import (
    Cloud,
    Confidence,
    GlobalModel,
    GlobalRegistration,
    GlobalResult,
    Perturbation,
    Scene,
    perturb,
    polish,
    poses,
    score,
)
from ido.global_registration import GlobalSettings
from ido.global_registration.climbing import climb
from ido.global_registration.cut_plane import Posterior
from ido.global_registration.fields import Field
from ido.global_registration.outliers import Background
from ido.global_registration.search import spread_rotations
from ido.global_registration.spread import moved_by
from ido.methods import shipped_global_model
from ido.types import DoubleArray, FloatArray

FAR = Perturbation(rotation=170, translation=1.0, outliers=100, noise=0.02, seed=5)


@pytest.fixture(scope="module")
def model() -> GlobalModel:
    return shipped_global_model("bunny")


@pytest.fixture(scope="module")
def scene(bunny: Cloud) -> Scene:
    return perturb(bunny, FAR)


@pytest.fixture(scope="module")
def result(model: GlobalModel, scene: Scene) -> GlobalResult:
    return GlobalRegistration(model).run(scene.points)


def posterior_of(model: GlobalModel, scene: Scene) -> Posterior:
    background = Background.of(scene.points, GlobalSettings(ball=False))
    return Posterior(scene.points, background, model.fields[2], model.planes, np.array([0.6, 0.0]))


def test_a_field_is_the_mean_of_gaussians_about_the_points(bunny: Cloud, model: GlobalModel):
    at = bunny.points[::700] + np.float32(0.02)
    distance2 = ((bunny.points[None].astype(float) - at[:, None]) ** 2).sum(axis=2)
    for field in model.fields:
        exact = np.exp(-distance2 / (2 * field.sigma**2)).mean(axis=1) / (2 * np.pi * field.sigma**2) ** 1.5
        np.testing.assert_allclose(field(at), exact, rtol=0.12)


def test_the_density_of_the_others_is_that_of_a_field_without_the_point(bunny: Cloud):
    points = bunny.points[:: len(bunny.points) // 300]
    field = Field.of(points, 0.1)
    own = 1 / (2 * np.pi * 0.1**2) ** 1.5 / len(points)  # what the grid's cells get wrong of it, too
    without = [Field.of(np.delete(points, i, axis=0), 0.1)(points[i : i + 1])[0] for i in range(0, len(points), 10)]
    np.testing.assert_allclose(field.of_the_others(points)[::10], without, rtol=0.12, atol=0.12 * own)


def test_rotations_are_spread_evenly():
    found = Rotation.from_matrix(spread_rotations(768))
    away = [
        np.degrees((found.inv() * one).magnitude().min()) for one in Rotation.random(200, rng=np.random.default_rng(1))
    ]
    assert max(away) < 25
    assert np.mean(away) < 14


def test_the_search_has_the_true_pose_among_its_best(model: GlobalModel, scene: Scene):
    middle = np.median(scene.points, axis=0)
    centred = scene.points - middle
    ((T, scores),) = model.search(centred, [Background.of(centred, GlobalSettings(ball=False))])
    back = np.eye(4)
    back[:3, 3] = -middle
    errors = score(scene, T[np.argsort(-scores)[:50]] @ back)
    assert ((errors.rotation < 25) & (errors.translation < 0.3)).any()


def test_the_gradient_of_the_likelihood(model: GlobalModel, scene: Scene):
    posterior, normal = posterior_of(model, scene), np.array([0.6, 0.0, 0.8])

    def value(x: DoubleArray) -> float:
        return posterior(moved_by(x[:6], scene.T_model_scene), normal + x[6:9], 0.2 + x[9])[0]

    gradient = posterior(scene.T_model_scene, normal, 0.2)[1]
    numeric = np.asarray(scipy.optimize.approx_fprime(np.zeros(10), value, 1e-5), dtype=float)
    np.testing.assert_allclose(gradient, numeric, atol=0.02 * np.abs(numeric).max())


def test_a_climb_goes_uphill(model: GlobalModel, scene: Scene):
    start = moved_by(np.array([0.1, -0.05, 0.1, 0.2, 0.1, -0.2]), scene.T_model_scene)[None]
    background = Background.of(scene.points, GlobalSettings(ball=False))
    climbed = climb(scene.points, background, model.fields[-1], start, 15)
    assert (np.diff(climbed.log_likelihood[0]) > -1e-3).all()
    assert climbed.log_likelihood[0, -1] > climbed.log_likelihood[0, 0] + 0.1
    assert score(scene, climbed.poses[0, -1]).rmse < score(scene, start[0]).rmse / 2


def test_a_ball_of_outliers_is_found_and_a_surface_is_none(bunny: Cloud):
    given = perturb(bunny, Perturbation(outlier_kind="structured", outliers=300, seed=3))
    in_ball = Background.of(given.points, GlobalSettings()).in_ball
    assert in_ball[given.is_outlier].mean() > 0.8
    assert in_ball[~given.is_outlier].mean() < 0.3
    assert not Background.of(given.points, GlobalSettings(ball=False)).has_ball


def test_far_scenes_are_registered(scene: Scene, result: GlobalResult):
    assert score(scene, np.eye(4)).accuracy < 0.05
    assert score(scene, result.T_model_scene).accuracy == 1
    assert result.evidence.error < 0.1


def test_where_a_scene_lies_does_not_matter(model: GlobalModel, scene: Scene, result: GlobalResult):
    T = poses.exp(np.array([3.0, -2.0, 5.0, 0.0, 0.0, 0.0]))
    moved = GlobalRegistration(model).run(poses.transform(T, scene.points))
    np.testing.assert_allclose(moved.T_model_scene @ T, result.T_model_scene, atol=1e-2)


def test_the_trajectory_leads_from_where_the_scene_lies_to_the_chosen_pose(result: GlobalResult):
    track = result.trajectory
    np.testing.assert_allclose(track.T_model_scene[0], np.eye(4), atol=1e-9)
    np.testing.assert_allclose(track.T_model_scene[-1], result.T_model_scene, atol=1e-6)
    assert len(track.x) == track.iterations + 1
    assert np.median(track.update_norms) < 0.1, "uphill, in small steps"


def test_every_stage_goes_on_from_the_ones_that_were_kept(result: GlobalResult):
    for branch in result.branches:
        for before, after in zip(branch.stages, branch.stages[1:], strict=False):
            np.testing.assert_array_equal(before.climb.poses[before.kept, -1], after.climb.poses[:, 0])


def test_polishing_makes_a_near_pose_better(model: GlobalModel, scene: Scene):
    near = moved_by(np.array([0.05, 0.05, -0.05, 0.1, -0.1, 0.1]), scene.T_model_scene)
    assert score(scene, polish(model, scene.points, near)).rmse < score(scene, near).rmse / 3


def test_right_poses_are_sure_and_other_shapes_are_not(model: GlobalModel, result: GlobalResult):
    right = Confidence.of(result)
    assert right.probability > 0.9
    assert right.reasons == ()
    rng = np.random.default_rng(0)
    ball = rng.standard_normal((500, 3))
    plane = rng.uniform(-1, 1, (500, 3)) * [1, 1, 0]
    for other in (ball / np.linalg.norm(ball, axis=1)[:, None], plane):
        doubted = Confidence.of(GlobalRegistration(model).run(other))
        assert doubted.probability < 0.5
        assert doubted.reasons


def test_a_sparse_model_of_the_same_shape_is_not_taken_for_another_one(bunny: Cloud):
    rng = np.random.default_rng(0)
    order = rng.permutation(len(bunny.points))
    sparse, fresh = bunny.points[order[:600]], bunny.points[order[600:1100]]
    registration = GlobalRegistration(GlobalModel.of(sparse))
    for size, is_told in ((1.0, False), (1.25, True)):
        scene = fresh * size + rng.normal(0, 0.005, fresh.shape)
        said = Confidence.of(registration.run(scene.astype(np.float32))).reasons
        assert any("another size" in reason for reason in said) == is_told


def box_surface(n: int, rng: np.random.Generator) -> FloatArray:
    """Points on a box with three different edges."""
    size = np.array([1, 0.7, 0.4])
    points = rng.uniform(-1, 1, (n, 3))
    face = rng.choice(3, n, p=size.prod() / size / (size.prod() / size).sum())
    points[np.arange(n), face] = np.sign(points[np.arange(n), face])
    return points * size


@pytest.mark.parametrize("seed", [0, 5])  # in the second draw, the four poses' likelihoods differ by more
def test_symmetric_poses_are_listed(seed: int):
    rng = np.random.default_rng(seed)
    box = GlobalModel.of(box_surface(40_000, rng), rotations=256)
    seen = box_surface(500, rng) + 0.02 * rng.standard_normal((500, 3))
    turn = Rotation.from_rotvec([1.0, 0.5, -0.3])
    result = GlobalRegistration(box).run(turn.apply(seen))
    confidence = Confidence.of(result)
    assert confidence.probability < 0.5
    assert any(text.startswith("symmetric:") for text in confidence.reasons)
    assert len(confidence.equals) > 0
    fitting = np.concatenate([result.T_model_scene[None], confidence.equals])
    turned = np.degrees((Rotation.from_matrix(fitting[:, :3, :3]) * turn).magnitude())
    assert ((turned < 5) | (turned > 175)).all()
    assert turned.max() > 175


@pytest.mark.parametrize(
    ("points", "message"),
    [
        (np.full((20, 3), np.nan), "not finite"),
        (np.arange(27.0).reshape(9, 3), "at least 10 points"),
        (np.ones((50, 3)), "lie in one place"),
    ],
)
def test_scenes_that_cannot_be_registered_are_refused(model: GlobalModel, points: FloatArray, message: str):
    with pytest.raises(ValueError, match=message):
        GlobalRegistration(model).run(points)


def test_all_points_of_a_large_scene_count(model: GlobalModel, bunny: Cloud):
    large = perturb(bunny, Perturbation(points=60_000, outliers=0, incomplete=0, noise=0.05, rotation=120, seed=2))
    found = GlobalRegistration(model).run(large.points)
    assert found.searched == 20_000
    assert score(large, found.T_model_scene).rmse < 0.01
