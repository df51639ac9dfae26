"""The shipped results in the explorer: curves, and the scenes behind them."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from ido import SHAPES, Cloud, FrontBack, Model, TrainingSettings, load_cloud, shipped_results, train
from ido.experiments import LEVELS, Results
from ido.experiments.families import COMPARED_METHODS, FAMILIES
from ido.files import save_cloud
from ido.methods import LEARNED, method_names
from ido_viz.core.library import shipped_library
from ido_viz.core.run import compute
from ido_viz.core.state import State, decode, encode
from ido_viz.core.sweep_results import GROUPS, Choice, mean_scores, rows_of, scene_labels
from ido_viz.panels.sweeps_tab import legend_html, series_of


@pytest.fixture(scope="module")
def results() -> Results:
    return shipped_results()


def some_rows(results: Results, count: int) -> list[int]:
    """Quick registrations of all kinds, to run again.

    A baseline that goes astray ends elsewhere on another kind of processor; where it found the place it finds it again.
    """
    same_everywhere = np.isin(results.method, list(LEARNED)) | (results.accuracy > 0.95)
    quick = (results.iterations < 200) & ~((results.sweep == "points") & (results.level > 1000))
    offered = np.isin(results.method, method_names("bunny")) & np.isin(results.sweep, list(LEVELS))
    few = np.flatnonzero(quick & same_everywhere & offered)
    return np.random.default_rng(5).choice(few, count, replace=False).tolist()


def test_the_results_are_of_every_method_sweep_and_shape(results: Results) -> None:
    for shape in ("bunny", "urban"):
        for sweep, levels in LEVELS.items():
            rows, _ = rows_of(shape, sweep)
            methods = (*method_names(shape), "Global")
            assert set(rows.method.tolist()) == set(methods)
            assert set(rows.level.tolist()) == set(map(float, levels))
            for method in methods:
                for level in levels:
                    assert sorted(rows.where(method=method, level=level).trial) == list(range(100))


def test_opening_a_registration_shows_what_was_recorded(results: Results) -> None:
    for i in some_rows(results, 25):
        sweep = str(results.sweep[i])
        level = next(value for value in LEVELS[sweep] if value == results.level[i])
        choice = Choice(str(results.dataset[i]), sweep, level, int(results.trial[i]), str(results.method[i]))
        state = choice.at(replace(State(), start=(0.1, 0.0, 0.0, 0.0, 0.0, 1.0), inside=2.0))
        assert state.perturbation.seed == results.seed[i]
        number = int(state.right == results.method[i])
        assert (state.left, state.right)[number] == results.method[i] != (state.right, state.left)[number]
        assert decode(encode(state)) == state and state.inside == 0
        side = compute(state, shipped_library()).sides[number]
        # in the last bits a run on one thread differs, which may end an iteration sooner or later
        assert abs(side.scores.accuracy[-1] - results.accuracy[i]) <= 0.02, choice
        assert abs(side.scores.rmse[-1] - results.rmse[i]) <= 0.01, choice


def test_the_left_pane_keeps_another_method(results: Results) -> None:
    opened = Choice("bunny", "noise", 0.0, 0, "DO").at(State())
    assert (opened.left, opened.right) == ("DO", "Improved DO")
    opened = Choice("bunny", "noise", 0.0, 0, "DO").at(replace(State(), left="Improved DO", right="DO"))
    assert (opened.left, opened.right) == ("Improved DO", "DO")
    assert Choice("bunny", "noise", 0.0, 0, "DO").at(replace(State(), left="ICP, tuned")).left == "ICP, tuned"
    odd = replace(State(), left="Improved DO (as printed)")
    assert Choice("urban", "noise", 0.0, 0, "Improved DO").at(odd).left == "DO"


def test_curves_are_the_means_of_the_levels(results: Results) -> None:
    rows = results.where(dataset="bunny", sweep="rotation")
    levels = LEVELS["rotation"]
    values = mean_scores(rows, "DO", "accuracy", levels)
    for level, value in zip(levels, values, strict=True):
        chosen = (rows.method == "DO") & (rows.level == level)
        assert np.isclose(value, rows.accuracy[chosen].mean())
    assert np.isnan(mean_scores(rows, "no such method", "accuracy", levels)).all()


def test_scenes_are_offered_worst_first(results: Results) -> None:
    rows = results.where(dataset="bunny", sweep="noise")
    labels = scene_labels(rows, "ICP, default", 0.1)
    accuracies = [float(text.split()[-1].rstrip(")")) for text in labels]
    assert accuracies == sorted(accuracies)
    assert len({text.split()[0] for text in labels}) == len(labels)
    assert scene_labels(rows, "no such method", 0.1) == ["–"]


def test_every_method_can_be_told_apart() -> None:
    for dark in (False, True):
        series = [series_of(name, dark) for name in method_names("bunny")]
        assert len({(its["stroke"], str(its.get("dash"))) for its in series}) == len(series)
    for group in GROUPS.values():
        assert {"DO", "Improved DO", "Did nothing"} <= {name for name in COMPARED_METHODS if group(name)}
    *one_of_each, _ = GROUPS.values()
    for group in one_of_each:
        colors = [series_of(name, dark=False)["stroke"] for name in COMPARED_METHODS if group(name)]
        assert len(set(colors)) == len(colors) == len(FAMILIES)


def test_a_cloud_of_ones_own_has_no_results_and_takes_no_shipped_name(tmp_path: Path) -> None:
    cloud = tmp_path / "bunny.ply"
    save_cloud(cloud, np.random.default_rng(0).uniform(-1, 1, (2000, 3)) * [1, 1, 0.999])
    maps = tmp_path / "own.npz"
    own = Cloud.of(load_cloud(cloud))
    train(own, FrontBack(Model.of(own, 60)), TrainingSettings(samples=60, maps=2)).save(maps)
    library, name = shipped_library().with_own(cloud, [maps])
    assert name not in SHAPES
    assert library.methods("bunny") == shipped_library().methods("bunny")
    rows, why = rows_of(name, "noise")
    assert len(rows) == 0
    assert "shipped shapes only" in why


@pytest.mark.parametrize("dark", [False, True])
def test_the_legend_s_lines_are_those_of_the_chart(dark: bool):
    written = legend_html(method_names("bunny"), shipped_results(), dark)
    lines = [("dash" in its, its["stroke"]) for its in (series_of(name, dark) for name in method_names("bunny"))]
    drawn = re.findall(r"border-top:3px (solid|dashed) ([^\"]+)\"", written)
    assert [(kind == "dashed", color) for kind, color in drawn] == lines
