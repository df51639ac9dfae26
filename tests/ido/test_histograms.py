"""Histograms: the compiled loops against their NumPy definition, and what must not change a histogram."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from ido import (
    HISTOGRAMS,
    AsPrinted,
    Block,
    Cloud,
    FrontBack,
    Histogram,
    Model,
    Perturbation,
    SceneBatch,
    TripleBinary,
    perturb,
    poses,
)
from ido.blocks import SIGMA2, azimuth, elevation
from ido.types import FloatArray

TOLERANCE = 1e-5
"""Largest error of a compiled block, relative to the block's length."""

ALL = pytest.mark.parametrize("kind", HISTOGRAMS.values(), ids=HISTOGRAMS.keys())
PAPER = pytest.mark.parametrize("kind", [FrontBack, TripleBinary, AsPrinted], ids=lambda kind: kind.name)


def scene_of(cloud: Cloud, seed: int, **values: float) -> FloatArray:
    return perturb(cloud, replace(Perturbation(), seed=seed, **values)).points


def without_ties(points: FloatArray, x: FloatArray, model: Model) -> FloatArray:
    """The points but for the few in the tangent plane of a model point, whose side float32 cannot tell."""
    moved = poses.transform(poses.exp(x), points)
    offset = moved[None] - model.points[:, None].astype(np.float64)
    height = (offset * model.normals[:, None]).sum(axis=-1)
    near = (offset**2).sum(axis=-1) < 0.5
    return points[~((np.abs(height) < 3e-6) & near).any(axis=0)]


def random_x(rng: np.random.Generator, angle: float | None = None) -> FloatArray:
    x = rng.normal(size=6) * [0.2, 0.2, 0.2, 1, 1, 1]
    if angle is not None:
        x[3:] *= angle / np.linalg.norm(x[3:])
    return x


def assert_compiled_equals_definition(histogram: Histogram, points: FloatArray, x: FloatArray) -> None:
    points = without_ties(points, x, histogram.model)
    defined = histogram.describe(poses.transform(poses.exp(x), points)).reshape(len(histogram.blocks), -1)
    compiled = histogram(points, x)
    assert compiled.dtype == np.float32
    assert compiled.shape == (histogram.n_bins,)
    error = np.linalg.norm(compiled.reshape(defined.shape) - defined, axis=1)
    assert (error <= TOLERANCE * np.linalg.norm(defined, axis=1)).all()


@ALL
def test_compiled_equals_definition_on_many_scenes(kind: type[Histogram], bunny: Cloud, full_model: Model):
    histogram, rng = kind(full_model), np.random.default_rng(0)
    for seed in range(12):
        points = scene_of(bunny, seed, noise=rng.uniform(0, 0.1), outliers=int(rng.integers(0, 600)))
        assert_compiled_equals_definition(histogram, points, random_x(rng))


@ALL
@pytest.mark.parametrize("n_points", [1, 2, 15, 17, 4000])
def test_compiled_equals_definition_on_scenes_of_any_size(
    kind: type[Histogram], n_points: int, bunny: Cloud, full_model: Model
):
    points = scene_of(bunny, 1, points=n_points, incomplete=0, outliers=0, noise=0.01)
    assert_compiled_equals_definition(kind(full_model), points, np.zeros(6))


@ALL
@pytest.mark.parametrize("n_model", [1, 2, 15, 16, 17, 64, 65, 130])
def test_compiled_equals_definition_for_models_of_any_size(
    kind: type[Histogram], n_model: int, bunny: Cloud, full_model: Model
):
    model = Model(full_model.points[:n_model], full_model.normals[:n_model])
    assert_compiled_equals_definition(kind(model), bunny.points[::100], np.zeros(6))


@ALL
@pytest.mark.parametrize("angle", [0.0, 1e-9, 1e-5, np.pi - 1e-6, np.pi, np.pi + 1e-6, 5.0])
def test_compiled_equals_definition_at_any_rotation(
    kind: type[Histogram], angle: float, bunny: Cloud, full_model: Model
):
    rng = np.random.default_rng(2)
    assert_compiled_equals_definition(kind(full_model), scene_of(bunny, 3), random_x(rng, angle))


@ALL
def test_compiled_equals_definition_with_most_points_far_away(kind: type[Histogram], bunny: Cloud, full_model: Model):
    points = np.concatenate([bunny.points[:5], bunny.points[::200] * 50, bunny.points[::500] + np.float32(1e4)])
    assert_compiled_equals_definition(kind(full_model), points, np.zeros(6))


@PAPER
@pytest.mark.parametrize("distance", [3.0, 1e3, 1e9, 1e30])
def test_a_scene_out_of_reach_leaves_front_and_back_empty(
    kind: type[Histogram], distance: float, bunny: Cloud, small_model: Model
):
    points = bunny.points[::500] * np.float32(0.1) + np.float32(distance)
    h = kind(small_model)(points, np.zeros(6)).reshape(-1, 2 * len(small_model.points))
    np.testing.assert_array_equal(h[0], 0)
    np.testing.assert_allclose(np.linalg.norm(h[1:], axis=1), 1, atol=1e-5)


@PAPER
def test_an_empty_scene_gives_an_empty_histogram(kind: type[Histogram], small_model: Model):
    np.testing.assert_array_equal(kind(small_model)(np.empty((0, 3), np.float32), np.zeros(6)), 0)


@PAPER
def test_every_block_has_length_one_and_no_bin_is_negative(kind: type[Histogram], bunny: Cloud, full_model: Model):
    histogram = kind(full_model)
    for seed in range(10):
        h = histogram(scene_of(bunny, seed), np.zeros(6))
        assert (h >= 0).all()
        np.testing.assert_allclose(np.linalg.norm(h.reshape(len(kind.blocks), -1), axis=1), 1, atol=1e-5)


def test_the_weight_of_a_pair_is_the_papers():
    model = Model(np.array([[0, 0, 0], [1, 0, 0]], np.float32), np.array([[0, 0, 1], [0, 0, -1]], np.float32))
    near, far = 0.1, 0.2
    points = np.array([[0, 0, near], [0, 0, -far], [1, 0, near]], np.float32)
    w = np.exp(-(np.array([near, far]) ** 2) / SIGMA2)
    sides = FrontBack(model).sides(points.astype(np.float64))
    np.testing.assert_allclose(sides, [[w[0], 0], [w[1], w[0]]], atol=1e-6)
    np.testing.assert_allclose(FrontBack(model)(points, np.zeros(6)), sides.ravel() / np.linalg.norm(sides), atol=1e-6)


@pytest.mark.parametrize("kind", [TripleBinary, AsPrinted])
def test_angle_blocks_count_scene_points_above_and_clockwise(
    kind: type[TripleBinary], bunny: Cloud, small_model: Model
):
    points = scene_of(bunny, 5).astype(np.float64)
    up, down, clockwise, anticlockwise = kind(small_model).sides(points)[2:]
    np.testing.assert_array_equal(up + down, len(points))
    np.testing.assert_array_equal(clockwise + anticlockwise, len(points))
    for a, m in enumerate(small_model.points.astype(np.float64)):
        theta = np.arcsin(m[2] / np.linalg.norm(m))
        assert up[a] == (np.arcsin(points[:, 2] / np.linalg.norm(points, axis=1)) > theta).sum()
        omega = np.angle(m[0] + 1j * m[1])
        assert clockwise[a] == (np.angle(points[:, 0] + 1j * points[:, 1]) > omega).sum()


def test_the_compiled_counts_of_both_sides_add_up(bunny: Cloud, small_model: Model):
    h = TripleBinary(small_model)(scene_of(bunny, 6), np.zeros(6)).reshape(3, 2, -1)
    for block in (1, 2):
        total = h[block].sum(axis=0)
        np.testing.assert_allclose(total, total[0], rtol=1e-5)


def test_angles():
    points = np.array([[1.0, 0, 0], [0, 2, 0], [-1, 0, 0], [0, -1, 0], [0, 0, 1], [1, 0, -1], [0, 0, 0]])
    np.testing.assert_allclose(elevation(points), np.array([0, 0, 0, 0, 90, -45, 0]) * np.pi / 180)
    np.testing.assert_allclose(azimuth(points), np.array([0, 90, 180, -90, 0, 0, 0]) * np.pi / 180)


@PAPER
def test_the_order_of_the_points_does_not_matter(kind: type[Histogram], bunny: Cloud, small_model: Model):
    points, histogram = scene_of(bunny, 7), kind(small_model)
    shuffled = np.random.default_rng(0).permutation(points)
    np.testing.assert_allclose(histogram(shuffled, np.zeros(6)), histogram(points, np.zeros(6)), atol=1e-6)


@PAPER
def test_repeating_every_point_does_not_matter(kind: type[Histogram], bunny: Cloud, small_model: Model):
    points, histogram = scene_of(bunny, 8), kind(small_model)
    np.testing.assert_allclose(
        histogram(np.repeat(points, 3, axis=0), np.zeros(6)), histogram(points, np.zeros(6)), atol=1e-6
    )


@PAPER
def test_a_far_point_does_not_change_the_front_back_block(kind: type[Histogram], bunny: Cloud, small_model: Model):
    points, histogram, block = scene_of(bunny, 9), kind(small_model), 2 * len(small_model.points)
    for far in ([3, 0, 0], [0, -50, 0], [1e6, 1e6, 1e6]):
        with_far = np.concatenate([points, np.array([far], np.float32)])
        np.testing.assert_allclose(
            histogram(with_far, np.zeros(6))[:block], histogram(points, np.zeros(6))[:block], atol=1e-7
        )


def test_moving_model_and_scene_together_does_not_change_the_front_back_block(bunny: Cloud, small_model: Model):
    rng = np.random.default_rng(3)
    for seed in range(5):
        T = poses.exp(random_x(rng))
        points = without_ties(scene_of(bunny, seed), np.zeros(6), small_model)
        moved_model = Model(
            poses.transform(T, small_model.points).astype(np.float32),
            (small_model.normals @ T[:3, :3].T).astype(np.float32),
        )
        moved_points = poses.transform(T, points).astype(np.float32)
        np.testing.assert_allclose(
            FrontBack(moved_model)(moved_points, np.zeros(6)), FrontBack(small_model)(points, np.zeros(6)), atol=2e-5
        )


@PAPER
def test_moving_the_points_equals_describing_them_at_the_pose(kind: type[Histogram], bunny: Cloud, small_model: Model):
    x, histogram = random_x(np.random.default_rng(4)), kind(small_model)
    points = without_ties(scene_of(bunny, 10), x, small_model)
    moved = poses.transform(poses.exp(x), points).astype(np.float32)
    difference = np.abs(histogram(points, x) - histogram(moved, np.zeros(6)))
    assert difference.max() < 1e-3  # an angle on a float32 edge may count differently
    assert np.median(difference) < 1e-6


@ALL
def test_a_batch_equals_its_scenes_one_by_one(kind: type[Histogram], bunny: Cloud, small_model: Model):
    rng, histogram = np.random.default_rng(5), kind(small_model)
    scenes = [scene_of(bunny, seed, points=int(rng.integers(1, 500))) for seed in range(40)]
    x = np.stack([random_x(rng) for _ in scenes])
    together = histogram.batch(SceneBatch.of(scenes), x)
    assert together.shape == (40, histogram.n_bins)
    assert together.dtype == np.float32
    for i, points in enumerate(scenes):
        np.testing.assert_allclose(together[i], histogram(points, x[i]), atol=1e-7)


def test_a_scene_batch_gives_back_its_scenes(bunny: Cloud):
    scenes = [scene_of(bunny, seed, points=seed + 1) for seed in range(6)]
    batch = SceneBatch.of(scenes)
    assert len(batch) == 6
    for i in range(6):
        np.testing.assert_array_equal(batch[i], scenes[i])
    part, chosen = batch.part(2, 5), batch.choose(np.array([4, 1]))
    assert (len(part), len(chosen), len(SceneBatch.of([]))) == (3, 2, 0)
    np.testing.assert_array_equal(part[0], scenes[2])
    np.testing.assert_array_equal(part[2], scenes[4])
    np.testing.assert_array_equal(chosen[0], scenes[4])
    np.testing.assert_array_equal(chosen[1], scenes[1])


@ALL
def test_the_reference_line_is_the_model_against_itself(kind: type[Histogram], full_model: Model):
    histogram = kind(full_model)
    np.testing.assert_array_equal(histogram.reference, histogram(full_model.points, np.zeros(6)))
    assert histogram.reference.shape == (histogram.n_bins,)


def test_the_reference_line_of_the_angles_is_their_rank(full_model: Model):
    up = TripleBinary(full_model).reference.reshape(6, -1)[2]
    angles = elevation(full_model.points.astype(np.float64))
    order = np.argsort(angles)[np.ediff1d(np.sort(angles), to_begin=1) > 1e-9]
    assert (np.diff(up[order]) < 0).all()


def test_printed_weights_are_the_models_shares_and_flipping_normals_swaps_sides(small_model: Model):
    weights = AsPrinted(small_model).weights
    np.testing.assert_allclose(weights[0::2] + weights[1::2], 1, atol=1e-6)
    points, normals = small_model.points.astype(np.float64), small_model.normals.astype(np.float64)
    for a in range(0, len(points), 7):
        in_front = sum(float(normals[a] @ (m - points[a])) > 0 for m in points)
        above = (elevation(points) > elevation(points)[a]).sum()
        clockwise = (azimuth(points) > azimuth(points)[a]).sum()
        np.testing.assert_allclose(weights[::2, a] * len(points), [in_front, above, clockwise], atol=1e-4)
    flipped = FrontBack(Model(small_model.points, -small_model.normals))
    x = np.full(6, 0.01)
    h, swapped = (f(small_model.points, x).reshape(2, -1) for f in (FrontBack(small_model), flipped))
    np.testing.assert_allclose(h, swapped[::-1], atol=1e-6)


class Distances(Histogram):
    """A histogram that a researcher might add: no compiled loop, only the definition."""

    name = "distances"
    blocks = (Block("near", "far"),)

    def describe(self, moved: FloatArray) -> FloatArray:
        distance = np.linalg.norm(moved[None] - self.model.points[:, None], axis=-1)
        return np.concatenate([(distance < 0.5).mean(axis=1), (distance >= 0.5).mean(axis=1)])


def test_a_new_histogram_needs_only_its_definition(bunny: Cloud, small_model: Model):
    histogram, x = Distances(small_model), np.array([0.1, 0, 0, 0, 0, 0.5])
    scenes = [scene_of(bunny, seed) for seed in range(3)]
    one, many = histogram(scenes[0], x), histogram.batch(SceneBatch.of(scenes), np.stack([x, x * 0, -x]))
    assert one.dtype == many.dtype == np.float32
    assert many.shape == (3, histogram.n_bins) == (3, 2 * len(small_model.points))
    np.testing.assert_array_equal(many[0], one)
    np.testing.assert_allclose(one, histogram.describe(poses.transform(poses.exp(x), scenes[0])), atol=1e-7)
    assert histogram.reference.shape == (histogram.n_bins,)
