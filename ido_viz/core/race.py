"""The race of a global registration's starts, and what else its pose may be, as poses to draw."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ido.global_registration import Branch, Confidence, GlobalResult
from ido.global_registration.spread import moved_by
from ido.types import DoubleArray, FloatArray, IntArray

FADING = 6
"""Steps in which a start that was given up fades away."""

_FAN = 8  # poses


@dataclass(frozen=True, slots=True, eq=False)
class Race:
    """What all starts did, step by step. Iteration k of the registration is step k - 1: the first one is the search.

    Args:
        T_model_scene: the pose of each start at each step, shape (n, steps + 1, 4, 4); one given up stays where it was.
        until: the step at which each start was given up, shape (n,); `steps` + 1 for those that got to the end.
        log_likelihood: of each start at each step, per scene point, shape (n, steps + 1); NaN once it was given up.
    """

    T_model_scene: FloatArray
    until: IntArray
    log_likelihood: DoubleArray

    @classmethod
    def of(cls, tried: GlobalResult) -> Race:
        """The race up to the stage that the chosen pose comes from."""
        parts = [_of_branch(branch, tried.candidates[0].stage) for branch in tried.branches]
        T, until, likelihood = (np.concatenate(column) for column in zip(*parts, strict=True))
        return cls((T @ tried.centring).astype(np.float32), until, likelihood)

    @property
    def steps(self) -> int:
        return self.T_model_scene.shape[1] - 1

    def step(self, iteration: int) -> int:
        """The step of an iteration; the first and the last one for those before and after the race."""
        return min(max(iteration - 1, 0), self.steps)

    def left(self, iteration: int) -> int:
        """How many starts still run after so many iterations."""
        return int((self.until > self.step(iteration)).sum())

    def strength(self, iteration: int) -> DoubleArray:
        """How clearly each start is seen, shape (n,): 1 while it runs, less and less once it was given up."""
        if iteration == 0:
            return np.zeros(len(self.until))
        return np.clip(1 - (self.step(iteration) - self.until + 1) / FADING, 0.0, 1.0)

    def survivors(self, most: int) -> DoubleArray:
        """The likelihoods of the starts that got to the end, the highest first, shape (n, steps + 1), n <= most."""
        ended = self.log_likelihood[self.until > self.steps]
        return ended[np.argsort(-ended[:, -1], kind="stable")[:most]]


def _of_branch(branch: Branch, end: int) -> tuple[DoubleArray, IntArray, DoubleArray]:
    """Poses of the centred scene, steps of giving up and likelihoods of a branch's starts, up to a stage."""
    stages = branch.stages[: end + 1]
    n, steps = len(branch.scores), sum(stage.climb.steps for stage in stages)
    T = np.empty((n, steps + 1, 4, 4))
    T[:] = stages[0].climb.poses[:, :1]
    likelihood = np.full((n, steps + 1), np.nan)
    until = np.full(n, steps + 1)
    running, done = np.arange(n), 0
    for number, stage in enumerate(stages):
        begun, done = done, done + stage.climb.steps
        T[running, begun : done + 1] = stage.climb.poses
        T[running, done + 1 :] = stage.climb.poses[:, -1:]
        likelihood[running, begun : done + 1] = stage.climb.log_likelihood
        if number < end:
            until[np.delete(running, stage.kept)] = done + 1
            running = running[stage.kept]
    return T, until, likelihood


def fan_of(confidence: Confidence, T_model_scene: DoubleArray) -> DoubleArray:
    """What else a pose may be: poses drawn from its predicted error, and those that fit equally; shape (n, 4, 4).

    Args:
        confidence: in the pose.
        T_model_scene: the pose, shape (4, 4).
    """
    factor = np.linalg.cholesky(confidence.evidence.covariance)
    draws = np.random.default_rng(0).standard_normal((_FAN, 6)) @ factor.T
    return np.concatenate([np.stack([moved_by(draw, T_model_scene) for draw in draws]), confidence.equals])
