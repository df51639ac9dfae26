"""Generalised ICP (Segal et al. 2009) of small_gicp, a local method: from where the scene lies."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ido.peers.peer import Finder, Found, Peer
from ido.registration import StopReason
from ido.types import DoubleArray, FloatArray


@dataclass(frozen=True, kw_only=True)
class GICP(Peer):
    """Nearest points are matched with the covariances of what is around them; the settings' defaults are the library's.

    Args:
        downsampling: clouds are thinned to a point for each cube of this side.
        neighbours: points that a covariance is that of.
        cutoff: matches longer than this do not count.
        max_iterations: limit of the iterations.
    """

    title: ClassVar[str] = "small_gicp"
    package: ClassVar[str] = "small_gicp"
    downsampling: float = 0.25
    neighbours: int = 10
    cutoff: float = 1.0
    max_iterations: int = 20

    def onto(self, cloud: FloatArray) -> Finder:
        library = self.library()
        model, tree = library.preprocess_points(cloud.astype(np.float64), self.downsampling, self.neighbours)

        def find(points: DoubleArray) -> Found:
            scene, _ = library.preprocess_points(points, self.downsampling, self.neighbours)
            found = library.align(
                model, scene, tree, max_correspondence_distance=self.cutoff, max_iterations=self.max_iterations
            )
            stop = StopReason.CONVERGED if found.converged else StopReason.MAX_ITERATIONS
            return np.array(found.T_target_source), stop

        return find
