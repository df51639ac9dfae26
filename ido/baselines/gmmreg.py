"""GMMReg, rigid (Jian & Vemuri 2011): the L2 distance of two Gaussian mixtures, minimised by its gradient."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import scipy  # a part of it is loaded when it is used: the program starts sooner
from scipy.spatial.transform import Rotation

from ido import poses
from ido.baselines.baseline import Baseline, Record
from ido.baselines.gaussian import Normalisation, gaussian_sums, normalised
from ido.kernels import left_jacobian
from ido.registration import StopReason
from ido.types import DoubleArray, FloatArray


@dataclass(frozen=True, kw_only=True)
class GMMReg(Baseline):
    """Every point is a Gaussian of width σ. The mixtures' own norms do not change as the scene moves, so minimising
    the L2 distance maximises f = (1/MS) Σ exp(-|m_a - T s_b|² / σ²), by L-BFGS, from coarse σ to fine.
    docs/method.md, Eq. 24.

    Args:
        normalisation: ``each`` cloud to zero mean and unit mean square, which makes the search one for a similarity
            whose scale is then dropped, or both ``together`` by the model's figures.
        sigmas: σ of each level, in normalised units.
        evaluations: limit of the evaluations at each level.
    """

    title: ClassVar[str] = "GMMReg"
    max_iterations: int = 1000
    normalisation: Normalisation = "each"
    sigmas: tuple[float, ...] = (0.5, 0.1)
    evaluations: tuple[int, ...] = (10, 100)

    def run(self, model: DoubleArray, scene: DoubleArray, record: Record) -> StopReason:
        units = normalised(model, scene, self.normalisation)
        parameters, done, stop = np.zeros(6), 0, StopReason.CONVERGED

        def take(parameters: FloatArray) -> None:
            nonlocal done
            if done == self.max_iterations:
                raise StopIteration
            done += 1
            record(units.pose(pose_of_parameters(parameters)))

        for sigma, evaluations in zip(self.sigmas, self.evaluations, strict=True):
            found = scipy.optimize.minimize(
                correlation_cost,
                parameters,
                args=(units.model, units.scene, sigma),
                jac=True,
                method="L-BFGS-B",
                callback=take,
                options={"maxfun": evaluations, "ftol": 1e-7, "gtol": 1e-6},
            )
            parameters = found.x
            # 1: limit of the evaluations; any other end is at a place from which no step leads up
            stop = StopReason.MAX_ITERATIONS if found.status == 1 else StopReason.CONVERGED
            if done == self.max_iterations:
                return StopReason.MAX_ITERATIONS
        return stop


def pose_of_parameters(parameters: FloatArray) -> DoubleArray:
    """The pose (4, 4) of a translation and a rotation vector, (6,)."""
    T = np.eye(4)
    T[:3, :3] = Rotation.from_rotvec(parameters[3:]).as_matrix()
    T[:3, 3] = parameters[:3]
    return T


def correlation_cost(
    parameters: FloatArray, model: FloatArray, scene: FloatArray, sigma: float
) -> tuple[float, DoubleArray]:
    """-f and its gradient with respect to translation and rotation vector (docs/method.md, Eq. 24).

    The gradient with respect to a moved point is g_b = -(2/σ²) (1/MS) Σ_a w_ab (m_a - T s_b). A small change δ of the
    rotation vector φ turns the scene by J_l(φ) δ, J_l being the left Jacobian of SO(3).
    """
    T = pose_of_parameters(parameters)
    moved = poses.transform(T, scene)
    sums = gaussian_sums(moved, model, sigma**2 / 2)
    scale = np.exp(-sums.nearest2 / sigma**2) / (len(model) * len(scene))
    gradient = -2 / sigma**2 * scale[:, None] * sums.offset
    torque = np.cross(moved - T[:3, 3], gradient).sum(axis=0)
    return -float(scale @ sums.weight), np.concatenate([gradient.sum(axis=0), left_jacobian(parameters[3:]).T @ torque])
