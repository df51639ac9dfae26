"""The sweeps' scenes and their summary."""

from __future__ import annotations

import numpy as np
import pytest

from ido import Perturbation, shipped_cloud
from ido.experiments import LEVELS, mean_and_interval, sweep_scenes, sweeps


def test_the_interval_covers_the_truth_19_times_out_of_20():
    rng = np.random.default_rng(0)
    truth = np.linspace(0.2, 0.9, 5)  # the levels differ, their mean is what counts
    covered = 0
    for _ in range(400):
        mean, half = mean_and_interval(rng.normal(truth[:, None], 0.1, (5, 40)))
        covered += abs(mean - truth.mean()) <= half
    assert covered / 400 == pytest.approx(0.95, abs=0.03)


def test_a_sweep_varies_one_perturbation_and_draws_every_scene_anew():
    levels = list(sweep_scenes(shipped_cloud("bunny"), Perturbation(noise=0.0), "outliers", scenes=3, seed=5))
    assert [[int(scene.is_outlier.sum()) for scene in level] for level in levels] == [
        [n] * 3 for n in LEVELS["outliers"]
    ]
    poses = [scene.T_model_scene.tobytes() for level in levels for scene in level]
    assert len(set(poses)) == len(poses)
    assert all((~scene.is_outlier).sum() == 280 for level in levels for scene in level)


def test_the_seeds_of_the_published_scenes_stay_and_do_not_depend_on_the_order_of_a_table(
    monkeypatch: pytest.MonkeyPatch,
):
    def seeds() -> dict[str, int]:
        levels = {name: sorted(its.levels)[1] for name, its in sweeps.SWEEPS.items()}
        return {n: sweeps.level_scene(Perturbation(), n, level, 2, 100, 1_000_000).seed for n, level in levels.items()}

    published = {
        "noise": 1_000_102,
        "points": 1_010_102,
        "outliers": 1_020_102,
        "incomplete": 1_030_102,
        "rotation": 1_040_102,
        "translation": 1_050_102,
    }
    assert seeds() == published
    turned = {n: sweeps.Sweep(its.number, dict(reversed(list(its.levels.items())))) for n, its in sweeps.SWEEPS.items()}
    monkeypatch.setattr(sweeps, "SWEEPS", dict(reversed(turned.items())))
    assert seeds() == published
