"""What the report says of a method: mean scores with their 95% confidence intervals, and medians of its costs.

Registrations may be missing, and levels may differ in how many there are. What was not run has no number. Nor has a
registration that failed without a pose: its PointAcc is 0, its PointRMSE is NaN and left out.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ido.experiments.beyond import ALL_LEVELS
from ido.results import Results
from ido.types import FloatArray

_NORMAL_95 = 1.96


@dataclass(frozen=True, slots=True)
class Estimate:
    """A mean and how sure it is.

    Args:
        mean: NaN if some level has no score.
        half: half of the 95% confidence interval; NaN if some level has fewer than two scores.
        scenes: number of scenes at each level, zeros included.
        failed: number of scenes that have no score.
    """

    mean: float
    half: float
    scenes: tuple[int, ...]
    failed: int

    @property
    def levels_run(self) -> int:
        """Number of levels with a scene."""
        return sum(count > 0 for count in self.scenes)

    @property
    def status(self) -> str:
        """``run``, ``not run``, how many of the levels were run, or that all scenes of a level failed."""
        if self.levels_run == 0:
            return "not run"
        if self.levels_run < len(self.scenes):
            return f"{self.levels_run} of {len(self.scenes)} levels run"
        return "failed" if np.isnan(self.mean) else "run"


def estimate(levels: Sequence[FloatArray]) -> Estimate:
    """The mean over levels of each level's mean, given the scores of the scenes at each.

    The levels are given, the scenes are independent draws: the variances of the levels' means add up.
    """
    scored = [values[np.isfinite(values)] for values in levels]
    counts = [len(values) for values in scored]
    scenes = tuple(len(values) for values in levels)
    mean = half = np.nan
    if min(counts) > 0:
        mean = float(np.mean([values.mean() for values in scored]))
    if min(counts) > 1:
        variances = [values.var(ddof=1) / len(values) for values in scored]
        half = float(_NORMAL_95 * np.sqrt(np.sum(variances)) / len(levels))
    return Estimate(mean, half, scenes, sum(scenes) - sum(counts))


def sweep_estimate(of_method: Results, sweep: str, score: str) -> Estimate:
    """One method's mean score over a sweep of one dataset."""
    return estimate(_level_scores(of_method, sweep, score))


def level_estimates(of_method: Results, sweep: str, score: str) -> list[Estimate]:
    """One method's mean score at each level of a sweep of one dataset."""
    return [estimate([values]) for values in _level_scores(of_method, sweep, score)]


def _level_scores(of_method: Results, sweep: str, score: str) -> list[FloatArray]:
    of_sweep = of_method.where(sweep=sweep)
    return [getattr(of_sweep.where(level=level), score) for level in ALL_LEVELS[sweep]]


@dataclass(frozen=True, slots=True)
class Costs:
    """What one method's registrations took.

    Args:
        registrations: how many there were.
        seconds: the median CPU time of one; NaN if there is none.
        iterations: the median number of iterations of one; NaN if there is none.
    """

    registrations: int
    seconds: float
    iterations: float

    @classmethod
    def of(cls, of_method: Results) -> Costs:
        """The costs of registrations, those left out that failed without a pose."""
        has_pose = np.isfinite(of_method.rmse)
        seconds, iterations = of_method.seconds[has_pose], of_method.iterations[has_pose]
        if not has_pose.any():
            return cls(len(of_method), np.nan, np.nan)
        return cls(len(of_method), float(np.median(seconds)), float(np.median(iterations)))
