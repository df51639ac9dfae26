"""Scores against hand computation and SciPy."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform, Rotation

from ido import Cloud, Perturbation, Scene, perturb, poses, score
from ido.scores import registered


def shifted(T: np.ndarray, by: float) -> np.ndarray:
    moved = T.copy()
    moved[:3, 3] += np.array([2, -1, 2]) / 3 * by
    return moved


def test_the_true_pose_is_perfect(bunny: Cloud):
    scene = perturb(bunny, Perturbation())
    scores = score(scene, scene.T_model_scene)
    assert (scores.accuracy, scores.rmse, scores.translation) == (1, 0, 0)
    assert scores.rotation == pytest.approx(0, abs=1e-6)


@pytest.mark.parametrize(("by", "accuracy"), [(0.05, 1), (0.0999, 1), (0.1001, 0), (3.0, 0)])
def test_a_shift_counts_as_far_as_it_goes(bunny: Cloud, by: float, accuracy: float):
    scene = perturb(bunny, Perturbation())
    scores = score(scene, shifted(scene.T_model_scene, by))
    assert scores.accuracy == accuracy
    assert scores.rmse == pytest.approx(by)
    assert scores.translation == pytest.approx(by)
    assert scores.rotation == pytest.approx(0, abs=1e-6)


def test_hand_computed_scene():
    points = np.array([[0.0, 0, 0], [0.05, 0, 0], [1, 0, 0], [0, 0, 1], [9, 9, 9]], dtype=np.float32)
    scene = Scene(points, np.array([False, False, False, False, True]), np.eye(4))
    quarter_turn = poses.exp(np.array([0, 0, 0, 0, 0, np.pi / 2]))  # about z: the third point moves by √2
    scores = score(scene, quarter_turn)
    assert scores.accuracy == pytest.approx(3 / 4)
    assert scores.rmse == pytest.approx(np.sqrt((0.05**2 * 2 + 2) / 4))
    assert scores.rotation == pytest.approx(90)
    assert scores.translation == pytest.approx(0)


def test_errors_against_scipy(bunny: Cloud):
    rng = np.random.default_rng(0)
    for seed in range(10):
        scene = perturb(bunny, Perturbation(seed=seed))
        T = poses.exp(rng.normal(size=6))
        true, estimate = RigidTransform.from_matrix(scene.T_model_scene), RigidTransform.from_matrix(T)
        points = scene.points[~scene.is_outlier].astype(float)
        distance = np.linalg.norm(estimate.apply(points) - true.apply(points), axis=1)
        scores = score(scene, T)
        assert scores.accuracy == pytest.approx((distance < 0.1).mean())
        assert scores.rmse == pytest.approx(np.sqrt((distance**2).mean()))
        angle = Rotation.magnitude(estimate.rotation * true.rotation.inv())
        assert scores.rotation == pytest.approx(np.rad2deg(angle))
        assert scores.translation == pytest.approx(np.linalg.norm(estimate.translation - true.translation))


def test_the_share_of_registered_points_is_point_acc(bunny: Cloud):
    scene = perturb(bunny, Perturbation(seed=4))
    nudges = np.random.default_rng(2).normal(size=(3, 5, 6)) * 0.08
    T = scene.T_model_scene @ poses.exp(nudges)
    arrived = registered(scene, T)
    assert arrived.shape == (3, 5, (~scene.is_outlier).sum())
    np.testing.assert_array_equal(arrived.mean(axis=-1), score(scene, T).accuracy)
    assert 0 < arrived.mean() < 1


def test_a_point_is_registered_within_a_tenth_of_its_true_place(bunny: Cloud):
    scene = perturb(bunny, Perturbation())
    T = scene.T_model_scene @ poses.exp(np.array([0.03, 0, 0, 0, 0, 0.09]))
    points = scene.points[~scene.is_outlier].astype(float)
    true, moved = (RigidTransform.from_matrix(each).apply(points) for each in (scene.T_model_scene, T))
    np.testing.assert_array_equal(registered(scene, T), np.linalg.norm(moved - true, axis=1) < 0.1)


def test_outliers_do_not_count(bunny: Cloud):
    with_outliers = perturb(bunny, Perturbation(outliers=300))
    without = perturb(bunny, Perturbation(outliers=0))
    T = shifted(with_outliers.T_model_scene, 0.07) @ poses.exp(np.full(6, 0.05))
    assert score(with_outliers, T).rmse == score(without, T).rmse
    assert score(with_outliers, T).accuracy == score(without, T).accuracy


def test_many_poses_at_once(bunny: Cloud):
    scene = perturb(bunny, Perturbation())
    T = poses.exp(np.random.default_rng(1).normal(size=(4, 3, 6)) * 0.2)
    many = score(scene, T)
    for i in np.ndindex(4, 3):
        one = score(scene, T[i])
        for name in ("accuracy", "rmse", "rotation", "translation"):
            assert getattr(many, name)[i] == pytest.approx(getattr(one, name))
