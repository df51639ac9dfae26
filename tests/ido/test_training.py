"""Training: each map against an independent least-squares solution, Theorem 1, and the ways to run it."""

from __future__ import annotations

import multiprocessing
import warnings
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace

import numpy as np
import pytest

from ido import Cloud, FrontBack, Maps, Model, TrainingSettings, TripleBinary, poses, register_batch, train, training
from ido.training import Learner, solve, training_scenes
from ido.types import FloatArray

SMALL = TrainingSettings(samples=250, maps=4, seed=3)


@pytest.fixture(scope="module")
def trained(bunny: Cloud, small_model: Model) -> Maps:
    return train(bunny, FrontBack(small_model), SMALL)


@pytest.mark.parametrize("ridge", [2e-4, 1e-2, 1.0])
@pytest.mark.parametrize("n", [300, 40, 30])  # more scenes than bins, as many, and fewer
def test_a_map_is_the_ridge_regression(n: int, ridge: float):
    rng, n_bins = np.random.default_rng(0), 40
    h = rng.random((n, n_bins)).astype(np.float32)
    h /= np.linalg.norm(h, axis=1, keepdims=True)
    step = rng.standard_normal((n, 6))
    # (1/N) ‖step - h Dᵀ‖² + λ‖D‖² as one plain least-squares problem
    A = np.concatenate([h.astype(np.float64) / np.sqrt(n), np.sqrt(ridge) * np.eye(n_bins)])
    b = np.concatenate([step / np.sqrt(n), np.zeros((n_bins, 6))])
    expected = np.linalg.lstsq(A, b)[0].T
    D = solve(h, step, ridge)
    assert D.shape == (6, n_bins)
    assert D.dtype == np.float32
    np.testing.assert_allclose(D, expected, rtol=0, atol=1e-4 * np.abs(expected).max())


def test_a_map_is_found_with_fewer_samples_than_bins():
    rng = np.random.default_rng(1)
    h, step = rng.random((20, 60)).astype(np.float32), rng.standard_normal((20, 6))
    np.testing.assert_allclose(h @ solve(h, step, 1e-4).T, step, atol=0.02)


@pytest.mark.parametrize("kind", [FrontBack, TripleBinary])
def test_the_error_falls_at_every_map(kind: type[FrontBack], bunny: Cloud, small_model: Model):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        maps = train(bunny, kind(small_model), SMALL)
    curves = maps.curves
    assert curves.always_falls
    assert (np.diff(curves.mean) < 0).all()
    assert curves.mean[-1] < 0.2 * curves.mean[0]
    np.testing.assert_allclose(curves.translation + curves.rotation, curves.mean)


def test_a_first_ridge_falls_to_the_ridge_by_the_middle_of_the_maps(bunny: Cloud, small_model: Model):
    settings = replace(SMALL, maps=5, ridge=1e-4, first_ridge=1e-2)
    np.testing.assert_allclose([settings.ridge_of(k) for k in range(5)], [1e-2, 1e-3, 1e-4, 1e-4, 1e-4])
    assert {replace(settings, first_ridge=None).ridge_of(k) for k in range(5)} == {1e-4}
    assert replace(settings, maps=1).ridge_of(0) == 1e-4
    maps = train(bunny, FrontBack(small_model), settings).maps
    strong, weak = (
        train(bunny, FrontBack(small_model), replace(SMALL, maps=1, ridge=ridge)).maps[0] for ridge in (1e-2, 1e-4)
    )
    np.testing.assert_array_equal(maps[0], strong)
    assert np.linalg.norm(weak) > 1.5 * np.linalg.norm(strong)


class Blind(FrontBack):
    """Sees nothing."""

    def batch(self, scenes: object, x: FloatArray) -> FloatArray:
        return np.zeros((len(x), self.n_bins), np.float32)


def test_an_error_that_does_not_fall_is_told(bunny: Cloud, small_model: Model):
    with pytest.warns(UserWarning, match=r"did not fall at map 1 \(Theorem 1\)"):
        maps = train(bunny, Blind(small_model), replace(SMALL, maps=1))
    assert not maps.curves.always_falls


def test_curves_say_how_far_the_samples_are_from_the_truth(bunny: Cloud, trained: Maps):
    _, x_true = training_scenes(bunny, SMALL)
    curves, squares = trained.curves, (x_true**2).sum(axis=1)
    assert curves.mean.shape == curves.deviation.shape == (5,)
    assert curves.residuals.shape == (5, 250, 6)
    assert curves.mean[0] == pytest.approx(squares.mean())
    assert curves.deviation[0] == pytest.approx(squares.std())
    assert curves.rotation[0] == pytest.approx((x_true[:, 3:] ** 2).sum(axis=1).mean())
    shown = (curves.residuals.astype(np.float64) ** 2).sum(axis=2)  # all 250 samples, in another order
    np.testing.assert_allclose(shown.mean(axis=1), curves.mean, rtol=1e-5)
    np.testing.assert_allclose(shown.std(axis=1), curves.deviation, rtol=1e-5)


def test_registering_the_training_scenes_ends_where_training_did(bunny: Cloud, trained: Maps):
    scenes, x_true = training_scenes(bunny, SMALL)
    tracks = register_batch(trained, scenes, max_iterations=len(trained.maps))
    residuals = x_true[:, None] - np.stack([track.x for track in tracks])
    np.testing.assert_allclose((residuals**2).sum(axis=2).mean(axis=0), trained.curves.mean, rtol=1e-4)
    of_walk, of_training = (np.linalg.norm(r, axis=1) for r in (residuals[:, -1], trained.curves.residuals[-1]))
    np.testing.assert_allclose(np.sort(of_walk), np.sort(of_training), atol=1e-4)


def test_training_scenes_follow_the_papers_ranges(bunny: Cloud):
    scenes, x_true = training_scenes(bunny, TrainingSettings(samples=400))
    T_scene_model = np.linalg.inv(poses.exp(x_true))
    angles = np.rad2deg(np.linalg.norm(x_true[:, 3:], axis=1))
    lengths = np.linalg.norm(T_scene_model[:, :3, 3], axis=1)
    sizes = np.diff(scenes.starts)
    for values, low, high in ((angles, 0, 90), (lengths, 0, 0.3), (sizes, 400 * 0.7, 800 + 300)):
        assert low - 1e-9 <= values.min() < low + 0.15 * (high - low)
        assert high - 0.15 * (high - low) < values.max() <= high + 1e-9
    assert angles.mean() == pytest.approx(45, abs=4)


def test_the_seed_decides(bunny: Cloud, small_model: Model, trained: Maps):
    again, other = (train(bunny, FrontBack(small_model), replace(SMALL, seed=seed)) for seed in (SMALL.seed, 4))
    np.testing.assert_array_equal(trained.maps, again.maps)
    np.testing.assert_array_equal(trained.curves.residuals, again.curves.residuals)
    assert not np.allclose(trained.maps, other.maps)


def test_a_process_pool_gives_the_same_maps(
    bunny: Cloud, small_model: Model, trained: Maps, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(training, "_CHUNK", 60)
    with ProcessPoolExecutor(2, mp_context=multiprocessing.get_context("spawn")) as pool:
        shared = train(bunny, FrontBack(small_model), SMALL, executor=pool)
    np.testing.assert_array_equal(shared.maps, trained.maps)
    np.testing.assert_array_equal(shared.curves.mean, trained.curves.mean)


def test_progress_is_told_before_the_first_map_and_after_each(bunny: Cloud, small_model: Model):
    told: list[tuple[int, float]] = []
    maps = train(bunny, FrontBack(small_model), SMALL, progress=lambda *now: told.append(now))
    assert [k for k, _ in told] == [0, 1, 2, 3, 4]
    np.testing.assert_array_equal([error for _, error in told], maps.curves.mean)


def interrupted_at(bunny: Cloud, model: Model, k: int) -> Maps:
    def progress(done: int, error: float) -> None:
        if done == k:
            raise KeyboardInterrupt

    return train(bunny, FrontBack(model), SMALL, progress=progress)


@pytest.mark.parametrize("k", [1, 3])
def test_an_interrupt_keeps_the_finished_maps(bunny: Cloud, small_model: Model, trained: Maps, k: int):
    maps = interrupted_at(bunny, small_model, k)
    assert len(maps.maps) == k
    assert not maps.complete
    assert trained.complete
    np.testing.assert_array_equal(maps.maps, trained.maps[:k])
    np.testing.assert_array_equal(maps.curves.mean, trained.curves.mean[: k + 1])
    assert maps.curves.residuals.shape == (k + 1, 250, 6)


def test_an_interrupt_before_the_first_map_is_passed_on(bunny: Cloud, small_model: Model):
    with pytest.raises(KeyboardInterrupt):
        interrupted_at(bunny, small_model, 0)


def test_maps_remember_the_cloud_and_the_settings(bunny: Cloud, small_maps: Maps):
    assert small_maps.frame is bunny.frame
    assert small_maps.maps.dtype == np.float32
    assert small_maps.maps.shape == (8, 6, small_maps.histogram.n_bins)
    assert small_maps.version


def test_what_is_learned_so_far_are_the_first_maps_of_the_whole(bunny: Cloud, small_model: Model, trained: Maps):
    learner = Learner(bunny, FrontBack(small_model), SMALL, scenes=training_scenes(bunny, SMALL))
    for count in (1, 2):
        learner.learn()
        so_far = learner.maps()
        assert learner.learned == count and not so_far.complete
        np.testing.assert_array_equal(so_far.maps, trained.maps[:count])
        np.testing.assert_array_equal(so_far.curves.mean, trained.curves.mean[: count + 1])
        assert learner.error == trained.curves.mean[count]


@pytest.mark.parametrize(("rotation", "translation"), [(180.0, 1.0), (20.0, 0.05)])
def test_scenes_are_drawn_from_the_whole_range_and_not_beyond(bunny: Cloud, rotation: float, translation: float):
    settings = replace(SMALL, rotation=rotation, translation=translation)
    T_model_scene = poses.exp(training_scenes(bunny, settings)[1])
    traces = np.trace(T_model_scene[:, :3, :3], axis1=1, axis2=2)
    turns = np.degrees(np.arccos(np.clip((traces - 1) / 2, -1, 1)))
    shifts = np.linalg.norm(T_model_scene[:, :3, 3], axis=1)
    assert 0.95 * rotation < turns.max() <= rotation + 1e-3
    assert 0.95 * translation < shifts.max() <= translation + 1e-6


@pytest.mark.parametrize("beyond", [{"rotation": 181.0}, {"translation": 1.1}, {"rotation": -1.0}])
def test_a_training_range_that_no_slider_has_is_refused(beyond: dict[str, float]):
    with pytest.raises(ValueError, match="must lie between 0 and"):
        replace(SMALL, **beyond)
