"""Figures of quality: what they measure, and when they raise a doubt."""

from __future__ import annotations

import numpy as np
import pytest

from ido import Cloud, Maps, Model, Perturbation, perturb, poses, register, shipped_maps
from ido.quality import POOR_BOTH, Quality, fit_of, quality, symmetry
from ido.types import FloatArray

EASY = Perturbation(noise=0.01, outliers=0, incomplete=0, points=1500, rotation=30, translation=0.1)


@pytest.fixture(scope="module")
def maps() -> Maps:
    return shipped_maps("bunny", "triple-binary")


def judged(maps: Maps, scene: FloatArray) -> Quality:
    """Of the pose that the maps find for a scene in model units."""
    T = register(maps, scene).T_model_scene[-1]
    return quality(maps, maps.frame.to_user_units(scene), maps.frame.pose_in_user_units(T))


def doubts(maps: Maps, scene: FloatArray) -> str:
    return "; ".join(judged(maps, scene).warnings)


@pytest.fixture
def scene(bunny: Cloud) -> FloatArray:
    return perturb(bunny, EASY).points.astype(np.float64)


@pytest.mark.parametrize("seed", range(5))
def test_right_poses_raise_no_doubt_and_wrong_ones_do(maps: Maps, bunny: Cloud, seed: int):
    given = perturb(bunny, Perturbation(seed=seed))
    points = maps.frame.to_user_units(given.points)
    right = quality(maps, points, maps.frame.pose_in_user_units(given.T_model_scene))
    assert right.warnings == ()
    assert min(right.fit.near_share, right.fit.covered_share) > POOR_BOTH
    turned = poses.exp(np.array([0, 0, 0, 0, 2.0, 0])) @ given.T_model_scene
    assert any("fit is poor" in text for text in quality(maps, points, maps.frame.pose_in_user_units(turned)).warnings)


def test_size_and_spread_follow_the_cloud(maps: Maps, scene: FloatArray):
    one, two = (judged(maps, scene * size).extent for size in (1, 2))
    assert one.size_ratio == pytest.approx(1, abs=0.05)
    assert two.size_ratio == pytest.approx(2 * one.size_ratio)
    np.testing.assert_allclose(two.spread, 2 * np.array(one.spread))
    assert list(one.spread) == sorted(one.spread, reverse=True)


def test_nothing_near_the_model_has_no_distance(maps: Maps, scene: FloatArray):
    fit = fit_of(maps, scene + 10)
    assert (fit.near_share, fit.covered_share) == (0, 0)
    assert np.isnan(fit.near_rmse)


def test_rounded_coordinates_are_told_with_their_step(maps: Maps, scene: FloatArray):
    step = 0.05 * maps.frame.scale
    original = maps.frame.to_user_units(scene)
    rounded = quality(maps, np.round(original / step) * step, np.eye(4))
    assert rounded.extent.step == pytest.approx(step)
    assert any("rounded to" in text for text in rounded.warnings)
    assert quality(maps, original, np.eye(4)).extent.step < step / 100
    of_map = (original + 6e6 * maps.frame.scale).astype(np.float32).astype(np.float64) - 6e6 * maps.frame.scale
    assert any("rounded to" in text for text in quality(maps, of_map, np.eye(4)).warnings)


def test_points_that_crowd_are_told(maps: Maps, scene: FloatArray):
    patch = scene[np.linalg.norm(scene - scene[0], axis=1) < 0.1]
    crowded = np.concatenate([scene, np.repeat(patch, 100, axis=0)])
    assert "crowd in one place" in doubts(maps, crowded)
    assert "crowd" not in doubts(maps, scene)


@pytest.mark.parametrize(
    ("axes", "message"),
    [((1, 1, 0.001), "in a plane"), ((1, 0.001, 0.001), "on a line"), ((-1, 1, 1), "mirrored along x")],
)
def test_what_cannot_be_known_is_told(maps: Maps, scene: FloatArray, axes: tuple[float, ...], message: str):
    assert message in doubts(maps, scene * axes)


def sphere(n: int = 5000) -> FloatArray:
    points = np.random.default_rng(0).normal(size=(n, 3))
    return points / np.linalg.norm(points, axis=1, keepdims=True)


def box() -> FloatArray:
    points = sphere()
    return points / np.abs(points).max(axis=1, keepdims=True) * [1, 0.6, 0.3]


def cylinder() -> FloatArray:
    points = sphere()
    points[:, :2] *= 0.4 / np.linalg.norm(points[:, :2], axis=1, keepdims=True)
    return points


@pytest.mark.parametrize(("shape", "angle"), [(sphere(), 60), (cylinder(), 60), (box(), 180)])
def test_a_symmetric_model_is_seen(shape: FloatArray, angle: int):
    assert symmetry(Model.of(Cloud.of(shape)).points.astype(np.float64)) == angle


def test_the_bunny_is_not_symmetric(full_model: Model):
    assert symmetry(full_model.points.astype(np.float64)) is None
