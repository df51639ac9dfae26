"""What a scene has besides the model: outliers scattered evenly, and outliers in one ball (docs/global.md, Eq. 2)."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial import KDTree

from ido.compiling import compiled
from ido.global_registration.settings import GlobalSettings
from ido.perturbation import OUTLIER_REACH, STRUCTURED_DEVIATION
from ido.types import DoubleArray, FloatArray, IntArray

_LEAST_SHARE = 0.08  # of a ball: fewer points are no ball, but a dense part of the scene
_LEAST_ROUND = 0.5  # least variance of a ball along any direction, as part of the greatest
_LARGEST = 1.15 * STRUCTURED_DEVIATION[1]
_STEPS = 30
_PLACES, _NEAR = 5, 0.2
_MOST = 600  # points that a ball is fitted to


@dataclass(frozen=True, slots=True, eq=False)
class Background:
    """The densities that a scene's outliers are drawn from (docs/global.md, Eq. 2).

    Args:
        uniform: of outliers scattered evenly, per cubic model unit.
        ball: of outliers in a ball, at each scene point, shape (S,), float32; zeros where there is no ball.
        in_ball: probability that each scene point is of the ball, shape (S,), float32.
    """

    uniform: float
    ball: FloatArray
    in_ball: FloatArray

    @classmethod
    def of(cls, points: FloatArray, settings: GlobalSettings) -> Background:
        """The background of a scene, points (S, 3) in model units."""
        points = points.astype(np.float64)
        if settings.known_volume:
            volume = (2 * OUTLIER_REACH) ** 3
        else:
            volume = float(np.prod(np.maximum(np.ptp(points, axis=0), 0.1)))
        ball = member = np.zeros(len(points))
        if settings.ball:
            ball, member = _ball(points, 1 / volume)
        return cls(1 / volume, ball.astype(np.float32), member.astype(np.float32))

    @property
    def has_ball(self) -> bool:
        return bool(self.in_ball.any())

    @property
    def without_ball(self) -> Background:
        """The same where every outlier is scattered."""
        return replace(self, ball=np.zeros_like(self.ball), in_ball=np.zeros_like(self.in_ball))

    def part(self, chosen: IntArray) -> Background:
        """That of the chosen points."""
        return Background(self.uniform, self.ball[chosen], self.in_ball[chosen])


def _ball(points: DoubleArray, uniform: float) -> tuple[DoubleArray, DoubleArray]:
    """Fit a round Gaussian, one of any shape and the uniform density to the points, from each of a few dense places.

    Returns:
        the round one's density at the points and each point's probability of it, of the likeliest fit; shapes (S,).
        Zeros where nothing round was found, as a part of a surface is not.
    """
    stride = -(-len(points) // _MOST)
    few = np.ascontiguousarray(points[::stride])
    highest, density, member = -np.inf, np.zeros(len(points)), np.zeros(len(points))
    for place in _dense_places(few):
        columns = np.zeros((3, len(points)))
        likelihood, share = fit_ball(points, stride, place, _LARGEST, uniform, columns)
        if likelihood <= highest or share < _LEAST_SHARE:
            continue
        spread = np.linalg.eigvalsh(np.cov(points.T, aweights=columns[1] + 1e-9))
        if spread[0] > _LEAST_ROUND * spread[2]:
            highest, density, member = likelihood, columns[0], columns[1]
    return density, member


def _dense_places(points: DoubleArray) -> DoubleArray:
    """The points with most others near them, none near another of them; shape (n, 3), n <= _PLACES."""
    neighbours = KDTree(points).query_ball_point(points, _NEAR, return_length=True).astype(float)
    places = []
    while len(places) < _PLACES and neighbours.max() > 0:
        places.append(points[neighbours.argmax()])
        neighbours[((points - places[-1]) ** 2).sum(axis=1) < (2 * _NEAR) ** 2] = 0
    return np.stack(places)


@compiled(error_model="numpy")
def fit_ball(
    points: DoubleArray, stride: int, centre: DoubleArray, largest: float, uniform: float, out: DoubleArray
) -> tuple[float, float]:
    """Expectation maximisation of a round Gaussian, one of any shape and a uniform density (docs/global.md, Eq. 2).

    Args:
        points: shape (S, 3).
        stride: every so manieth point is fitted to.
        centre: where the round one starts, shape (3,).
        largest: deviation that the round one can have.
        uniform: the density of scattered points.
        out: shape (3, S): the density of the round one at all points, and their probability of it, are written to it.

    Returns:
        the log-likelihood of the fitted points, and the round one's share.
    """
    n_fitted = -(-len(points) // stride)
    share, broad_share, deviation = 0.3, 0.4, 0.7 * largest
    round_centre, broad_centre, offset = centre.copy(), np.zeros(3), np.empty(3)
    for axis in range(3):
        broad_centre[axis] = points[:, axis].mean()
    covariance = 0.25 * np.eye(3)
    likelihood = 0.0
    sums, second = np.empty((2, 5)), np.empty((3, 3))
    for iteration in range(_STEPS + 1):
        last = iteration == _STEPS
        inverse = np.linalg.inv(covariance)
        broad = broad_share / np.sqrt((2 * np.pi) ** 3 * np.linalg.det(covariance))
        tight = 1 / (2 * np.pi * deviation**2) ** 1.5
        sums[:] = 0.0
        second[:] = 0.0
        likelihood = 0.0
        for s in range(0, len(points), 1 if last else stride):
            d2, form = 0.0, 0.0
            for axis in range(3):
                d2 += (points[s, axis] - round_centre[axis]) ** 2
                offset[axis] = points[s, axis] - broad_centre[axis]
            for i in range(3):
                for j in range(3):
                    form += offset[i] * inverse[i, j] * offset[j]
            density = tight * np.exp(-d2 / (2 * deviation**2))
            first, other = share * density, broad * np.exp(-form / 2)
            total = first + other + (1 - share - broad_share) * uniform
            if s % stride == 0:
                likelihood += np.log(total)
            if last:
                out[0, s], out[1, s] = density, first / total
                continue
            first, other = first / total, other / total
            sums[0, 0] += first
            sums[1, 0] += other
            sums[0, 4] += first * (points[s, 0] ** 2 + points[s, 1] ** 2 + points[s, 2] ** 2)
            for i in range(3):
                sums[0, 1 + i] += first * points[s, i]
                sums[1, 1 + i] += other * points[s, i]
                for j in range(3):
                    second[i, j] += other * points[s, i] * points[s, j]
        if last:
            break
        weight, other = max(sums[0, 0], 1e-9), max(sums[1, 0], 1e-9)
        square = 0.0
        for i in range(3):
            round_centre[i], broad_centre[i] = sums[0, 1 + i] / weight, sums[1, 1 + i] / other
            square += round_centre[i] ** 2
        for i in range(3):
            for j in range(3):
                covariance[i, j] = second[i, j] / other - broad_centre[i] * broad_centre[j]
            covariance[i, i] += 1e-3
        covariance *= max(1.0, 5 * largest**2 / np.trace(covariance))  # else both Gaussians share one ball
        deviation = min(max(np.sqrt(max(sums[0, 4] / weight - square, 0.0) / 3), 0.05), largest)
        share, broad_share = weight / n_fitted, other / n_fitted
        if share + broad_share > 0.98:
            share, broad_share = share * 0.98 / (share + broad_share), broad_share * 0.98 / (share + broad_share)
    return likelihood, share
