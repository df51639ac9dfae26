"""The last step: pose and cut plane together, for scenes that miss what lies beyond a plane (docs/global.md, Eq. 6)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy  # a part of it is loaded when it is used: the program starts sooner

from ido.compiling import compiled
from ido.global_registration.fields import REACH, Field
from ido.global_registration.outliers import Background
from ido.global_registration.planes import NO_PLANE, Planes
from ido.kernels import left_jacobian, pose_of
from ido.poses import transform
from ido.types import DoubleArray, FloatArray

_SOFT = 0.02  # how gradually the kept side ends, model units
_LEAST_SEEN = 0.1  # a plane keeps at least so much of the model
_LEAST_DENSITY = 1e-12  # of outliers, where shares leave none
_UNIT = 0.02  # of the parameters: about as far as a pose may be from the top (rad, model units)
_ITERATIONS = 30


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

    @property
    def has_plane(self) -> bool:
        """Whether the plane lies anywhere near the model."""
        return self.offset < NO_PLANE[1] / 2


def refine(posterior: Posterior, T: DoubleArray, *, cut: bool) -> Refined:
    """Climb to the top from a pose near it, by quasi-Newton steps (BFGS) on pose and plane (docs/global.md, Eq. 6).

    Args:
        posterior: the scene's.
        T: where to start, shape (4, 4).
        cut: whether there may be a plane; else the pose alone is moved.
    """
    normal, offset = posterior.first_plane(T) if cut else NO_PLANE
    tangents = np.linalg.svd(normal[None])[2][1:]
    free = 9 if cut else 6

    def value(parameters: DoubleArray) -> tuple[float, DoubleArray]:
        step, gradient = np.zeros(9), np.zeros(9)
        step[:free] = _UNIT * parameters
        likelihood = likelihood_after(*data, T, normal, tangents, offset, step, gradient)
        return -likelihood, -_UNIT * gradient[:free]

    data, T = posterior.data, np.ascontiguousarray(T, dtype=np.float64)
    found = scipy.optimize.minimize(
        value, np.zeros(free), jac=True, method="BFGS", options={"maxiter": _ITERATIONS, "gtol": 1e-5}
    )
    step = np.zeros(9)
    step[:free] = _UNIT * found.x
    moved, tilted, _ = _moved(T, normal, tangents, step)
    return Refined(posterior.field.sigma, moved, tilted, offset + step[8], posterior.shares, -float(found.fun))


@dataclass(frozen=True, slots=True, eq=False)
class Posterior:
    """The likelihood of a scene at a pose and a plane (docs/global.md, Eq. 6).

    Args:
        points: the scene, shape (S, 3), float32, model units.
        background: its outliers.
        field: the model's density, of the width that fits the noise.
        planes: of the model, whose sample measures how much of it any plane keeps.
        shares: of the model and of the ball among the scene's points, shape (2,).
    """

    points: FloatArray
    background: Background
    field: Field
    planes: Planes
    shares: DoubleArray

    @property
    def n_different(self) -> int:
        """How many points there are; repeated ones say nothing new, and count once."""
        return len(np.unique(self.points, axis=0))

    @property
    def model(self) -> FloatArray:
        """Points of the model, shape (M, 3), float32."""
        return self.planes.sample

    def __call__(self, T: FloatArray, normal: DoubleArray, offset: float) -> tuple[float, DoubleArray]:
        """Log-likelihood per scene point, and its gradient by shift (3), turn about the model's origin (3), the plane's
        normal (3) and offset; shape (10,)."""
        gradient = np.zeros(10)
        T = np.ascontiguousarray(T, dtype=np.float64)
        return plane_likelihood(*self.data, T, normal, offset, gradient), gradient

    @property
    def data(self) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray, DoubleArray]:
        """The first arguments of `plane_likelihood`."""
        soft = np.hypot(_SOFT, 0.55 * self.field.sigma)  # the logistic curve nearest to the smeared model's edge
        numbers = np.array([REACH, self.field.step, self.background.uniform, *self.shares, _SOFT, soft])
        return self.points, self.background.ball, self.field.density, self.model, numbers

    def explained(self, T: DoubleArray) -> DoubleArray:
        """Each scene point's probability of being of the model, without a plane; shape (S,)."""
        odds = self._odds(transform(T, self.points))
        return odds / (1 + odds)

    def first_plane(self, T: DoubleArray) -> tuple[DoubleArray, float]:
        """The likeliest of many planes at a pose: its unit normal (3,) and its offset."""
        moved = transform(T, self.points)
        return self.planes.likeliest(moved, self._odds(moved))

    def _odds(self, moved: FloatArray) -> DoubleArray:
        return odds_of(self.background, self.field, self.shares, moved)


def odds_of(background: Background, field: Field, shares: DoubleArray, moved: FloatArray) -> DoubleArray:
    """How much likelier each point is of the model than of the outliers, without a plane (docs/global.md, Eq. 4).

    Args:
        background: of the scene.
        field: the model's density.
        shares: of the model and of the ball among the points, shape (..., 2).
        moved: the scene at a pose, shape (..., S, 3).

    Returns:
        the odds, shape (..., S).
    """
    model, ball = shares[..., :1], shares[..., 1:]
    others = ball * background.ball + (1 - model - ball) * background.uniform
    density = field(moved.reshape(-1, 3)).reshape(moved.shape[:-1])
    return model * density.astype(np.float64) / np.maximum(others, _LEAST_DENSITY)


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
    """Mean log-likelihood of points (S, 3) at a pose and a plane (docs/global.md, Eq. 6).

    `gradient` (10,) is filled as `Posterior` says.
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


@compiled(error_model="numpy")
def _moved(
    T: DoubleArray, normal: DoubleArray, tangents: DoubleArray, step: DoubleArray
) -> tuple[DoubleArray, DoubleArray, float]:
    """A pose (4, 4) and a plane's unit normal (3,) after a step (9,): shift, turn, and along both tangents.

    And the length that the normal had before it was made unit.
    """
    turn = np.zeros(6)
    for i in range(3, 6):
        turn[i] = step[i]
    E = pose_of(turn)
    moved = np.zeros((4, 4))
    for i in range(3):
        for j in range(4):
            for k in range(3):
                moved[i, j] += E[i, k] * T[k, j]
        moved[i, 3] += step[i]
    moved[3, 3] = 1.0
    tilted = normal + step[6] * tangents[0] + step[7] * tangents[1]
    length = np.sqrt((tilted**2).sum())
    return moved, tilted / length, length


@compiled(error_model="numpy")
def likelihood_after(
    points: FloatArray,
    ball: FloatArray,
    density: FloatArray,
    model: FloatArray,
    numbers: DoubleArray,
    T: DoubleArray,
    normal: DoubleArray,
    tangents: DoubleArray,
    offset: float,
    step: DoubleArray,
    gradient: DoubleArray,
) -> float:
    """`plane_likelihood` after a step (9,) of shift, turn, and plane; `gradient` (9,) by the step is filled."""
    moved, unit, length = _moved(T, normal, tangents, step)
    by_place = np.zeros(10)
    value = plane_likelihood(points, ball, density, model, numbers, moved, unit, offset + step[8], by_place)
    x, y, z = by_place[0], by_place[1], by_place[2]
    # the turn comes before the shift
    about = np.array(
        [
            by_place[3] - step[1] * z + step[2] * y,
            by_place[4] - step[2] * x + step[0] * z,
            by_place[5] - step[0] * y + step[1] * x,
        ]
    )
    J = left_jacobian(step[3:6])
    across = (unit * by_place[6:9]).sum()
    for i in range(3):
        gradient[i] = by_place[i]
        gradient[3 + i] = (J[:, i] * about).sum()
    for i in range(2):
        gradient[6 + i] = (tangents[i] * (by_place[6:9] - across * unit)).sum() / length
    gradient[8] = by_place[9]
    return value
