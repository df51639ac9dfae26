"""Perturbations: the same value gives the same scene everywhere, and neighbouring values neighbouring scenes."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import linprog
from scipy.spatial import KDTree
from scipy.spatial.transform import RigidTransform, Rotation

from ido import RANGES, Cloud, Perturbation, Scene, TrainingSettings, perturb, perturbation, poses, training
from ido.perturbation import LARGEST_SEED, OUTLIER_REACH, STRUCTURED_DEVIATION
from ido.types import FloatArray

CLEAN = Perturbation(noise=0, outliers=0, incomplete=0)

# of the bunny at the paper's defaults, seed 2021: points 0, 100 and 279, and the first three rows of T_model_scene
PINNED_POINTS = [
    [-0.1922155, -0.115551, -0.4616635],
    [-0.6119642, -0.1832664, 1.1776878],
    [-0.139791, 0.0100672, 0.6465778],
]
PINNED_POSE = [
    [0.949237228, 0.004972118, -0.3145218, -0.0412889],
    [0.262230443, 0.539732464, 0.799952537, -0.199247651],
    [0.173735085, -0.84182192, 0.511030308, -0.220444098],
]

perturbations = st.builds(
    Perturbation,
    noise=st.floats(0, 0.1),
    points=st.integers(1, 600),
    outliers=st.integers(0, 300),
    incomplete=st.floats(0, 0.7),
    rotation=st.floats(0, 180),
    translation=st.floats(0, 1),
    outlier_kind=st.sampled_from(["uniform", "structured"]),
    seed=st.integers(0, LARGEST_SEED),
)


def true_points(scene: Scene) -> FloatArray:
    return scene.points[~scene.is_outlier]


@settings(deadline=None, max_examples=30)
@given(p=perturbations)
def test_the_same_value_gives_the_same_scene(bunny: Cloud, p: Perturbation):
    first, second = perturb(bunny, p), perturb(bunny, replace(p))
    np.testing.assert_array_equal(first.points, second.points)
    np.testing.assert_array_equal(first.T_model_scene, second.T_model_scene)
    assert first.points.dtype == np.float32
    assert np.isfinite(first.points).all()
    assert first.is_outlier.sum() == p.outliers
    assert not first.is_outlier[: len(first.points) - p.outliers].any()


def test_another_seed_gives_another_scene(bunny: Cloud):
    first, second = perturb(bunny, Perturbation(seed=1)), perturb(bunny, Perturbation(seed=2))
    assert not np.isclose(first.points, second.points).all(axis=1).any()
    assert not np.allclose(first.T_model_scene, second.T_model_scene)


@pytest.mark.parametrize(
    ("kind", "outliers"),
    [
        ("uniform", [[1.4515978, -0.356001, 0.7556755], [-1.3198342, 0.9321035, -0.6858077]]),
        ("structured", [[0.8547375, -0.5207546, 0.7303147], [1.473482, -0.2164115, 0.8061888]]),
    ],
)
def test_the_random_draw_is_the_one_that_was_published(bunny: Cloud, kind: Any, outliers: list[list[float]]):
    scene = perturb(bunny, Perturbation(seed=2021, outlier_kind=kind))
    assert len(scene.points) == 580
    np.testing.assert_allclose(scene.points[[0, 100, 279]], PINNED_POINTS, atol=1e-6)
    np.testing.assert_allclose(scene.points[[280, 579]], outliers, atol=1e-6)
    np.testing.assert_allclose(scene.T_model_scene[:3], PINNED_POSE, atol=1e-6)


def test_the_noise_slider_scales_the_same_noise(bunny: Cloud):
    clean, little, much = (
        true_points(perturb(bunny, replace(CLEAN, noise=noise))).astype(float) for noise in (0, 0.02, 0.1)
    )
    np.testing.assert_allclose(much - clean, 5 * (little - clean), atol=2e-6)
    assert (much - clean).std() == pytest.approx(0.1, rel=0.1)


@pytest.mark.parametrize("kind", ["uniform", "structured"])
def test_more_outliers_keep_the_earlier_ones(bunny: Cloud, kind: Any):
    few = perturb(bunny, Perturbation(outliers=100, outlier_kind=kind))
    many = perturb(bunny, Perturbation(outliers=250, outlier_kind=kind))
    np.testing.assert_array_equal(few.points, many.points[:-150])


def test_more_points_keep_the_earlier_ones(bunny: Cloud):
    few = perturb(bunny, Perturbation(points=200, incomplete=0, outliers=0))
    many = perturb(bunny, Perturbation(points=900, incomplete=0, outliers=0))
    np.testing.assert_array_equal(few.points, many.points[:200])


def test_more_missing_removes_further_points(bunny: Cloud):
    little, much = (
        {tuple(p) for p in true_points(perturb(bunny, Perturbation(incomplete=share)))} for share in (0.1, 0.5)
    )
    assert much < little


@pytest.mark.parametrize("share", [0.0, 0.1, 0.333, 0.7])
def test_incompleteness_removes_its_share_on_one_side_of_a_plane(bunny: Cloud, share: float):
    whole = true_points(perturb(bunny, Perturbation(incomplete=0)))
    kept = true_points(perturb(bunny, Perturbation(incomplete=share)))
    assert len(kept) == 400 - round(share * 400)
    is_kept = (whole[:, None] == kept[None]).all(axis=2).any(axis=1)
    assert is_kept.sum() == len(kept)
    # a plane n·s = b with n·s <= b - 1 for all kept points and n·s >= b + 1 for all removed ones
    side = np.where(is_kept, 1.0, -1.0)
    plane = linprog(
        np.zeros(4),
        A_ub=side[:, None] * np.column_stack([whole, -np.ones(400)]),
        b_ub=-np.ones(400),
        bounds=(None, None),
    )
    assert plane.status == 0


def test_at_least_one_true_point_is_left(bunny: Cloud):
    assert len(true_points(perturb(bunny, Perturbation(points=1, incomplete=0.7)))) == 1


@settings(deadline=None, max_examples=30)
@given(angle=st.floats(0, 180), length=st.floats(0, 1), seed=st.integers(0, 10**6))
def test_rotation_has_the_given_angle_and_translation_the_given_length(
    bunny: Cloud, angle: float, length: float, seed: int
):
    p = Perturbation(rotation=angle, translation=length, points=1, seed=seed)
    T_scene_model = np.linalg.inv(perturb(bunny, p).T_model_scene)
    assert np.rad2deg(Rotation.from_matrix(T_scene_model[:3, :3]).magnitude()) == pytest.approx(angle, abs=1e-5)
    assert np.linalg.norm(T_scene_model[:3, 3]) == pytest.approx(length, abs=1e-9)


def test_sliders_of_the_pose_keep_axis_and_direction(bunny: Cloud):
    poses_of = [
        perturb(bunny, Perturbation(rotation=a, translation=t)).T_model_scene for a, t in ((20, 0.1), (80, 0.9))
    ]
    little, much = (np.linalg.inv(T) for T in poses_of)
    turns = [Rotation.from_matrix(T[:3, :3]).as_rotvec() for T in (little, much)]
    np.testing.assert_allclose(turns[1], 4 * turns[0], atol=1e-9)
    np.testing.assert_allclose(much[:3, 3], 9 * little[:3, 3], atol=1e-9)


def test_axes_and_directions_favour_no_side(bunny: Cloud):
    scenes = [perturb(bunny, Perturbation(points=1, outliers=0, seed=seed)) for seed in range(600)]
    turns = np.array([Rotation.from_matrix(scene.T_model_scene[:3, :3]).as_rotvec() for scene in scenes])
    for vectors in (turns, np.array([scene.T_model_scene[:3, 3] for scene in scenes])):
        units = vectors / np.linalg.norm(vectors, axis=1, keepdims=True)
        assert np.abs(units.mean(axis=0)).max() < 0.08  # the standard error is 0.024
        np.testing.assert_allclose(units.T @ units / 600, np.eye(3) / 3, atol=0.05)


@settings(deadline=None, max_examples=20)
@given(p=perturbations)
def test_the_true_pose_brings_the_points_back_onto_the_cloud(bunny: Cloud, p: Perturbation):
    scene = perturb(bunny, replace(p, noise=0))
    distance, _ = KDTree(bunny.points).query(poses.transform(scene.T_model_scene, true_points(scene)))
    assert distance.max() < 1e-6


def test_points_are_drawn_from_the_whole_cloud(bunny: Cloud):
    scene = perturb(bunny, replace(CLEAN, points=100_000, rotation=0, translation=0))
    drawn = KDTree(bunny.points).query(scene.points)[1]
    assert len(np.unique(drawn)) / len(bunny.points) == pytest.approx(
        1 - np.exp(-100_000 / len(bunny.points)), abs=0.01
    )


def test_uniform_outliers_fill_their_cube(bunny: Cloud):
    outliers = perturb(bunny, Perturbation(points=1, outliers=5000)).points[1:]
    assert np.abs(outliers).max() <= OUTLIER_REACH
    np.testing.assert_allclose(outliers.mean(axis=0), 0, atol=0.05)
    np.testing.assert_allclose(outliers.var(axis=0), (2 * OUTLIER_REACH) ** 2 / 12, rtol=0.05)


@pytest.mark.parametrize("seed", range(5))
def test_structured_outliers_are_one_ball(bunny: Cloud, seed: int):
    p = Perturbation(points=1, outliers=5000, outlier_kind="structured", seed=seed)
    outliers = perturb(bunny, p).points[1:]
    deviation = outliers.std(axis=0)
    assert STRUCTURED_DEVIATION[0] * 0.95 < deviation.mean() < STRUCTURED_DEVIATION[1] * 1.05
    np.testing.assert_allclose(deviation, deviation.mean(), rtol=0.05)
    assert np.abs(outliers.mean(axis=0)).max() < OUTLIER_REACH + 0.02


@pytest.mark.parametrize(
    ("values", "message"),
    [
        *(({name: r.limit * 1.01 + 1}, f"{name} must lie between") for name, r in RANGES.items()),
        *(({name: -1}, f"{name} must lie between") for name in RANGES),
        *(({name: float("nan")}, f"{name} must lie between") for name in RANGES),
        *(({name: float("inf")}, f"{name} must lie between") for name in RANGES),
        ({"points": 0}, "points must lie between 1 and"),
        ({"points": 400.0}, "points must be a whole number"),
        ({"outliers": 0.5}, "outliers must be a whole number"),
        ({"seed": 1.5}, "seed must be a whole number"),
        ({"seed": -1}, "seed must lie between 0 and 4294967295"),
        ({"outlier_kind": "spiral"}, "outlier_kind must be one of"),
    ],
)
def test_values_out_of_range_are_refused(values: dict[str, Any], message: str):
    with pytest.raises(ValueError, match=message):
        Perturbation(**values)


def test_the_order_of_the_table_of_ranges_decides_nothing(bunny: Cloud, monkeypatch: pytest.MonkeyPatch):
    def drawn() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        scenes, x_true = training.training_scenes(bunny, TrainingSettings(samples=3))
        return perturb(bunny, Perturbation(seed=5)).points, scenes.points, x_true

    before = drawn()
    np.testing.assert_allclose(before[0][0], [0.2507, 0.2261, -0.0913], atol=1e-4)
    np.testing.assert_allclose(before[2][0], [0.0895, 0.1348, 0.2367, -1.207, 0.009, -0.4182], atol=1e-4)
    turned = dict(reversed(RANGES.items()))
    for module in (perturbation, training):
        monkeypatch.setattr(module, "RANGES", turned)
    for old, new in zip(before, drawn(), strict=True):
        np.testing.assert_array_equal(old, new)


# Moved by hand


def test_a_moved_scene_keeps_its_points_apart_and_its_true_place(bunny: Cloud):
    scene = perturb(bunny, Perturbation(seed=6))
    T = poses.exp(np.array([0.4, -0.2, 0.1, 0.5, -1.0, 2.0]))
    moved = scene.moved(T)
    np.testing.assert_allclose(moved.points, RigidTransform.from_matrix(T).apply(scene.points), atol=1e-6)
    assert moved.points.dtype == np.float32
    np.testing.assert_array_equal(moved.is_outlier, scene.is_outlier)
    before, after = (poses.transform(each.T_model_scene, each.points) for each in (scene, moved))
    np.testing.assert_allclose(after, before, atol=1e-6)


def test_a_scene_moved_there_and_back_is_the_same(bunny: Cloud):
    scene = perturb(bunny, Perturbation())
    T = poses.exp(np.array([0.3, 0.0, -0.5, 1.0, 1.0, 0.0]))
    back = scene.moved(T).moved(poses.invert(T))
    np.testing.assert_allclose(back.points, scene.points, atol=1e-6)
    np.testing.assert_allclose(back.T_model_scene, scene.T_model_scene, atol=1e-12)


@pytest.mark.parametrize("seed", range(3))
def test_the_start_pose_is_the_inverse_of_the_true_one(bunny: Cloud, seed: int):
    p = Perturbation(seed=seed, rotation=110, translation=0.6)
    T = perturbation.start_pose(p)
    np.testing.assert_allclose(T @ perturb(bunny, p).T_model_scene, np.eye(4), atol=1e-9)
    assert Rotation.from_matrix(T[:3, :3]).magnitude() == pytest.approx(np.deg2rad(110))
    assert np.linalg.norm(T[:3, 3]) == pytest.approx(0.6)
