"""Lessons on what the methods make of what they see: maps, their iterations, and when to stop."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ido import Perturbation, perturb, register, score
from ido_viz.lesson import (
    BOTH,
    BOTH_IN_PLACE,
    BOTH_WRONG,
    LEFT,
    RIGHT,
    Claim,
    Lesson,
    Step,
    angle_share,
    ends,
    map_size,
    means,
    rotation_error,
    training_error,
)
from ido_viz.run import Run, norms
from ido_viz.state import LAST, State


def _first_step_is_mostly_better(run: Run) -> bool:
    """Whether Improved DO's first update leaves less rotation than DO's in more than half of 40 scenes."""
    better = 0
    for seed in range(40):
        scene = perturb(run.subject.cloud(), replace(_QUARTER, seed=seed))
        left = []
        for side in run.sides:
            assert side.maps is not None
            trajectory = register(side.maps, scene.points, max_iterations=1)
            left.append(float(score(scene, trajectory.T_model_scene[-1]).rotation))
        better += left[RIGHT] < left[LEFT]
    return better > 20


_QUARTER = Perturbation(noise=0.02, points=1000, outliers=0, incomplete=0.0, rotation=90.0, translation=0.0, seed=17)

TWO_MORE = Lesson(
    "two-more",
    "What two more questions add",
    (
        Step(
            (
                "DO asks one question: front or back? Improved DO adds two: up or down, clockwise or anticlockwise. "
                "This clean scene is turned by 90°. Press **N** three times.",
                Claim("DO still has more than 30° to go,", lambda run: rotation_error(run, LEFT, 3) > 30),
                Claim("Improved DO less than 5°.", lambda run: rotation_error(run, RIGHT, 3) < 5),
                Claim(
                    "One scene proves little, but in more than half of 40 such scenes Improved DO's first iteration is "
                    "the better one, too.",
                    _first_step_is_mostly_better,
                ),
                "Try *New seed*.",
            ),
            State(perturbation=_QUARTER, playing=False),
        ),
        Step(
            (
                "The paper says that front and back alone leave out how points are turned. They do feel this turn, "
                "though:",
                Claim("DO ends *in place*,", ends("in place", LEFT)),
                Claim("as Improved DO does.", ends("in place", RIGHT)),
                Claim(
                    "After ten iterations both have less than 5° to go.",
                    lambda run: all(rotation_error(run, side, 10) < 5 for side in BOTH),
                ),
                "(A ball that is turned moves no dot; a bunny is no ball.) Here, then, the two questions give a better "
                "start, not something that DO cannot see.",
            ),
            State(perturbation=_QUARTER, speed=5),
        ),
        Step(
            (
                "A hard scene: 90°, noise, a part missing, 300 outliers.",
                Claim("DO ends in a *wrong pose*,", ends("wrong pose", LEFT)),
                Claim("Improved DO *in place*.", ends("in place", RIGHT)),
                Claim(
                    "On 100 such scenes, the share of points put right is 0.69 for DO and 0.75 for Improved DO.",
                    means(("DO", "0.69"), ("Improved DO", "0.75"), sweep="rotation", level=90),
                ),
                Claim(
                    "Over all our experiments on the bunny the two are equal: 0.81 and 0.81.",
                    means(("DO", "0.81"), ("Improved DO", "0.81")),
                ),
                "See **Sweeps**.",
            ),
            State(perturbation=Perturbation(rotation=90.0, seed=30)),
        ),
        Step(
            (
                "Open **Training**: how far the training scenes still are from their place after each map.",
                Claim(
                    "After the last map, Improved DO's error is less than half of DO's.",
                    lambda run: training_error(run, RIGHT) < 0.5 * training_error(run, LEFT),
                ),
                "It has learned the training scenes better. On new scenes, as the last step said, this pays little: "
                "learning the examples better is not the same as doing better elsewhere.",
            ),
            State(perturbation=Perturbation(seed=7)),
        ),
    ),
)

_MAPS = State(perturbation=Perturbation(seed=5), playing=False)

MAPS = Lesson(
    "maps",
    "Maps 1, 15 and 30",
    (
        Step(
            (
                "A *map* turns the dots of the histogram into the next update. Open **Maps**: a column for each bin, "
                "six rows for three numbers of shift (ρ) and three of turn (φ). Red and blue push opposite ways. Map 1 "
                "is made for scenes that are far off.",
                Claim(
                    "In Improved DO about a third of its strength (the sum of its squared numbers) belongs to the two "
                    "questions about angles.",
                    lambda run: 0.28 < angle_share(run, RIGHT, 1) < 0.40,
                ),
            ),
            replace(_MAPS, pinned_map=1),
        ),
        Step(
            (
                "Map 15 works on scenes that are nearly in place:",
                Claim(
                    "in training, less than a thirtieth of the error was left by then.",
                    lambda run: all(training_error(run, side, 14) < training_error(run, side, 0) / 30 for side in BOTH),
                ),
                Claim(
                    "Both methods' maps are now less than a fifth as large as map 1,",
                    lambda run: all(map_size(run, side, 15) < map_size(run, side, 1) / 5 for side in BOTH),
                ),
                Claim(
                    "and the questions about angles keep less than a twentieth of the strength.",
                    lambda run: angle_share(run, RIGHT, 15) < 0.05,
                ),
                "Near the goal, front and back say more. The scale above each map shows how small its numbers are.",
            ),
            replace(_MAPS, pinned_map=15, iteration=14),
        ),
        Step(
            (
                "Map 30 is the last, and is repeated until the update is smaller than ε.",
                Claim(
                    "Both maps are smaller than a tenth of map 1,",
                    lambda run: all(map_size(run, side, 30) < map_size(run, side, 1) / 10 for side in BOTH),
                ),
                Claim(
                    "and their first update here is less than a fiftieth of the very first one.",
                    lambda run: all(
                        side.trajectory.update_norms[29] < side.trajectory.update_norms[0] / 50 for side in run.sides
                    ),
                ),
                "Further down, **Maps** shows 1, 15 and 30 together, as the paper's figure does. Order the bins by "
                "*azimuth* to see patterns.",
                BOTH_IN_PLACE,
            ),
            replace(_MAPS, pinned_map=30, iteration=29),
        ),
    ),
)


PAPERS_EPSILON = 0.005


def _stop_of_paper(run: Run, side: int) -> int:
    """Iteration at which the paper's ε would have stopped a side: the first small update after the last map."""
    its = run.sides[side]
    assert its.maps is not None
    small = np.flatnonzero(norms(its) < PAPERS_EPSILON)
    return int(small[small >= len(its.maps.maps)][0])


def _would_be_wrong(run: Run, side: int) -> bool:
    return float(run.sides[side].scores.accuracy[_stop_of_paper(run, side)]) < 0.5


_SLOW = Perturbation(seed=7, translation=0.5)
_STOP_OF_DO = 31
"""Iteration at which the paper's ε stops DO in that scene."""

STOPPING = Lesson(
    "stopping",
    "Stopping too early, and too late",
    (
        Step(
            (
                "A method stops when its next update is smaller than ε. The paper takes ε = 0.005, and so does this "
                "page.",
                BOTH_WRONG,
                Claim(
                    "DO gives up after fewer than 50 iterations,",
                    lambda run: run.sides[LEFT].trajectory.iterations < 50,
                ),
                Claim(
                    "Improved DO after fewer than 100.",
                    lambda run: run.sides[RIGHT].trajectory.iterations < 100,
                ),
                "Open **Errors**. The third chart has the size of the updates, and ε as a dashed line. Remember the "
                "numbers.",
            ),
            State(perturbation=_SLOW, epsilon=PAPERS_EPSILON),
        ),
        Step(
            (
                "The same scene with ε = 0.001, the default here.",
                BOTH_IN_PLACE,
                Claim(
                    "Both take more than twice the iterations.",
                    lambda run: all(
                        run.sides[side].trajectory.iterations > 2 * _stop_of_paper(run, side) for side in BOTH
                    ),
                ),
                "Where ε = 0.005 stopped,",
                Claim(
                    "both were still in a wrong pose,",
                    lambda run: all(_would_be_wrong(run, side) for side in BOTH),
                ),
                "creeping on with small updates. The paler points stay at iteration 31,",
                Claim("where it stopped DO.", lambda run: _stop_of_paper(run, LEFT) == _STOP_OF_DO),
                "A small update does not mean that the goal is near.",
            ),
            State(perturbation=_SLOW, speed=40, overlay="another iteration", overlaid_iteration=_STOP_OF_DO),
        ),
        Step(
            (
                "An ordinary scene, with ε = 0.001.",
                BOTH_IN_PLACE,
                Claim(
                    "Here ε = 0.005 would have done as well: both are in place at iteration 30, as soon as stopping is "
                    "allowed.",
                    lambda run: all(
                        _stop_of_paper(run, side) == 30 and run.sides[side].scores.accuracy[30] > 0.95 for side in BOTH
                    ),
                ),
                "It is the hard scenes that need patience. Try *Stop below ε* at 0.01 and at 0.0001.",
            ),
            State(perturbation=Perturbation(seed=0), iteration=LAST, playing=False),
        ),
        Step(
            (
                "Too late exists as well: ε = 0.00001.",
                Claim(
                    "Both make all of the 300 iterations that this page allows,",
                    lambda run: all(side.trajectory.iterations == 300 for side in run.sides),
                ),
                Claim(
                    "though the last 200 hardly move anything: PointRMSE, the typical distance from the right place, "
                    "changes by less than 0.02.",
                    lambda run: all(abs(s.scores.rmse[300] - s.scores.rmse[100]) < 0.02 for s in run.sides),
                ),
                "The update goes on jittering and never gets that small.",
            ),
            State(perturbation=Perturbation(seed=0), epsilon=1e-5, max_iterations=300, iteration=LAST, playing=False),
        ),
    ),
)
