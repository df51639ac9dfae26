"""Checks of the lesson on how much there must be to learn from."""

from __future__ import annotations

from functools import cache

import numpy as np
from scipy.spatial import KDTree

from checks.helpers import BOTH, LEFT, RIGHT, Check, both_in_place, ends, map_of, map_size, training_error
from ido import Maps, Perturbation, TrainingSettings, perturb, register, score, train
from ido.training import training_scenes
from ido_viz.core.library import OVERFITTED, shipped_library
from ido_viz.core.run import Run
from ido_viz.core.verdict import Verdict

_STRONGER_RIDGE = TrainingSettings(samples=500, ridge=0.2)


def _was_learned(run: Run) -> bool:
    """Whether the scene is among those that the right side's maps were trained on."""
    maps = run.sides[RIGHT].maps
    assert maps is not None
    scenes, _ = training_scenes(run.subject.cloud(), maps.settings)
    return any(np.array_equal(scenes[i], run.scene.points) for i in range(len(scenes)))


@cache
def _accuracy(maps: Maps, seeds: int) -> float:
    """Mean PointAcc of maps of the bunny in scenes with the paper's default settings."""
    cloud = shipped_library().subject("bunny").cloud()
    scenes = [perturb(cloud, Perturbation(seed=seed)) for seed in range(seeds)]
    ended = [score(scene, register(maps, scene.points).T_model_scene[-1]) for scene in scenes]
    return float(np.mean([each.accuracy for each in ended]))


@cache
def _with_more_ridge() -> Maps:
    """Maps trained on the same 500 scenes, with a thousand times the ridge."""
    overfitted = shipped_library().subject("bunny").maps[OVERFITTED]()
    return train(shipped_library().subject("bunny").cloud(), overfitted.histogram, _STRONGER_RIDGE)


def _alikeness(run: Run, side: int, number: int) -> float:
    """Correlation of a map's entries with those of the nearest model points, the same side and row."""
    points = run.sides[side].histogram.model.points
    _, found = KDTree(points).query(points, k=2)
    nearest = np.asarray(found)[:, 1]
    entries = map_of(run.sides[side], number).reshape(6, 2, len(points))
    return float(np.corrcoef(entries.ravel(), entries[:, :, nearest].ravel())[0, 1])


CHECKS: dict[str, Check] = {
    "overfitting/scene-was-learned": _was_learned,
    "overfitting/learned-both-in-place": both_in_place,
    "overfitting/learned-is-nearer-after-five": lambda run: (
        [f"{side.scores.rmse[5]:.2f}" for side in run.sides] == ["0.27", "0.01"]
    ),
    "overfitting/errors-after-the-last-map": lambda run: (
        f"{training_error(run, LEFT):.3f}" == "0.008" and f"{training_error(run, RIGHT):.6f}" == "0.000005"
    ),
    "overfitting/left-in-place": ends(Verdict.IN_PLACE, LEFT),
    "overfitting/right-wrong": ends(Verdict.WRONG_POSE, RIGHT),
    "overfitting/right-fails-nearly-always": lambda run: np.allclose(
        [_accuracy(its.maps, 60) for its in run.sides if its.maps], (0.97, 0.05), atol=0.02
    ),
    "overfitting/right-stops-at-once": lambda run: (
        run.sides[RIGHT].trajectory.iterations == 30 and run.sides[RIGHT].trajectory.converged
    ),
    "overfitting/right-map-is-a-tenth": lambda run: map_size(run, RIGHT, 15) < map_size(run, LEFT, 15) / 10,
    "overfitting/no-error-was-left": lambda run: training_error(run, RIGHT, 14) < 1e-4,
    "overfitting/neighbours-alike-on-the-left": lambda run: _alikeness(run, LEFT, 15) > 0.4,
    "overfitting/nothing-in-common-on-the-right": lambda run: abs(_alikeness(run, RIGHT, 15)) < 0.05,
    "overfitting/first-map-is-larger": lambda run: 1.7 < map_size(run, RIGHT, 1) / map_size(run, LEFT, 1) < 2,
    "overfitting/easy-both-in-place": both_in_place,
    "overfitting/as-many-numbers-as-conditions": lambda run: all(
        run.sides[side].histogram.n_bins == 1028 for side in BOTH
    ),
    "overfitting/ridge-raises-the-training-error": lambda _: (
        f"{float(_with_more_ridge().curves.mean[-1]):.2f}" == "0.15"
    ),
    "overfitting/ridge-cures": lambda _: _accuracy(_with_more_ridge(), 20) > 0.8,
}
