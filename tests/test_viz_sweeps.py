"""The shipped results in the explorer: curves, and the scenes behind them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from ido import shipped_results
from ido.experiments import LEVELS, Results
from ido.methods import method_names
from ido_viz import palette
from ido_viz.library import shipped_library
from ido_viz.run import compute
from ido_viz.state import State, decode, encode
from ido_viz.sweeps import GROUPS, Choice, curve, scene_labels, series_of


@pytest.fixture(scope="module")
def results() -> Results:
    return shipped_results()


def some_rows(results: Results, count: int) -> list[int]:
    """Quick registrations of all kinds, to run again."""
    few = np.flatnonzero((results.iterations < 200) & ~((results.sweep == "points") & (results.level > 1000)))
    return np.random.default_rng(5).choice(few, count, replace=False).tolist()


def test_the_results_are_of_every_method_sweep_and_shape(results: Results) -> None:
    for shape in ("bunny", "urban"):
        for sweep, levels in LEVELS.items():
            rows = results.where(dataset=shape, sweep=sweep)
            assert set(rows.method.tolist()) == set(method_names(shape))
            assert set(rows.level.round(6).tolist()) == {round(float(level), 6) for level in levels}
            counts = np.unique(np.stack([rows.method, rows.level.round(6).astype(str)]), axis=1, return_counts=True)[1]
            assert counts.min() >= 20


def test_opening_a_registration_shows_what_was_recorded(results: Results) -> None:
    for i in some_rows(results, 25):
        sweep = str(results.sweep[i])
        level = next(value for value in LEVELS[sweep] if np.isclose(value, results.level[i]))
        choice = Choice(str(results.dataset[i]), sweep, level, int(results.trial[i]), str(results.method[i]))
        state = choice.at(State())
        assert state.perturbation.seed == results.seed[i]
        assert state.right == results.method[i] != state.left
        assert decode(encode(state)) == state
        side = compute(state, shipped_library()).sides[1]
        # in the last bits a run on one thread differs, which may end an iteration sooner or later
        assert abs(side.scores.accuracy[-1] - results.accuracy[i]) <= 0.02, choice
        assert abs(side.scores.rmse[-1] - results.rmse[i]) <= 0.01, choice


def test_the_left_pane_keeps_another_method(results: Results) -> None:
    assert Choice("bunny", "noise", 0.0, 0, "DO").at(State()).left == "Improved DO"
    assert Choice("bunny", "noise", 0.0, 0, "DO").at(replace(State(), left="ICP, tuned")).left == "ICP, tuned"
    odd = replace(State(), left="Improved DO (as printed)")
    assert Choice("urban", "noise", 0.0, 0, "Improved DO").at(odd).left == "DO"


def test_curves_are_the_means_of_the_levels(results: Results) -> None:
    rows = results.where(dataset="bunny", sweep="rotation")
    levels = np.array(LEVELS["rotation"])
    values = curve(rows, "DO", "accuracy", levels)
    for level, value in zip(levels, values, strict=True):
        chosen = (rows.method == "DO") & (np.abs(rows.level - level) < 1e-6)
        assert np.isclose(value, rows.accuracy[chosen].mean())
    assert np.isnan(curve(rows, "no such method", "accuracy", levels)).all()


def test_scenes_are_offered_worst_first(results: Results) -> None:
    rows = results.where(dataset="bunny", sweep="noise")
    labels = scene_labels(rows, "ICP, default", 0.1)
    accuracies = [float(text.split()[-1].rstrip(")")) for text in labels]
    assert accuracies == sorted(accuracies)
    assert len({text.split()[0] for text in labels}) == len(labels)
    assert scene_labels(rows, "no such method", 0.1) == ["–"]


def test_every_method_can_be_told_apart() -> None:
    looks = [(series_of(name)["stroke"], str(series_of(name).get("dash"))) for name in method_names("bunny")]
    assert len(set(looks)) == len(looks)
    assert len(set(palette.FAMILIES)) == len(palette.FAMILIES)
    for group in GROUPS.values():
        assert {"DO", "Improved DO", "Did nothing"} <= {name for name in method_names("bunny") if group(name)}
