"""The pose to expect, and how far from it the truth may be: mean and spread of the likelihood (docs/global.md, Eq. 7).

Where noise is strong or much is missing, the top of the likelihood over pose and plane lies aside of the middle of what
is nearly as likely; the mean is nearer to the truth.
"""

from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np
from scipy.stats import multivariate_t

from ido.compiling import compiled
from ido.global_registration.cut_plane import Posterior, Refined, likelihood_after
from ido.kernels import pose_of
from ido.types import DoubleArray, FloatArray

_ROUNDS, _PAIRS = 4, 100  # each round draws so many steps, and their opposites, in the place that the last one found
_TAILS = 6  # degrees of freedom of what is drawn from: more often far away than a Gaussian
_WIDER = 1.2  # than the top's curvature says, in the first round
_ENOUGH = 30.0  # as many draws as it takes to learn a place from, in effect
_OLD = 0.2  # of a place that is kept in the next, so that none collapses
_STEP = 0.01  # rad, model units: over the kinks of the field between its corners
_FIRST_WIDTH = 0.15  # along any direction at most, in the first round (rad, model units)
_LOOSEST = 1.0  # deviation that a pose can have along any direction (rad, model units)


@dataclass(frozen=True, slots=True, eq=False)
class Spread:
    """Where the pose of a scene may be.

    Args:
        T: the mean pose, T_model_scene, shape (4, 4).
        covariance: shift (model units) and turn (rad) in the model's frame, shape (6, 6), wherever the plane is.
    """

    T: DoubleArray
    covariance: DoubleArray

    @classmethod
    def of(cls, posterior: Posterior, top: Refined) -> Spread:
        """The mean by adaptive importance sampling about a top of the likelihood over pose and plane; the covariance by
        the top's curvature.

        The draws are always the same. Points that are repeated say nothing new, and are counted once.
        """
        around = _Around(posterior, top)
        curvature = around.curvature()
        rng = np.random.default_rng(0)
        middle, shape = np.zeros(9), _WIDER**2 * _inverse(curvature, _FIRST_WIDTH)
        steps, logs = np.zeros((1, 9)), np.zeros(1)
        for number in range(_ROUNDS):
            if number:
                weights = _tempered(logs)
                middle, learned = _moments(weights, steps)
                shape = (1 - _OLD) * learned + _OLD * shape
            drawn_from = multivariate_t(np.zeros(9), shape, df=_TAILS)
            aside = drawn_from.rvs(_PAIRS, random_state=rng)
            aside = np.concatenate([aside, -aside])
            steps = middle + aside
            logs = around.log_likelihoods(steps) - drawn_from.logpdf(aside)
        mean, _ = _moments(_weights(logs), steps)
        return cls(moved_by(mean[:6], top.T), _inverse(curvature, _LOOSEST)[:6, :6])


@dataclass(frozen=True, slots=True, eq=False)
class _Around:
    """The likelihood of all points at steps (n, 9) from a top: shift, turn, and of the plane along both tangents and
    its normal."""

    posterior: Posterior
    top: Refined

    def log_likelihoods(self, steps: DoubleArray) -> DoubleArray:
        """Log-likelihoods, shape (n,)."""
        return self._evaluated(steps)[0]

    def curvature(self) -> DoubleArray:
        """Minus the second derivatives at the top, by differences of the gradient, shape (9, 9)."""
        there, back = np.split(self._evaluated(np.concatenate([np.eye(9), -np.eye(9)]) * _STEP)[1], 2)
        curvature = (back - there) / (2 * _STEP)
        return (curvature + curvature.T) / 2

    def _evaluated(self, steps: DoubleArray) -> tuple[DoubleArray, DoubleArray]:
        values, gradients = np.empty(len(steps)), np.zeros((len(steps), 9))
        top = self.top
        tangents = np.linalg.svd(top.normal[None])[2][1:]
        place = np.ascontiguousarray(top.T), top.normal, tangents, top.offset
        data = self.posterior.data
        edges = np.linspace(0, len(steps), (os.cpu_count() or 1) + 1).astype(int)

        def part(begin: int, end: int) -> None:
            likelihoods_after(*data, *place, steps[begin:end], values[begin:end], gradients[begin:end])

        with ThreadPoolExecutor(len(edges) - 1) as pool:
            list(pool.map(part, edges[:-1], edges[1:]))
        n = len(np.unique(self.posterior.points, axis=0))
        return n * values, n * gradients


def _weights(logs: DoubleArray) -> DoubleArray:
    weights = np.exp(logs - logs.max())
    return weights / weights.sum()


def _tempered(logs: DoubleArray) -> DoubleArray:
    """Weights by a power of the likelihood, 1 if possible, for which enough draws have some."""
    weights = _weights(logs)
    while 1 / (weights**2).sum() < _ENOUGH:
        logs = 0.7 * logs
        weights = _weights(logs)
    return weights


def _moments(weights: DoubleArray, steps: DoubleArray) -> tuple[DoubleArray, DoubleArray]:
    mean = weights @ steps
    aside = steps - mean
    return mean, (weights[:, None] * aside).T @ aside


def _inverse(curvature: DoubleArray, loosest: float) -> DoubleArray:
    """The covariance that a curvature means, along no direction wider than the loosest."""
    values, vectors = np.linalg.eigh(curvature)
    return (vectors / np.maximum(values, loosest**-2)) @ vectors.T


def covariance_at(posterior: Posterior, top: Refined) -> DoubleArray:
    """The covariance of the pose with the plane held where it is, by the curvature of the top; shape (6, 6)."""
    return _inverse(_Around(posterior, top).curvature()[:6, :6], _LOOSEST)


def moved_by(motion: FloatArray, T: FloatArray) -> DoubleArray:
    """A pose (4, 4) turned about the model's origin and then shifted: motion (6,) is shift first, turn last."""
    moved = pose_of(np.concatenate([np.zeros(3), motion[3:]])) @ T
    moved[:3, 3] += motion[:3]
    return moved


@compiled(error_model="numpy")
def likelihoods_after(
    points: FloatArray,
    ball: FloatArray,
    density: FloatArray,
    model: FloatArray,
    numbers: DoubleArray,
    T: DoubleArray,
    normal: DoubleArray,
    tangents: DoubleArray,
    offset: float,
    steps: DoubleArray,
    values: DoubleArray,
    gradients: DoubleArray,
) -> None:
    """`likelihood_after` for many steps (n, 9)."""
    for i in range(len(steps)):
        values[i] = likelihood_after(
            points, ball, density, model, numbers, T, normal, tangents, offset, steps[i], gradients[i]
        )
