"""Lessons on what is in a scene: outliers, and missing parts."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ido import Perturbation
from ido.histograms import SIGMA2
from ido.types import FloatArray
from ido_viz.lesson import (
    BOTH,
    BOTH_IN_PLACE,
    BOTH_WRONG,
    LEFT,
    RIGHT,
    Claim,
    Lesson,
    Step,
    at,
    change_by_outliers,
    ends,
    means,
)
from ido_viz.run import Run
from ido_viz.state import LAST, State

_FAR_OUTLIER = Perturbation(seed=3, outliers=1)
_FEW = Perturbation(seed=2, points=100, outliers=600)

_BESIDE, _ONE_OUTLIER = 298, 280
"""The one outlier that lies within the bunny, and the model point that is nearest to it."""


def _weight_beside(run: Run) -> float:
    away = run.scene.points[_ONE_OUTLIER].astype(np.float64) - run.sides[RIGHT].histogram.model.points[_BESIDE]
    return float(run.scene.is_outlier[_ONE_OUTLIER] * np.exp(-(away**2).sum() / SIGMA2))


OUTLIERS = Lesson(
    "outliers",
    "One outlier, and 300",
    (
        Step(
            (
                "*Outliers* are scene points that belong to nothing. There is one here, purple, far from the bunny.",
                Claim(
                    "For front and back it does not exist: DO's dots are the same without it.",
                    lambda run: float(change_by_outliers(run, LEFT)[0]) < 1e-5,
                ),
                "Up / down and clockwise / anticlockwise count it, wherever it lies,",
                Claim(
                    "but one among 280 changes them by less than a hundredth.",
                    lambda run: bool(np.all(change_by_outliers(run, RIGHT)[1:] < 0.01)),
                ),
                BOTH_IN_PLACE,
                "Press **P**.",
            ),
            State(perturbation=_FAR_OUTLIER, playing=False),
        ),
        Step(
            (
                "Here the one outlier lies within the bunny. Now front and back see it, and",
                Claim(
                    "it changes them more than five times as much as the two other blocks.",
                    lambda run: bool(
                        change_by_outliers(run, RIGHT)[0] > 5 * float(change_by_outliers(run, RIGHT)[1:].max())
                    ),
                ),
                "The model point beside it, yellow,",
                Claim("gives it a weight of 0.79,", lambda run: f"{_weight_beside(run):.2f}" == "0.79"),
                "as **Inspect** says.",
                BOTH_IN_PLACE,
                "A histogram adds up hundreds of points, so that a single one cannot pull it far. Press **P**.",
            ),
            State(
                perturbation=Perturbation(seed=1, outliers=1),
                playing=False,
                inspected=_BESIDE,
                scene_point=_ONE_OUTLIER,
            ),
        ),
        Step(
            (
                "The first scene again, with 300 outliers:",
                Claim(
                    "more than there are true points.",
                    lambda run: bool(run.scene.is_outlier.mean() > 0.5),
                ),
                Claim(
                    "They change DO's histogram by more than a fifth of its length.",
                    lambda run: float(change_by_outliers(run, LEFT)[0]) > 0.2,
                ),
                BOTH_IN_PLACE,
                "The maps have seen scenes with up to 300 outliers in training, and have learned to cope with them.",
            ),
            State(perturbation=replace(_FAR_OUTLIER, outliers=300)),
        ),
        Step(
            (
                "Now 600 outliers, and of the bunny only",
                Claim("70 points.", lambda run: int((~run.scene.is_outlier).sum()) == 70),
                BOTH_WRONG,
                "Is it the outliers? Drag *Points* to 400, and leave the 600 outliers:",
                Claim(
                    "both end *in place*.",
                    at(State(perturbation=replace(_FEW, points=400)), ends("in place", *BOTH)),
                ),
                "Now 100 points, and drag *Outliers* to 0:",
                Claim(
                    "both fail again.",
                    at(State(perturbation=replace(_FEW, outliers=0)), ends("wrong pose", *BOTH)),
                ),
                "In this scene it is the lack of points. Change one thing at a time before you blame it.",
            ),
            State(perturbation=_FEW),
        ),
    ),
)


def _share_of_reference(run: Run, side: int) -> FloatArray:
    """Front and back of each model point at the end, as a share of what the reference line holds; shape (M,)."""
    its = run.sides[side]
    n_model = len(its.histogram.model.points)
    seen, reference = (
        bins[: 2 * n_model].reshape(2, n_model).sum(axis=0)
        for bins in (run.histogram(side, run.iterations), its.histogram.reference)
    )
    return seen / reference


_MOSTLY_MISSING = Perturbation(seed=4, incomplete=0.7)

HALF = Lesson(
    "half",
    "Half of the cloud is missing",
    (
        Step(
            (
                "Half of the scene is cut away, as when a scanner sees one side of a thing.",
                BOTH_IN_PLACE,
                "Look at the dots at the end:",
                Claim(
                    "more than a third of the model points see less than half of what the line says,",
                    lambda run: all(float((_share_of_reference(run, s) < 0.5).mean()) > 0.34 for s in BOTH),
                ),
                "as nothing is left near them, and",
                Claim(
                    "more than a third see more than the line,",
                    lambda run: all(float((_share_of_reference(run, s) > 1).mean()) > 0.34 for s in BOTH),
                ),
                "as each block is scaled to the same length: what some bins lose, others gain.",
            ),
            State(perturbation=Perturbation(seed=2, incomplete=0.5), iteration=LAST, playing=False),
        ),
        Step(
            (
                "Seven of ten points are missing; the training had at most three of ten.",
                BOTH_WRONG,
                Claim(
                    "On 100 such scenes, the share of points put right is 0.49 for DO and 0.47 for Improved DO.",
                    means(("DO", "0.49"), ("Improved DO", "0.47"), sweep="incomplete", level=0.7),
                ),
                "It depends on the scene:",
                Claim(
                    "with *Seed* 0 both end *in place*.",
                    at(State(perturbation=replace(_MOSTLY_MISSING, seed=0)), ends("in place", *BOTH)),
                ),
            ),
            State(perturbation=_MOSTLY_MISSING),
        ),
        Step(
            (
                "The same scene without its outliers.",
                BOTH_IN_PLACE,
                "So the missing part alone did not do it. Of the bunny there are",
                Claim("120 points here,", lambda run: int((~run.scene.is_outlier).sum()) == 120),
                "and before there were 300 outliers among them. Drag *Outliers* up, and find where it breaks. Then try "
                "other seeds: is it always the outliers?",
            ),
            State(perturbation=replace(_MOSTLY_MISSING, outliers=0)),
        ),
    ),
)
