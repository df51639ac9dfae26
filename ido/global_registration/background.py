"""What a scene has besides the model: outliers scattered evenly, and outliers in one ball (docs/global.md, Eq. 2)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import KDTree

from ido.compiling import compiled
from ido.global_registration.settings import GlobalSettings
from ido.perturbation import OUTLIER_REACH, STRUCTURED_DEVIATION
from ido.types import BoolArray, DoubleArray, FloatArray

_LEAST_SHARE = 0.08  # of a ball: fewer points are no ball, but a dense part of the scene
_LEAST_ROUND = 0.5  # least variance of a ball along any direction, as part of the greatest
_STEPS = 30
_PLACES, _NEAR = 4, 0.2
_MOST = 600  # points that a ball is fitted to


@dataclass(frozen=True, slots=True, eq=False)
class Background:
    """The densities that a scene's outliers are drawn from.

    Args:
        uniform: of outliers scattered evenly, per cubic model unit.
        ball: of outliers in a ball, at each scene point, shape (S,), float32; zeros where there is no ball.
        ball_share: share of the scene's points in the ball; 0 where there is none.
        in_ball: probability that each scene point is of the ball, shape (S,), float32.
    """

    uniform: float
    ball: FloatArray
    ball_share: float
    in_ball: FloatArray

    @classmethod
    def of(cls, points: FloatArray, settings: GlobalSettings) -> Background:
        """The background of a scene, points (S, 3) in model units."""
        points = points.astype(np.float64)
        if settings.known_volume:
            volume = (2 * OUTLIER_REACH) ** 3
        else:
            volume = float(np.prod(np.maximum(np.ptp(points, axis=0), 0.1)))
        nothing = np.zeros(len(points), dtype=np.float32)
        if settings.ball:
            share, density, member = _ball(points, 1 / volume)
            if share > _LEAST_SHARE:
                return cls(1 / volume, density.astype(np.float32), share, member.astype(np.float32))
        return cls(1 / volume, nothing, 0.0, nothing)

    def part(self, chosen: BoolArray | np.ndarray) -> Background:
        """That of the chosen points."""
        return Background(self.uniform, self.ball[chosen], self.ball_share, self.in_ball[chosen])


def _ball(points: DoubleArray, uniform: float) -> tuple[float, DoubleArray, DoubleArray]:
    """Fit a tight and a broad round Gaussian and the uniform density to the points, from each of a few dense places.

    Returns:
        the tight one's share, its density at the points and each point's probability of it; shapes (S,). The share is
        0 where what was found is not round, as a part of a surface is not.
    """
    few = points[:: -(-len(points) // _MOST)]
    fits = np.array([fit_ball(few, centre, STRUCTURED_DEVIATION[1], uniform) for centre in _dense_places(few)])
    _, share, deviation, *centre = fits[fits[:, 0].argmax()]
    distance2 = ((points - centre[:3]) ** 2).sum(axis=1)
    density = np.exp(-distance2 / (2 * deviation**2)) / (2 * np.pi * deviation**2) ** 1.5
    broad_share, broad_deviation, *broad_centre = centre[3:]
    broad = np.exp(-((points - broad_centre) ** 2).sum(axis=1) / (2 * broad_deviation**2))
    broad *= broad_share / (2 * np.pi * broad_deviation**2) ** 1.5
    member = share * density / (share * density + broad + (1 - share - broad_share) * uniform)
    spread = np.linalg.eigvalsh(np.cov(points.T, aweights=member + 1e-9))
    return (share if spread[0] > _LEAST_ROUND * spread[2] else 0.0), density, member


def _dense_places(points: DoubleArray) -> DoubleArray:
    """The points with most others near them, none near another of them; shape (n, 3), n <= _PLACES."""
    neighbours = KDTree(points).query_ball_point(points, _NEAR, return_length=True).astype(float)
    places = []
    while len(places) < _PLACES and neighbours.max() > 0:
        places.append(points[neighbours.argmax()])
        neighbours[((points - places[-1]) ** 2).sum(axis=1) < (2 * _NEAR) ** 2] = 0
    return np.stack(places)


@compiled(error_model="numpy")
def fit_ball(points: DoubleArray, centre: DoubleArray, largest: float, uniform: float) -> DoubleArray:
    """Expectation maximisation of two round Gaussians and a uniform density.

    Args:
        points: shape (S, 3).
        centre: where the tight one starts, shape (3,).
        largest: deviation that the tight one can have.
        uniform: the density of scattered points.

    Returns:
        the log-likelihood; then share, deviation and centre (3) of the tight one, and of the broad one; shape (11,).
    """
    out = np.empty(11)
    share = np.array([0.3, 0.4])
    deviation = np.array([0.7 * largest, 0.6])
    centres = np.empty((2, 3))
    centres[0] = centre
    for axis in range(3):
        centres[1, axis] = points[:, axis].mean()
    density, sums = np.empty(2), np.empty((2, 5))
    for _ in range(_STEPS):
        sums[:] = 0.0
        total_log = 0.0
        for s in range(len(points)):
            for g in range(2):
                d2 = 0.0
                for axis in range(3):
                    d2 += (points[s, axis] - centres[g, axis]) ** 2
                density[g] = share[g] * np.exp(-d2 / (2 * deviation[g] ** 2)) / (2 * np.pi * deviation[g] ** 2) ** 1.5
            total = density[0] + density[1] + (1 - share[0] - share[1]) * uniform
            total_log += np.log(total)
            for g in range(2):
                r = density[g] / total
                sums[g, 0] += r
                for axis in range(3):
                    sums[g, 1 + axis] += r * points[s, axis]
                    sums[g, 4] += r * points[s, axis] ** 2
        out[0] = total_log
        for g in range(2):
            weight = max(sums[g, 0], 1e-9)
            square = 0.0
            for axis in range(3):
                centres[g, axis] = sums[g, 1 + axis] / weight
                square += centres[g, axis] ** 2
            deviation[g] = np.sqrt(max(sums[g, 4] / weight - square, 1e-6) / 3)
            share[g] = min(weight / len(points), 0.95)
        deviation[0] = min(max(deviation[0], 0.02), 1.15 * largest)
        deviation[1] = max(deviation[1], 1.5 * deviation[0])
        if share.sum() > 0.98:
            share *= 0.98 / share.sum()
    for g in range(2):
        out[1 + 5 * g], out[2 + 5 * g] = share[g], deviation[g]
        out[3 + 5 * g : 6 + 5 * g] = centres[g]
    return out
