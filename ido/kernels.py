"""The compiled loops. Each has a plain NumPy definition in `ido.histograms` that the tests hold it against.

Front / back weighs every scene point against every model point, and dominates everything else. The weight
exp(-d²/σ²) is below 1e-6, and counts as nothing, for nine pairs out of ten. So the model points are put into small
boxes, the scene points within reach of a box are gathered, first for a group of boxes and then for each, and only those
are weighed.
Coordinates are scaled so that the weight is 2^-d², computed as a quartic times a power of two put together from bits.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numba import njit

from ido.types import FloatArray

SMALLEST_WEIGHT = 1e-6
BOX = 16  # model points in a box
GROUP = 4  # boxes in a group
_LANES = 16  # gathered points are padded to a multiple of this
_FAR = np.float32(1e4)

# 2^f on [-1/2, 1/2], least relative error at Chebyshev nodes: 3e-6
_nodes = np.cos(np.linspace(0.0, np.pi, 400)) / 2
_E4, _E3, _E2, _E1, _E0 = (np.float32(c) for c in np.polyfit(_nodes, 2.0**_nodes, 4, w=2.0**-_nodes))

_ZERO, _HALF = np.float32(0), np.float32(0.5)
_MANTISSA_BITS = np.int32(23)
_TABLE = 1024  # cells of the table that finds an angle's rank


class BoxedModel(NamedTuple):
    """A model laid out for the kernels: points in boxes, and both angles sorted.

    `order[i]` is the model point that stands at place i of `points` and `normals`.
    """

    order: np.ndarray  # (M,) int64
    points: FloatArray  # (3, M) float32, scaled
    normals: FloatArray  # (3, M) float32
    box_low: FloatArray  # (boxes, 3) float32, scaled
    box_high: FloatArray
    group_low: FloatArray  # (groups, 3)
    group_high: FloatArray
    scale: float
    elevation: FloatArray  # (M,) float64, sorted
    elevation_order: np.ndarray
    elevation_table: np.ndarray
    azimuth: FloatArray
    azimuth_order: np.ndarray
    azimuth_table: np.ndarray


def box_model(points: FloatArray, normals: FloatArray, sigma2: float) -> BoxedModel:
    """Lay out a model, points and normals of shape (M, 3), for the kernels."""
    exact = np.asarray(points, dtype=np.float64)
    order = _spatial_order(exact, np.arange(len(exact)))
    scale = float(np.sqrt(np.log2(np.e) / sigma2))
    scaled = (exact[order] * scale).astype(np.float32)
    starts = np.arange(0, len(scaled), BOX)
    box_low, box_high = np.minimum.reduceat(scaled, starts), np.maximum.reduceat(scaled, starts)
    groups = np.arange(0, len(starts), GROUP)
    angles: list[np.ndarray] = []
    for key, low, high in ((_elevation_key, -1.0, 1.0), (_azimuth_key, -2.0, 2.0)):
        keys = np.array([key(*point) for point in exact])
        ranks = np.argsort(keys, kind="stable")
        edges = low + (high - low) * np.arange(_TABLE) / _TABLE
        # one cell too low is safe: the rank is found by walking up
        table = np.searchsorted(keys[ranks], edges - (high - low) / _TABLE, side="left")
        angles += [keys[ranks], ranks, table.astype(np.int64)]
    return BoxedModel(
        order,
        np.ascontiguousarray(scaled.T),
        np.ascontiguousarray(np.asarray(normals, dtype=np.float32)[order].T),
        box_low,
        box_high,
        np.minimum.reduceat(box_low, groups),
        np.maximum.reduceat(box_high, groups),
        scale,
        *angles,
    )


def _spatial_order(points: FloatArray, chosen: np.ndarray) -> np.ndarray:
    """The points in an order in which every BOX of them lie close together: halve along the longest side."""
    if len(chosen) <= BOX:
        return chosen
    here = points[chosen]
    along = np.argsort(here[:, np.ptp(here, axis=0).argmax()], kind="stable")
    half = -(-len(chosen) // BOX) // 2 * BOX
    return np.concatenate([_spatial_order(points, chosen[along[:half]]), _spatial_order(points, chosen[along[half:]])])


@njit(cache=True, inline="always")
def _elevation_key(x: float, y: float, z: float) -> float:
    """The sine of the elevation atan2(z, hypot(x, y)): grows with it, and needs no trigonometry."""
    length = np.sqrt(x * x + y * y + z * z)
    return z / length if length > 0 else 0.0


@njit(cache=True, inline="always")
def _azimuth_key(x: float, y: float, z: float) -> float:
    """Grows with the azimuth atan2(y, x) in (-π, π], from -2 to 2: where the ray meets a unit diamond."""
    length = abs(x) + abs(y)
    if length == 0:
        return 0.0
    return 1 - x / length if y >= 0 else x / length - 1


@njit(cache=True, inline="always", fastmath=True)
def _gather(
    xyz: FloatArray, n: int, low: FloatArray, high: FloatArray, reach2: Any, out: FloatArray, distance2: FloatArray
) -> int:
    """Copy the first n points that lie within reach of a box to `out`; returns how many."""
    for j in range(n):
        dx = max(max(low[0] - xyz[0, j], xyz[0, j] - high[0]), _ZERO)
        dy = max(max(low[1] - xyz[1, j], xyz[1, j] - high[1]), _ZERO)
        dz = max(max(low[2] - xyz[2, j], xyz[2, j] - high[2]), _ZERO)
        distance2[j] = dx * dx + dy * dy + dz * dz
    count = 0
    for j in range(n):
        out[0, count] = xyz[0, j]
        out[1, count] = xyz[1, j]
        out[2, count] = xyz[2, j]
        count += distance2[j] < reach2
    return count


@njit(cache=True, fastmath=True, error_model="numpy")
def _front_back(moved: FloatArray, model: BoxedModel, front: FloatArray, back: FloatArray) -> None:
    """Σ w over the moved points in front of and behind each model point, w = exp(-d²/σ²). `moved` is (S, 3)."""
    n = len(moved)
    scene = np.empty((3, n + _LANES), np.float32)
    for j in range(n):
        for axis in range(3):
            scene[axis, j] = moved[j, axis] * model.scale
    near_group = np.empty_like(scene)
    near = np.empty_like(scene)
    distance2 = np.empty(n, np.float32)
    reach2 = np.float32(-np.log2(SMALLEST_WEIGHT))
    n_model, n_boxes = model.points.shape[1], len(model.box_low)
    for group in range(len(model.group_low)):
        n_group = _gather(scene, n, model.group_low[group], model.group_high[group], reach2, near_group, distance2)
        for box in range(group * GROUP, min(n_boxes, group * GROUP + GROUP)):
            count = _gather(near_group, n_group, model.box_low[box], model.box_high[box], reach2, near, distance2)
            padded = (count + _LANES - 1) // _LANES * _LANES
            near[0, count:padded] = _FAR
            near[1, count:padded] = _FAR
            near[2, count:padded] = _FAR
            x, y, z = near[0, :padded], near[1, :padded], near[2, :padded]
            for i in range(box * BOX, min(n_model, box * BOX + BOX)):
                mx, my, mz = model.points[0, i], model.points[1, i], model.points[2, i]
                nx, ny, nz = model.normals[0, i], model.normals[1, i], model.normals[2, i]
                in_front, total = _ZERO, _ZERO
                for j in range(padded):
                    dx, dy, dz = x[j] - mx, y[j] - my, z[j] - mz
                    exponent = -(dx * dx + dy * dy + dz * dz)
                    whole = np.int32(exponent - _HALF)
                    f = exponent - np.float32(whole)
                    mantissa = (((_E4 * f + _E3) * f + _E2) * f + _E1) * f + _E0
                    bits = np.float32(mantissa).view(np.int32) + (whole << _MANTISSA_BITS)
                    weight = np.int32(bits).view(np.float32) if exponent > -reach2 else _ZERO
                    total += weight
                    in_front += weight if dx * nx + dy * ny + dz * nz > _ZERO else _ZERO
                front[model.order[i]] = in_front
                back[model.order[i]] = total - in_front


@njit(cache=True)
def _count_above(
    keys: FloatArray,
    sorted_keys: FloatArray,
    order: np.ndarray,
    table: np.ndarray,
    reach: float,
    above: FloatArray,
    below: FloatArray,
) -> None:
    """How many keys are greater than each of the model's sorted keys, and how many are not. Keys lie in ±reach."""
    n_model, n = len(sorted_keys), len(keys)
    ends_at = np.zeros(n_model + 1, np.int64)  # ends_at[r]: keys that are greater than exactly r model keys
    cells = _TABLE / (2 * reach)
    for j in range(n):
        key = keys[j]
        rank = table[min(_TABLE - 1, int((key + reach) * cells))]
        while rank < n_model and sorted_keys[rank] < key:
            rank += 1
        ends_at[rank] += 1
    greater = n
    for r in range(n_model):
        greater -= ends_at[r]
        above[order[r]] = greater
        below[order[r]] = n - greater


@njit(cache=True)
def pose_of(x: FloatArray) -> FloatArray:
    """T = exp(ξ^) of x = [ρ, φ], shape (4, 4); `ido.poses.exp` defines it."""
    T = np.eye(4)
    a, b, c = x[3], x[4], x[5]
    angle2 = a * a + b * b + c * c
    angle = np.sqrt(angle2)
    if angle > 1e-4:
        sine = np.sin(angle) / angle
        cosine = (1 - np.cos(angle)) / angle2
        rest = (1 - sine) / angle2
    else:  # Taylor series, exact to double precision
        sine, cosine, rest = 1 - angle2 / 6, 0.5 - angle2 / 24, 1 / 6 - angle2 / 120
    cross = np.array([[0.0, -c, b], [c, 0.0, -a], [-b, a, 0.0]])
    for i in range(3):
        for j in range(3):
            square = x[3 + i] * x[3 + j] - (angle2 if i == j else 0.0)  # (φ^)²
            T[i, j] += sine * cross[i, j] + cosine * square
            J = (1.0 if i == j else 0.0) + cosine * cross[i, j] + rest * square
            T[i, 3] += J * x[j]
    return T


@njit(cache=True, error_model="numpy")
def _describe(
    points: FloatArray, x: FloatArray, model: BoxedModel, weights: FloatArray, unit_norm: bool, out: FloatArray
) -> None:
    """A histogram: `weights` is (2, M) for front / back alone or (6, M) for all three blocks; `out` of its shape."""
    T = pose_of(x)
    n = len(points)
    moved = np.empty((n, 3), np.float64)
    for j in range(n):
        px, py, pz = float(points[j, 0]), float(points[j, 1]), float(points[j, 2])
        for axis in range(3):
            moved[j, axis] = T[axis, 0] * px + T[axis, 1] * py + T[axis, 2] * pz + T[axis, 3]
    _front_back(moved, model, out[0], out[1])
    if len(out) == 6:
        keys = np.empty(n, np.float64)
        for j in range(n):
            keys[j] = _elevation_key(moved[j, 0], moved[j, 1], moved[j, 2])
        _count_above(keys, model.elevation, model.elevation_order, model.elevation_table, 1.0, out[2], out[3])
        for j in range(n):
            keys[j] = _azimuth_key(moved[j, 0], moved[j, 1], moved[j, 2])
        _count_above(keys, model.azimuth, model.azimuth_order, model.azimuth_table, 2.0, out[4], out[5])
    for block in range(0, len(out), 2):
        size = 0.0
        for side in range(block, block + 2):
            for a in range(out.shape[1]):
                value = out[side, a] * weights[side, a]
                out[side, a] = value
                size += value * value if unit_norm else value
        size = np.sqrt(size) if unit_norm else size
        if size > 0:  # a block that sees nothing stays zero
            for side in range(block, block + 2):
                for a in range(out.shape[1]):
                    out[side, a] /= size


@njit(cache=True, nogil=True)
def histogram(points: FloatArray, x: FloatArray, model: BoxedModel, weights: FloatArray, unit_norm: bool) -> FloatArray:
    """The histogram of one scene, points (S, 3), moved by x; shape (2M,) or (6M,), float32."""
    out = np.empty(weights.shape, np.float32)
    _describe(points, x, model, weights, unit_norm, out)
    return out.reshape(-1)


@njit(cache=True, nogil=True)
def histograms(
    points: FloatArray,
    starts: np.ndarray,
    x: FloatArray,
    model: BoxedModel,
    weights: FloatArray,
    unit_norm: bool,
    out: FloatArray,
) -> None:
    """Histograms of many scenes into `out` (B, sides, M): scene i is points[starts[i]:starts[i+1]] moved by x[i]."""
    for i in range(len(x)):
        _describe(points[starts[i] : starts[i + 1]], x[i], model, weights, unit_norm, out[i])
