"""How sure a global registration is: a probability that its pose is right, and why it may not be."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache

import numpy as np

from ido.global_registration.evidence import EQUAL, Evidence
from ido.global_registration.global_result import GlobalResult
from ido.shipped import asset
from ido.types import DoubleArray

POOR_FIT = 0.25
"""A fit whose deficit is greater is one of another shape, size or surface."""

FEW, LITTLE, LOOSE = 40.0, 0.25, 0.1
"""Fewer explained points, a smaller covered share, a greater expected error (model units) are reasons for doubt."""

SURE = 0.5
"""Reasons are given for probabilities below."""


@dataclass(frozen=True, slots=True, eq=False)
class Confidence:
    """How sure one can be of a pose without knowing the truth.

    Args:
        probability: that at least 90% of the scene's true points lie within 0.1 of their places (PointAcc ≥ 0.9).
        evidence: what it follows from, with the pose's covariance.
        equals: other poses that fit equally, T_model_scene, shape (n, 4, 4).
        reasons: why it may be wrong; empty where nothing speaks against it.
    """

    probability: float
    evidence: Evidence
    equals: DoubleArray
    reasons: tuple[str, ...]

    @classmethod
    def of(cls, result: GlobalResult) -> Confidence:
        """The confidence in the chosen pose of a registration."""
        evidence, n = result.evidence, len(result.candidates[0].posterior.points)
        others = [
            other.refined.T @ result.centring
            for other in result.candidates[1:]
            if n * (result.best.log_likelihood - other.refined.log_likelihood) < EQUAL
        ]
        equals = np.stack(others) if others else np.empty((0, 4, 4))
        chance = probability(evidence, coefficients())
        return cls(chance, evidence, equals, tuple(_reasons(evidence, len(equals), chance)))


def features(evidence: Evidence) -> dict[str, float]:
    """The numbers that the probability is a logistic function of, each of moderate size."""
    margin = float(np.log1p(min(max(evidence.margin, 0.0), 500.0)))
    return {
        "log_margin": margin,
        "log_margin_squared": margin**2,
        "log_explained": float(np.log1p(evidence.explained)),
        "covered": evidence.covered,
        "seen": evidence.seen,
        "log_sigma": float(np.log(evidence.sigma)),
    }


def probability(evidence: Evidence, weights: Mapping[str, float]) -> float:
    """How probable a pose is: that a fit like it is right, times its weight among those that fit as well.

    The first is the logistic function of the features' weighted sum and the weight called ``intercept``.
    """
    total = weights["intercept"] + sum(weights[name] * value for name, value in features(evidence).items())
    return float(evidence.weight / (1 + np.exp(-np.clip(total, -30, 30))))


@cache
def coefficients() -> dict[str, float]:
    """The weights that `assets/scripts/make_confidence.py` found."""
    return tomllib.loads(asset("confidence.toml").read_text(encoding="utf-8"))["coefficients"]


def _reasons(evidence: Evidence, n_equal: int, chance: float) -> list[str]:
    found = []
    firm = evidence.explained >= FEW and evidence.covered >= LITTLE
    if n_equal:
        found.append(f"{'symmetric: ' if firm else ''}{n_equal + 1} poses fit equally")
    if evidence.deficit > POOR_FIT:
        found.append("what lies on the model is not shaped like it; is it another shape, or another size?")
    if evidence.explained < FEW:
        found.append(f"nothing of it fits: the model explains only {evidence.explained:.0f} points")
    elif evidence.covered < LITTLE:
        found.append(f"little to go by: points lie near only {evidence.covered:.0%} of the model")
    if evidence.error > LOOSE:
        found.append(f"the points leave the pose loose: it can be off by {evidence.error:.2g} of the model's half-size")
    if chance < SURE and not found:
        found.append("another pose fits nearly as well" if evidence.margin < 3 * EQUAL else "it fits only weakly")
    return found
