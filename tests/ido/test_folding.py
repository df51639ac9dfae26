"""Folded histograms: maps learned on them are those of the whole ones, and nothing is lost."""

from __future__ import annotations

import numpy as np
import pytest

from ido import HISTOGRAMS, Cloud, Histogram, Model, TrainingSettings
from ido.folding import Folding
from ido.histograms import SceneBatch
from ido.training import solve, training_scenes
from ido.types import FloatArray

SETTINGS = TrainingSettings(samples=4000, maps=1, seed=5)  # more than there are bins


@pytest.fixture(scope="module", params=list(HISTOGRAMS.values()), ids=list(HISTOGRAMS))
def histogram(request: pytest.FixtureRequest, small_model: Model) -> Histogram:
    return request.param(small_model)


@pytest.fixture(scope="module")
def drawn(bunny: Cloud) -> tuple[SceneBatch, FloatArray]:
    """Training scenes and their true x, the same for all histograms."""
    return training_scenes(bunny, SETTINGS)


@pytest.fixture(scope="module")
def described(histogram: Histogram, drawn: tuple[SceneBatch, FloatArray]) -> tuple[FloatArray, FloatArray]:
    """Histograms of training scenes where they lie, and their true x."""
    scenes, x_true = drawn
    return histogram.batch(scenes, np.zeros_like(x_true)), x_true


def test_blocks_whose_bins_sum_to_the_scene_s_size_are_folded(histogram: Histogram):
    expected = {
        "front-back": (False,),
        "triple-binary": (False, True, True),
        "as-printed": (False, False, False),
        "quadruple-binary": (False, True, True, False),
    }
    assert Folding.of(histogram).folded == expected[histogram.name]


def test_lengths_and_products_stay_as_they_were(histogram: Histogram, described: tuple[FloatArray, FloatArray]):
    h, folding = described[0][:300], Folding.of(histogram)
    z = folding.fold(h)
    assert z.shape == (len(h), folding.n_numbers) and z.dtype == np.float32
    np.testing.assert_allclose(z @ z.T, h @ h.T, atol=1e-5)


def test_a_folded_map_and_its_unfolded_one_do_the_same(histogram: Histogram, described: tuple[FloatArray, FloatArray]):
    h, folding = described[0], Folding.of(histogram)
    E = np.random.default_rng(0).standard_normal((6, folding.n_numbers)).astype(np.float32)
    D = folding.unfold(E)
    assert D.shape == (6, histogram.n_bins) and D.dtype == np.float32
    np.testing.assert_allclose(h @ D.T, folding.fold(h) @ E.T, atol=1e-4)
    assert np.linalg.norm(D) == pytest.approx(np.linalg.norm(E), rel=1e-5)


def test_the_map_is_that_of_the_whole_histograms(histogram: Histogram, described: tuple[FloatArray, FloatArray]):
    h, x_true = described
    folding = Folding.of(histogram)
    whole = solve(h, -x_true, SETTINGS.ridge)
    folded = folding.unfold(solve(folding.fold(h), -x_true, SETTINGS.ridge))
    np.testing.assert_allclose(folded, whole, rtol=0, atol=1e-4 * np.abs(whole).max())
