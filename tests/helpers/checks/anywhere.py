"""Checks of the lessons on methods that start from anywhere: basins, and how sure one can be."""

from __future__ import annotations

from functools import cache

from checks.helpers import LEFT, RIGHT, Check, all_of, both_wrong, ends, page_of
from ido import score
from ido.global_registration import Confidence
from ido_viz.core.basin import ANGLES, AXES, start_of
from ido_viz.core.library import shipped_library
from ido_viz.core.run import Run, make_scene
from ido_viz.core.state import with_values
from ido_viz.core.verdict import IN_PLACE, Verdict


@cache
def _share_in_place(claim: str, method: str, angle: int) -> float:
    """Of the basin's starts of an angle on the page of a claim, the share that a method brings in place."""
    state, library = page_of(claim), shipped_library()
    register = library.entry(state.shape, method).make(state.epsilon, state.max_iterations, lambda _: None).register
    subject = library.subject(state.shape)
    in_place = 0
    for axis in range(AXES):
        start = start_of(state, subject.up, ANGLES.index(angle) * AXES + axis)
        scene = make_scene(subject, with_values(state, {"start": start}))
        in_place += float(score(scene, register(scene.points).T_model_scene[-1]).accuracy) >= IN_PLACE
    return in_place / AXES


def _sure(run: Run) -> Confidence:
    sure = run.sides[RIGHT].confidence
    assert sure is not None
    return sure


def _starts_left(run: Run, iteration: int) -> int:
    race = run.sides[RIGHT].race
    assert race is not None
    return race.left(iteration)


CHECKS: dict[str, Check] = {
    "basin/do-is-local": lambda _: (
        _share_in_place("basin/do-is-local", "DO", 30) == 1 and _share_in_place("basin/do-is-local", "DO", 120) < 0.25
    ),
    "basin/icp-is-more-local": lambda _: _share_in_place("basin/icp-is-more-local", "ICP, tuned", 60) < 0.25,
    "basin/do-has-an-edge": lambda _: 0.25 < _share_in_place("basin/do-has-an-edge", "DO", 90) < 0.9,
    "basin/global-has-no-edge": lambda _: _share_in_place("basin/global-has-no-edge", "Global", 180) == 1,
    "basin/few-starts-are-left": lambda run: _starts_left(run, 1) == 360 and _starts_left(run, 30) < 20,
    "sure/converged-and-wrong": all_of(
        ends(Verdict.WRONG_POSE, LEFT), lambda run: run.sides[LEFT].trajectory.converged
    ),
    "sure/sure": lambda run: _sure(run).probability > 0.9,
    "sure/sure-and-right": ends(Verdict.IN_PLACE, RIGHT),
    "sure/both-wrong": both_wrong,
    "sure/doubts": lambda run: _sure(run).probability < 0.1 and len(_sure(run).equals) > 0 and bool(_sure(run).reasons),
    "sure/right-and-unsure": all_of(ends(Verdict.IN_PLACE, RIGHT), lambda run: _sure(run).probability < 0.5),
}
