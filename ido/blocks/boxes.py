"""The compiled loop that weighs every scene point against every model point, for the blocks that weigh by distance.

It dominates everything else. The weight exp(-d²/σ²) is below 1e-6, and counts as nothing, for nine pairs out of ten. So
the model points are put into small boxes, the scene points within reach of a box are gathered, first for a group of
boxes and then for each, and only those are weighed. Coordinates are scaled so that the weight is 2^-d², computed as a
quartic times a power of two put together from bits.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from ido.clouds import Model
from ido.compiling import compiled
from ido.types import DoubleArray, FloatArray

SIGMA2 = 0.03
"""σ² of the Gaussian weight exp(-d²/σ²), in squared model units, as in the paper."""

SCALED_SIGMA2 = float(np.log2(np.e))
"""The same in `Boxes`, where the weight is 2^-d²."""

SMALLEST_WEIGHT = 1e-6
"""A smaller weight counts as nothing."""

BOX = 16  # model points in a box
GROUP = 4  # boxes in a group
_LANES = 16  # gathered points are padded to a multiple of this
_FAR = np.float32(1e4)

# 2^f on [-1/2, 1/2], least relative error at Chebyshev nodes: 3e-6
_nodes = np.cos(np.linspace(0.0, np.pi, 400)) / 2
_E4, _E3, _E2, _E1, _E0 = (np.float32(c) for c in np.polyfit(_nodes, 2.0**_nodes, 4, w=2.0**-_nodes))

_ZERO, _HALF = np.float32(0), np.float32(0.5)
_MANTISSA_BITS = np.int32(23)


def gaussian_weights(points: FloatArray, moved: FloatArray) -> DoubleArray:
    """w = exp(-‖s - m_a‖²/σ²), or nothing below `SMALLEST_WEIGHT`: the definition; (M, 3) and (S, 3) to (M, S).

    docs/method.md, Eq. 5.
    """
    weight = np.exp(-((moved[None] - points[:, None]) ** 2).sum(axis=-1) / SIGMA2)
    return np.where(weight > SMALLEST_WEIGHT, weight, 0.0)


IsFirst = Callable[[np.float32, np.float32, np.float32, np.float32, np.float32, np.float32], np.bool_]
"""Whether a scene point lies on the first side: from x, y, z of s - m_a, scaled as `Boxes` are, and of the normal."""


class Boxes(NamedTuple):
    """A model's points and normals in boxes; the point at place i is the model's point ``order[i]``."""

    order: np.ndarray  # (M,) int64
    points: FloatArray  # (3, M) float32, scaled
    normals: FloatArray  # (3, M) float32
    box_low: FloatArray  # (boxes, 3) float32, scaled
    box_high: FloatArray
    group_low: FloatArray  # (groups, 3)
    group_high: FloatArray
    scale: float


def boxes_of(model: Model) -> Boxes:
    """Lay out a model for `weigh`."""
    exact = np.asarray(model.points, dtype=np.float64)
    order = _spatial_order(exact, np.arange(len(exact)))
    scale = float(np.sqrt(SCALED_SIGMA2 / SIGMA2))
    scaled = (exact[order] * scale).astype(np.float32)
    starts = np.arange(0, len(scaled), BOX)
    box_low, box_high = np.minimum.reduceat(scaled, starts), np.maximum.reduceat(scaled, starts)
    groups = np.arange(0, len(starts), GROUP)
    return Boxes(
        order,
        np.ascontiguousarray(scaled.T),
        np.ascontiguousarray(np.asarray(model.normals, dtype=np.float32)[order].T),
        box_low,
        box_high,
        np.minimum.reduceat(box_low, groups),
        np.maximum.reduceat(box_high, groups),
        scale,
    )


def _spatial_order(points: FloatArray, chosen: np.ndarray) -> np.ndarray:
    """The points in an order in which every BOX of them lie close together: halve along the longest side."""
    if len(chosen) <= BOX:
        return chosen
    here = points[chosen]
    along = np.argsort(here[:, np.ptp(here, axis=0).argmax()], kind="stable")
    half = -(-len(chosen) // BOX) // 2 * BOX
    return np.concatenate([_spatial_order(points, chosen[along[:half]]), _spatial_order(points, chosen[along[half:]])])


@compiled(inline="always", fastmath=True)
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


@compiled(inline="always", fastmath=True, error_model="numpy")
def weigh(
    boxes: Boxes, moved: FloatArray, starts: np.ndarray, out: FloatArray, side: int, is_first: IsFirst
) -> None:  # pragma: no cover (compiled)
    """Write Σ w over the points of each scene on the first and on the second side of each model point.

    The sums of docs/method.md, Eq. 6, of the weights of Eq. 5, by any question.

    Args:
        boxes: the model.
        moved: points of all scenes in the model frame, shape (N, 3), float64.
        starts: scene i is ``moved[starts[i] : starts[i + 1]]``.
        out: shape (B, sides, M), float32.
        side: number of the first side in it.
        is_first: the block's question, a compiled function named in the call.
    """
    reach2 = np.float32(-np.log2(SMALLEST_WEIGHT))
    n_model, n_boxes = boxes.points.shape[1], len(boxes.box_low)
    largest = 0
    for i in range(len(starts) - 1):
        largest = max(largest, starts[i + 1] - starts[i])
    scene = np.empty((3, largest + _LANES), np.float32)
    near_group = np.empty_like(scene)
    near = np.empty_like(scene)
    distance2 = np.empty(largest, np.float32)
    for scene_number in range(len(starts) - 1):
        begin = starts[scene_number]
        n = starts[scene_number + 1] - begin
        for j in range(n):
            for axis in range(3):
                scene[axis, j] = moved[begin + j, axis] * boxes.scale
        for group in range(len(boxes.group_low)):
            n_group = _gather(scene, n, boxes.group_low[group], boxes.group_high[group], reach2, near_group, distance2)
            for box in range(group * GROUP, min(n_boxes, group * GROUP + GROUP)):
                count = _gather(near_group, n_group, boxes.box_low[box], boxes.box_high[box], reach2, near, distance2)
                padded = (count + _LANES - 1) // _LANES * _LANES
                near[0, count:padded] = _FAR
                near[1, count:padded] = _FAR
                near[2, count:padded] = _FAR
                x, y, z = near[0, :padded], near[1, :padded], near[2, :padded]
                for a in range(box * BOX, min(n_model, box * BOX + BOX)):
                    mx, my, mz = boxes.points[0, a], boxes.points[1, a], boxes.points[2, a]
                    nx, ny, nz = boxes.normals[0, a], boxes.normals[1, a], boxes.normals[2, a]
                    first, total = _ZERO, _ZERO
                    for j in range(padded):
                        dx, dy, dz = x[j] - mx, y[j] - my, z[j] - mz
                        exponent = -(dx * dx + dy * dy + dz * dz)
                        whole = np.int32(exponent - _HALF)
                        f = exponent - np.float32(whole)
                        mantissa = (((_E4 * f + _E3) * f + _E2) * f + _E1) * f + _E0
                        bits = np.float32(mantissa).view(np.int32) + (whole << _MANTISSA_BITS)
                        weight = np.int32(bits).view(np.float32) if exponent > -reach2 else _ZERO
                        total += weight
                        first += weight if is_first(dx, dy, dz, nx, ny, nz) else _ZERO
                    out[scene_number, side, boxes.order[a]] = first
                    out[scene_number, side + 1, boxes.order[a]] = total - first
