"""The race of a global registration's starts, compared with what the registration itself tells of them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from ido import Perturbation, perturb, poses, shipped_cloud
from ido.global_registration import Confidence, GlobalModel, GlobalRegistration, GlobalResult
from ido_viz.core.frame import frame_of
from ido_viz.core.library import shipped_library
from ido_viz.core.race import FADING, Race, fan_of
from ido_viz.core.run import compute
from ido_viz.core.state import LAST, State

STRUCTURED = Perturbation(rotation=140.0, outliers=200, outlier_kind="structured", seed=2)


@pytest.fixture(scope="module")
def tried() -> GlobalResult:
    """Of a scene with a ball, so that there are two branches; few rotations are quick."""
    cloud = shipped_cloud("bunny")
    return GlobalRegistration(GlobalModel.of(cloud.points, rotations=48)).run(perturb(cloud, STRUCTURED).points)


@pytest.fixture(scope="module")
def race(tried: GlobalResult) -> Race:
    return Race.of(tried)


def test_the_way_of_the_chosen_start_is_the_registration(tried: GlobalResult, race: Race):
    way = tried.trajectory.T_model_scene[1:-1]
    assert race.T_model_scene.shape[1] == len(way) == race.steps + 1
    away = np.abs(race.T_model_scene - way).max(axis=(1, 2, 3))
    assert away.min() < 1e-5
    assert race.until[away.argmin()] > race.steps


def test_so_many_starts_are_left_as_the_stages_kept(tried: GlobalResult, race: Race):
    end, done = tried.candidates[0].stage, 0
    for number in range(end + 1):
        here = [branch.stages[number] for branch in tried.branches]
        done += here[0].climb.steps
        assert race.left(done + 1) == sum(len(stage.climb.poses) for stage in here)
        if number < end:
            assert race.left(done + 2) == sum(len(stage.kept) for stage in here)


def test_a_start_that_was_given_up_stays_and_fades(race: Race):
    loser = int(np.argmin(race.until))
    until = race.until[loser]
    assert 0 < until < race.steps
    still = race.T_model_scene[loser, until - 1 :]
    assert np.array_equal(still, np.broadcast_to(still[0], still.shape))
    seen = [race.strength(k)[loser] for k in range(1, until + 1 + FADING)]
    assert seen[:until] == [1.0] * until
    assert np.all(np.diff(seen[until - 1 :]) < 0) and seen[-1] == 0
    assert np.isnan(race.log_likelihood[loser, until:]).all()
    assert np.isfinite(race.log_likelihood[loser, :until]).all()


def test_nothing_races_before_the_search(race: Race):
    assert not race.strength(0).any()
    assert race.strength(1).all()


def test_the_survivors_are_those_at_the_end_the_likeliest_first(tried: GlobalResult, race: Race):
    end = tried.candidates[0].stage
    ends = np.concatenate([branch.stages[end].climb.log_likelihood[:, -1] for branch in tried.branches])
    assert np.allclose(race.survivors(3)[:, -1], np.sort(ends)[::-1][:3])
    assert len(race.survivors(1000)) == len(ends)


def test_the_fan_spreads_as_the_covariance_says_and_has_the_equals(tried: GlobalResult):
    sure, T = Confidence.of(tried), tried.T_model_scene
    equals = np.stack([np.eye(4), T])
    fan = fan_of(replace(sure, equals=equals), T)
    assert np.array_equal(fan[-2:], equals)
    spread = replace(sure, equals=equals[:0], evidence=replace(sure.evidence, covariance=1e-6 * np.eye(6)))
    motions = fan_of(spread, T) @ poses.invert(T)
    assert np.allclose(motions, np.eye(4), atol=0.02)
    deviation = np.sqrt(np.mean(poses.log(motions) ** 2))
    assert 0.5e-3 < deviation < 2e-3


def test_the_page_shows_the_method_with_its_race_and_how_sure_it_is():
    state = State(perturbation=Perturbation(rotation=170.0, seed=3), left="DO", right="Global", iteration=LAST)
    run = compute(state, shipped_library())
    left, right = run.sides
    assert (left.race, left.confidence) == (None, None)
    assert right.race is not None and right.confidence is not None
    assert right.trajectory.iterations == right.race.steps + 2
    assert 0 < right.confidence.probability < 1
    assert right.maps is None
    assert frame_of(run, replace(state, iteration=1)).sides[1].caption.progress.endswith("360 starts")
    assert frame_of(run, state).sides[0].caption.progress.endswith(f"of {left.trajectory.iterations}")


@pytest.mark.parametrize("shape", ["bunny", "urban"])
def test_every_shape_offers_the_methods_from_any_start(shape: str):
    methods = shipped_library().methods(shape)
    assert {"Global", "DO, many starts", "Improved DO, many starts"} <= set(methods)
    assert len(set(methods)) == len(methods)
    for name in methods:
        entry = shipped_library().entry(shape, name)
        assert entry.name == name
