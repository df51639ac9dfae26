"""The basin: what it says of a start is what the pane shows that begins there."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest
from seen import Seen
from tab import PAUSED, Tab

from ido import Perturbation, StopReason, poses
from ido.baselines import Nothing
from ido.baselines.baseline import Record
from ido.methods import BASELINES
from ido.perturbation import start_pose
from ido.types import DoubleArray
from ido_viz.core.basin import ANGLES, AXES, STARTS, Basin, axes, start_of, starts_of, turn_of
from ido_viz.core.library import Library, shipped_library
from ido_viz.core.run import compute, make_scene, start_size
from ido_viz.core.state import State, decode, encode

LIBRARY = shipped_library()
STATE = replace(PAUSED, perturbation=Perturbation(points=100, outliers=0, rotation=25.0, seed=4))
UPS = [subject.up for subject in LIBRARY.subjects.values()]


def test_axes_are_spread_evenly():
    found = axes()
    assert np.allclose(np.linalg.norm(found, axis=1), 1)
    assert np.abs(found.mean(axis=0)).max() < 0.05
    apart = np.arccos(np.clip(found @ found.T, -1, 1)) + 10 * np.eye(AXES)
    ideal = np.sqrt(4 * np.pi / AXES)
    assert apart.min() > 0.6 * ideal
    assert apart.min(axis=1).max() < 1.4 * ideal


@pytest.mark.parametrize("up", UPS)
@pytest.mark.parametrize("number", [0, 40, 100, STARTS - AXES - 1])
def test_a_start_is_turned_as_it_says_and_shifted_as_before(up: tuple[float, float, float], number: int):
    state = replace(STATE, start=start_of(STATE, up, number))
    degrees, distance = start_size(state)
    assert np.isclose(degrees, ANGLES[number // AXES], atol=1e-3)
    assert np.isclose(distance, STATE.perturbation.translation, atol=1e-5)
    assert np.allclose(turn_of(state, up), ANGLES[number // AXES] * axes()[number % AXES], atol=1e-3)
    assert decode(encode(state)) == state


def test_a_scene_that_nobody_has_moved_is_turned_as_its_perturbation_says():
    turn = turn_of(STATE, (0.0, 0.0, 1.0))
    T = poses.exp(np.concatenate([np.zeros(3), np.deg2rad(turn)]))
    assert np.allclose(T[:3, :3], start_pose(STATE.perturbation)[:3, :3])


def test_all_starts_have_the_same_scene_where_it_belongs():
    subject = LIBRARY.subject("bunny")
    scenes = [make_scene(subject, replace(STATE, start=start_of(STATE, subject.up, i))) for i in (3, 170)]
    first, second = (poses.transform(scene.T_model_scene, scene.points) for scene in scenes)
    assert np.allclose(first, second, atol=1e-5)


def test_the_map_says_what_the_pane_shows(seen: Seen):
    basin = Basin(LIBRARY, seen)
    assert not basin.begun
    basin.begin(STATE)
    seen.wait(lambda: not basin.running)
    for number in (5, 77, 150):
        run = compute(replace(STATE, start=start_of(STATE, LIBRARY.subject("bunny").up, number)), LIBRARY)
        for side in run.sides:
            assert np.isclose(basin.accuracies(side.method)[number], side.scores.accuracy[-1])
    assert np.isnan(basin.accuracies("ICP, tuned")).all()
    near, far = basin.accuracies("DO")[:AXES], basin.accuracies("DO")[-AXES:]
    assert near.mean() > far.mean()


def test_the_map_is_of_the_scene_however_it_is_turned_by_hand(seen: Seen):
    basin = Basin(LIBRARY, seen)
    basin.begin(STATE)
    basin.cancel()
    assert not basin.running
    assert basin.fits(replace(STATE, start=start_of(STATE, UPS[0], 9), iteration=3, right="ICP, tuned"))
    assert not basin.fits(replace(STATE, perturbation=replace(STATE.perturbation, seed=5)))
    assert not basin.fits(replace(STATE, max_iterations=7))


def test_what_is_known_of_a_scene_is_kept_and_goes_on_after_cancelling(seen: Seen):
    basin = Basin(LIBRARY, seen)
    basin.begin(STATE)
    seen.wait(lambda: bool(np.isfinite(basin.accuracies("DO")).sum() > 3) or not basin.running)
    basin.cancel()
    known = np.isfinite(basin.accuracies("DO"))
    before = basin.accuracies("DO")[known]
    basin.begin(replace(STATE, right="Did nothing"))
    seen.wait(lambda: not basin.running)
    assert np.array_equal(basin.accuracies("DO")[known], before)
    assert np.isfinite(basin.accuracies("DO")).all() and np.isfinite(basin.accuracies("Did nothing")).all()


def test_the_newest_scene_wins(seen: Seen):
    basin = Basin(LIBRARY, seen)
    other = replace(STATE, perturbation=replace(STATE.perturbation, seed=8))
    for state in (STATE, other, STATE, other):
        basin.begin(state)
    seen.wait(lambda: not basin.running)
    assert basin.fits(other)
    run = compute(replace(other, start=start_of(other, LIBRARY.subject("bunny").up, 60)), LIBRARY)
    assert np.isclose(basin.accuracies("DO")[60], run.sides[0].scores.accuracy[-1])


def test_a_failing_method_says_why_and_the_other_has_its_map(seen: Seen, monkeypatch: pytest.MonkeyPatch):
    @dataclass(frozen=True, kw_only=True)
    class Failing(Nothing):
        def run(self, model: DoubleArray, scene: DoubleArray, record: Record) -> StopReason:
            raise ZeroDivisionError("by <b>")

    monkeypatch.setitem(BASELINES, "Did nothing", Failing())
    basin = Basin(LIBRARY, seen)
    basin.begin(replace(STATE, left="Did nothing", right="DO"))
    seen.wait(lambda: not basin.running)
    assert basin.failure("Did nothing") == "ZeroDivisionError: by <b>"
    assert basin.failure("DO") == ""
    assert np.isfinite(basin.accuracies("DO")).all()


def test_a_click_on_a_dot_begins_there(tab: Tab):
    tab.actions.pick("start", 0, 70.0)
    state = tab.settle().state
    assert state == replace(PAUSED, start=start_of(PAUSED, LIBRARY.subject("bunny").up, 70))
    tab.actions.pick("start", 0, 1e6)
    assert tab.settle().state.start == start_of(PAUSED, LIBRARY.subject("bunny").up, STARTS - 1)


def test_a_tab_maps_its_scene_and_stops_when_it_is_closed(tab: Tab):
    tab.actions.map_basin()
    tab.wait("a map", lambda: bool(np.isfinite(tab.basin.accuracies("DO")).any()))
    assert tab.basin.fits(PAUSED)
    tab.session.close()
    tab.wait("the end", lambda: not tab.basin.running)


def test_every_start_fits_into_a_state():
    for seed in range(5):
        state = State(perturbation=Perturbation(rotation=175.0, translation=1.0, seed=seed))
        for up in UPS:
            starts = starts_of(state, up)
            assert len(starts) == STARTS
            for start in starts:
                assert replace(state, start=start).start


def test_what_is_known_is_not_of_a_shape_whose_maps_are_others_by_now(seen: Seen):
    subjects = dict(LIBRARY.subjects)
    basin = Basin(Library(subjects), seen)
    basin.begin(STATE)
    basin.cancel()
    assert basin.fits(STATE)
    subjects[STATE.shape] = replace(subjects[STATE.shape], title="with another map")
    assert not basin.fits(STATE)
