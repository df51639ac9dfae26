"""Methods that do not keep up with a slider: computed in the background, shown when they are there, cancelled."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
import pytest
from tab import PATIENCE, PAUSED, Tab

from ido import StopReason
from ido.baselines import Baseline
from ido.baselines.baseline import Record
from ido.methods import BASELINES
from ido.types import DoubleArray
from ido_viz.core.library import shipped_library
from ido_viz.core.live_run import LiveRun
from ido_viz.core.run import compute
from ido_viz.core.state import State

SLOW = replace(PAUSED, left="Slow")


@dataclass(frozen=True, kw_only=True)
class Slow(Baseline):
    """Takes its first steps, then waits to be let on; it may fail."""

    title: ClassVar[str] = "Slow"
    go: ClassVar[threading.Event] = threading.Event()
    begun: ClassVar[list[DoubleArray]] = []
    failure: ClassVar[Exception | None] = None

    def run(self, model: DoubleArray, scene: DoubleArray, record: Record) -> StopReason:
        self.begun.append(scene)
        for _ in range(3):
            record(np.eye(4))
        while not self.go.wait(0.01):
            record(np.eye(4))
        if self.failure:
            raise self.failure
        record(np.eye(4))
        return StopReason.CONVERGED


@pytest.fixture(autouse=True)
def slow(monkeypatch: pytest.MonkeyPatch) -> Iterator[type[Slow]]:
    monkeypatch.setitem(BASELINES, "Slow", Slow())
    monkeypatch.setattr(Slow, "begun", [])
    Slow.go.clear()
    yield Slow
    Slow.go.set()


def begin(open_tab: Callable[..., Tab], state: State) -> Tab:
    """A tab that has drawn its first frame."""
    tab = open_tab(state, calm=False)
    tab.wait("a first frame", lambda: bool(tab.frames))
    return tab


def test_the_quick_pane_does_not_wait_for_the_slow_one(open_tab: Callable[..., Tab]) -> None:
    tab = begin(open_tab, SLOW)
    tab.wait("a frame that tells how far it is", lambda: "iteration" in tab.shown.run.sides[0].waiting)
    slow_side, quick_side = tab.shown.run.sides
    assert slow_side.trajectory.iterations == 0
    assert quick_side.waiting == ""
    assert quick_side.trajectory.iterations > 0
    Slow.go.set()
    tab.wait("the slow pane", lambda: tab.shown.run.sides[0].waiting == "")
    assert tab.shown.run.sides[0].trajectory.converged
    assert tab.shown.run.sides[1] is quick_side


def test_cancelling_is_offered_after_a_while_and_ends_the_work(open_tab: Callable[..., Tab]) -> None:
    tab = begin(open_tab, SLOW)
    tab.wait("the offer to cancel", lambda: tab.may_cancel)
    tab.actions.cancel()
    tab.wait("the end", lambda: tab.shown.run.sides[0].waiting == "cancelled")
    tab.wait("no more offer", lambda: not tab.may_cancel)
    tab.set(noise=0.01)
    tab.wait("another attempt", lambda: len(Slow.begun) == 2)


def test_the_newest_scene_wins(open_tab: Callable[..., Tab]) -> None:
    tab = begin(open_tab, SLOW)
    for rotation in (10.0, 20.0, 30.0, 45.0):
        tab.set(rotation=rotation)
        tab.wait("a frame", lambda rotation=rotation: tab.shown.state.perturbation.rotation == rotation)
    Slow.go.set()
    tab.wait("the slow pane", lambda: tab.shown.run.sides[0].waiting == "")
    shown = tab.shown
    assert shown.state.perturbation.rotation == 45.0
    np.testing.assert_array_equal(shown.run.scene.points, compute(shown.state, shipped_library()).scene.points)
    np.testing.assert_array_equal(Slow.begun[-1], shown.run.scene.points)


def test_closing_the_tab_ends_the_work(open_tab: Callable[..., Tab]) -> None:
    tab = begin(open_tab, SLOW)
    tab.wait("work under way", lambda: len(Slow.begun) == 1)
    tab.session.close()
    for thread in threading.enumerate():
        if thread.name == "job":
            thread.join(PATIENCE)
            assert not thread.is_alive()


def test_both_panes_set_out_together(open_tab: Callable[..., Tab]) -> None:
    tab = begin(open_tab, replace(SLOW, playing=True, speed=60))
    tab.wait("work told", lambda: "iteration" in tab.shown.run.sides[0].waiting)
    assert tab.shown.iteration == 0
    Slow.go.set()
    tab.wait("the end of the playing", lambda: not tab.shown.state.playing)
    assert tab.shown.iteration == tab.shown.run.iterations


def test_two_slow_methods_are_played_once_they_are_there(open_tab: Callable[..., Tab]) -> None:
    tab = begin(open_tab, replace(SLOW, right="ICP, tuned", playing=True, speed=60))
    tab.wait("work told", lambda: "iteration" in tab.shown.run.sides[0].waiting)
    Slow.go.set()
    tab.wait("the end of the playing", lambda: not tab.shown.state.playing)
    assert tab.shown.iteration == tab.shown.run.iterations > 0


def test_a_page_that_comes_back_begins_anew_what_was_given_up(tab: Tab) -> None:
    live = LiveRun(shipped_library(), lambda: None)
    assert live.begin(SLOW) and not live.begin(SLOW)
    live.close()
    assert not live.waiting and live.begin(SLOW) and live.waiting
    live.close()


def test_a_failing_method_says_so_and_the_rest_goes_on(
    open_tab: Callable[..., Tab], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Slow, "failure", RuntimeError("singular"))
    Slow.go.set()
    tab = begin(open_tab, SLOW)
    tab.wait("the failure told", lambda: "RuntimeError: singular" in tab.shown.run.sides[0].waiting)
    tab.set(rotation=10.0)
    tab.wait("the next frame", lambda: tab.shown.state.perturbation.rotation == 10.0)
    assert tab.shown.run.sides[1].trajectory.iterations > 0


def test_tabs_do_not_wait_for_each_other(open_tab: Callable[..., Tab]) -> None:
    busy = begin(open_tab, SLOW)
    busy.wait("work under way", lambda: len(Slow.begun) == 1)
    other = open_tab()
    other.set(rotation=77.0)
    other.wait("its frame", lambda: other.shown.state.perturbation.rotation == 77.0)


def test_first_while_both_panes_are_computed_is_the_first(open_tab: Callable[..., Tab]) -> None:
    tab = begin(open_tab, replace(SLOW, right="Slow"))
    tab.wait("work told", lambda: "iteration" in tab.shown.run.sides[0].waiting)
    tab.actions.jump(0)
    Slow.go.set()
    tab.wait("the results", lambda: not any(side.waiting for side in tab.shown.run.sides))
    assert tab.shown.run.iterations > 0
    assert tab.shown.iteration == 0


def test_playing_what_does_not_move_stops(open_tab: Callable[..., Tab]) -> None:
    tab = begin(open_tab, replace(PAUSED, left="Did nothing", right="Did nothing", playing=True))
    tab.wait("the results", lambda: not any(side.waiting for side in tab.shown.run.sides))
    tab.wait("the end of the playing", lambda: not tab.shown.state.playing)


def test_the_points_are_sent_once_while_a_method_is_computed(open_tab: Callable[..., Tab]) -> None:
    tab = begin(open_tab, SLOW)
    tab.wait("work told", lambda: "iteration" in tab.shown.run.sides[0].waiting)
    before = tab.shown.run
    tab.wait("more work told", lambda: tab.shown.run.sides[0].waiting != before.sides[0].waiting)
    assert tab.shown.run.scene is before.scene
    assert tab.shown.run.sides[0].trajectory is before.sides[0].trajectory
