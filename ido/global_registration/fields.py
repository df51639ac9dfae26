"""The density of a cloud, smoothed by Gaussians of several widths, on grids (docs/global.md, "Fields")."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy  # a part of it is loaded when it is used: the program starts sooner

from ido.compiling import compiled
from ido.types import FloatArray

SIGMAS = (0.03, 0.045, 0.065, 0.1)
"""Standard deviations of the Gaussians, narrowest first (model units). The best one of them tells the noise."""

REACH = 1.35
"""The grids reach from -REACH to REACH; a normalised cloud and its Gaussians hardly pass it (model units)."""

_STEPS_A_SIGMA = 1.5


@dataclass(frozen=True, slots=True, eq=False)
class Field:
    """The density p_σ of a cloud: of one of its points and Gaussian noise of deviation σ (docs/global.md, Eq. 1).

    Args:
        sigma: σ, model units.
        step: of the grid, model units.
        density: at the grid's corners, shape (n, n, n), float32; per cubic model unit.
        n_points: of the cloud.
    """

    sigma: float
    step: float
    density: FloatArray
    n_points: int

    @classmethod
    def of(cls, points: FloatArray, sigma: float) -> Field:
        """The field of points (N, 3) within ±1."""
        step = sigma / _STEPS_A_SIGMA
        n = int(np.ceil(2 * REACH / step)) + 1
        counts = np.zeros((n, n, n), dtype=np.float32)
        deposit(np.ascontiguousarray(points, dtype=np.float32), np.ones(len(points), np.float32), REACH, step, counts)
        # spreading the points over the corners and reading between corners widen by step² / 6 each
        width = np.sqrt(sigma**2 - step**2 / 3) / step
        density = scipy.ndimage.gaussian_filter(counts, width, mode="constant", truncate=5)
        return cls(sigma, step, density / np.float32(len(points) * step**3), len(points))

    def __call__(self, points: FloatArray) -> FloatArray:
        """The density at points (S, 3), shape (S,); 0 beyond the grid."""
        out = np.empty(len(points), dtype=np.float32)
        read(np.ascontiguousarray(points, dtype=np.float32), self.density, REACH, self.step, out)
        return out

    def of_the_others(self, points: FloatArray) -> FloatArray:
        """The density at points (S, 3) of the cloud itself, each time without that point, shape (S,), float64.

        So much a fresh sample of the same surface would find there. In a sparse cloud a point's own part is most of it.
        """
        own = 1 / (2 * np.pi * self.sigma**2) ** 1.5  # of one point, in its place
        n = self.n_points
        return np.maximum(self(points) * n - own, 0.0) / max(n - 1, 1)


@compiled(error_model="numpy")
def deposit(points: FloatArray, weights: FloatArray, reach: float, step: float, out: FloatArray) -> None:
    """Add each point's weight to the 8 corners around it, the nearer the more; points beyond ±reach are left out."""
    n = out.shape[0]
    for s in range(len(points)):
        x, y, z = (points[s, 0] + reach) / step, (points[s, 1] + reach) / step, (points[s, 2] + reach) / step
        i, j, k = int(np.floor(x)), int(np.floor(y)), int(np.floor(z))
        if i < 0 or j < 0 or k < 0 or i >= n - 1 or j >= n - 1 or k >= n - 1:
            continue
        x, y, z = x - i, y - j, z - k
        for a in range(2):
            for b in range(2):
                for c in range(2):
                    near = (x if a else 1 - x) * (y if b else 1 - y) * (z if c else 1 - z)
                    out[i + a, j + b, k + c] += weights[s] * near


@compiled(error_model="numpy")
def read(points: FloatArray, values: FloatArray, reach: float, step: float, out: FloatArray) -> None:
    """Values between the corners of a grid, at points (S, 3); 0 beyond ±reach."""
    n = values.shape[0]
    for s in range(len(points)):
        x, y, z = (points[s, 0] + reach) / step, (points[s, 1] + reach) / step, (points[s, 2] + reach) / step
        out[s] = 0.0
        if not (0 <= x < n - 1 and 0 <= y < n - 1 and 0 <= z < n - 1):
            continue
        i, j, k = int(x), int(y), int(z)
        x, y, z = x - i, y - j, z - k
        for a in range(2):
            for b in range(2):
                for c in range(2):
                    near = (x if a else 1 - x) * (y if b else 1 - y) * (z if c else 1 - z)
                    out[s] += near * values[i + a, j + b, k + c]
