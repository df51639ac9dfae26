"""The compiled loops that all histograms share; those of a block stand beside it in `ido.blocks`."""

from __future__ import annotations

import numpy as np

from ido.compiling import compiled
from ido.types import DoubleArray, FloatArray


@compiled()
def pose_of(x: FloatArray) -> DoubleArray:
    """T = exp(x^) of x = [ρ, φ], shape (4, 4); `ido.poses.exp` defines it (docs/method.md, Eq. 2)."""
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


@compiled()
def left_jacobian(turn: FloatArray) -> DoubleArray:
    """How the turn by a rotation vector (3,) changes with it: exp(turn + δ) ≈ exp(J δ) exp(turn); shape (3, 3).

    J is the V of docs/method.md, Eq. 2 (Barfoot 2017: its "Sources").
    """
    a, b, c = turn[0], turn[1], turn[2]
    angle2 = a * a + b * b + c * c
    angle = np.sqrt(angle2)
    if angle > 1e-4:
        cosine, rest = (1 - np.cos(angle)) / angle2, (1 - np.sin(angle) / angle) / angle2
    else:  # Taylor series, exact to double precision
        cosine, rest = 0.5 - angle2 / 24, 1 / 6 - angle2 / 120
    cross = np.array([[0.0, -c, b], [c, 0.0, -a], [-b, a, 0.0]])
    J = np.eye(3)
    for i in range(3):
        for j in range(3):
            square = turn[i] * turn[j] - (angle2 if i == j else 0.0)
            J[i, j] += cosine * cross[i, j] + rest * square
    return J


@compiled()
def move(points: FloatArray, starts: np.ndarray, x: FloatArray) -> DoubleArray:
    """The points (N, 3) of many scenes in the model frame: points[starts[i]:starts[i+1]] moved by x[i] (6,).

    docs/method.md, Eq. 1.
    """
    moved = np.empty((len(points), 3), np.float64)
    for i in range(len(x)):
        T = pose_of(x[i])
        for j in range(starts[i], starts[i + 1]):
            px, py, pz = float(points[j, 0]), float(points[j, 1]), float(points[j, 2])
            for axis in range(3):
                moved[j, axis] = T[axis, 0] * px + T[axis, 1] * py + T[axis, 2] * pz + T[axis, 3]
    return moved


@compiled(error_model="numpy")
def scale_blocks(out: FloatArray, weights: FloatArray, unit_norm: bool) -> None:
    """Weigh the bins of many histograms (B, sides, M), and scale each block to length 1 or sum 1, in place.

    docs/method.md, Eq. 9 and 10.
    """
    for i in range(len(out)):
        for block in range(0, out.shape[1], 2):
            size = 0.0
            for side in range(block, block + 2):
                for a in range(out.shape[2]):
                    value = out[i, side, a] * weights[side, a]
                    out[i, side, a] = value
                    size += value * value if unit_norm else value
            size = np.sqrt(size) if unit_norm else size
            if size > 0:  # a block that sees nothing stays zero
                for side in range(block, block + 2):
                    for a in range(out.shape[2]):
                        out[i, side, a] /= size
