"""ICP, point to point (Besl & McKay 1992)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Literal

import numpy as np
from scipy.spatial import KDTree

from ido import poses
from ido.baselines.baseline import Baseline, Record
from ido.baselines.gaussian import best_pose
from ido.registration import StopReason
from ido.types import DoubleArray


@dataclass(frozen=True, kw_only=True)
class ICP(Baseline):
    """Match nearest points, move by the best rigid pose for the matches, repeat (docs/method.md, Eq. 21).

    Args:
        search: whose points look for their nearest neighbour. ``scene``: every scene point takes the nearest model
            point, as Besl & McKay have it (the moving cloud's points look for the fixed one). ``model``: every model
            point takes the nearest scene point, which leaves far outliers unmatched.
        cutoff: matches longer than this do not count (model units).
        tolerance: stop when the mean squared length of the matches changes by less than this share.
    """

    title: ClassVar[str] = "ICP"
    max_iterations: int = 100
    search: Literal["scene", "model"] = "scene"
    cutoff: float = float("inf")
    tolerance: float = 1e-6

    def run(self, model: DoubleArray, scene: DoubleArray, record: Record) -> StopReason:
        T, before = np.eye(4), np.inf
        fixed = KDTree(model if self.search == "scene" else scene)
        for _ in range(self.max_iterations):
            # where the model looks, it comes to the scene, whose tree stays as it was built
            looking = poses.transform(T, scene) if self.search == "scene" else poses.transform(poses.invert(T), model)
            distance, match = fixed.query(looking, distance_upper_bound=self.cutoff)
            near = np.isfinite(distance)
            if near.sum() < 3:  # nothing within reach: nowhere to go
                return StopReason.NOTHING_NEAR
            found = np.asarray(match)[near]
            source, target = (scene[near], model[found]) if self.search == "scene" else (scene[found], model[near])
            T = best_pose(source, target, np.ones(len(source)))
            record(T)
            error = float((np.asarray(distance)[near] ** 2).mean())
            if abs(before - error) <= self.tolerance * error:
                return StopReason.CONVERGED
            before = error
        return StopReason.MAX_ITERATIONS
