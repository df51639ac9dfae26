"""The picture of the model: a surface that lies on the cloud, or shaded points of it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import trimesh
from scipy.spatial import KDTree

from ido import Cloud, shipped_cloud
from ido.shipped import shipped_surface
from ido_viz.core.geometry import upright
from ido_viz.core.library import Subject, shipped_library
from ido_viz.core.model_picture import MOST_POINTS, ModelPicture, picture_of

CLOSE = 0.03  # model units; samples of the surface lie up to 0.02 apart


def subject_of(points: np.ndarray, up: tuple[float, float, float] = (0.0, 0.0, 1.0)) -> Subject:
    """A shape without maps or surface, in the units that it comes in."""
    cloud = replace(shipped_cloud("bunny"), points=points.astype(np.float32))
    return Subject("a shape", lambda: cloud, {}, up)


def sphere(count: int) -> np.ndarray:
    directions = np.random.default_rng(3).standard_normal((count, 3))
    return directions / np.linalg.norm(directions, axis=1, keepdims=True)


@pytest.fixture(scope="module")
def bunny_picture() -> ModelPicture:
    return picture_of(shipped_library().subject("bunny"))


def test_the_bunny_s_surface_lies_on_its_cloud(bunny_picture: ModelPicture, bunny: Cloud):
    surface = trimesh.Trimesh(bunny_picture.vertices, bunny_picture.faces, process=False)
    sampled = trimesh.sample.sample_surface(surface, 50_000, seed=0)[0]
    assert KDTree(sampled).query(bunny.points)[0].max() < CLOSE
    assert KDTree(bunny.points).query(sampled)[0].max() < CLOSE
    np.testing.assert_allclose(surface.bounds[0], bunny.points.min(axis=0), atol=CLOSE)
    np.testing.assert_allclose(surface.bounds[1], bunny.points.max(axis=0), atol=CLOSE)


def test_the_bunny_s_surface_is_seen_from_outside(bunny_picture: ModelPicture):
    surface = trimesh.Trimesh(bunny_picture.vertices, bunny_picture.faces, process=False)
    assert 1000 < len(surface.faces) <= 6000
    assert bunny_picture.faces.max() == len(bunny_picture.vertices) - 1
    assert surface.volume > 0  # of faces that look outwards


def test_a_shape_without_a_surface_is_drawn_as_points_of_its_cloud():
    assert shipped_surface("urban") is None
    picture, cloud = picture_of(shipped_library().subject("urban")), shipped_cloud("urban")
    assert len(picture.faces) == 0
    assert len(picture.vertices) == len(picture.shades) == min(MOST_POINTS, len(cloud.points))
    assert {tuple(point) for point in picture.vertices.tolist()} <= {tuple(point) for point in cloud.points.tolist()}


@pytest.mark.parametrize("count", [500, MOST_POINTS + 1])
def test_a_small_cloud_is_drawn_whole_and_a_large_one_in_part(count: int):
    picture = picture_of(subject_of(sphere(count)))
    assert len(picture.vertices) == min(count, MOST_POINTS)
    assert len(np.unique(picture.vertices, axis=0)) == len(picture.vertices)


def test_the_same_shape_has_the_same_picture():
    one, other = (picture_of(subject_of(sphere(MOST_POINTS + 500))) for _ in range(2))
    assert one is not other
    np.testing.assert_array_equal(one.vertices, other.vertices)
    np.testing.assert_array_equal(one.shades, other.shades)


@pytest.mark.parametrize("up", [(0.0, 0.0, 1.0), (0.0, 1.0, 0.0)])
def test_light_falls_from_the_left_the_front_and_above_whichever_way_is_up(up: tuple[float, float, float]):
    picture = picture_of(subject_of(sphere(4000), up))
    seen = upright(up).apply(picture.vertices)  # as it stands on the page
    upper = seen[:, 2] > 0.3  # where the normals, which look up, look outwards
    light = np.array([-0.4, -0.6, 0.7]) / np.sqrt(0.4**2 + 0.6**2 + 0.7**2)
    expected = 0.5 + 0.5 * seen[upper] @ light
    np.testing.assert_allclose(picture.shades[upper], expected, atol=0.1)
    assert (picture.shades >= -1e-6).all() and (picture.shades <= 1 + 1e-6).all()
