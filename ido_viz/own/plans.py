"""How long a training takes on this machine, and how large it may be for a given time."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from ido import Cloud, Model, TrainingSettings
from ido.folding import Folding
from ido.training import solve, training_scenes
from ido_viz.own.kept import TRAINED

Result = TypeVar("Result")

_PAPER = TrainingSettings()

FEWEST_SCENES = 200
"""Of a training, however slow the machine is."""

_TRIED = 100  # scenes of the calibration
_SPARE = 0.8  # of the time, that is planned with


@dataclass(frozen=True, slots=True)
class Cost:
    """Seconds that a training of all methods takes on this machine while it is as busy as it was.

    Args:
        scene: to draw a scene.
        scene_in_map: for each scene, in a map of each method together.
        map_itself: in a map of each method together, however many scenes there are.
    """

    scene: float
    scene_in_map: float
    map_itself: float

    def seconds(self, settings: TrainingSettings) -> float:
        """Of a training, without the start of its process."""
        return settings.samples * self.scene + settings.maps * (settings.samples * self.scene_in_map + self.map_itself)


@dataclass(frozen=True, slots=True)
class Plan:
    """A training by the time that it may take.

    Args:
        limit: seconds; None for as long as it needs.
        maps: number of maps.
        most_scenes: however fast the machine is.
    """

    limit: float | None
    maps: int
    most_scenes: int

    def settings(self, cost: Cost, rotation: float, translation: float) -> TrainingSettings:
        """As many scenes as there is time for, in round numbers."""
        samples = self.most_scenes
        if self.limit is not None:
            left = self.limit * _SPARE - self.maps * cost.map_itself
            fit = left / (cost.scene + self.maps * cost.scene_in_map)
            samples = min(max(_rounded_down(fit), FEWEST_SCENES), self.most_scenes)
        return TrainingSettings(
            samples=samples,
            maps=self.maps,
            first_ridge=_PAPER.ridge * max(_PAPER.samples / samples, 1.0),  # N λ is that of the paper
            rotation=rotation,
            translation=translation,
        )


PLANS: dict[str, Plan] = {
    "quick": Plan(30.0, 10, 10_000),
    "standard": Plan(120.0, 20, 30_000),
    "paper": Plan(None, _PAPER.maps, _PAPER.samples),
}
"""What a person can choose."""


def measured_cost(cloud: Cloud, model: Model) -> Cost:
    """The cost of training on a cloud, measured with a few scenes in about a second."""
    settings = TrainingSettings(samples=_TRIED)
    training_scenes(cloud, TrainingSettings(samples=2))  # imports and compiles
    drawing, (scenes, x_true) = _timed(lambda: training_scenes(cloud, settings))
    x = np.zeros_like(x_true)
    scene_in_map = map_itself = 0.0
    for kind in TRAINED.values():
        histogram = kind(model)
        histogram.batch(scenes.part(0, 2), x[:2])  # compiles
        describing, seen = _timed(lambda histogram=histogram: histogram.batch(scenes, x))
        z = Folding.of(histogram).fold(seen)
        fewest = z.shape[1]  # with fewer, a regression is another one; see `ido.training.solve`
        few, many = (_regression_seconds(z, rows) for rows in (fewest, 2 * fewest))
        in_row = max(many - few, 0.0) / fewest
        scene_in_map += describing / _TRIED + in_row
        map_itself += max(few - fewest * in_row, 0.0)
    return Cost(drawing / _TRIED, scene_in_map, map_itself)


def _regression_seconds(z: np.ndarray, rows: int) -> float:
    h = np.resize(z, (rows, z.shape[1]))
    return _timed(lambda: solve(h, np.ones((rows, 6)), _PAPER.ridge))[0]


def _timed(work: Callable[[], Result]) -> tuple[float, Result]:
    began = time.perf_counter()
    result = work()
    return time.perf_counter() - began, result


def _rounded_down(number: float) -> int:
    """To two digits."""
    whole = max(int(number), 0)
    step = 10 ** max(len(str(whole)) - 2, 0)
    return whole // step * step


def time_left(expected: float, times: Sequence[float], of: int) -> float:
    """Seconds until the last map: each takes the mean of those so far, among which the expected one counts as one.

    Args:
        expected: seconds of the whole training.
        times: when learning began, and when each map so far was there; seconds.
        of: maps in all.
    """
    done = len(times) - 1
    return (expected / of + times[-1] - times[0]) / (1 + done) * (of - done)


def in_words(seconds: float) -> str:
    """A time as a person says it."""
    if seconds < 10:
        return f"{max(round(seconds), 1)} s"
    return f"{round(seconds / 5) * 5} s" if seconds < 100 else f"{round(seconds / 60)} min"
