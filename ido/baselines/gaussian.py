"""What CPD, BCPD, GMMReg and KCCE share: sums of Gaussians between two clouds, and the pose they lead to."""

from __future__ import annotations

from typing import Any, Literal, NamedTuple

import numpy as np

from ido.compiling import compiled
from ido.types import DoubleArray, FloatArray

Normalisation = Literal["each", "together"]

# 2^f on [-1/2, 1/2], least relative error at Chebyshev nodes: 3e-6
_nodes = np.cos(np.linspace(0.0, np.pi, 400)) / 2
_E4, _E3, _E2, _E1, _E0 = (np.float32(c) for c in np.polyfit(_nodes, 2.0**_nodes, 4, w=2.0**-_nodes))
_ZERO, _HALF, _SMALLEST_EXPONENT = np.float32(0), np.float32(0.5), np.float32(-126)
_MANTISSA_BITS = np.int32(23)


class GaussianSums(NamedTuple):
    """Sums over the model points a of w_ab = exp(-(d²_ab - d²_b) / (2σ²)), d_b = min_a d_ab, for each scene point b.

    Leaving out the nearest distance keeps the weights from vanishing when σ is small.
    """

    nearest2: DoubleArray  # (S,), d²_b
    weight: DoubleArray  # (S,), Σ w
    offset: DoubleArray  # (S, 3), Σ w (m_a - s_b)
    distance2: DoubleArray  # (S,), Σ w d²_ab

    @property
    def target(self) -> DoubleArray:
        """Where each scene point is drawn to: the weighted mean of the model points, less the point; shape (S, 3)."""
        return self.offset / self.weight[:, None]


def gaussian_sums(moved: FloatArray, model: FloatArray, sigma2: float) -> GaussianSums:
    """The sums between moved scene points (S, 3) and model points (M, 3); `reference_sums` defines them."""
    rows = np.empty((len(moved), 6))
    columns = np.ascontiguousarray(np.asarray(model, dtype=np.float32).T)
    _sums(np.ascontiguousarray(moved, dtype=np.float64), columns, np.float32(np.log2(np.e) / (2 * sigma2)), rows)
    return GaussianSums(rows[:, 0], rows[:, 1], rows[:, 2:5], rows[:, 5])


def reference_sums(moved: FloatArray, model: FloatArray, sigma2: float) -> GaussianSums:
    """The same in plain NumPy."""
    offset = np.asarray(model, dtype=np.float64)[None] - np.asarray(moved, dtype=np.float64)[:, None]
    distance2 = (offset**2).sum(axis=-1)
    nearest2 = distance2.min(axis=1)
    weight = np.exp((nearest2[:, None] - distance2) / (2 * sigma2))
    return GaussianSums(
        nearest2, weight.sum(axis=1), (weight[..., None] * offset).sum(axis=1), (weight * distance2).sum(axis=1)
    )


@compiled(fastmath=True, error_model="numpy")
def _sums(moved: FloatArray, model: FloatArray, rate: Any, out: FloatArray) -> None:
    """`model` is (3, M) float32, weights are 2^(rate (d²_b - d²)); `out` is (S, 6)."""
    n_model = model.shape[1]
    d2 = np.empty(n_model, np.float32)
    mx, my, mz = model[0], model[1], model[2]
    for b in range(len(moved)):
        x, y, z = np.float32(moved[b, 0]), np.float32(moved[b, 1]), np.float32(moved[b, 2])
        nearest = np.float32(1e30)
        for a in range(n_model):
            dx, dy, dz = mx[a] - x, my[a] - y, mz[a] - z
            d = dx * dx + dy * dy + dz * dz
            d2[a] = d
            nearest = min(nearest, d)
        total, ox, oy, oz, spread = _ZERO, _ZERO, _ZERO, _ZERO, _ZERO
        for a in range(n_model):
            exponent = max((nearest - d2[a]) * rate, _SMALLEST_EXPONENT)
            whole = np.int32(exponent - _HALF)
            f = exponent - np.float32(whole)
            mantissa = (((_E4 * f + _E3) * f + _E2) * f + _E1) * f + _E0
            bits = np.float32(mantissa).view(np.int32) + (whole << _MANTISSA_BITS)
            w = np.int32(bits).view(np.float32) if exponent > _SMALLEST_EXPONENT else _ZERO
            total += w
            ox += w * (mx[a] - x)
            oy += w * (my[a] - y)
            oz += w * (mz[a] - z)
            spread += w * d2[a]
        out[b, 0], out[b, 1] = nearest, total
        out[b, 2], out[b, 3], out[b, 4] = ox, oy, oz
        out[b, 5] = spread


def soft_share(sums: GaussianSums, sigma2: float, outlier_density: float) -> DoubleArray:
    """The share of each scene point that belongs to the model, Σ_a P_ab = Σ g / (Σ g + c), g = exp(-d² / 2σ²).

    docs/method.md, Eq. 22.

    Args:
        sums: of the scene at its pose.
        sigma2: σ².
        outlier_density: c, what an outlier is worth beside the Gaussians; 0 for none.
    """
    if outlier_density <= 0:
        return np.ones(len(sums.weight))
    exponent = np.log(outlier_density) + sums.nearest2 / (2 * sigma2) - np.log(sums.weight)
    return 1 / (1 + np.exp(np.minimum(exponent, 700.0)))


def mean_distance2(scene: FloatArray, model: FloatArray) -> float:
    """Mean squared distance of all pairs, (1/SM) Σ_ab |m_a - s_b|²."""
    between = ((scene.mean(axis=0) - model.mean(axis=0)) ** 2).sum()
    return float(between + scene.var(axis=0).sum() + model.var(axis=0).sum())


def best_pose(source: FloatArray, target: FloatArray, weight: FloatArray) -> DoubleArray:
    """The rigid pose T (4, 4) that minimises Σ w |T(source) - target|² (weighted Procrustes).

    It solves docs/method.md, Eq. 25, for T in closed form (Kabsch 1976: its "Sources").
    SciPy's `align_vectors` does the same but warns, from every thread, of each flat cloud.
    """
    share = weight / weight.sum()
    source_mean, target_mean = share @ source, share @ target
    U, _, Vt = np.linalg.svd((target - target_mean).T @ (share[:, None] * (source - source_mean)))
    U[:, 2] *= np.sign(np.linalg.det(U @ Vt))
    T = np.eye(4)
    T[:3, :3] = U @ Vt
    T[:3, 3] = target_mean - T[:3, :3] @ source_mean
    return T


class Normalised(NamedTuple):
    """Both clouds in the units that a method works in, and how to come back."""

    model: DoubleArray  # (M, 3)
    scene: DoubleArray  # (S, 3)
    model_centre: DoubleArray
    scene_centre: DoubleArray
    model_scale: float

    def pose(self, T: FloatArray) -> DoubleArray:
        """T_model_scene in model units of a pose between the normalised clouds.

        Where each cloud had a scale of its own, the pose is the rigid part of the similarity.
        """
        back = np.eye(4)
        back[:3, :3] = T[:3, :3]
        back[:3, 3] = self.model_centre + self.model_scale * T[:3, 3] - T[:3, :3] @ self.scene_centre
        return back


def normalised(model: FloatArray, scene: FloatArray, normalisation: Normalisation) -> Normalised:
    """Clouds of zero mean and unit mean square, each by its own figures or both by the model's."""
    model, scene = np.asarray(model, dtype=np.float64), np.asarray(scene, dtype=np.float64)
    model_centre = model.mean(axis=0)
    model_scale = float(np.sqrt(((model - model_centre) ** 2).sum(axis=1).mean()))
    scene_centre, scene_scale = model_centre, model_scale
    if normalisation == "each":
        scene_centre = scene.mean(axis=0)
        scene_scale = float(np.sqrt(((scene - scene_centre) ** 2).sum(axis=1).mean())) or 1.0
    return Normalised(
        (model - model_centre) / model_scale,
        (scene - scene_centre) / scene_scale,
        model_centre,
        scene_centre,
        model_scale,
    )
