"""Clouds: user's units, normals, even model points, and clear refusals."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial import KDTree

from ido import Cloud, CloudError, CloudWarning, Model, clouds, poses
from ido.clouds import Frame, local_normals
from ido.types import FloatArray

POINTS = np.random.default_rng(0).normal([300, -20, 5], [40, 10, 2], (60, 3))


def test_normalised_cloud_fits_the_unit_cube_and_keeps_its_shape():
    cloud = Cloud.of(POINTS)
    low, high = cloud.points.min(axis=0), cloud.points.max(axis=0)
    np.testing.assert_allclose(low, -high, atol=1e-6)
    assert np.abs(cloud.points).max() == pytest.approx(1)
    assert cloud.points.dtype == np.float32
    np.testing.assert_allclose(cloud.frame.to_user_units(cloud.points), POINTS, atol=1e-4)
    np.testing.assert_allclose(cloud.frame.to_model_units(POINTS), cloud.points, atol=1e-6)


def test_far_from_the_origin_no_detail_is_lost():
    cloud, near = Cloud.of(POINTS + 5e6), Cloud.of(POINTS)
    np.testing.assert_allclose(cloud.points, near.points, atol=1e-6)


def test_pose_in_user_units_does_the_same_to_the_users_points():
    rng = np.random.default_rng(1)
    frame, T = Frame(np.array([4e5, -7.0, 30.0]), 37.0), poses.exp(rng.standard_normal((4, 6)))
    normalised = rng.uniform(-1, 1, (20, 3))
    in_user_units = poses.transform(frame.pose_in_user_units(T), frame.to_user_units(normalised))
    np.testing.assert_allclose(frame.to_model_units(in_user_units), poses.transform(T, normalised), atol=1e-9)
    normalise = np.diag([1 / 37.0] * 3 + [1.0])
    normalise[:3, 3] = -frame.centre / 37.0
    np.testing.assert_allclose(frame.pose_in_user_units(T), np.linalg.inv(normalise) @ T @ normalise, rtol=1e-9)


def test_model_points_are_cloud_points_spread_evenly(bunny: Cloud, full_model: Model):
    assert full_model.points.shape == full_model.normals.shape == (514, 3)
    distance, _ = KDTree(bunny.points).query(full_model.points)
    assert distance.max() < 1e-6
    gaps = KDTree(full_model.points).query(full_model.points, k=2)[0][:, 1]
    reach = KDTree(full_model.points).query(bunny.points)[0].max()
    assert reach <= gaps.min() * 1.001  # farthest-point sampling: no cloud point is farther than the smallest gap
    np.testing.assert_allclose(np.linalg.norm(full_model.normals, axis=1), 1, atol=1e-6)


def test_normals_of_a_sphere_point_outward_and_those_of_a_plane_up():
    rng = np.random.default_rng(2)
    sphere = rng.standard_normal((20_000, 3))
    sphere /= np.linalg.norm(sphere, axis=1, keepdims=True)
    model = Model.of(Cloud.of(sphere))
    assert (model.points * model.normals).sum(axis=1).min() > 0.97
    tilted = rng.uniform(-1, 1, (2000, 2)) @ np.array([[1.0, 0, 0.5], [0, 1, 0]])
    normals = Model.of(Cloud.of(tilted), orientation="up").normals
    np.testing.assert_allclose(normals, np.tile(np.array([-0.5, 0, 1]) / np.sqrt(1.25), (514, 1)), atol=1e-4)


def test_a_hint_decides_the_side_of_a_normal():
    flat = np.random.default_rng(3).uniform(-1, 1, (50, 3)) * [1, 1, 0]
    for hint in ([0.0, 0, 1], [0.0, 0, -1]):
        np.testing.assert_allclose(local_normals(flat, np.array(hint)), np.tile(hint, (50, 1)), atol=1e-12)


def test_a_flat_cloud_is_a_cloud():
    flat = POINTS * [1, 1, 0]
    assert np.ptp(Cloud.of(flat).points, axis=0)[2] == 0


@pytest.mark.parametrize(
    ("points", "message"),
    [
        (np.zeros((0, 3)), "at least 10 points; this has 0"),
        (POINTS[:9], "at least 10 points; this has 9"),
        (POINTS[:, :2], "three columns"),
        (POINTS.ravel(), "three columns"),
        (np.where(np.arange(60)[:, None] == 3, np.nan, POINTS), "1 of 60 points"),
        (np.where(np.arange(60)[:, None] < 2, np.inf, POINTS), "2 of 60 points"),
        (np.ones((60, 3)), "in one place"),
        (np.ones((60, 3)) * 1e7 + POINTS * 1e-9, "in one place"),
        (POINTS * 1e15, "beyond 1e15"),
        (np.full((60, 3), "one"), "must be numbers"),
    ],
)
def test_unusable_points_are_refused(points: FloatArray, message: str):
    with pytest.raises(CloudError, match=message):
        Cloud.of(points)


def test_a_model_needs_enough_different_points():
    with pytest.raises(CloudError, match="a model needs at least 514"):
        Model.of(Cloud.of(POINTS))
    with pytest.raises(CloudError, match="fewer than 514 different points"):
        Model.of(Cloud.of(np.tile(POINTS, (20, 1))))


def test_very_large_clouds_are_thinned_the_same_way_each_time_and_say_so(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(clouds, "LARGEST_CLOUD", 40)
    with pytest.warns(CloudWarning, match="of 60 points 40 are used"):
        first = Cloud.of(POINTS)
    with pytest.warns(CloudWarning):
        again = Cloud.of(POINTS)
    kept = first.frame.to_user_units(first.points)
    assert len(kept) == len(np.unique(kept, axis=0)) == 40
    assert KDTree(POINTS).query(kept)[0].max() < 1e-4
    np.testing.assert_array_equal(first.points, again.points)
