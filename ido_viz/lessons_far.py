"""Lessons on scenes that lie far off: long ways and large turns."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ido import FrontBack, Perturbation
from ido.methods import method_names
from ido.types import FloatArray
from ido_viz.lesson import (
    BOTH_IN_PLACE,
    BOTH_WRONG,
    LEFT,
    RIGHT,
    Claim,
    Lesson,
    Step,
    at,
    ends,
    in_its_place,
    mean,
    means,
    paper_says,
    rotation_error,
)
from ido_viz.run import Run
from ido_viz.state import State


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


_FAR = Perturbation(seed=11, translation=0.8)

DARK = Lesson(
    "dark",
    "When the Gaussian goes dark",
    (
        Step(
            (
                "Front and back weigh each scene point by a *Gaussian*, a bell curve of the distance: at 0.3 it is "
                "down to a twentieth. Here the scene lies 1.0 away.",
                Claim(
                    "More than half of the model points see less than a tenth of one point.",
                    lambda run: float((_sees_something(run) < 0.1).mean()) > 0.5,
                ),
                "The angles have no Gaussian:",
                Claim(
                    "nine of ten of their bins hold something.",
                    lambda run: float((_angle_bins(run) > 0).mean()) > 0.9,
                ),
                "Drag *Translation* to 0, and see the light return.",
            ),
            State(perturbation=replace(_FAR, translation=1.0, outliers=0), playing=False),
        ),
        Step(
            (
                "A translation of 0.8; the training had at most 0.3. Beyond 0.7 the paper expects DO to fall off, and "
                "Improved DO to hold on better, thanks to its angles. On average over the sweep",
                Claim(
                    "it has 0.545 and 0.755 of the points right.",
                    paper_says("translation", ("DO", "0.545"), ("Improved DO", "0.755")),
                ),
                "Here",
                Claim(
                    "they are equal: 0.67 and 0.67.",
                    means(("DO", "0.67"), ("Improved DO", "0.67"), sweep="translation"),
                ),
                Claim("In this scene both end in a *wrong pose*.", BOTH_WRONG.holds),
            ),
            State(perturbation=_FAR, speed=30),
        ),
        Step(
            (
                "The same scene, with two methods that learn nothing, GMMReg and CPD, set to suit such scenes "
                "(*tuned*).",
                BOTH_IN_PLACE,
                Claim(
                    "On 100 scenes 0.8 away they put 0.85 and 0.86 of the points right,",
                    means(("GMMReg, tuned", "0.85"), ("CPD, tuned", "0.86"), sweep="translation", level=0.8),
                ),
                Claim(
                    "DO 0.30 and Improved DO 0.39.",
                    means(("DO", "0.30"), ("Improved DO", "0.39"), sweep="translation", level=0.8),
                ),
            ),
            State(perturbation=_FAR, left="GMMReg, tuned", right="CPD, tuned"),
        ),
        Step(
            (
                "Is the paper's idea wrong? Here is a scene where",
                Claim("Improved DO ends *in place*", ends("in place", RIGHT)),
                Claim("and DO in a *wrong pose*.", ends("wrong pose", LEFT)),
                Claim(
                    "With *Seed* 3 it is the other way round.",
                    at(
                        State(perturbation=replace(_FAR, seed=3)),
                        lambda run: ends("in place", LEFT)(run) and ends("wrong pose", RIGHT)(run),
                    ),
                ),
                "With 100 scenes each,",
                Claim(
                    "Improved DO is ahead at 0.8, by 0.39 against 0.30,",
                    means(("Improved DO", "0.39"), ("DO", "0.30"), sweep="translation", level=0.8),
                ),
                Claim(
                    "and behind at 0.6, by 0.53 against 0.58.",
                    means(("Improved DO", "0.53"), ("DO", "0.58"), sweep="translation", level=0.6),
                ),
                "One scene, or one level, can show anything.",
            ),
            State(perturbation=replace(_FAR, seed=6), speed=60),
        ),
    ),
)

FAR_TURN = Lesson(
    "turn",
    "Turned by 90°, 120°, 180°",
    (
        Step(
            (
                "A turn of 90° is the largest that the training had.",
                BOTH_IN_PLACE,
                Claim(
                    "This is not sure any more: on 100 such scenes, the share of points put right is 0.69 and 0.75.",
                    means(("DO", "0.69"), ("Improved DO", "0.75"), sweep="rotation", level=90),
                ),
                Claim(
                    "After 20 iterations Improved DO has less than 10° to go, DO more than 20°.",
                    lambda run: rotation_error(run, RIGHT, 20) < 10 and rotation_error(run, LEFT, 20) > 20,
                ),
                "Each pane has the other's scene laid over its own (*Overlay*, under *View*). Press **P**.",
            ),
            State(
                perturbation=Perturbation(seed=2, rotation=90.0),
                iteration=20,
                playing=False,
                speed=8,
                overlay="other method",
            ),
        ),
        Step(
            (
                "At 120° we leave what was learned.",
                BOTH_WRONG,
                Claim(
                    "Both stop by themselves all the same:",
                    lambda run: all(side.trajectory.converged for side in run.sides),
                ),
                "the update became small, and that is all that a method can notice. The green lines to where each "
                "point belongs are for us alone.",
                Claim(
                    "The dots stay further from the line than they would in place",
                    lambda run: all(
                        side.distances[-1] > _distance_in_place(run, i) for i, side in enumerate(run.sides)
                    ),
                ),
                "(last chart of **Errors**, further down), but the maps make nothing of it.",
                Claim(
                    "On 100 such scenes, 0.27 and 0.28 of the points are put right.",
                    means(("DO", "0.27"), ("Improved DO", "0.28"), sweep="rotation", level=120),
                ),
            ),
            State(perturbation=Perturbation(seed=3, rotation=120.0), error_vectors=True),
        ),
        Step(
            (
                "Another scene at 120°.",
                BOTH_IN_PLACE,
                "The turn is as large; its axis, the missing side and the outliers are others.",
                Claim(
                    "After 30 iterations the typical distance from the right place, PointRMSE, is below 0.1.",
                    lambda run: all(side.scores.rmse[30] < 0.1 for side in run.sides),
                ),
                "Press *New seed*, and count how many of ten scenes end in place. Does it fit the average that you "
                "just read?",
            ),
            State(perturbation=Perturbation(seed=10, rotation=120.0)),
        ),
        Step(
            (
                "At 180° the scene faces the other way.",
                BOTH_WRONG,
                Claim(
                    "No method that we compare puts more than a twentieth of the points right at 180°.",
                    lambda _: all(mean(name, "rotation", 180) < 0.05 for name in method_names("bunny")),
                ),
                "All of them set out from where the scene lies, and go on in small steps. There are methods that "
                "search all turns; none is among those of the paper.",
            ),
            State(perturbation=Perturbation(seed=1, rotation=180.0), speed=30),
        ),
    ),
)
