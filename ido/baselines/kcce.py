"""KCCE, kernel correlation with correspondence estimation (Chen 2011): a reconstruction.

Neither code nor text of the method is public. This rebuilds the published idea: kernel correlation (Tsin & Kanade 2004)
is increased by estimating soft correspondences, moving by the best rigid pose for them, and narrowing the kernel.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ido import poses
from ido.baselines.baseline import Baseline, Record
from ido.baselines.gaussian import best_pose, gaussian_sums
from ido.registration import StopReason
from ido.types import DoubleArray


@dataclass(frozen=True, kw_only=True)
class KCCE(Baseline):
    """Each scene point corresponds to the kernel-weighted mean of the model points, Σ w m / Σ w, and counts by its
    correlation Σ w, w = exp(-d²/2σ²). Moving by the best pose for these pairs never lowers the correlation Σ_ab w_ab.
    docs/method.md, Eq. 25.

    Args:
        start: first kernel width σ (model units).
        end: last kernel width.
        rate: factor of σ once the pose has settled or `steps` were made at a width.
        steps: most iterations at one width.
        tolerance: a pose has settled when no point of the scene moved farther (model units).
    """

    title: ClassVar[str] = "KCCE (reconstruction)"
    max_iterations: int = 300
    start: float = 0.5
    end: float = 0.05
    rate: float = 0.8
    steps: int = 20
    tolerance: float = 1e-3

    def run(self, model: DoubleArray, scene: DoubleArray, record: Record) -> StopReason:
        sigma, moved, at_width = self.start, scene, 0
        for _ in range(self.max_iterations):
            sums = gaussian_sums(moved, model, sigma**2)
            # by their logarithm, so that a scene far away still has weights
            logarithm = np.log(sums.weight) - sums.nearest2 / (2 * sigma**2)
            T = best_pose(scene, moved + sums.target, np.exp(logarithm - logarithm.max()))
            before, moved = moved, poses.transform(T, scene)
            record(T)
            at_width += 1
            settled = bool(np.abs(moved - before).max() < self.tolerance)
            if settled or at_width == self.steps:
                if sigma <= self.end:
                    return StopReason.CONVERGED if settled else StopReason.MAX_ITERATIONS
                sigma, at_width = max(sigma * self.rate, self.end), 0
        return StopReason.MAX_ITERATIONS
