"""Checks of the lessons on what results depend on: settings, weights, and a case to explain."""

from __future__ import annotations

import numpy as np

from checks.helpers import (
    LEFT,
    RIGHT,
    Check,
    at,
    both_in_place,
    change_by_outliers,
    ends,
    front_share,
    means,
    page_of,
)
from ido.attribution import Attribution
from ido.types import FloatArray
from ido_viz.core.run import Run
from ido_viz.core.verdict import Verdict


def _turn_about_z(run: Run, side: int) -> float:
    """The first update's turn about the upright axis, radians; positive where it is towards the goal."""
    its = run.sides[side]
    return float(its.trajectory.x[1, 5] * np.sign(_upright(run)))


def _upright(run: Run) -> float:
    """Part of the true turn about the upright axis: positive, negative or none."""
    R = run.scene.T_model_scene[:3, :3]
    return float(R[1, 0] - R[0, 1])


def _pushes(run: Run) -> FloatArray:
    """What each block of Improved DO adds to the turn about the upright axis in the first update; shape (blocks,)."""
    its = run.sides[RIGHT]
    assert its.maps is not None
    return Attribution.of(its.maps.maps[0], its.histogram, run.histogram(RIGHT, 0)).of_blocks[5]


def _few_in_front(run: Run) -> float:
    """Share of the model points with fewer than a tenth of the model in front of them."""
    weights = getattr(run.sides[LEFT].histogram, "weights", None)
    assert weights is not None
    return float((weights[0] < 0.1).mean())


CHECKS: dict[str, Check] = {
    "settings/gmmreg-default-wrong": ends(Verdict.WRONG_POSE, LEFT),
    "settings/gmmreg-tuned-in-place": ends(Verdict.IN_PLACE, RIGHT),
    "settings/gmmreg-over-all": means(("GMMReg, default", "0.08"), ("GMMReg, tuned", "0.79")),
    "settings/cpd-default-wrong": ends(Verdict.WRONG_POSE, LEFT),
    "settings/cpd-tuned-in-place": ends(Verdict.IN_PLACE, RIGHT),
    "settings/cpd-over-all": means(("CPD, default", "0.10"), ("CPD, tuned", "0.74")),
    "settings/cpd-default-without-outliers": at(
        page_of("settings/cpd-default-without-outliers", outliers=0), ends(Verdict.IN_PLACE, LEFT)
    ),
    "settings/do-in-place": ends(Verdict.IN_PLACE, LEFT),
    "settings/gmmreg-wrong": ends(Verdict.WRONG_POSE, RIGHT),
    "settings/do-ahead-when-turned": means(("DO", "0.69"), ("GMMReg, tuned", "0.37"), sweep="rotation", level=90),
    "settings/nearly-equal-over-all": means(("DO", "0.81"), ("GMMReg, tuned", "0.79")),
    "failure/do-in-place": ends(Verdict.IN_PLACE, LEFT),
    "failure/improved-do-wrong": ends(Verdict.WRONG_POSE, RIGHT),
    "failure/front-and-back-miss-the-ball": lambda run: float(change_by_outliers(run, LEFT)[0]) < 1e-3,
    "failure/angles-see-the-ball": lambda run: bool(np.all(change_by_outliers(run, RIGHT)[1:] > 0.4)),
    "failure/most-of-what-they-count": lambda run: bool(run.scene.is_outlier.mean() > 0.5),
    "failure/positive-turn-needed": lambda run: _upright(run) > 0,
    "failure/front-and-back-push-wrong": lambda run: f"{_pushes(run)[0]:.2f}" == "-0.22",
    "failure/third-question-hardly-pushes": lambda run: f"{_pushes(run)[2]:.2f}" == "-0.02",
    "failure/third-question-pushes-without-the-ball": at(
        page_of("failure/third-question-pushes-without-the-ball", outliers=0),
        lambda run: f"{_pushes(run)[2]:+.2f}" == "+0.16",
    ),
    "failure/both-turn-the-wrong-way": lambda run: (
        _turn_about_z(run, LEFT) < 0 and _turn_about_z(run, RIGHT) < 2 * _turn_about_z(run, LEFT)
    ),
    "failure/do-finds-back": ends(Verdict.IN_PLACE, LEFT),
    "failure/improved-do-rests-elsewhere": ends(Verdict.WRONG_POSE, RIGHT),
    "failure/no-ball-both-in-place": both_in_place,
    "as-printed/printed-wrong": ends(Verdict.WRONG_POSE, LEFT),
    "as-printed/ours-in-place": ends(Verdict.IN_PLACE, RIGHT),
    "as-printed/printed-behind-over-all": means(("Improved DO (as printed)", "0.70"), ("Improved DO", "0.81")),
    "as-printed/little-lies-in-front": lambda run: _few_in_front(run) > 0.5,
    "as-printed/printed-is-blind-in-front": lambda run: front_share(run, LEFT, 30) < 0.1,
    "as-printed/ours-is-not": lambda run: 0.6 < front_share(run, RIGHT, 30) < 0.72,
    "as-printed/both-in-place": both_in_place,
    "as-printed/nearly-equal-when-turned": means(
        ("Improved DO (as printed)", "0.92"), ("Improved DO", "0.96"), sweep="rotation", level=60
    ),
    "as-printed/printed-behind-with-noise": means(
        ("Improved DO (as printed)", "0.43"), ("Improved DO", "0.80"), sweep="noise", level=0.1
    ),
}
