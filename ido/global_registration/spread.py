"""The pose to expect, and how far from it the truth may be: mean and spread of the likelihood (docs/global.md, Eq. 7).

Where a plane is uncertain, the top of the likelihood over pose and plane lies aside of the middle of what is nearly as
likely, and the mean is nearer to the truth.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ido.compiling import compiled
from ido.global_registration.cut_plane import Posterior, Refined, likelihood_after
from ido.global_registration.parts import in_parts
from ido.kernels import pose_of
from ido.types import DoubleArray, FloatArray

_ROUNDS, _PAIRS = 4, 100  # each round draws so many steps, and their opposites, in the place that the last one found
_TAILS = 6  # degrees of freedom of what is drawn from: more often far away than a Gaussian
_WIDER = 1.2  # than the top's curvature says, in the first round
_ENOUGH = 30.0  # as many draws as it takes to learn a place from, in effect
_OLD = 0.2  # of a place that is kept in the next, so that none collapses
_STEP = 0.01  # rad, model units: over the kinks of the field between its corners
_WIDEST = 0.15  # deviation that a curvature is believed to mean, at most (rad, model units)


@dataclass(frozen=True, slots=True, eq=False)
class Spread:
    """Where the pose of a scene may be (docs/global.md, Eq. 7).

    Args:
        motion: from the top of the likelihood to its mean: shift (model units) and turn (rad) in the model's frame, as
            `moved_by` takes it; shape (6,).
        covariance: of the pose, of the same six numbers, shape (6, 6).
    """

    motion: DoubleArray
    covariance: DoubleArray

    @classmethod
    def of(cls, posterior: Posterior, top: Refined) -> Spread:
        """Mean and covariance of the pose by adaptive importance sampling about a top of the likelihood.

        It is sampled over the plane, too, if there is one. The draws are always the same.

        Args:
            posterior: the likelihood of the scene.
            top: of it.
        """
        around = _Around(posterior, top)
        rng, n = np.random.default_rng(0), around.n_numbers
        middle, covariance = np.zeros(n), _inverse(around.curvature())
        shape = _WIDER**2 * covariance
        for _ in range(_ROUNDS):
            aside = drawn_steps(rng, shape)
            aside = np.concatenate([aside, -aside])
            weights = _tempered(around.log_likelihoods(middle + aside) - log_densities(aside, shape))
            middle, covariance = _moments(weights, middle + aside)
            shape = (1 - _OLD) * covariance + _OLD * shape
        return cls(middle[:6], covariance[:6, :6])


@dataclass(frozen=True, slots=True, eq=False)
class _Around:
    """The likelihood of all points at steps from a top (n, 9 or 6): shift, turn, and of a plane, if there is one, its
    tilt along both tangents and its shift along its normal."""

    posterior: Posterior
    top: Refined

    @property
    def n_numbers(self) -> int:
        """Of a step: without a plane, nothing changes with its tilt and shift."""
        return 9 if self.top.has_plane else 6

    def log_likelihoods(self, steps: DoubleArray) -> DoubleArray:
        """Log-likelihoods, shape (n,)."""
        return self._evaluated(steps)[0]

    def curvature(self) -> DoubleArray:
        """Minus the second derivatives at the top, by differences of the gradient, shape (9, 9) or (6, 6)."""
        each = _STEP * np.eye(self.n_numbers)
        there, back = np.split(self._evaluated(np.concatenate([each, -each]))[1], 2)
        curvature = (back - there) / (2 * _STEP)
        return (curvature + curvature.T) / 2

    def _evaluated(self, steps: DoubleArray) -> tuple[DoubleArray, DoubleArray]:
        """Log-likelihoods (n,), and their gradients by the steps."""
        full, top = np.zeros((len(steps), 9)), self.top
        full[:, : steps.shape[1]] = steps
        values, gradients = np.empty(len(full)), np.zeros((len(full), 9))
        tangents = np.linalg.svd(top.normal[None])[2][1:]
        place = np.ascontiguousarray(top.T), top.normal, tangents, top.offset
        data = self.posterior.data

        def part(begin: int, end: int) -> None:
            likelihoods_after(*data, *place, full[begin:end], values[begin:end], gradients[begin:end])

        in_parts(len(full), part)
        n = self.posterior.n_different
        return n * values, n * gradients[:, : steps.shape[1]]


def drawn_steps(rng: np.random.Generator, shape: DoubleArray) -> DoubleArray:
    """Steps (_PAIRS, n) from the Student t distribution about zero that has a scale matrix (n, n);
    the q of docs/global.md, Eq. 7.

    As `scipy.stats.multivariate_t` draws them, which takes a quarter of a second to import.
    """
    narrowed = rng.chisquare(_TAILS, _PAIRS) / _TAILS
    return rng.multivariate_normal(np.zeros(len(shape)), shape, _PAIRS) / np.sqrt(narrowed)[:, None]


def log_densities(steps: DoubleArray, shape: DoubleArray) -> DoubleArray:
    """Logarithms (m,) of that distribution's density at steps (m, n), but for a constant, which is in all weights;
    the q of docs/global.md, Eq. 7.
    """
    squares = np.einsum("ij,ji->i", steps, np.linalg.solve(shape, steps.T))
    return -(_TAILS + len(shape)) / 2 * np.log1p(squares / _TAILS)


def _tempered(logs: DoubleArray) -> DoubleArray:
    """Weights by a power of the likelihood, 1 if possible, for which enough draws have some; shape (n,)."""
    while True:
        weights = np.exp(logs - logs.max())
        weights /= weights.sum()
        if 1 / (weights**2).sum() >= _ENOUGH:
            return weights
        logs = 0.7 * logs


def _moments(weights: DoubleArray, steps: DoubleArray) -> tuple[DoubleArray, DoubleArray]:
    mean = weights @ steps
    aside = steps - mean
    return mean, (weights[:, None] * aside).T @ aside


def _inverse(curvature: DoubleArray) -> DoubleArray:
    """The covariance that a curvature means, along no direction wider than `_WIDEST`."""
    values, vectors = np.linalg.eigh(curvature)
    return (vectors / np.maximum(values, _WIDEST**-2)) @ vectors.T


def newton_step(posterior: Posterior, top: Refined, gradient: DoubleArray) -> DoubleArray:
    """The motion of the pose, shape (6,), that leads to where a gradient would vanish, with the plane where it is.

    Args:
        posterior: whose curvature at the top is taken.
        top: of it.
        gradient: by the motion, of the log-likelihood of its points, shape (6,).
    """
    return _inverse(_Around(posterior, top).curvature()[:6, :6]) @ gradient


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
    """`likelihood_after`, the mean over the points, for many steps (n, 9): `values` (n,) and `gradients` (n, 9)."""
    for i in range(len(steps)):
        values[i] = likelihood_after(
            points, ball, density, model, numbers, T, normal, tangents, offset, steps[i], gradients[i]
        )
