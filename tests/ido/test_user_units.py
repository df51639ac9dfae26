"""Registering a cloud in the user's own units."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from ido import Cloud, CloudError, Maps, Perturbation, perturb, poses, register
from ido.clouds import Frame
from ido.types import FloatArray
from ido.user_units import REGISTERED_POINTS, cloud_of_maps, doubts, register_original, scene_at_start

FRAME = Frame(np.array([4e5, -30.0, 12.0]), 37.0)


@pytest.fixture
def maps(small_maps: Maps) -> Maps:
    """The small maps as if trained on a cloud in other units."""
    return replace(small_maps, frame=FRAME)


@pytest.fixture
def scene(bunny: Cloud) -> FloatArray:
    """An easy scene, model units."""
    p = Perturbation(noise=0, outliers=0, incomplete=0, rotation=20, translation=0.1)
    return perturb(bunny, p).points.astype(np.float64)


def test_the_pose_moves_the_users_points_as_the_walk_moves_them(maps: Maps, scene: FloatArray):
    T, track = register_original(maps, FRAME.to_user_units(scene), max_iterations=20)
    walk = register(maps, scene, max_iterations=20)
    np.testing.assert_allclose(track.x, walk.x, atol=1e-4)
    moved = poses.transform(T, FRAME.to_user_units(scene))
    np.testing.assert_allclose(FRAME.to_model_units(moved), poses.transform(walk.T_model_scene[-1], scene), atol=1e-4)


def test_from_the_centre_a_far_cloud_ends_where_a_near_one_does(maps: Maps, scene: FloatArray):
    shift = np.array([5000.0, -8000.0, 3.0])
    ends = []
    for original in (FRAME.to_user_units(scene), FRAME.to_user_units(scene) + shift):
        T, _ = register_original(maps, original, start="centre", max_iterations=20)
        ends.append(poses.transform(T, original))
    np.testing.assert_allclose(ends[0], ends[1], atol=37 * 1e-4)


def test_the_centre_start_puts_the_bounding_box_on_the_model(maps: Maps, scene: FloatArray):
    original = FRAME.to_user_units(scene) + 1000
    at_start, T_start = scene_at_start(maps, original, "centre")
    np.testing.assert_allclose(at_start.min(axis=0), -at_start.max(axis=0), atol=1e-9)
    np.testing.assert_allclose(poses.transform(T_start, FRAME.to_model_units(original)), at_start, atol=1e-9)
    here, identity = scene_at_start(maps, original, "here")
    np.testing.assert_allclose(here, FRAME.to_model_units(original))
    np.testing.assert_array_equal(identity, np.eye(4))


def test_dense_clouds_are_registered_by_a_subset_always_the_same(maps: Maps, bunny: Cloud):
    dense = FRAME.to_user_units(bunny.points)
    first, again = (scene_at_start(maps, dense, "here")[0] for _ in range(2))
    assert len(np.unique(first, axis=0)) == REGISTERED_POINTS
    np.testing.assert_array_equal(first, again)


def test_an_ordinary_scene_raises_no_doubts(maps: Maps, bunny: Cloud):
    for seed in range(5):
        original = FRAME.to_user_units(perturb(bunny, Perturbation(seed=seed)).points)
        assert doubts(maps, original, "here") == doubts(maps, original, "centre") == []


def test_a_far_cloud_is_advised_to_start_from_the_centre(maps: Maps, scene: FloatArray):
    far = FRAME.to_user_units(scene) + 500
    said = "; ".join(doubts(maps, far, "here"))
    assert "0% of the points" in said
    assert "±55.5 in your units" in said
    assert "see nothing" in said
    assert "--start centre" in said
    assert doubts(maps, far, "centre") == []


@pytest.mark.parametrize("factor", [1000.0, 0.001])
def test_other_units_are_suspected(maps: Maps, scene: FloatArray, factor: float):
    said = "; ".join(doubts(maps, FRAME.to_user_units(scene * factor), "centre"))
    assert "times as large as the model; is it in the units" in said
    assert "--start" not in said


def test_a_cloud_of_the_maps_is_recognised(maps: Maps, bunny: Cloud):
    original = FRAME.to_user_units(bunny.points)
    cloud = cloud_of_maps(maps, original)
    np.testing.assert_allclose(cloud.points, bunny.points, atol=1e-5)
    assert cloud.frame is FRAME
    for other in (original * 2, original + 20, bunny.points):
        with pytest.raises(CloudError, match="another size or in another place"):
            cloud_of_maps(maps, other)
