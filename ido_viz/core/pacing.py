"""How long each iteration is played: as long as the cloud has to move, so that the first few can be followed."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ido import poses
from ido.types import DoubleArray
from ido_viz.core.run import Run
from ido_viz.core.state import NORMAL_SPEED

SHORTEST, LONGEST = 2.5, 8.0
"""Seconds that a run takes at the normal speed."""

_EACH = 0.1  # seconds that an iteration adds, up to the longest
_OF_MOTION = 0.5  # share of the time that is dealt out by how far the cloud moves; the rest evenly
_POINTS = 50  # of the scene, from which its motion is measured


@dataclass(frozen=True, eq=False)
class Pacing:
    """When each iteration of a run is reached at the normal speed.

    Args:
        run: both registrations. They are played together, iteration by iteration.
    """

    run: Run

    @cached_property
    def times(self) -> DoubleArray:
        """Seconds after which so many iterations are done, from 0; shape (n + 1,)."""
        n = self.run.iterations
        points = self.run.scene.points[:: max(1, len(self.run.scene.points) // _POINTS)]
        steps = np.zeros(n)
        for side in self.run.sides:
            places = poses.transform(side.T_model_scene, points.astype(np.float64))
            moved = np.sqrt(((places[1:] - places[:-1]) ** 2).sum(axis=-1).mean(axis=-1))
            steps[: len(moved)] = np.maximum(steps[: len(moved)], np.nan_to_num(moved))
        total = steps.sum()
        motion = steps / total if total > 0 else np.full(n, 1 / max(n, 1))
        shares = _OF_MOTION * motion + (1 - _OF_MOTION) / max(n, 1)
        seconds = float(np.clip(SHORTEST + _EACH * n, SHORTEST, LONGEST))
        return np.concatenate([[0.0], np.cumsum(seconds * shares)])

    def after(self, position: float, seconds: float, speed: int) -> float:
        """Where it is so many seconds later, an iteration and a fraction of the next.

        Args:
            position: where it is now, iterations.
            seconds: how long it plays.
            speed: of the state.
        """
        iterations = np.arange(len(self.times))
        now = float(np.interp(position, iterations, self.times)) + seconds * speed / NORMAL_SPEED
        return float(np.interp(now, self.times, iterations))

    def moments(self, speed: int, apart: float, most: int) -> tuple[DoubleArray, float]:
        """Where it is at evenly spaced moments from the start to the end, with fractions, and their distance.

        Args:
            speed: of the state.
            apart: seconds between two moments, more if there would be more of them than
            most: this number.
        """
        seconds = float(self.times[-1]) * NORMAL_SPEED / speed
        count = max(2, min(most, round(seconds / apart) + 1))
        at = np.linspace(0.0, self.times[-1], count)
        return np.interp(at, self.times, np.arange(len(self.times))), seconds / (count - 1)
