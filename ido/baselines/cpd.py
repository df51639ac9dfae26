"""CPD, rigid and without scale (Myronenko & Song 2010), and BCPD, its rigid special case (Hirose 2021)."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ido import poses
from ido.baselines.baseline import Baseline, Record
from ido.baselines.gaussian import (
    GaussianSums,
    Normalisation,
    best_pose,
    gaussian_sums,
    mean_distance2,
    normalised,
    soft_share,
)
from ido.registration import StopReason
from ido.types import DoubleArray

_SMALLEST_SIGMA2 = 1e-10  # normalised units; the clouds coincide


@dataclass(frozen=True, kw_only=True)
class _DriftingMixture(Baseline):
    """EM: the model points are the centres of a Gaussian mixture that the scene points are drawn from.

    E: P_ab = g_ab / (Σ_a g_ab + c), g = exp(-|m_a - T s_b|² / 2σ²), c standing for outliers.
    M: T minimises Σ P |m_a - T s_b|², and σ² = Σ P |m_a - T s_b|² / (3 Σ P).

    Args:
        normalisation: ``each`` cloud to zero mean and unit mean square, or both ``together`` by the model's figures.
        start: the first σ² is the mean squared distance of all pairs / 3, times this squared (γ of BCPD).
        tolerance: when to stop; see the method.
    """

    normalisation: Normalisation = "each"
    start: float = 1.0
    tolerance: float = 1e-5

    def run(self, model: DoubleArray, scene: DoubleArray, record: Record) -> StopReason:
        units = normalised(model, scene, self.normalisation)
        sigma2 = self.start**2 * mean_distance2(units.scene, units.model) / 3
        moved, previous = units.scene, np.nan
        for iteration in range(self.max_iterations):
            sums = gaussian_sums(moved, units.model, sigma2)
            density = self.outlier_density(units.model, units.scene, sigma2)
            share = soft_share(sums, sigma2, density)
            if share.sum() < 1e-6:  # everything is an outlier
                return StopReason.NOTHING_NEAR
            before = moved
            T = best_pose(units.scene, before + sums.target, share)
            moved = poses.transform(T, units.scene)
            record(units.pose(T))
            spread = _spread(sums, share, moved - before)
            now = self.criterion(sums, sigma2, spread, density)
            if spread < _SMALLEST_SIGMA2 or self.settled(iteration, previous, now):
                return StopReason.CONVERGED
            previous, sigma2 = now, spread
        return StopReason.MAX_ITERATIONS

    @abstractmethod
    def outlier_density(self, model: DoubleArray, scene: DoubleArray, sigma2: float) -> float:
        """c, beside Gaussians of height 1."""

    @abstractmethod
    def criterion(self, sums: GaussianSums, sigma2: float, spread: float, density: float) -> float:
        """What must settle; σ² is what the sums were taken with, `spread` the next one."""

    @abstractmethod
    def settled(self, iteration: int, before: float, now: float) -> bool:
        """Whether to stop."""


def _spread(sums: GaussianSums, share: DoubleArray, motion: DoubleArray) -> float:
    """σ² of scene points that were moved on by `motion` (S, 3) since the sums were taken."""
    share_of_weight = share / sums.weight
    distance2 = sums.distance2 - 2 * (motion * sums.offset).sum(axis=1) + (motion**2).sum(axis=1) * sums.weight
    return max(float((share_of_weight * distance2).sum() / (3 * share.sum())), 0.0)


@dataclass(frozen=True, kw_only=True)
class CPD(_DriftingMixture):
    """Coherent Point Drift. Stops when the likelihood changes by less than a share `tolerance`.

    docs/method.md, Eq. 22.

    Args:
        outliers: w, the weight of the uniform distribution that outliers come from; its density depends on the units.
    """

    title: ClassVar[str] = "CPD"
    outliers: float = 0.1

    def outlier_density(self, model: DoubleArray, scene: DoubleArray, sigma2: float) -> float:
        odds = self.outliers / (1 - self.outliers)
        return (2 * np.pi * sigma2) ** 1.5 * odds * len(model) / len(scene)

    def criterion(self, sums: GaussianSums, sigma2: float, spread: float, density: float) -> float:
        inliers = np.log(sums.weight) - sums.nearest2 / (2 * sigma2)
        mixture = np.logaddexp(inliers, np.log(density)) if density > 0 else inliers
        return float(-mixture.sum() + 1.5 * len(mixture) * np.log(sigma2))

    def settled(self, iteration: int, before: float, now: float) -> bool:
        return abs(now - before) <= self.tolerance * abs(now)


@dataclass(frozen=True, kw_only=True)
class BCPD(_DriftingMixture):
    """Bayesian Coherent Point Drift without deformation (v = 0) and scale (s = 1), mixing weights fixed (κ = ∞).

    What then differs from CPD is the outliers' density, 1/V over the scene's bounding box, the first σ² and when it
    stops: once σ changes by less than `tolerance`, after 30 iterations at the earliest. docs/method.md, Eq. 22 and 23.

    Args:
        outliers: ω, the probability of an outlier.
    """

    title: ClassVar[str] = "BCPD"
    max_iterations: int = 500
    normalisation: Normalisation = "together"
    tolerance: float = 1e-4
    outliers: float = 0.0

    def outlier_density(self, model: DoubleArray, scene: DoubleArray, sigma2: float) -> float:
        volume = float(np.ptp(scene, axis=0).prod())
        odds = self.outliers / (1 - self.outliers)
        return (2 * np.pi * sigma2) ** 1.5 * odds * len(model) / max(volume, 1e-12)

    def criterion(self, sums: GaussianSums, sigma2: float, spread: float, density: float) -> float:
        return float(np.sqrt(spread))

    def settled(self, iteration: int, before: float, now: float) -> bool:
        return iteration >= _EARLIEST and abs(now - before) < self.tolerance


_EARLIEST = 30
