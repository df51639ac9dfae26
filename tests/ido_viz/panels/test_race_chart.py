"""The chart of a race: the curves of the starts that got to the end, beside the iterations of the registration."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from ido import Perturbation
from ido_viz.core.frame import frame_of
from ido_viz.core.library import shipped_library
from ido_viz.core.run import Run, compute
from ido_viz.core.state import LAST, State
from ido_viz.panels.race_chart import chart_data

STATE = State(perturbation=Perturbation(rotation=170.0, seed=3), left="DO", right="Global", iteration=LAST)


@pytest.fixture(scope="module")
def run() -> Run:
    return compute(STATE, shipped_library())


def test_the_best_curve_is_first_and_begins_with_the_search(run: Run):
    iterations, *columns = chart_data(frame_of(run, STATE))
    curves, marks = columns[:-2], columns[-2:]
    left, right = np.split(np.stack(curves), 2)
    assert np.isnan(left).all() and np.isnan(marks[0]).all()
    race = run.sides[1].race
    assert race is not None
    best = race.survivors(1)[0]
    assert np.isnan(right[0][0]) and np.array_equal(right[0][1 : len(best) + 1], best)
    assert np.nanmax(right[:, race.steps + 1]) == right[0][race.steps + 1]
    assert all(len(column) == len(iterations) for column in columns)


@pytest.mark.parametrize("iteration", [1, 20, LAST])
def test_the_shown_iteration_is_marked_on_the_best_curve(run: Run, iteration: int):
    _, *columns = chart_data(frame_of(run, replace(STATE, iteration=iteration)))
    (marked,) = np.flatnonzero(np.isfinite(columns[-1]))
    assert columns[-1][marked] == columns[len(columns) // 2 - 1][marked]
    race = run.sides[1].race
    assert race is not None
    assert marked == (race.steps + 1 if iteration == LAST else iteration)


def test_nothing_is_marked_before_the_search(run: Run):
    assert np.isnan(chart_data(frame_of(run, replace(STATE, iteration=0)))[-1]).all()
