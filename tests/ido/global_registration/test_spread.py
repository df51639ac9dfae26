"""The pose to expect: a mean that other ways of computing it have, too, nearer to the truth than the top is."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from ido import Cloud, GlobalModel, GlobalRegistration, Perturbation, Scene, perturb, poses, score
from ido.global_registration import GlobalSettings
from ido.global_registration.cut_plane import Posterior, Refined, likelihood_after, refine
from ido.global_registration.evidence import Evidence
from ido.global_registration.outliers import Background
from ido.global_registration.spread import Spread, drawn_steps, log_densities, moved_by
from ido.methods import shipped_global_model
from ido.types import DoubleArray

HARD = [Perturbation(noise=0.1, outliers=100, incomplete=0.4, seed=seed) for seed in range(24)]


@pytest.fixture(scope="module")
def model() -> GlobalModel:
    return shipped_global_model("bunny")


@pytest.fixture(scope="module")
def hard(bunny: Cloud, model: GlobalModel) -> list[tuple[Scene, Posterior, Refined]]:
    """Hard scenes, each with the top of its likelihood near the truth."""
    found = []
    for scene in (perturb(bunny, its) for its in HARD):
        share = float((~scene.is_outlier).mean())
        background = Background.of(scene.points, GlobalSettings(ball=False))
        posterior = Posterior(scene.points, background, model.fields[-1], model.planes, np.array([share, 0.0]))
        found.append((scene, posterior, refine(posterior, scene.T_model_scene.astype(np.float64), cut=True)))
    return found


def walked_mean(posterior: Posterior, top: Refined, scale: DoubleArray, n: int) -> DoubleArray:
    """The mean step from a top by a random walk (Metropolis) on the likelihood of all points, shape (9,)."""
    rng = np.random.default_rng(1)
    tangents = np.linalg.svd(top.normal[None])[2][1:]

    def height(step: DoubleArray) -> float:
        place = (np.ascontiguousarray(top.T), top.normal, tangents, top.offset)
        return len(posterior.points) * likelihood_after(*posterior.data, *place, step, np.zeros(9))

    here, total = np.zeros(9), np.zeros(9)
    now = height(here)
    for move, luck in zip(rng.standard_normal((n, 9)) * scale, np.log(rng.random(n)), strict=True):
        there = height(here + move)
        if there - now > luck:
            here, now = here + move, there
            here = here.copy()
        total += here
    return total / n


def motion(T: DoubleArray, start: DoubleArray) -> DoubleArray:
    """Shift and turn (6,) that lead from one pose to another."""
    E = T @ poses.invert(start)
    return np.concatenate([E[:3, 3], Rotation.from_matrix(E[:3, :3]).as_rotvec()])


def test_a_random_walk_has_the_same_mean(hard: list[tuple[Scene, Posterior, Refined]]):
    for _, posterior, top in hard[:4]:
        spread = Spread.of(posterior, top)
        wide = np.sqrt(np.diag(spread.covariance))
        scale = 0.5 * np.concatenate([wide, np.full(3, wide.min())])
        mean = walked_mean(posterior, top, scale, 12_000)[:6]
        assert np.abs(spread.motion - mean).max() < 0.6 * wide.max()


def test_under_noise_the_mean_is_nearer_to_the_truth_than_the_top(bunny: Cloud, model: GlobalModel):
    of_top, of_mean = [], []
    for seed in range(900, 924):
        scene = perturb(bunny, Perturbation(noise=0.1, seed=seed))
        found = GlobalRegistration(model).run(scene.points)
        of_top.append(score(scene, found.best.T @ found.centring).rmse)
        of_mean.append(score(scene, found.T_model_scene).rmse)
    assert np.mean(of_mean) < 0.95 * np.mean(of_top)


def test_the_truth_is_as_far_away_as_the_covariance_says(hard: list[tuple[Scene, Posterior, Refined]]):
    distances, ratios = [], []
    for scene, posterior, top in hard:
        spread = Spread.of(posterior, top)
        mean = moved_by(spread.motion, top.T)
        away = motion(scene.T_model_scene.astype(np.float64), mean)
        distances.append(away @ np.linalg.solve(spread.covariance, away))
        ratios.append(Evidence.of(posterior, top, [], spread.covariance).error / score(scene, mean).rmse)
    assert 3 < np.median(distances) < 9  # 5.3 of six numbers that are Gaussian
    assert 0.7 < np.exp(np.mean(np.log(ratios))) < 1.5


def test_the_draws_are_always_the_same(hard: list[tuple[Scene, Posterior, Refined]]):
    _, posterior, top = hard[0]
    np.testing.assert_array_equal(Spread.of(posterior, top).motion, Spread.of(posterior, top).motion)


def test_without_a_plane_there_are_six_numbers_and_little_between_top_and_mean(bunny: Cloud, model: GlobalModel):
    for seed in range(6):
        scene = perturb(bunny, Perturbation(noise=0.05, incomplete=0, seed=seed))
        found = GlobalRegistration(model, GlobalSettings(cut_plane=False)).run(scene.points)
        assert not found.best.has_plane
        assert np.abs(found.T - found.best.T).max() < 0.02
        assert 0.3 < found.evidence.error / score(scene, found.T_model_scene).rmse < 3


def test_repeated_points_say_nothing_new(hard: list[tuple[Scene, Posterior, Refined]]):
    for _, posterior, top in hard[:3]:
        twice = replace(
            posterior,
            points=np.repeat(posterior.points, 2, axis=0),
            background=Background.of(np.repeat(posterior.points, 2, axis=0), GlobalSettings(ball=False)),
        )
        assert twice.n_different == posterior.n_different
        one, other = Spread.of(posterior, top), Spread.of(twice, top)
        np.testing.assert_allclose(other.covariance, one.covariance, rtol=0.2, atol=1e-6)


@pytest.mark.parametrize("points", [1195, 1205, 1700])
def test_of_more_points_than_are_climbed_with_the_mean_is_found_too(bunny: Cloud, model: GlobalModel, points: int):
    of_top, of_mean = [], []
    for seed in range(8):
        n = round((points - 300) / 0.5)
        scene = perturb(bunny, Perturbation(noise=0.1, points=n, incomplete=0.5, outliers=300, seed=seed))
        assert len(scene.points) == points
        found = GlobalRegistration(model).run(scene.points)
        of_top.append(score(scene, found.best.T @ found.centring).rmse)
        of_mean.append(score(scene, found.T_model_scene).rmse)
    assert np.mean(of_mean) < 0.95 * np.mean(of_top)


def test_steps_are_drawn_from_the_distribution_that_their_densities_are_of():
    from scipy.stats import multivariate_t  # a quarter of a second, for this test alone

    root = np.random.default_rng(3).standard_normal((9, 9))
    shape: Any = root @ root.T  # SciPy's types know no matrix as a shape
    ours, theirs = np.random.default_rng(4), np.random.default_rng(4)
    drawn = drawn_steps(ours, shape)
    distribution = multivariate_t(shape=shape, df=6)
    np.testing.assert_allclose(drawn, distribution.rvs(len(drawn), random_state=theirs), rtol=1e-12)
    differences = log_densities(drawn, shape) - distribution.logpdf(drawn)
    np.testing.assert_allclose(differences, differences[0], rtol=1e-9)
