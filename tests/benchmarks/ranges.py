"""Do maps that were trained on wider ranges register from farther away? Beside the paper's ranges, on the same scenes.

    python tests/benchmarks/ranges.py [--samples 30000] [--rotation 180] [--translation 1]

Prints the mean PointAcc of each sweep, for the maps alone and as starts of the global method (*many starts*).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import tyro
from rich.console import Console
from rich.table import Table

from ido import Maps, TrainingSettings, train
from ido.experiments.sweeps import LEVELS, mean_and_interval, sweep, sweep_scenes
from ido.global_registration import GlobalModel, GlobalRegistration, ManyStarts
from ido.perturbation import Perturbation
from ido.scores import score
from ido.shipped import shipped_cloud, shipped_maps
from ido.types import FloatArray

Accuracies = Callable[[str], FloatArray]
"""PointAcc of a sweep's scenes, shape (levels, scenes)."""


def main(
    shape: str = "bunny",
    histogram: str = "triple-binary",
    samples: int = 30_000,
    rotation: float = 180.0,
    translation: float = 1.0,
    scenes: int = 100,
    many_starts_scenes: int = 10,
) -> None:
    """Train and compare.

    Args:
        shape: of the shipped ones.
        histogram: of the maps.
        samples: training scenes.
        rotation: trained up to so many degrees.
        translation: trained up to so far, model units.
        scenes: at each level, for the maps alone.
        many_starts_scenes: at each level, for many starts.
    """
    cloud, feature = shipped_cloud(shape), shipped_maps(shape, histogram).histogram
    paper = TrainingSettings(samples=samples)
    console, trained = Console(), {}
    for settings in (paper, replace(paper, rotation=rotation, translation=translation)):
        title = f"to {settings.rotation:g}° and {settings.translation:g}"
        with console.status(f"training {title}"):
            trained[title] = train(cloud, feature, settings)
    model = GlobalModel.of(cloud.points)

    def alone(maps: Maps) -> Accuracies:
        return lambda name: sweep(cloud, maps, name, scenes=scenes)[..., 0]

    def as_starts(maps: Maps) -> Accuracies:
        registration = GlobalRegistration(model, starts=ManyStarts(maps))

        def accuracies(name: str) -> FloatArray:
            levels = sweep_scenes(cloud, Perturbation(), name, many_starts_scenes, 1_000_000)
            return np.array(
                [
                    [score(scene, registration.register(scene.points).T_model_scene[-1]).accuracy for scene in level]
                    for level in levels
                ]
            )

        return accuracies

    table = Table("maps", "", *LEVELS)
    for way, of_maps in (("alone", alone), ("many starts", as_starts)):
        for title, maps in trained.items():
            with console.status(f"{way}, {title}"):
                found = [mean_and_interval(of_maps(maps)(name)) for name in LEVELS]
            table.add_row(title, way, *(f"{mean:.3f} ± {half:.3f}" for mean, half in found))
    console.print(table)


if __name__ == "__main__":
    tyro.cli(main)
