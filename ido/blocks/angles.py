"""Improved DO's two questions about angles, seen from the model's origin: higher or not, further round or not?

All scene points count alike, however far they are. So no pair loop is needed: each angle is ranked among the model's.
"""

from __future__ import annotations

from abc import abstractmethod
from typing import Any, NamedTuple

import numpy as np

from ido.blocks.block import Question, Surface, fan
from ido.clouds import Model
from ido.compiling import compiled
from ido.types import BoolArray, DoubleArray, FloatArray

_REACH = 1.2  # of the drawn cone and half-plane, model units
_AROUND = 48  # corners of the drawn circle
_CELLS = 1024  # of the table that finds an angle's rank


def elevation(points: FloatArray) -> DoubleArray:
    """θ = atan2(z, hypot(x, y)) of points (S, 3), radians (docs/method.md, Eq. 7)."""
    return np.arctan2(points[:, 2], np.hypot(points[:, 0], points[:, 1]))


def azimuth(points: FloatArray) -> DoubleArray:
    """ω = atan2(y, x) of points (S, 3), radians in (-π, π] (docs/method.md, Eq. 7)."""
    return np.arctan2(points[:, 1], points[:, 0])


class Ranks(NamedTuple):
    """A model's angles by size, as keys that grow with them: the point of rank r is the model's point ``order[r]``."""

    keys: DoubleArray  # (M,), sorted
    order: np.ndarray  # (M,) int64
    table: np.ndarray  # (cells,): a rank at or below that of any key in a cell


class _Angle(Question):
    """On the first side when the scene point's angle is greater than the model point's."""

    __slots__ = ()

    counts_all = True

    @abstractmethod
    def angle(self, points: FloatArray) -> DoubleArray:
        """The angle of points (S, 3), radians."""

    def answers(self, points: FloatArray, normals: FloatArray, moved: FloatArray) -> BoolArray:
        return self.angle(moved)[None] > self.angle(points)[:, None]

    def weights(self, points: FloatArray, moved: FloatArray) -> DoubleArray:
        return np.ones((len(points), len(moved)))


class UpOrDown(_Angle):
    """Up when θ_s > θ_a, for the elevation θ above the xy plane; every point counts 1. docs/method.md, Eq. 7 and 8."""

    __slots__ = ()

    def __init__(self) -> None:
        super().__init__("up", "down", (86, 180, 233))

    def angle(self, points: FloatArray) -> DoubleArray:
        return elevation(points)

    def surface(self, point: FloatArray, normal: FloatArray) -> Surface:
        """All directions with the point's elevation: a cone around z."""
        height = elevation(point[None])[0]
        angle = np.linspace(0, 2 * np.pi, _AROUND, endpoint=False)
        flat = np.cos(height)
        rim = _REACH * np.stack([flat * np.cos(angle), flat * np.sin(angle), np.full(_AROUND, np.sin(height))], axis=1)
        return Surface(*fan(np.zeros(3), rim, closed=True), guides=_axis_and_arm(point))

    def layout(self, model: Model) -> Ranks:
        return _ranks(model, _elevation_key, 1.0)

    def count(self, layout: Ranks, moved: FloatArray, starts: np.ndarray, out: FloatArray, side: int) -> None:
        _count_up(layout, moved, starts, out, side)


class ClockwiseOrAnticlockwise(_Angle):
    """Clockwise when ω_s > ω_a, for the azimuth ω around z; every point counts 1. docs/method.md, Eq. 7 and 8.

    The names are the paper's; seen from the tip of z, a greater ω lies anticlockwise.
    """

    __slots__ = ()

    def __init__(self) -> None:
        super().__init__("clockwise", "anticlockwise", (204, 121, 167))

    def angle(self, points: FloatArray) -> DoubleArray:
        return azimuth(points)

    def surface(self, point: FloatArray, normal: FloatArray) -> Surface:
        """All points with the point's azimuth: a rectangle from the z axis outwards."""
        angle = azimuth(point[None])[0]
        out = _REACH * np.array([np.cos(angle), np.sin(angle), 0.0])
        up = np.array([0.0, 0.0, _REACH])
        return Surface(*fan(-up, np.stack([out - up, out + up, up]), closed=False), guides=_axis_and_arm(point))

    def layout(self, model: Model) -> Ranks:
        return _ranks(model, _azimuth_key, 2.0)

    def count(self, layout: Ranks, moved: FloatArray, starts: np.ndarray, out: FloatArray, side: int) -> None:
        _count_clockwise(layout, moved, starts, out, side)


def _axis_and_arm(point: FloatArray) -> DoubleArray:
    """The z axis, and a line from the origin to the point."""
    return np.array([[[0.0, 0.0, -_REACH], [0.0, 0.0, _REACH]], [[0.0, 0.0, 0.0], point]])


def _ranks(model: Model, key: Any, reach: float) -> Ranks:
    """Lay out a model's angles; their keys lie in ±reach."""
    keys = np.array([key(*point) for point in np.asarray(model.points, dtype=np.float64)])
    order = np.argsort(keys, kind="stable")
    edges = -reach + 2 * reach * np.arange(_CELLS) / _CELLS
    # one cell too low is safe: the rank is found by walking up
    table = np.searchsorted(keys[order], edges - 2 * reach / _CELLS, side="left")
    return Ranks(keys[order], order, table.astype(np.int64))


@compiled(inline="always")
def _elevation_key(x: float, y: float, z: float) -> float:
    """The sine of the elevation atan2(z, hypot(x, y)): grows with it, and needs no trigonometry."""
    length = np.sqrt(x * x + y * y + z * z)
    return z / length if length > 0 else 0.0


@compiled(inline="always")
def _azimuth_key(x: float, y: float, z: float) -> float:
    """Grows with the azimuth atan2(y, x) in (-π, π], from -2 to 2: where the ray meets a unit diamond."""
    length = abs(x) + abs(y)
    if length == 0:
        return 0.0
    return 1 - x / length if y >= 0 else x / length - 1


@compiled(inline="always")
def _rank(key: float, ranks: Ranks, reach: float) -> int:
    """How many of the model's keys are smaller than a key in ±reach; of a point that is not finite, none."""
    if not key >= -reach:  # NaN, which would look beyond the table
        return 0
    rank = ranks.table[min(_CELLS - 1, int((key + reach) * (_CELLS / (2 * reach))))]
    while rank < len(ranks.keys) and ranks.keys[rank] < key:
        rank += 1
    return rank


@compiled(inline="always")
def _write_counts(ends_at: np.ndarray, n: int, ranks: Ranks, first: FloatArray, second: FloatArray) -> None:
    """From how many of n keys are greater than exactly r model keys: how many are greater than each, and not."""
    greater = n
    for r in range(len(ranks.keys)):
        greater -= ends_at[r]
        first[ranks.order[r]] = greater
        second[ranks.order[r]] = n - greater


@compiled()
def _count_up(ranks: Ranks, moved: FloatArray, starts: np.ndarray, out: FloatArray, side: int) -> None:
    ends_at = np.empty(len(ranks.keys) + 1, np.int64)
    for i in range(len(starts) - 1):
        ends_at[:] = 0
        for j in range(starts[i], starts[i + 1]):
            ends_at[_rank(_elevation_key(moved[j, 0], moved[j, 1], moved[j, 2]), ranks, 1.0)] += 1
        _write_counts(ends_at, starts[i + 1] - starts[i], ranks, out[i, side], out[i, side + 1])


@compiled()
def _count_clockwise(ranks: Ranks, moved: FloatArray, starts: np.ndarray, out: FloatArray, side: int) -> None:
    ends_at = np.empty(len(ranks.keys) + 1, np.int64)
    for i in range(len(starts) - 1):
        ends_at[:] = 0
        for j in range(starts[i], starts[i + 1]):
            ends_at[_rank(_azimuth_key(moved[j, 0], moved[j, 1], moved[j, 2]), ranks, 2.0)] += 1
        _write_counts(ends_at, starts[i + 1] - starts[i], ranks, out[i, side], out[i, side + 1])
