"""Lessons on how the methods see a scene."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ido import Perturbation
from ido.histograms import SIGMA2, azimuth, elevation
from ido.types import BoolArray, DoubleArray
from ido_viz.lesson import (
    BOTH,
    BOTH_IN_PLACE,
    LEFT,
    RIGHT,
    Claim,
    Lesson,
    Step,
    from_line,
    in_its_place,
    rotation_error,
)
from ido_viz.run import Run
from ido_viz.state import State

_CLEAN = Perturbation(noise=0.02, points=1000, outliers=0, incomplete=0.0, rotation=0.0, translation=0.0, seed=1)
_TURNED = replace(_CLEAN, rotation=60.0)


def _off_line(run: Run, iteration: int) -> float:
    """How far the left side's dots are from the line after so many iterations."""
    return float(from_line(run.sides[LEFT], run.histogram(LEFT, iteration))[0])


def _off_line_in_place(run: Run) -> float:
    return float(from_line(run.sides[LEFT], in_its_place(run, LEFT))[0])


TAIL = 28
"""Number of a model point on the bunny's tail."""

_IN_FRONT, _BEHIND, _FAR = 69, 159, 359
"""Scene points of `_SPARSE`: two near the tail, and one at the ears."""

_SPARSE = replace(_CLEAN, noise=0.05, points=400)
_ONE_PAIR = State(perturbation=_SPARSE, playing=False, inspected=TAIL, inspected_pane="left", scene_point=_IN_FRONT)


def _of_tail(run: Run) -> tuple[BoolArray, DoubleArray]:
    """Which scene points lie in front of the tail's point at the start, and what each of them weighs."""
    model = run.sides[LEFT].histogram.model
    offset = run.scene.points.astype(np.float64) - model.points[TAIL]
    return offset @ model.normals[TAIL] > 0, np.exp(-(offset**2).sum(axis=1) / SIGMA2)


def _weight(run: Run, scene_point: int) -> float:
    return float(_of_tail(run)[1][scene_point])


def _share_of_bin(run: Run, scene_point: int) -> float:
    """Share of a scene point in what its side of the tail's point adds up to."""
    front, weight = _of_tail(run)
    return float(weight[scene_point] / weight[front == front[scene_point]].sum())


HISTOGRAM = Lesson(
    "histogram",
    "What a histogram sees",
    (
        Step(
            (
                "Grey is the *model*, coloured the *scene*: a copy of it, here already in its place. In the left pane "
                "all but one scene point are faded. At the tail, one model point, yellow, asks it: *are you in front "
                "of me, outside my plane, or behind me?*",
                Claim("In front,", lambda run: bool(_of_tail(run)[0][_IN_FRONT])),
                "so it adds its *weight* to this model point's bin *front*.",
                Claim("The weight is 0.59 of 1:", lambda run: f"{_weight(run, _IN_FRONT):.2f}" == "0.59"),
                "the nearer, the more. The last table of **Inspect** has these numbers.",
            ),
            _ONE_PAIR,
        ),
        Step(
            (
                "The same model point, another scene point.",
                Claim("This one is behind,", lambda run: not _of_tail(run)[0][_BEHIND]),
                "on the other side of the plane, and further away:",
                Claim("it adds only 0.04", lambda run: f"{_weight(run, _BEHIND):.2f}" == "0.04"),
                Claim(
                    "and is a thirtieth of the bin *back*.", lambda run: 1 / 33 < _share_of_bin(run, _BEHIND) < 1 / 30
                ),
                "In **Inspect**, set *Scene point* to 359, at the ears:",
                Claim("its weight is nothing.", lambda run: _weight(run, _FAR) < 1e-6),
                Claim(
                    "Of the 400 scene points, 15 weigh more than a hundredth here.",
                    lambda run: len(run.scene.points) == 400 and int((_of_tail(run)[1] > 0.01).sum()) == 15,
                ),
            ),
            replace(_ONE_PAIR, scene_point=_BEHIND),
        ),
        Step(
            (
                "Now all points of the scene, and all of the model. Look at **Histograms**. Each dot is a bin: how "
                "much of the scene lies near one point of the model, in front of it or behind it. The line is what the "
                "model sees of itself.",
                Claim("The dots gather along the line", lambda run: _off_line(run, 0) < 0.45),
                Claim(
                    "but do not lie on it, because the scene has points of its own.",
                    lambda run: _off_line(run, 0) > 0.1,
                ),
                "Try *Histogram minus reference* under *View*.",
            ),
            State(perturbation=_CLEAN, playing=False),
        ),
        Step(
            (
                "Now the scene is turned by 60°.",
                Claim(
                    "The dots have left the line: they are more than twice as far from it as when the scene is in its "
                    "place.",
                    lambda run: _off_line(run, 0) > 2 * _off_line_in_place(run),
                ),
                "This is all that a method knows. Nobody tells it which point belongs to which. Drag *Rotation* slowly "
                "to 0, and see the dots come back. Then press **Again**.",
            ),
            State(perturbation=_TURNED, playing=False),
        ),
        Step(
            (
                "The same scene, played slowly. At every *iteration* a method looks at its dots and works out a small "
                "turn and shift of the scene, its *update*.",
                Claim(
                    "Five iterations undo nine tenths of the turn in both panes.",
                    lambda run: all(rotation_error(run, side, 5) < 6 for side in BOTH),
                ),
                BOTH_IN_PLACE,
                Claim(
                    "The dots are back at the line, less than half as far from it as at the start.",
                    lambda run: _off_line(run, run.iterations) < 0.5 * _off_line(run, 0),
                ),
                "The last chart of **Errors**, further down, draws this distance. Press **R**, then **N** for one "
                "iteration at a time.",
            ),
            State(perturbation=_TURNED, speed=3),
        ),
    ),
)

EAR = 378
"""Number of the model point at the tip of the bunny's ear."""


def _counts_near(run: Run, least: float) -> float:
    """Share of the scene points that count at least so much, of 1, for the ear's front and back."""
    ear = run.sides[RIGHT].histogram.model.points[EAR]
    return float((np.exp(-((run.scene.points - ear) ** 2).sum(axis=1) / SIGMA2) >= least).mean())


def _above(run: Run) -> BoolArray:
    ear = run.sides[RIGHT].histogram.model.points[[EAR]]
    return elevation(run.scene.points) > elevation(ear)


def _clockwise(run: Run) -> BoolArray:
    ear = run.sides[RIGHT].histogram.model.points[[EAR]]
    return azimuth(run.scene.points) > azimuth(ear)


def _pair_sums_are_equal(run: Run) -> bool:
    """Whether the two bins of every model point add up to the same, in both blocks of angles, at the start."""
    n_model = len(run.sides[RIGHT].histogram.model.points)
    pairs = run.histogram(RIGHT, 0).reshape(3, 2, n_model)[1:].sum(axis=1)
    return bool(np.allclose(pairs, pairs[:, :1], rtol=1e-4))


_EAR = State(perturbation=_SPARSE, playing=False, inspected=EAR)

BINARIES = Lesson(
    "binaries",
    "Three questions of one model point",
    (
        Step(
            (
                "Look at the tip of the ear in the right pane. This model point asks of each scene point: *are you in "
                "front of me, outside the surface, or behind me?* The colours are the answers, paler where an answer "
                "counts less: it fades with distance.",
                Claim(
                    "Fewer than one in twenty of the scene points count for even a hundredth of one point.",
                    lambda run: _counts_near(run, 0.01) < 0.05,
                ),
                "Click other grey points in the right pane. **Inspect** shows their numbers.",
            ),
            _EAR,
        ),
        Step(
            (
                "The second question, asked by Improved DO alone: *do you lie higher than I, seen from the middle?* "
                "Distance plays no part. *Up* is the z axis of the file; for this bunny that is towards you, not "
                "towards its ears, as the page opens. So",
                Claim(
                    "most points count as above the tip of the ear,",
                    lambda run: float(_above(run).mean()) > 0.6,
                ),
                "which leans back. Drag *Rotation*, and watch points change sides.",
            ),
            replace(_EAR, question="up / down"),
        ),
        Step(
            (
                "The third question: *are you further round than I?* It is the angle around the same axis, the one "
                "that points at you. The paper calls the side of larger angles clockwise.",
                Claim(
                    "For the ear, it holds less than half of the points.",
                    lambda run: float(_clockwise(run).mean()) < 0.45,
                ),
                Claim(
                    "For every model point the two bins of such a question add up to the same number,",
                    _pair_sums_are_equal,
                ),
                "as each scene point is on one side or the other. Front and back do not: far points count for neither.",
            ),
            replace(_EAR, question="clockwise / anticlockwise"),
        ),
    ),
)
