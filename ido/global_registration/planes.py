"""Planes beyond which a scene may miss the model: the likeliest of many is where the last step begins."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ido.compiling import compiled
from ido.global_registration.parts import in_parts
from ido.types import DoubleArray, FloatArray

KEPT = np.array([0.12, 0.16, 0.2, 0.25, 0.3, 0.36, 0.43, 0.5, 0.58, 0.66, 0.75, 0.84, 0.92])
"""Shares of the model that planes keep."""

FEW_DIRECTIONS, FEW_KEPT = 60, np.array([0.2, 0.3, 0.43, 0.6, 0.8])
"""Of few planes, to tell roughly how likely many poses are."""

NO_PLANE = (np.array([1.0, 0.0, 0.0]), 1e3)
"""Normal and offset of a plane beyond everything (model units)."""

_DIRECTIONS = 200  # with half as many, the last step begins too far from the best plane, and more scenes are lost
_TELLING = 1e-3  # a point that is less likely of the model than so often of the outliers says nothing of a plane


@dataclass(frozen=True, slots=True, eq=False)
class Planes:
    """Planes of a model in many directions; plane k of each keeps the share ``kept[k]`` of it.

    Args:
        sample: points of the model, shape (M, 3), float32, model units.
        directions: unit normals, towards what is missing, shape (D, 3).
        offsets: of the planes along their normals, shape (D, K), model units.
        kept: shares of the model, shape (K,).
    """

    sample: FloatArray
    directions: DoubleArray
    offsets: DoubleArray
    kept: DoubleArray

    @classmethod
    def of(cls, sample: FloatArray, n_directions: int = _DIRECTIONS, kept: DoubleArray = KEPT) -> Planes:
        """The planes of a model, given by some of its points (M, 3)."""
        directions = spread_directions(n_directions)
        offsets = np.quantile(sample.astype(np.float64) @ directions.T, kept, axis=0).T
        return cls(np.ascontiguousarray(sample, dtype=np.float32), directions, np.ascontiguousarray(offsets), kept)

    def likeliest(self, moved: FloatArray, odds: DoubleArray) -> tuple[DoubleArray, float]:
        """The plane under which a scene is likeliest (docs/global.md, Eq. 6); `NO_PLANE` where none helps.

        Args:
            moved: the scene at its pose, shape (S, 3).
            odds: of each point, of the model against the outliers, without a plane; shape (S,).

        Returns:
            its unit normal (3,) and its offset.
        """
        telling = odds > _TELLING
        along = np.ascontiguousarray(self.directions @ moved[telling].T.astype(np.float64))
        _, direction, number = _likeliest(along, odds[telling], self.offsets, self.kept)
        if direction < 0:
            return NO_PLANE
        return self.directions[direction], float(self.offsets[direction, number])

    def gains(self, moved: FloatArray, odds: DoubleArray) -> DoubleArray:
        """By how much the likeliest plane raises the log-likelihood of a scene at many poses, shape (n,).

        Args:
            moved: the scene at each pose, shape (n, S, 3).
            odds: of each point there, of the model against the outliers, without a plane; shape (n, S).
        """
        gains = np.empty(len(moved))

        def part(begin: int, end: int) -> None:
            _gains(moved[begin:end], odds[begin:end], self.directions, self.offsets, self.kept, gains[begin:end])

        in_parts(len(moved), part)
        return gains


def spread_directions(n: int) -> DoubleArray:
    """Unit vectors spread evenly over the sphere (Fibonacci spiral), shape (n, 3)."""
    height = 1 - (2 * np.arange(n) + 1) / n
    around = np.pi * (1 + np.sqrt(5)) * np.arange(n)
    radius = np.sqrt(1 - height**2)
    return np.stack([radius * np.cos(around), radius * np.sin(around), height], axis=1)


@compiled(fastmath=True, error_model="numpy")  # sums may be taken in any order, several terms at once
def _likeliest(
    along: DoubleArray, odds: DoubleArray, offsets: DoubleArray, kept: DoubleArray
) -> tuple[float, int, int]:
    """Direction and number of the plane with the greatest Σ log(1 + odds [on its kept side] / kept), -1 for none, and
    by how much that is greater than without a plane.

    Points (S,) lie `along` the directions, shape (D, S); the planes have `offsets` (D, K) there and keep shares (K,).
    """
    without, direction, number = 0.0, -1, -1
    for s in range(len(odds)):
        without += np.log(1 + odds[s])
    best = without
    terms = np.empty(len(odds))
    for k in range(len(kept)):
        for s in range(len(odds)):
            terms[s] = np.log(1 + odds[s] / kept[k])
        for d in range(len(along)):
            total = 0.0
            for s in range(len(odds)):
                total += terms[s] if along[d, s] < offsets[d, k] else 0.0
            if total > best:
                best, direction, number = total, d, k
    return best - without, direction, number


@compiled(error_model="numpy")
def _gains(
    moved: FloatArray,
    odds: DoubleArray,
    directions: DoubleArray,
    offsets: DoubleArray,
    kept: DoubleArray,
    out: DoubleArray,
) -> None:
    """For each pose, points (n, S, 3) and their odds (n, S), what `_likeliest` gains."""
    for i in range(len(moved)):
        telling = np.flatnonzero(odds[i] > _TELLING)
        along = np.empty((len(directions), len(telling)))
        for d in range(len(directions)):
            a, b, c = directions[d]
            for place, s in enumerate(telling):
                along[d, place] = a * moved[i, s, 0] + b * moved[i, s, 1] + c * moved[i, s, 2]
        out[i] = _likeliest(along, odds[i][telling], offsets, kept)[0]
