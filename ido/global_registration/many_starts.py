"""The learned methods from many starts: each walks its maps from every rotation of a set, all in one batch."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ido.global_registration.outliers import Background
from ido.global_registration.search import spread_rotations
from ido.histograms import SceneBatch
from ido.maps import Maps
from ido.poses import transform
from ido.registration import register_batch
from ido.types import DoubleArray, FloatArray

_STARTS = 128
_POINTS = 256
_ITERATIONS = 30  # what is not there by then, the climb brings there


@dataclass(frozen=True, slots=True, eq=False)
class ManyStarts:
    """Where maps lead from 128 rotations of the scene about its middle, which lies at the model's origin.

    Args:
        maps: to walk.
    """

    maps: Maps

    def __call__(self, points: FloatArray, backgrounds: Sequence[Background]) -> list[tuple[DoubleArray, FloatArray]]:
        """For each background of points (S, 3) the same poses (128, 4, 4), and scores (128,) that prefer none."""
        T = np.tile(np.eye(4), (_STARTS, 1, 1))
        T[:, :3, :3] = spread_rotations(_STARTS)
        few = np.random.default_rng(0).permutation(len(points))[:_POINTS]
        tracks = register_batch(self.maps, SceneBatch.of(list(transform(T, points[few]))), max_iterations=_ITERATIONS)
        found = np.stack([track.T_model_scene[-1] for track in tracks]) @ T
        return [(found, np.zeros(_STARTS)) for _ in backgrounds]
