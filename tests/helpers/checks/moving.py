"""Checks of the lessons on what the methods make of what they see: maps, their iterations, and when to stop."""

from __future__ import annotations

import numpy as np

from checks.helpers import (
    BOTH,
    LEFT,
    RIGHT,
    Check,
    angle_share,
    both_in_place,
    both_wrong,
    ends,
    map_size,
    means,
    page_of,
    rotation_error,
    training_error,
)
from ido import perturb, register, score
from ido_viz.core.run import Run
from ido_viz.core.verdict import Verdict


def _first_step_is_mostly_better(run: Run) -> bool:
    """Whether Improved DO's first update leaves less rotation than DO's in more than half of 40 scenes."""
    better = 0
    for seed in range(40):
        scene = perturb(run.subject.cloud(), page_of("two-more/first-iteration-mostly-better", seed=seed).perturbation)
        left = []
        for side in run.sides:
            assert side.maps is not None
            trajectory = register(side.maps, scene.points, max_iterations=1)
            left.append(float(score(scene, trajectory.T_model_scene[-1]).rotation))
        better += left[RIGHT] < left[LEFT]
    return better > 20


PAPERS_EPSILON = page_of("stopping/both-wrong").epsilon


def _stop_of_paper(run: Run, side: int) -> int:
    """Iteration at which the paper's ε would have stopped a side: the first small update after the last map."""
    its = run.sides[side]
    assert its.maps is not None
    small = np.flatnonzero(its.norms < PAPERS_EPSILON)
    return int(small[small >= len(its.maps.maps)][0])


def _would_be_wrong(run: Run, side: int) -> bool:
    return float(run.sides[side].scores.accuracy[_stop_of_paper(run, side)]) < 0.5


_STOP_OF_DO = page_of("stopping/where-do-was-stopped").overlaid_iteration
"""Iteration at which the paper's ε stops DO, as the page has it."""


CHECKS: dict[str, Check] = {
    "two-more/do-is-still-far": lambda run: rotation_error(run, LEFT, 3) > 30,
    "two-more/improved-do-is-near": lambda run: rotation_error(run, RIGHT, 3) < 5,
    "two-more/first-iteration-mostly-better": _first_step_is_mostly_better,
    "two-more/do-in-place": ends(Verdict.IN_PLACE, LEFT),
    "two-more/improved-do-in-place": ends(Verdict.IN_PLACE, RIGHT),
    "two-more/both-near-after-ten": lambda run: all(rotation_error(run, side, 10) < 5 for side in BOTH),
    "two-more/do-wrong": ends(Verdict.WRONG_POSE, LEFT),
    "two-more/improved-do-right": ends(Verdict.IN_PLACE, RIGHT),
    "two-more/a-little-better-when-turned": means(("DO", "0.69"), ("Improved DO", "0.75"), sweep="rotation", level=90),
    "two-more/equal-over-all": means(("DO", "0.81"), ("Improved DO", "0.81")),
    "two-more/half-the-training-error": lambda run: training_error(run, RIGHT) < 0.5 * training_error(run, LEFT),
    "maps/a-third-for-angles": lambda run: 0.28 < angle_share(run, RIGHT, 1) < 0.40,
    "maps/little-error-was-left": lambda run: all(
        training_error(run, side, 14) < training_error(run, side, 0) / 30 for side in BOTH
    ),
    "maps/maps-are-a-fifth": lambda run: all(map_size(run, side, 15) < map_size(run, side, 1) / 5 for side in BOTH),
    "maps/hardly-any-for-angles": lambda run: angle_share(run, RIGHT, 15) < 0.05,
    "maps/maps-are-a-tenth": lambda run: all(map_size(run, side, 30) < map_size(run, side, 1) / 10 for side in BOTH),
    "maps/update-is-a-fiftieth": lambda run: all(
        side.trajectory.update_norms[29] < side.trajectory.update_norms[0] / 50 for side in run.sides
    ),
    "maps/both-in-place": both_in_place,
    "stopping/both-wrong": both_wrong,
    "stopping/do-gives-up": lambda run: run.sides[LEFT].trajectory.iterations < 50,
    "stopping/improved-do-gives-up": lambda run: run.sides[RIGHT].trajectory.iterations < 100,
    "stopping/both-in-place": both_in_place,
    "stopping/twice-the-iterations": lambda run: all(
        run.sides[side].trajectory.iterations > 2 * _stop_of_paper(run, side) for side in BOTH
    ),
    "stopping/still-wrong-when-stopped": lambda run: all(_would_be_wrong(run, side) for side in BOTH),
    "stopping/where-do-was-stopped": lambda run: _stop_of_paper(run, LEFT) == _STOP_OF_DO,
    "stopping/ordinary-both-in-place": both_in_place,
    "stopping/larger-epsilon-would-do": lambda run: all(
        _stop_of_paper(run, side) == 30 and run.sides[side].scores.accuracy[30] > 0.95 for side in BOTH
    ),
    "stopping/all-iterations-are-made": lambda run: all(side.trajectory.iterations == 300 for side in run.sides),
    "stopping/last-ones-hardly-move": lambda run: all(
        abs(s.scores.rmse[300] - s.scores.rmse[100]) < 0.02 for s in run.sides
    ),
}
