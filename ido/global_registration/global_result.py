"""A global registration: the pose that was chosen, and all that was tried on the way to it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ido import poses
from ido.global_registration.climbing import Climb
from ido.global_registration.cut_plane import Posterior, Refined, refine
from ido.global_registration.evidence import Evidence
from ido.global_registration.outliers import Background
from ido.registration import StopReason, Trajectory
from ido.types import DoubleArray, FloatArray, IntArray


@dataclass(frozen=True, slots=True, eq=False)
class Stage:
    """A part of the climb.

    Args:
        climb: what all its starts did. Start i is number ``kept[i]`` of the stage before.
        kept: which starts of this stage went on, the best first; shape (n,).
    """

    climb: Climb
    kept: IntArray


@dataclass(frozen=True, slots=True, eq=False)
class Branch:
    """All that was tried with one background: with a ball where one was found, and without.

    Poses are those of the centred scene; ``T @ GlobalResult.centring`` is a T_model_scene.

    Args:
        background: of the centred scene.
        scores: of the poses that the climb starts from, in the search, shape (n,), the highest first.
        stages: one after the other, the first from n starts.
    """

    background: Background
    scores: FloatArray
    stages: tuple[Stage, ...]

    def lineage(self, start: int, end: int) -> DoubleArray:
        """All poses of a start of stage `end`, from the search to the last one of that stage; shape (n, 4, 4)."""
        parts = [self.stages[end].climb.poses[start]]
        for stage in reversed(self.stages[:end]):
            start = int(stage.kept[start])
            parts.append(stage.climb.poses[start, :-1])
        return np.concatenate(parts[::-1])


@dataclass(frozen=True, slots=True, eq=False)
class Candidate:
    """One of the poses that the method chooses from.

    Args:
        refined: the pose of the centred scene, and the plane.
        posterior: the likelihood that it is at the top of.
        branch: number of the branch that it comes from.
        start: its number in the last stages of that branch.
        stage: number of the stage whose width fits it best.
    """

    refined: Refined
    posterior: Posterior
    branch: int
    start: int
    stage: int

    def again(self) -> Candidate:
        """Refined once more, from the plane that is the likeliest now; itself where that leads no higher."""
        refined = refine(self.posterior, self.refined.T, cut=True)
        return replace(self, refined=refined) if refined.log_likelihood > self.refined.log_likelihood else self


@dataclass(frozen=True, eq=False)
class GlobalResult:
    """A registration from any start, with all that was tried.

    Args:
        centring: the pose (4, 4) that moved the scene's middle to the origin, before all else.
        branches: what was tried.
        candidates: the tops of the likelihood, no two alike, the highest first: that is the one chosen.
        covariance: of the chosen pose: shift (model units) and turn (rad) in the model's frame, shape (6, 6).
        T: the pose of the centred scene, at or near the chosen top, shape (4, 4).
        searched: number of points that were searched and climbed with; all are used at the end.
    """

    centring: DoubleArray
    branches: tuple[Branch, ...]
    candidates: tuple[Candidate, ...]
    covariance: DoubleArray
    T: DoubleArray
    searched: int

    @cached_property
    def evidence(self) -> Evidence:
        """What speaks for the chosen pose."""
        first, *others = self.candidates
        return Evidence.of(first.posterior, first.refined, [other.refined for other in others], self.covariance)

    @property
    def best(self) -> Refined:
        return self.candidates[0].refined

    @property
    def T_model_scene(self) -> DoubleArray:
        """The pose, shape (4, 4)."""
        return self.T @ self.centring

    @property
    def trajectory(self) -> Trajectory:
        """The way of the chosen pose: from where the scene lies to a start of the search, uphill, and to the mean."""
        chosen = self.candidates[0]
        climbed = self.branches[chosen.branch].lineage(chosen.start, chosen.stage)
        T = np.concatenate([np.eye(4)[None], np.stack([*climbed, self.T]) @ self.centring])
        motions = poses.log(T[1:] @ poses.invert(T[:-1]))
        return Trajectory(poses.log(T), np.linalg.norm(motions, axis=1), StopReason.CONVERGED, np.nan)
