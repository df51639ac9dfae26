"""A lesson on research: from a failure to the bins that led there, and a test of whether they are the cause."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ido import Perturbation, Scene, register, score
from ido.attribution import bin_name
from ido.histograms import SIGMA2
from ido.poses import transform
from ido.types import DoubleArray
from ido_viz.lesson import LEFT, RIGHT, Claim, Lesson, Step, ends, rotation_error
from ido_viz.microscope import Inspection, inspect
from ido_viz.run import Run
from ido_viz.state import LAST, State

MISLEADING = 430
"""Number of the model point whose bin *front* misleads most."""

_PIECE = 179
"""Scene point that weighs most in that bin."""

_CASE = State(
    perturbation=Perturbation(seed=130, rotation=90.0),
    playing=False,
    coloring="towards the truth",
    order="contribution",
    inspected_pane="right",
)


def _look(run: Run) -> Inspection:
    """What Improved DO makes of the start, towards the true pose."""
    found = inspect(run, _CASE, 0)
    assert found is not None
    return found


def _one_bin_decides(run: Run) -> bool:
    """Whether the first update leads astray, and without what that one bin adds it would not."""
    values = _look(run).values
    return bool(values.sum() < 0 < values.sum() - values[MISLEADING])


def _in_the_bin(run: Run) -> tuple[np.ndarray, DoubleArray]:
    """Numbers of the scene points that weigh something in front of the misleading point, and all weights there."""
    model = run.sides[RIGHT].histogram.model
    offset = run.scene.points.astype(np.float64) - model.points[MISLEADING]
    weight = np.where(offset @ model.normals[MISLEADING] > 0, np.exp(-(offset**2).sum(axis=1) / SIGMA2), 0.0)
    return np.flatnonzero(weight > 0.05), weight


def _neighbours_come_next(run: Run) -> bool:
    """Whether two of the next three misleading bins are in front of model points close by."""
    histogram = run.sides[RIGHT].histogram
    names = [bin_name(histogram, int(number)) for number in _look(run).strongest[1:4]]
    close = np.linalg.norm(histogram.model.points - histogram.model.points[MISLEADING], axis=1) < 0.2
    return sum(side == "front" and bool(close[point]) for side, point in names) == 2


def _belong_far_away(run: Run) -> bool:
    piece = run.scene.points[_in_the_bin(run)[0]]
    away = np.linalg.norm(transform(run.scene.T_model_scene, piece) - piece, axis=1)
    return bool(np.all((away > 0.8) & (away < 1.2)))


def _in_place_without(run: Run, taken: np.ndarray) -> bool:
    """Whether Improved DO registers the scene when some of its points are taken away."""
    kept = np.ones(len(run.scene.points), dtype=bool)
    kept[taken] = False
    scene = Scene(run.scene.points[kept], run.scene.is_outlier[kept], run.scene.T_model_scene)
    maps = run.sides[RIGHT].maps
    assert maps is not None
    return bool(score(scene, register(maps, scene.points).T_model_scene[-1]).accuracy > 0.95)


def _chance_does_not_help(run: Run) -> bool:
    """Whether as many points taken away at random help in none of 20 tries."""
    rng = np.random.default_rng(0)
    taken = [rng.choice(len(run.scene.points), 11, replace=False) for _ in range(20)]
    return not any(_in_place_without(run, some) for some in taken)


def _still_wrong_without_the_bin(run: Run) -> bool:
    """Whether Improved DO fails as well with that one bin switched off in all maps."""
    its = run.sides[RIGHT]
    assert its.maps is not None
    off = its.maps.maps.copy()
    off[:, :, MISLEADING] = 0.0
    trajectory = register(replace(its.maps, maps=off), run.scene.points)
    return bool(score(run.scene, trajectory.T_model_scene[-1]).accuracy < 0.5)


def _recovers(run: Run) -> bool:
    """Whether DO's first update leads astray as well, and it ends in place all the same."""
    return rotation_error(run, LEFT, 1) > rotation_error(run, LEFT, 0) and ends("in place", LEFT)(run)


MISLED = Lesson(
    "misled",
    "Find the bin that misleads",
    (
        Step(
            (
                "A failure, and a way to search for its cause.",
                Claim("Improved DO ends in a *wrong pose*.", ends("wrong pose", RIGHT)),
                Claim(
                    "Its first update already leads astray: 90° to go become 94°.",
                    lambda run: [f"{rotation_error(run, RIGHT, k):.0f}" for k in (0, 1)] == ["90", "94"],
                ),
                "Open **Inspect**. The model's colours are *towards the truth*: a red point pushes towards the right "
                "pose, a blue one away from it. In **Histograms** the bins are ordered the same way.",
                Claim(
                    "Thousands of small pushes nearly cancel: +2.08 and -2.10.",
                    lambda run: (
                        [f"{v.sum():+.2f}" for v in (_look(run).values.clip(min=0), _look(run).values.clip(max=0))]
                        == ["+2.08", "-2.10"]
                    ),
                ),
            ),
            _CASE,
        ),
        Step(
            (
                "*Strongest bins* lists those that lead astray most.",
                Claim(
                    "First comes *front* of model point 430, now yellow.",
                    lambda run: int(_look(run).strongest[0]) == MISLEADING,
                ),
                Claim(
                    "The reference has nothing there (below 0.001), the bin holds 0.07.",
                    lambda run: (
                        run.sides[RIGHT].histogram.reference[MISLEADING] < 0.001
                        and f"{_look(run).seen[MISLEADING]:.2f}" == "0.07"
                    ),
                ),
                Claim("Two of the next three are neighbours of it, less than 0.2 away.", _neighbours_come_next),
                Claim(
                    "Without this one bin, the sum of all pushes would point the right way.",
                    _one_bin_decides,
                ),
                "Turn the view: the point is on the far side.",
            ),
            replace(_CASE, inspected=MISLEADING),
        ),
        Step(
            (
                "What is in this bin?",
                Claim(
                    "Eleven scene points, each with a weight above 0.05, make up 95% of it.",
                    lambda run: (
                        len(_in_the_bin(run)[0]) == 11
                        and f"{_in_the_bin(run)[1][_in_the_bin(run)[0]].sum() / _in_the_bin(run)[1].sum():.0%}" == "95%"
                    ),
                ),
                Claim("The heaviest is scene point 179.", lambda run: int(_in_the_bin(run)[1].argmax()) == _PIECE),
                "Outliers?",
                Claim("Only one of them.", lambda run: int(run.scene.is_outlier[_in_the_bin(run)[0]].sum()) == 1),
                "Follow the green lines:",
                Claim("they belong about 1.0 from here.", _belong_far_away),
                "A piece of the bunny lies where none should be, and the map takes it for something else.",
            ),
            replace(_CASE, inspected=MISLEADING, scene_point=_PIECE, error_vectors=True),
        ),
        Step(
            (
                "Is that the cause? A test in Python. Without these eleven of the 580 points",
                Claim("Improved DO ends in place;", lambda run: _in_place_without(run, _in_the_bin(run)[0])),
                Claim("without eleven drawn by chance it never does, in 20 draws.", _chance_does_not_help),
                "So this piece is to blame; the one bin is not:",
                Claim("switched off in all maps, Improved DO still fails,", _still_wrong_without_the_bin),
                "as the piece fills the bins around it too.",
                Claim("DO, too, turns the wrong way first, and recovers.", _recovers),
                "The strongest bin shows where to look. Only a test shows whether it is the cause.",
            ),
            replace(_CASE, iteration=LAST),
        ),
    ),
)
