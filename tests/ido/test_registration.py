"""Registration: the walk along the maps, when it stops, and that batches change nothing."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from ido import (
    Cloud,
    Maps,
    Perturbation,
    SceneBatch,
    StopReason,
    perturb,
    poses,
    register,
    register_batch,
    score,
    shipped_maps,
)
from ido.registration import Trajectory

EASY = Perturbation(noise=0, outliers=0, incomplete=0, rotation=30, translation=0.2)


def assert_same(first: Trajectory, second: Trajectory) -> None:
    assert first.stop is second.stop
    assert first.iterations == second.iterations
    np.testing.assert_allclose(first.x, second.x, atol=1e-4)
    np.testing.assert_allclose(first.update_norms, second.update_norms, atol=1e-5)


@pytest.mark.parametrize("limit", [0, 1, 5, 8, 12, 60])
def test_a_batch_gives_what_single_registrations_give(bunny: Cloud, small_maps: Maps, limit: int):
    scenes = [perturb(bunny, Perturbation(seed=seed)).points for seed in range(12)]
    together = register_batch(small_maps, SceneBatch.of(scenes), epsilon=0.02, max_iterations=limit)
    assert len(together) == 12
    for points, track in zip(scenes, together, strict=True):
        assert_same(track, register(small_maps, points, epsilon=0.02, max_iterations=limit))


def test_an_empty_batch_gives_nothing(small_maps: Maps):
    assert register_batch(small_maps, SceneBatch.of([])) == []


def test_every_step_is_one_map_applied_to_the_histogram(bunny: Cloud, small_maps: Maps):
    points = perturb(bunny, Perturbation()).points
    track = register(small_maps, points, epsilon=0, max_iterations=12)
    np.testing.assert_array_equal(track.x[0], 0)
    for k in range(12):
        D = small_maps.maps[min(k, 7)].astype(np.float64)  # after the last map it is repeated
        update = D @ small_maps.histogram(points, track.x[k]).astype(np.float64)
        np.testing.assert_allclose(track.x[k + 1], track.x[k] - update, atol=1e-6)


def test_the_norms_are_the_lengths_of_the_steps(bunny: Cloud, small_maps: Maps):
    track = register(small_maps, perturb(bunny, Perturbation()).points, max_iterations=40)
    assert len(track.x) == track.iterations + 1
    np.testing.assert_allclose(np.linalg.norm(np.diff(track.x, axis=0), axis=1), track.update_norms, rtol=1e-5)
    np.testing.assert_allclose(track.T_model_scene, poses.exp(track.x))


def test_it_converges_when_the_next_update_is_below_epsilon(bunny: Cloud, small_maps: Maps):
    epsilon, points = 0.02, perturb(bunny, EASY).points
    track = register(small_maps, points, epsilon=epsilon)
    assert track.stop is StopReason.CONVERGED
    assert track.converged
    assert track.iterations >= 8  # all maps are applied, however small their updates
    assert (track.update_norms[8:] >= epsilon).all()
    assert np.linalg.norm(small_maps.maps[-1] @ small_maps.histogram(points, track.x[-1])) < epsilon


def test_a_large_epsilon_still_applies_every_map_once(bunny: Cloud, small_maps: Maps):
    track = register(small_maps, perturb(bunny, Perturbation()).points, epsilon=1e9)
    assert (track.stop, track.iterations) == (StopReason.CONVERGED, 8)


@pytest.mark.parametrize("limit", [0, 3, 8, 20])
def test_it_stops_at_the_iteration_limit(bunny: Cloud, small_maps: Maps, limit: int):
    track = register(small_maps, perturb(bunny, Perturbation()).points, epsilon=0, max_iterations=limit)
    assert track.stop is StopReason.MAX_ITERATIONS
    assert not track.converged
    assert track.iterations == limit
    assert track.update_norms.shape == (limit,)


@pytest.mark.parametrize("factor", [1e6, 1e15, np.nan])
def test_absurd_maps_diverge_and_keep_the_last_sound_pose(bunny: Cloud, small_maps: Maps, factor: float):
    last_is_absurd = small_maps.maps.copy()
    last_is_absurd[2] *= np.float32(factor)
    maps = replace(small_maps, maps=last_is_absurd)
    scenes = [perturb(bunny, Perturbation(seed=seed)).points for seed in range(3)]
    for track in [register(maps, scenes[0]), *register_batch(maps, SceneBatch.of(scenes))]:
        assert track.stop is StopReason.DIVERGED
        assert not track.converged
        assert track.iterations == 2
        assert np.isfinite(track.T_model_scene).all()


def test_it_starts_where_it_is_told_to(bunny: Cloud, small_maps: Maps):
    points = perturb(bunny, EASY).points
    whole = register(small_maps, points, epsilon=0, max_iterations=20)
    rest = register(replace(small_maps, maps=small_maps.maps[-1:]), points, epsilon=0, max_iterations=10, x=whole.x[10])
    np.testing.assert_allclose(rest.x, whole.x[10:], atol=1e-9)


@pytest.mark.parametrize("histogram", ["front-back", "triple-binary", "as-printed"])
@pytest.mark.parametrize("seed", range(3))
def test_shipped_maps_put_every_point_of_an_easy_scene_right(bunny: Cloud, histogram: str, seed: int):
    scene = perturb(bunny, replace(EASY, seed=seed))
    track = register(shipped_maps("bunny", histogram), scene.points, max_iterations=60)
    scores = score(scene, track.T_model_scene)
    assert scores.accuracy[0] < 1
    assert scores.accuracy[-1] == 1
    assert scores.rmse[-1] < 0.03


def test_a_small_training_registers_easy_scenes(bunny: Cloud, small_maps: Maps):
    scenes = [perturb(bunny, replace(EASY, seed=seed, noise=0.01)) for seed in range(20)]
    tracks = register_batch(small_maps, SceneBatch.of([scene.points for scene in scenes]), epsilon=0.01)
    accuracy = [score(scene, track.T_model_scene[-1]).accuracy for scene, track in zip(scenes, tracks, strict=True)]
    assert np.mean(accuracy) == pytest.approx(1, abs=0.01)


def test_a_scene_out_of_reach_stays_where_it_is(small_maps: Maps):
    track = register(small_maps, np.full((20, 3), 50.0))
    assert track.converged
    np.testing.assert_array_equal(track.x, 0)
