"""The clock of a page, with a time that the tests set."""

from __future__ import annotations

import pytest

from ido_viz.core import clock as clock_module
from ido_viz.core.clock import FRAME, Clock
from ido_viz.core.library import shipped_library
from ido_viz.core.pacing import Pacing
from ido_viz.core.run import Run, compute
from ido_viz.core.state import State


class Time:
    """Stands for the module `time`."""

    def __init__(self) -> None:
        self.now = 1000.0

    def perf_counter(self) -> float:
        return self.now


@pytest.fixture
def time(monkeypatch: pytest.MonkeyPatch) -> Time:
    time = Time()
    monkeypatch.setattr(clock_module, "time", time)
    return time


@pytest.fixture(scope="module")
def run() -> Run:
    return compute(State(), shipped_library())


@pytest.fixture
def clock(time: Time, run: Run) -> Clock:
    clock = Clock(0)
    clock.follow(run)
    return clock


def test_it_goes_by_the_pace_of_its_run_however_often_it_ticks(time: Time, clock: Clock, run: Run):
    for seconds in (0.01, 0.4, 0.09, 1.1):
        time.now += seconds
        clock.tick(20, moves=True)
    assert clock.position == pytest.approx(Pacing(run).after(0.0, 1.6, 20))
    assert 0 < clock.position < run.iterations


def test_it_waits_before_it_sets_out_and_loses_nothing_then(time: Time, clock: Clock, run: Run):
    clock.start(3.0, 2.0)
    time.now += 1.5
    assert clock.waits
    clock.tick(15, moves=True)
    assert clock.position == 3
    assert clock.next_frame == pytest.approx(0.5 + FRAME)
    time.now += 1.0
    assert not clock.waits
    clock.tick(15, moves=True)
    assert clock.position == pytest.approx(Pacing(run).after(3.0, 0.5, 15))


def test_time_in_which_nothing_moves_does_not_count(time: Time, clock: Clock, run: Run):
    time.now += 5.0
    clock.tick(15, moves=False)
    assert clock.position == 0
    time.now += 0.5
    clock.tick(15, moves=True)
    assert clock.position == pytest.approx(Pacing(run).after(0.0, 0.5, 15))


def test_it_ends_at_the_end(time: Time, clock: Clock, run: Run):
    time.now += 1e6
    clock.tick(1, moves=True)
    assert clock.position == run.iterations


def test_the_next_frame_is_due_a_frame_after_the_last(time: Time, clock: Clock):
    clock.tick(15, moves=True)
    time.now += 0.25 * FRAME
    assert clock.next_frame == pytest.approx(0.75 * FRAME)
    time.now += 5 * FRAME
    assert clock.next_frame == 0


def test_without_a_run_it_stands(time: Time):
    clock = Clock(4)
    time.now += 3.0
    clock.tick(60, moves=True)
    assert clock.position == 4


def test_another_run_is_played_at_its_own_pace(time: Time, clock: Clock):
    still = compute(State(left="Did nothing", right="Did nothing"), shipped_library())
    clock.follow(still)
    time.now += 1.0
    clock.tick(15, moves=True)
    assert clock.position == 0
