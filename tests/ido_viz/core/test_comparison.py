"""The comparison of all methods on one scene."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import zip_longest

import numpy as np
import pytest
from seen import Seen
from tab import PATIENCE, PAUSED

from ido import Cloud, StopReason
from ido.baselines import Nothing
from ido.baselines.baseline import Record
from ido.methods import BASELINES
from ido.types import DoubleArray
from ido_viz.core import comparison as comparison_module
from ido_viz.core.library import shipped_library
from ido_viz.core.run import compute
from ido_viz.core.state import State
from ido_viz.core.turns import Turns
from ido_viz.panels.compare_tab import COLUMNS, SORTS, Comparison, Row, head_html, label

ROWS = (
    Row("DO", 0.9, 0.05, 0.004, 30),
    Row("ICP, tuned", 0.4, 0.3, 0.02, 50),
    Row("KCCE (reconstruction), default", 1.0, 0.02, 0.15, 210),
)


def test_every_method_gets_its_row_with_what_its_own_registration_gives(seen: Seen) -> None:
    comparison = Comparison(shipped_library(), seen)
    comparison.begin(PAUSED)
    seen.wait(lambda: not comparison.running)
    assert [row.method for row in comparison.rows] == list(shipped_library().methods("bunny"))
    rows = comparison.rows
    sides = {
        side.method: side
        for one, other in zip_longest(rows[::2], rows[1::2], fillvalue=rows[0])
        for side in compute(replace(PAUSED, left=one.method, right=other.method), shipped_library()).sides
    }
    for row in rows:
        side = sides[row.method]
        assert np.isclose(row.accuracy, side.scores.accuracy[-1])
        assert np.isclose(row.rmse, side.scores.rmse[-1])
        assert row.iterations == side.trajectory.iterations
        assert row.seconds > 0
    assert comparison.fits(PAUSED)
    assert not comparison.fits(replace(PAUSED, perturbation=replace(PAUSED.perturbation, seed=5)))
    assert comparison.fits(replace(PAUSED, left="Improved DO", iteration=3))


def test_cancelling_leaves_the_rows_that_are_there(seen: Seen) -> None:
    comparison = Comparison(shipped_library(), seen)
    comparison.begin(State())
    seen.wait(lambda: len(comparison.rows) >= 2)
    comparison.cancel()
    seen.wait(lambda: not comparison.running)
    assert 2 <= len(comparison.rows) < len(comparison.methods)


def test_it_tells_that_it_waits_for_its_turn_and_nothing_else_that_work_reports(
    seen: Seen, monkeypatch: pytest.MonkeyPatch
) -> None:
    turns = Turns(1)
    monkeypatch.setattr(comparison_module, "SLOW", turns)
    comparison = Comparison(shipped_library(), seen)
    with turns.turn():
        comparison.begin(PAUSED)
        seen.wait(lambda: comparison.waiting == "waiting, 1 before it")
        comparison.cancel()
    seen.wait(lambda: not comparison.running)
    assert comparison.waiting == ""

    told: list[str] = []

    def talk(_method: object, _scene: object, report: Callable[[str], None]) -> Row:
        report("waiting for the compiler")
        told.append(comparison.waiting)
        return ROWS[0]

    monkeypatch.setattr(comparison_module, "measured", talk)
    comparison.begin(PAUSED)
    seen.wait(lambda: not comparison.running)
    assert set(told) == {""}


def test_a_new_comparison_takes_the_place_of_the_one_under_way(seen: Seen) -> None:
    comparison = Comparison(shipped_library(), seen)
    comparison.begin(State())
    seen.wait(lambda: len(comparison.rows) >= 1)
    other = replace(PAUSED, shape="urban")
    comparison.begin(other)
    seen.wait(lambda: not comparison.running)
    assert comparison.fits(other)
    assert [row.method for row in comparison.rows] == list(shipped_library().methods("urban"))


@pytest.mark.parametrize(
    ("by", "first"),
    [("PointAcc", "KCCE (reconstruction), default"), ("PointRMSE", "KCCE (reconstruction), default"), ("time", "DO")],
)
def test_sorting_puts_the_best_first(by: str, first: str) -> None:
    assert min(ROWS, key=SORTS[by]).method == first
    assert max(ROWS, key=SORTS["PointAcc"]).method == "ICP, tuned"


def test_accuracy_counts_before_nearness() -> None:
    better, nearer = Row("better", 0.004, 1.2, 1.0, 1), Row("nearer", 0.001, 0.6, 1.0, 1)
    assert SORTS["PointAcc"](better) < SORTS["PointAcc"](nearer)
    assert SORTS["PointRMSE"](nearer) < SORTS["PointRMSE"](better)


def test_a_failing_method_gets_a_row_that_says_so(seen: Seen, monkeypatch: pytest.MonkeyPatch) -> None:
    @dataclass(frozen=True, kw_only=True)
    class Failing(Nothing):
        def run(self, model: DoubleArray, scene: DoubleArray, record: Record) -> StopReason:
            raise ZeroDivisionError

    monkeypatch.setitem(BASELINES, "Did nothing", Failing())
    comparison = Comparison(shipped_library(), seen)
    comparison.begin(PAUSED)
    seen.wait(lambda: not comparison.running)
    assert len(comparison.rows) == len(shipped_library().methods("bunny"))
    failed = next(row for row in comparison.rows if row.method == "Did nothing")
    assert "✗ ZeroDivisionError" in label(failed)
    assert max(comparison.rows, key=SORTS["PointRMSE"]) == failed


def test_rows_are_columns() -> None:
    assert len({len(label(row)) for row in ROWS}) == 1
    assert len(label(ROWS[0])) <= 52  # what fits a panel


def test_the_head_says_what_the_rows_are_of() -> None:
    assert "scene has changed" in head_html(14, 14, False, False)
    assert "scene has changed" not in head_html(14, 14, False, True)
    assert "3 of 14" in head_html(3, 14, True, True)


class Unmakeable:
    """A method of one's own that cannot be made."""

    def __init__(self, cloud: Cloud) -> None:
        raise SystemExit("not today")

    def update(self, points: np.ndarray, x: np.ndarray) -> np.ndarray:
        return np.zeros(6)


def test_a_method_of_ones_own_that_cannot_be_made_gets_a_row_and_the_others_theirs() -> None:
    library = shipped_library().with_methods({"Unmakeable, with a name that is too long": Unmakeable})
    comparison = Comparison(library, lambda: None)
    comparison.begin(PAUSED)
    deadline = time.monotonic() + PATIENCE
    while comparison.running:
        assert time.monotonic() < deadline
        time.sleep(0.01)
    assert [row.method for row in comparison.rows] == list(library.methods("bunny"))
    failed = [row for row in comparison.rows if row.failure]
    assert [row.failure for row in failed] == ["SystemExit"]
    assert {len(label(row)) for row in comparison.rows} == {len(COLUMNS)}
