"""Checks of the lessons on scenes that lie far off: long ways and large turns."""

from __future__ import annotations

import numpy as np

from checks.helpers import (
    LEFT,
    RIGHT,
    Check,
    all_of,
    at,
    both_in_place,
    both_wrong,
    ends,
    in_its_place,
    mean,
    means,
    page_of,
    paper_says,
    rotation_error,
)
from ido import FrontBack
from ido.methods import method_names
from ido.types import FloatArray
from ido_viz.core.run import Run
from ido_viz.core.verdict import Verdict


def _sees_something(run: Run) -> FloatArray:
    """How much lies near each model point at the start, front and back together, in scene points; shape (M,)."""
    histogram = run.sides[LEFT].histogram
    assert isinstance(histogram, FrontBack)
    return histogram.sides(run.scene.points.astype(np.float64))[:2].sum(axis=0)


def _angle_bins(run: Run) -> FloatArray:
    n_model = len(run.sides[RIGHT].histogram.model.points)
    return run.histogram(RIGHT, 0)[2 * n_model :]


def _distance_in_place(run: Run, side: int) -> float:
    """How far the whole histogram would be from the line if the scene lay in its place."""
    reference = run.sides[side].histogram.reference
    return float(np.linalg.norm(in_its_place(run, side) - reference) / np.linalg.norm(reference))


CHECKS: dict[str, Check] = {
    "dark/most-see-nothing": lambda run: float((_sees_something(run) < 0.1).mean()) > 0.5,
    "dark/angles-still-see": lambda run: float((_angle_bins(run) > 0).mean()) > 0.9,
    "dark/paper-has-improved-do-ahead": paper_says("translation", ("DO", "0.545"), ("Improved DO", "0.755")),
    "dark/here-they-are-equal": means(("DO", "0.67"), ("Improved DO", "0.67"), sweep="translation"),
    "dark/both-wrong": both_wrong,
    "dark/untrained-both-in-place": both_in_place,
    "dark/tuned-put-most-right": means(
        ("GMMReg, tuned", "0.85"), ("CPD, tuned", "0.86"), sweep="translation", level=0.8
    ),
    "dark/learned-put-fewer-right": means(("DO", "0.30"), ("Improved DO", "0.39"), sweep="translation", level=0.8),
    "dark/improved-do-in-place": ends(Verdict.IN_PLACE, RIGHT),
    "dark/do-wrong": ends(Verdict.WRONG_POSE, LEFT),
    "dark/another-seed-the-other-way-round": at(
        page_of("dark/another-seed-the-other-way-round", seed=3),
        all_of(ends(Verdict.IN_PLACE, LEFT), ends(Verdict.WRONG_POSE, RIGHT)),
    ),
    "dark/ahead-when-far": means(("Improved DO", "0.39"), ("DO", "0.30"), sweep="translation", level=0.8),
    "dark/behind-when-nearer": means(("Improved DO", "0.53"), ("DO", "0.58"), sweep="translation", level=0.6),
    "turn/quarter-both-in-place": both_in_place,
    "turn/quarter-not-sure": means(("DO", "0.69"), ("Improved DO", "0.75"), sweep="rotation", level=90),
    "turn/improved-do-is-ahead-after-twenty": lambda run: (
        rotation_error(run, RIGHT, 20) < 10 and rotation_error(run, LEFT, 20) > 20
    ),
    "turn/both-wrong": both_wrong,
    "turn/both-stop-by-themselves": lambda run: all(side.trajectory.converged for side in run.sides),
    "turn/dots-stay-further-from-the-line": lambda run: all(
        side.distances[-1] > _distance_in_place(run, i) for i, side in enumerate(run.sides)
    ),
    "turn/few-come-right": means(("DO", "0.27"), ("Improved DO", "0.28"), sweep="rotation", level=120),
    "turn/another-scene-both-in-place": both_in_place,
    "turn/both-near-after-thirty": lambda run: all(side.scores.rmse[30] < 0.1 for side in run.sides),
    "turn/half-turn-both-wrong": both_wrong,
    "turn/no-method-turns-it": lambda _: all(mean(name, "rotation", 180) < 0.05 for name in method_names("bunny")),
}
