"""Checks of the lessons on what is in a scene: outliers, and missing parts."""

from __future__ import annotations

import numpy as np

from checks.helpers import (
    BOTH,
    LEFT,
    RIGHT,
    Check,
    at,
    both_in_place,
    both_wrong,
    change_by_outliers,
    means,
    page_of,
)
from ido.blocks import SIGMA2
from ido.types import FloatArray
from ido_viz.core.run import Run

_INSIDE = page_of("outliers/weighs-much-beside-it")
_BESIDE, _ONE_OUTLIER = _INSIDE.inspected, _INSIDE.scene_point
"""The model point that is nearest to the one outlier that lies within the bunny, and that outlier."""


def _weight_beside(run: Run) -> float:
    away = run.scene.points[_ONE_OUTLIER].astype(np.float64) - run.sides[RIGHT].histogram.model.points[_BESIDE]
    return float(run.scene.is_outlier[_ONE_OUTLIER] * np.exp(-(away**2).sum() / SIGMA2))


def _share_of_reference(run: Run, side: int) -> FloatArray:
    """Front and back of each model point at the end, as a share of what the reference line holds; shape (M,)."""
    its = run.sides[side]
    n_model = len(its.histogram.model.points)
    seen, reference = (
        bins[: 2 * n_model].reshape(2, n_model).sum(axis=0)
        for bins in (run.histogram(side, run.iterations), its.histogram.reference)
    )
    return seen / reference


CHECKS: dict[str, Check] = {
    "outliers/unseen-by-do": lambda run: float(change_by_outliers(run, LEFT)[0]) < 1e-5,
    "outliers/hardly-counted-by-angles": lambda run: bool(np.all(change_by_outliers(run, RIGHT)[1:] < 0.01)),
    "outliers/far-outlier-both-in-place": both_in_place,
    "outliers/front-and-back-see-it": lambda run: bool(
        change_by_outliers(run, RIGHT)[0] > 5 * float(change_by_outliers(run, RIGHT)[1:].max())
    ),
    "outliers/weighs-much-beside-it": lambda run: f"{_weight_beside(run):.2f}" == "0.79",
    "outliers/near-outlier-both-in-place": both_in_place,
    "outliers/more-than-true-points": lambda run: bool(run.scene.is_outlier.mean() > 0.5),
    "outliers/change-a-fifth": lambda run: float(change_by_outliers(run, LEFT)[0]) > 0.2,
    "outliers/three-hundred-both-in-place": both_in_place,
    "outliers/seventy-points": lambda run: int((~run.scene.is_outlier).sum()) == 70,
    "outliers/both-wrong": both_wrong,
    "outliers/more-points-help": at(page_of("outliers/more-points-help", points=400), both_in_place),
    "outliers/fewer-outliers-do-not": at(page_of("outliers/fewer-outliers-do-not", outliers=0), both_wrong),
    "half/both-in-place": both_in_place,
    "half/a-third-sees-less": lambda run: all(float((_share_of_reference(run, s) < 0.5).mean()) > 0.34 for s in BOTH),
    "half/a-third-sees-more": lambda run: all(float((_share_of_reference(run, s) > 1).mean()) > 0.34 for s in BOTH),
    "half/both-wrong": both_wrong,
    "half/half-come-right": means(("DO", "0.49"), ("Improved DO", "0.47"), sweep="incomplete", level=0.7),
    "half/another-seed-in-place": at(page_of("half/another-seed-in-place", seed=0), both_in_place),
    "half/no-outliers-both-in-place": both_in_place,
    "half/points-left": lambda run: int((~run.scene.is_outlier).sum()) == 120,
}
