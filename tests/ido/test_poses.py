"""Poses against SciPy's matrix exponential, and the compiled one against both."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import expm
from scipy.spatial.transform import Rotation

from ido import kernels, poses
from ido.types import FloatArray

NEAR_ZERO = (0.0, 1e-300, 1e-12, 1e-9, 1e-7, 1e-5, 0.99e-4, 1.01e-4, 1e-3)
NEAR_PI = tuple(np.pi + d for d in (-1e-3, -1e-6, -1e-9, -1e-12, 0.0, 1e-12, 1e-9, 1e-6, 1e-3))


def twist(x: FloatArray) -> FloatArray:
    """ξ^ of x = [ρ, φ], shape (4, 4)."""
    (a, b, c), matrix = x[3:], np.zeros((4, 4))
    matrix[:3, :3] = [[0, -c, b], [c, 0, -a], [-b, a, 0]]
    matrix[:3, 3] = x[:3]
    return matrix


def samples(angles: tuple[float, ...], seed: int = 0) -> FloatArray:
    """Random x, five for each rotation angle."""
    rng = np.random.default_rng(seed)
    axes = rng.standard_normal((len(angles), 5, 3))
    axes *= np.array(angles)[:, None, None] / np.linalg.norm(axes, axis=-1, keepdims=True)
    return np.concatenate([rng.standard_normal(axes.shape), axes], axis=-1).reshape(-1, 6)


ALL = np.concatenate([samples(NEAR_ZERO), samples(NEAR_PI), samples((0.1, 1.0, 2.0, 3.0, 4.0, 6.0, 9.0))])

coordinates = st.lists(st.floats(-3, 3), min_size=6, max_size=6).map(np.array)


@pytest.mark.parametrize("pose_of", [poses.exp, kernels.pose_of])
def test_exp_is_the_matrix_exponential_of_the_twist(pose_of):
    for x in ALL:
        np.testing.assert_allclose(pose_of(x), expm(twist(x)), atol=1e-10)


@settings(deadline=None, max_examples=50)
@given(coordinates)
def test_compiled_pose_equals_exp(x: FloatArray):
    np.testing.assert_allclose(kernels.pose_of(x), poses.exp(x), atol=1e-12)


def test_compiled_pose_equals_exp_for_tiny_angles_and_near_pi():
    for x in ALL:
        np.testing.assert_allclose(kernels.pose_of(x), poses.exp(x), atol=1e-12)


def test_log_undoes_exp_below_pi():
    x = np.concatenate([samples(NEAR_ZERO), samples((0.5, 2.0, 3.0, np.pi - 1e-3, np.pi - 1e-6))])
    np.testing.assert_allclose(poses.log(poses.exp(x)), x, atol=1e-9)


def test_exp_undoes_log_at_any_angle():
    T = poses.exp(ALL)
    np.testing.assert_allclose(poses.exp(poses.log(T)), T, atol=1e-9)


@settings(deadline=None, max_examples=50)
@given(coordinates)
def test_a_pose_is_rigid(x: FloatArray):
    T = poses.exp(x)
    np.testing.assert_allclose(T[:3, :3] @ T[:3, :3].T, np.eye(3), atol=1e-12)
    assert np.linalg.det(T[:3, :3]) == pytest.approx(1)
    np.testing.assert_array_equal(T[3], [0, 0, 0, 1])


def test_batch_axes():
    x = samples((0.0, 1e-6, 1.0, np.pi)).reshape(4, 5, 6)
    T, points = poses.exp(x), np.random.default_rng(1).standard_normal((4, 5, 7, 3))
    assert T.shape == (4, 5, 4, 4)
    moved, inverse, coords = poses.transform(T, points), poses.invert(T), poses.log(T)
    for i in np.ndindex(4, 5):
        np.testing.assert_allclose(T[i], poses.exp(x[i]), atol=1e-15)
        np.testing.assert_allclose(moved[i], poses.transform(T[i], points[i]), atol=1e-15)
        np.testing.assert_allclose(inverse[i], np.linalg.inv(T[i]), atol=1e-12)
        np.testing.assert_allclose(coords[i], poses.log(T[i]), atol=1e-12)


def test_transform_is_rotation_then_translation():
    T = np.array([[0.0, -1, 0, 10], [1, 0, 0, 20], [0, 0, 1, 30], [0, 0, 0, 1]])
    np.testing.assert_allclose(poses.transform(T, np.array([[1.0, 2, 3]])), [[8, 21, 33]])


SHARES = (0.0, 0.2, 0.5, 0.9, 1.0)


def test_between_begins_and_ends_exactly():
    for start, end in zip(poses.exp(samples((0.0, 0.4, 3.0))), poses.exp(samples((2.0, 0.4, 1.0), 1)), strict=True):
        np.testing.assert_allclose(poses.between(start, end, 0.0), start, atol=1e-12)
        np.testing.assert_allclose(poses.between(start, end, 1.0), end, atol=1e-12)
        np.testing.assert_allclose(poses.between(start, start, 0.3), start, atol=1e-12)


def test_between_turns_evenly_about_one_axis_and_shifts_along_a_line():
    """Against the matrix exponential of a share of the turn from one to the other."""
    for start, end in zip(poses.exp(samples((0.1, 1.0, 2.0))), poses.exp(samples((0.3, 1.5, 0.0), 1)), strict=True):
        φ = Rotation.from_matrix(end[:3, :3] @ start[:3, :3].T).as_rotvec()
        turn = twist(np.concatenate([np.zeros(3), φ]))[:3, :3]
        for share in SHARES:
            T = poses.between(start, end, share)
            np.testing.assert_allclose(T[:3, :3], expm(share * turn) @ start[:3, :3], atol=1e-9)
            np.testing.assert_allclose(T[:3, 3], start[:3, 3] + share * (end - start)[:3, 3], atol=1e-12)
            np.testing.assert_array_equal(T[3], [0, 0, 0, 1])


def test_one_pose_moves_many_clouds_and_many_poses_one_cloud():
    T, points = poses.exp(samples((0.5,))), np.random.default_rng(2).standard_normal((3, 4, 3))
    assert poses.transform(T[0], points).shape == (3, 4, 3)
    assert poses.transform(T, points[0]).shape == (5, 4, 3)
