"""What can be known of a pose without the truth: what it explains, how far it leads, and how firmly it stands."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial import KDTree

from ido.global_registration.cut_plane import Posterior, Refined
from ido.poses import transform
from ido.types import DoubleArray

NEAR = 0.1
"""A part of the model is covered when an explained point lies within this distance of it (model units)."""

EQUAL = 5.0
"""Poses whose log-likelihoods differ by less fit equally. Equal poses of a symmetric shape, whose fields are made of
different samples, differ by a few."""

_TEMPER = 3.0  # how soon poses that fit worse than equally count less, log-likelihood


@dataclass(frozen=True, slots=True, eq=False)
class Evidence:
    """Figures of a pose, all without units of the scene's size.

    Args:
        explained: how many points of the scene the model explains, repeated ones counted once.
        share: of the points that it explains.
        deficit: by how much the explained points' mean log-density is lower than that of other points of the model.
        margin: log-likelihood of all points, repeated ones counted once, over that of the second-best pose; inf when
            there is no second.
        weight: of the pose among all that it was chosen from, by their likelihoods; those that fit equally share it.
        covered: share of the model, of what the plane keeps, that has an explained point near.
        seen: share of the model that the plane keeps.
        sigma: width of the field that fits best (model units).
        error: expected error of a point of the model (root mean square, model units).
        covariance: of the pose: shift (model units) and turn (rad) in the model's frame, shape (6, 6).
    """

    explained: float
    share: float
    deficit: float
    margin: float
    weight: float
    covered: float
    seen: float
    sigma: float
    error: float
    covariance: DoubleArray

    @classmethod
    def of(cls, posterior: Posterior, best: Refined, others: Sequence[Refined], covariance: DoubleArray) -> Evidence:
        """The evidence for a pose.

        Args:
            posterior: of the scene that it was found for.
            best: the pose and its plane.
            others: those that it was chosen over, none alike, the likeliest first.
            covariance: of the pose, shape (6, 6).
        """
        points, model = posterior.points, posterior.model
        n = posterior.n_different
        margins = [n * (best.log_likelihood - other.log_likelihood) for other in others]
        moved = transform(best.T, points)
        density = posterior.field(moved).astype(np.float64)
        member = posterior.explained(best.T) * (moved @ best.normal < best.offset)
        share = float(member.mean())
        at_home = float(np.log(posterior.field.of_the_others(model) + 1e-9).mean())
        at_home -= 0.5  # points that are noisy lie a little beside the densest places
        reached = float((member * np.log(density + 1e-9)).mean() / max(share, 1e-9))
        kept = model[model @ best.normal < best.offset]
        near = moved[member > 0.5]
        covered = float((KDTree(near).query(kept)[0] < NEAR).mean()) if len(near) and len(kept) else 0.0
        return cls(
            explained=share * n,
            share=share,
            deficit=at_home - reached,
            margin=min(margins, default=np.inf),
            weight=float(1 / (1 + sum(np.exp(-max(margin - EQUAL, 0.0) / _TEMPER) for margin in margins))),
            covered=covered,
            seen=len(kept) / len(model),
            sigma=best.sigma,
            error=_error(covariance, model.astype(np.float64)),
            covariance=covariance,
        )


def _error(covariance: DoubleArray, model: DoubleArray) -> float:
    """Root mean square over the model's points of the deviation that a pose's covariance gives them."""
    x, y, z = model.T
    zero, one = np.zeros(len(model)), np.ones(len(model))
    motion = np.array(
        [[one, zero, zero, zero, z, -y], [zero, one, zero, -z, zero, x], [zero, zero, one, y, -x, zero]]
    )  # of a point by shift and turn, (3, 6, M)
    return float(np.sqrt(np.einsum("aim,ij,ajm->m", motion, covariance, motion).mean()))
