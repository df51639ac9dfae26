"""A lesson on how much there must be to learn from."""

from __future__ import annotations

from functools import cache

import numpy as np
from scipy.spatial import KDTree

from ido import Maps, Perturbation, TrainingSettings, perturb, register, score, train
from ido.training import training_scenes
from ido_viz.lesson import BOTH, BOTH_IN_PLACE, LEFT, RIGHT, Claim, Lesson, Step, ends, map_of, map_size, training_error
from ido_viz.library import OVERFITTED, shipped_library
from ido_viz.run import Run
from ido_viz.state import State

_LEARNED = Perturbation(
    noise=0.019546499534180153,
    points=543,
    outliers=282,
    incomplete=0.2577427708745517,
    rotation=78.54537249725138,
    translation=0.2027010178646025,
    seed=1056358288,
)
"""One of the 500 scenes, exactly as it was drawn for the training."""

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


OVERFITTING = Lesson(
    "overfitting",
    "Learned by heart",
    (
        Step(
            (
                "Two DOs. The left one was trained on 30,000 scenes, the right one on 500, all else alike.",
                Claim("This scene is one of the 500.", _was_learned),
                BOTH_IN_PLACE,
                Claim(
                    "After five iterations the typical distance, PointRMSE, is 0.27 on the left and 0.01 on the right.",
                    lambda run: [f"{side.scores.rmse[5]:.2f}" for side in run.sides] == ["0.27", "0.01"],
                ),
                "Open **Training**:",
                Claim(
                    "after the last map, an error of 0.008 is left on the left, and on the right 0.000005.",
                    lambda run: (
                        f"{training_error(run, LEFT):.3f}" == "0.008"
                        and f"{training_error(run, RIGHT):.6f}" == "0.000005"
                    ),
                ),
                "Which would you take?",
            ),
            State(perturbation=_LEARNED, right=OVERFITTED, iteration=5, playing=False),
        ),
        Step(
            (
                "A new scene, with the paper's default settings.",
                Claim("The left DO ends *in place*,", ends("in place", LEFT)),
                Claim("the right one in a *wrong pose*.", ends("wrong pose", RIGHT)),
                Claim(
                    "Over 60 such scenes, the share of points put right is about 0.97 and 0.05.",
                    lambda run: np.allclose(
                        [_accuracy(its.maps, 60) for its in run.sides if its.maps], (0.97, 0.05), atol=0.02
                    ),
                ),
                Claim(
                    "The right one stops as soon as it may, at iteration 30:",
                    lambda run: run.sides[RIGHT].trajectory.iterations == 30 and run.sides[RIGHT].trajectory.converged,
                ),
                "it is sure of itself. It has learned its scenes by heart, not how to register. Press *New seed*.",
            ),
            State(perturbation=Perturbation(seed=3), right=OVERFITTED),
        ),
        Step(
            (
                "Look at **Maps**, here map 15.",
                Claim(
                    "The right one is less than a tenth as large:",
                    lambda run: map_size(run, RIGHT, 15) < map_size(run, LEFT, 15) / 10,
                ),
                Claim(
                    "there was no error left to learn from, less than 0.0001 after map 14.",
                    lambda run: training_error(run, RIGHT, 14) < 1e-4,
                ),
                Claim(
                    "On the left, neighbouring model points have similar numbers (their correlation is above 0.4),",
                    lambda run: _alikeness(run, LEFT, 15) > 0.4,
                ),
                Claim("on the right they have nothing in common:", lambda run: abs(_alikeness(run, RIGHT, 15)) < 0.05),
                "that is noise. Set *Map* to 1:",
                Claim(
                    "there the right one is nearly twice as large.",
                    lambda run: 1.7 < map_size(run, RIGHT, 1) / map_size(run, LEFT, 1) < 2,
                ),
            ),
            State(perturbation=Perturbation(seed=3), right=OVERFITTED, pinned_map=15, iteration=14, playing=False),
        ),
        Step(
            (
                "An easy scene: clean, turned by 20°.",
                BOTH_IN_PLACE,
                "Easy scenes do not show it either. What went wrong?",
                Claim(
                    "Each row of a map has 1028 unknown numbers, and 500 scenes give 500 conditions:",
                    lambda run: all(run.sides[side].histogram.n_bins == 1028 for side in BOTH),
                ),
                "all can be met, by chance patterns too. The cure is more scenes, or more *ridge*, which holds the "
                "numbers small. With 500 scenes and 1000 times the ridge,",
                Claim(
                    "the training error is 0.15, far worse,",
                    lambda _: f"{float(_with_more_ridge().curves.mean[-1]):.2f}" == "0.15",
                ),
                Claim("and more than 0.8 of the points come right.", lambda _: _accuracy(_with_more_ridge(), 20) > 0.8),
            ),
            State(
                perturbation=Perturbation(
                    noise=0.02, points=800, outliers=0, incomplete=0.0, rotation=20.0, translation=0.1, seed=0
                ),
                right=OVERFITTED,
                speed=5,
            ),
        ),
    ),
)
