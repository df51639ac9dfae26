"""The last step: pose and cut plane together, for scenes that miss what lies beyond a plane (docs/global.md, Eq. 6)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize

from ido.compiling import compiled
from ido.global_registration.fields import REACH, Field
from ido.global_registration.outliers import Background
from ido.kernels import pose_of
from ido.poses import transform
from ido.types import DoubleArray, FloatArray

_SOFT = 0.02  # how gradually the kept side ends, model units
_LEAST_SEEN = 0.1  # a plane keeps at least so much of the model
_DIRECTIONS = 64
_WITHIN = 0.97  # share of the explained points that the first plane keeps
_UNIT = 0.02  # of the parameters: about as far as a pose may be from the top (rad, model units)
_ITERATIONS = 30

NO_PLANE = (np.array([1.0, 0.0, 0.0]), 1e3)
"""Normal and offset of a plane beyond everything (model units)."""


@dataclass(frozen=True, slots=True, eq=False)
class Refined:
    """A pose at the top of the likelihood, and the plane beyond which the scene misses the model.

    Args:
        sigma: of the field that it was found on, model units.
        T: T_model_scene, shape (4, 4).
        normal: of the plane, unit, towards what is missing, model frame, shape (3,).
        offset: of the plane along its normal, model units.
        shares: of the model and of the ball among the scene's points, shape (2,).
        log_likelihood: per scene point.
    """

    sigma: float
    T: DoubleArray
    normal: DoubleArray
    offset: float
    shares: DoubleArray
    log_likelihood: float


def refine(posterior: Posterior, T: DoubleArray, *, cut: bool) -> Refined:
    """Climb to the top from a pose near it, by quasi-Newton steps (BFGS) on pose and plane.

    Args:
        posterior: the scene's.
        T: where to start, shape (4, 4).
        cut: whether there may be a plane; else the pose alone is moved.
    """
    normal, offset = posterior.first_plane(T) if cut else NO_PLANE
    tangents = np.linalg.svd(normal[None])[2][1:]
    free = 9 if cut else 6

    def place(parameters: DoubleArray) -> tuple[DoubleArray, DoubleArray, float]:
        full = np.zeros(9)
        full[:free] = _UNIT * parameters
        tilted = normal + full[6:8] @ tangents
        motion = np.concatenate([np.zeros(3), full[3:6]])
        moved = pose_of(motion) @ T
        moved[:3, 3] += full[:3]
        return moved, tilted, offset + full[8]

    def value(parameters: DoubleArray) -> tuple[float, DoubleArray]:
        moved, tilted, at = place(parameters)
        length = float(np.linalg.norm(tilted))
        likelihood, gradient = posterior(moved, tilted / length, at)
        about = gradient[3:6] - np.cross(_UNIT * parameters[:3], gradient[:3])  # the turn comes before the shift
        gradient[3:6] = left_jacobian(_UNIT * parameters[3:6]).T @ about
        along = gradient[6:9] - tilted * (tilted @ gradient[6:9]) / length**2
        reduced = np.concatenate([gradient[:6], tangents @ along / length, gradient[9:]])
        return -likelihood, -_UNIT * reduced[:free]

    found = minimize(value, np.zeros(free), jac=True, method="BFGS", options={"maxiter": _ITERATIONS, "gtol": 1e-5})
    moved, tilted, at = place(found.x)
    normal = tilted / np.linalg.norm(tilted)
    return Refined(posterior.field.sigma, moved, normal, at, posterior.shares, -float(found.fun))


@dataclass(frozen=True, slots=True, eq=False)
class Posterior:
    """The likelihood of a scene at a pose and a plane.

    Args:
        points: the scene, shape (S, 3), float32, model units.
        background: its outliers.
        field: the model's density, of the width that fits the noise.
        model: points of the model, which measure how much of it a plane keeps, shape (M, 3), float32.
        shares: of the model and of the ball among the scene's points, shape (2,).
    """

    points: FloatArray
    background: Background
    field: Field
    model: FloatArray
    shares: DoubleArray

    def __call__(self, T: FloatArray, normal: DoubleArray, offset: float) -> tuple[float, DoubleArray]:
        """Log-likelihood per scene point, and its gradient by shift (3), turn about the model's origin (3), the plane's
        normal (3) and offset; shape (10,)."""
        gradient = np.zeros(10)
        soft = np.hypot(
            _SOFT, 0.55 * self.field.sigma
        )  # the logistic curve that is nearest to the smeared model's edge
        numbers = np.array([REACH, self.field.step, self.background.uniform, *self.shares, _SOFT, soft])
        ball, density = self.background.ball, self.field.density
        value = plane_likelihood(self.points, ball, density, self.model, numbers, T, normal, offset, gradient)
        return value, gradient

    def explained(self, T: DoubleArray) -> DoubleArray:
        """Each scene point's probability of being of the model, without a plane; shape (S,)."""
        model, ball = self.shares
        p = model * self.field(transform(T, self.points)).astype(np.float64)
        return p / (p + ball * self.background.ball + (1 - model - ball) * self.background.uniform)

    def first_plane(self, T: DoubleArray) -> tuple[DoubleArray, float]:
        """Of planes in many directions, each just beyond the explained points, the one that keeps least of the model.

        Returns:
            its unit normal (3,) and its offset.
        """
        weight, moved = self.explained(T), transform(T, self.points)
        directions = spread_directions(_DIRECTIONS)
        along = moved @ directions.T
        order = np.argsort(along, axis=0)
        passed = np.cumsum(weight[order], axis=0) >= _WITHIN * weight.sum()
        offsets = np.take_along_axis(along, order, axis=0)[passed.argmax(axis=0), np.arange(_DIRECTIONS)]
        seen = (self.model @ directions.T < offsets).mean(axis=0)
        best = int(seen.argmin())
        return directions[best], float(offsets[best])


def spread_directions(n: int) -> DoubleArray:
    """Unit vectors spread evenly over the sphere (Fibonacci spiral), shape (n, 3)."""
    height = 1 - (2 * np.arange(n) + 1) / n
    around = np.pi * (1 + np.sqrt(5)) * np.arange(n)
    radius = np.sqrt(1 - height**2)
    return np.stack([radius * np.cos(around), radius * np.sin(around), height], axis=1)


def left_jacobian(turn: DoubleArray) -> DoubleArray:
    """How the turn by a rotation vector (3,) changes with it: exp(turn + δ) ≈ exp(J δ) exp(turn); shape (3, 3)."""
    angle = float(np.linalg.norm(turn))
    if angle < 1e-6:
        return np.eye(3)
    cross = np.cross(np.eye(3), turn / angle)
    return np.eye(3) + (1 - np.cos(angle)) / angle * cross + (1 - np.sin(angle) / angle) * cross @ cross


@compiled(error_model="numpy")
def plane_likelihood(
    points: FloatArray,
    ball: FloatArray,
    density: FloatArray,
    model: FloatArray,
    numbers: DoubleArray,
    T: FloatArray,
    normal: DoubleArray,
    offset: float,
    gradient: DoubleArray,
) -> float:
    """Mean log-likelihood of points (S, 3) at a pose and a plane; `gradient` (10,) is filled as `Posterior` says.

    `numbers` are reach, step, uniform density, shares of model and ball, softness of the plane and of the model there.
    """
    reach, step, uniform, model_share, ball_share, soft, model_soft = numbers
    n = density.shape[0]
    a, b, c = normal
    seen, seen_offset = 0.0, 0.0
    seen_normal = np.zeros(3)
    for m in range(len(model)):
        kept = 1 / (1 + np.exp((a * model[m, 0] + b * model[m, 1] + c * model[m, 2] - offset) / model_soft))
        slope = kept * (1 - kept) / model_soft
        seen += kept
        seen_offset += slope
        for axis in range(3):
            seen_normal[axis] -= slope * model[m, axis]
    seen /= len(model)
    if seen < _LEAST_SEEN:
        seen, seen_offset = _LEAST_SEEN, 0.0
        seen_normal[:] = 0.0
    by_seen, total_log = 0.0, 0.0
    for s in range(len(points)):
        px, py, pz = float(points[s, 0]), float(points[s, 1]), float(points[s, 2])
        x = T[0, 0] * px + T[0, 1] * py + T[0, 2] * pz + T[0, 3]
        y = T[1, 0] * px + T[1, 1] * py + T[1, 2] * pz + T[1, 3]
        z = T[2, 0] * px + T[2, 1] * py + T[2, 2] * pz + T[2, 3]
        total = (1 - model_share - ball_share) * uniform + ball_share * ball[s]
        gx, gy, gz = (x + reach) / step, (y + reach) / step, (z + reach) / step
        if 0 <= gx < n - 1 and 0 <= gy < n - 1 and 0 <= gz < n - 1:
            i, j, h = int(gx), int(gy), int(gz)
            fx, fy, fz = gx - i, gy - j, gz - h
            d00 = density[i, j, h + 1] - density[i, j, h]
            d01 = density[i, j + 1, h + 1] - density[i, j + 1, h]
            d10 = density[i + 1, j, h + 1] - density[i + 1, j, h]
            d11 = density[i + 1, j + 1, h + 1] - density[i + 1, j + 1, h]
            q00, q01 = density[i, j, h] + fz * d00, density[i, j + 1, h] + fz * d01
            q10, q11 = density[i + 1, j, h] + fz * d10, density[i + 1, j + 1, h] + fz * d11
            e0, e1 = q01 - q00, q11 - q10
            q0, q1 = q00 + fy * e0, q10 + fy * e1
            g0, g1 = d00 + fy * (d01 - d00), d10 + fy * (d11 - d10)
            side = 1 / (1 + np.exp((a * x + b * y + c * z - offset) / soft))
            factor = model_share / seen
            p = factor * (q0 + fx * (q1 - q0))
            total += p * side
            slope = -p * side * (1 - side) / soft / total
            ux = factor * side * (q1 - q0) / step / total + slope * a
            uy = factor * side * (e0 + fx * (e1 - e0)) / step / total + slope * b
            uz = factor * side * (g0 + fx * (g1 - g0)) / step / total + slope * c
            gradient[0] += ux
            gradient[1] += uy
            gradient[2] += uz
            gradient[3] += y * uz - z * uy
            gradient[4] += z * ux - x * uz
            gradient[5] += x * uy - y * ux
            gradient[6] += slope * x
            gradient[7] += slope * y
            gradient[8] += slope * z
            gradient[9] -= slope
            by_seen -= p * side / total / seen
        total_log += np.log(total)
    for axis in range(3):
        gradient[6 + axis] += by_seen * seen_normal[axis] / len(model)
    gradient[9] += by_seen * seen_offset / len(model)
    gradient /= len(points)
    return total_log / len(points)
