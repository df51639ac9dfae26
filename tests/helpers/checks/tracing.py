"""Checks of the lesson on research: from a failure to the bins behind it, and a test whether they are the cause."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from checks.helpers import LEFT, RIGHT, Check, ends, page_of, rotation_error
from ido import Scene, register, score
from ido.attribution import bin_name
from ido.blocks import SIGMA2
from ido.poses import transform
from ido.types import DoubleArray
from ido_viz.core.inspection import Inspection, inspect
from ido_viz.core.run import Run
from ido_viz.core.verdict import Verdict

MISLEADING = page_of("misled/front-of-one-point-comes-first").inspected
"""Number of the model point whose bin *front* misleads most."""

_PIECE = page_of("misled/heaviest-point").scene_point
"""Scene point that weighs most in that bin."""


def _look(run: Run) -> Inspection:
    """What Improved DO makes of the start, towards the true pose."""
    found = inspect(run, page_of("misled/improved-do-wrong"), 0, RIGHT)
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
    return rotation_error(run, LEFT, 1) > rotation_error(run, LEFT, 0) and ends(Verdict.IN_PLACE, LEFT)(run)


CHECKS: dict[str, Check] = {
    "misled/improved-do-wrong": ends(Verdict.WRONG_POSE, RIGHT),
    "misled/first-update-leads-astray": lambda run: (
        [f"{rotation_error(run, RIGHT, k):.0f}" for k in (0, 1)] == ["90", "94"]
    ),
    "misled/pushes-nearly-cancel": lambda run: (
        [f"{v.sum():+.2f}" for v in (_look(run).values.clip(min=0), _look(run).values.clip(max=0))]
        == ["+2.08", "-2.10"]
    ),
    "misled/front-of-one-point-comes-first": lambda run: int(_look(run).strongest[0]) == MISLEADING,
    "misled/reference-has-nothing-there": lambda run: (
        run.sides[RIGHT].histogram.reference[MISLEADING] < 0.001 and f"{_look(run).seen[MISLEADING]:.2f}" == "0.07"
    ),
    "misled/neighbours-come-next": _neighbours_come_next,
    "misled/one-bin-decides": _one_bin_decides,
    "misled/eleven-points-fill-it": lambda run: (
        len(_in_the_bin(run)[0]) == 11
        and f"{_in_the_bin(run)[1][_in_the_bin(run)[0]].sum() / _in_the_bin(run)[1].sum():.0%}" == "95%"
    ),
    "misled/heaviest-point": lambda run: int(_in_the_bin(run)[1].argmax()) == _PIECE,
    "misled/one-is-an-outlier": lambda run: int(run.scene.is_outlier[_in_the_bin(run)[0]].sum()) == 1,
    "misled/they-belong-far-away": _belong_far_away,
    "misled/in-place-without-them": lambda run: _in_place_without(run, _in_the_bin(run)[0]),
    "misled/chance-does-not-help": _chance_does_not_help,
    "misled/still-wrong-without-the-bin": _still_wrong_without_the_bin,
    "misled/do-recovers": _recovers,
}
