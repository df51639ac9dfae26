"""KISS-Matcher (Lim et al. 2025): Faster-PFH features, matches pruned as a graph, then a robust pose."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ido.peers.peer import Finder, Found, Peer
from ido.registration import StopReason
from ido.types import DoubleArray, FloatArray


@dataclass(frozen=True, kw_only=True)
class KISS(Peer):
    """KISS-Matcher; the settings' defaults are the library's.

    Args:
        voxel: clouds are thinned to a point for each cube of this side.
        normal_gain: normals are those of the neighbours within so many voxels.
        feature_gain: features are those of the neighbours within so many voxels.
        noise_gain: matches that agree within so many voxels are kept in the graph.
        solver_gain: matches that agree within so many voxels make the pose.
    """

    title: ClassVar[str] = "KISS-Matcher"
    package: ClassVar[str] = "kiss_matcher"
    voxel: float = 0.3
    normal_gain: float = 3.0
    feature_gain: float = 5.0
    noise_gain: float = 1.0
    solver_gain: float = 0.75

    def onto(self, cloud: FloatArray) -> Finder:
        library = self.library()
        config = library.KISSMatcherConfig(
            voxel_size=self.voxel,
            normal_r_gain=self.normal_gain,
            fpfh_r_gain=self.feature_gain,
            robin_noise_bound_gain=self.noise_gain,
            solver_noise_bound_gain=self.solver_gain,
        )
        model = cloud.astype(np.float32)

        def find(points: DoubleArray) -> Found:
            solution = library.KISSMatcher(config).estimate(points.astype(np.float32), model)
            if not solution.valid:
                return np.eye(4), StopReason.NOTHING_NEAR
            T = np.eye(4)
            T[:3, :3], T[:3, 3] = solution.rotation, solution.translation
            return T, StopReason.CONVERGED

        return find
