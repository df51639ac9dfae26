"""Why a step was made: an update is a sum over the bins, Δx = -Σ_j D[:, j] h_j, so every bin has a share in it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ido.histograms import Histogram
from ido.types import DoubleArray, FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Attribution:
    """What each bin of a histogram adds to an update of x = [ρ, φ].

    Args:
        of_bins: shape (6, n_bins); column j is -D[:, j] h_j, or -D[:, j] (h_j - reference_j).
        histogram: the feature, with its blocks and its model.
    """

    of_bins: DoubleArray
    histogram: Histogram

    @classmethod
    def of(cls, D: FloatArray, histogram: Histogram, h: FloatArray, *, against_reference: bool = False) -> Attribution:
        """The shares in the update that map D (6, n_bins) makes of a histogram h (n_bins,) (docs/method.md, Eq. 19).

        Against the reference, the shares are those of what differs from the model's own histogram. They add up to the
        update less the one that the map would make at the reference, which training drives towards zero.
        """
        seen = np.asarray(h, dtype=np.float64)
        if against_reference:
            seen = seen - histogram.reference
        return cls(-np.asarray(D, dtype=np.float64) * seen, histogram)

    @property
    def update(self) -> DoubleArray:
        """The sum over all bins: Δx, shape (6,)."""
        return self.of_bins.sum(axis=1)

    @property
    def of_points(self) -> DoubleArray:
        """The sum over the bins of each model point, shape (6, M)."""
        return self.of_bins.reshape(6, -1, len(self.histogram.model.points)).sum(axis=1)

    @property
    def of_blocks(self) -> DoubleArray:
        """The sum over the bins of each block, shape (6, blocks)."""
        return self.of_bins.reshape(6, len(self.histogram.blocks), -1).sum(axis=2)

    def along(self, direction: FloatArray | None = None) -> DoubleArray:
        """What each bin adds along a direction u of x (6,), uᵀcⱼ / ‖u‖, by default the update's own; shape (n_bins,).

        The cⱼ are those of docs/method.md, Eq. 19.
        Along the update's own direction, the values add up to its length ‖Δx‖.
        """
        direction = self.update if direction is None else np.asarray(direction, dtype=np.float64)
        size = float(np.linalg.norm(direction))
        return self.of_bins.T @ (direction / size) if size > 0 else np.zeros(self.of_bins.shape[1])


def strongest(values: FloatArray, count: int) -> np.ndarray:
    """Places of the largest absolute values, the largest first; shape (count,) or fewer."""
    order = np.argsort(-np.abs(values), kind="stable")
    return order[:count]


def bin_name(histogram: Histogram, number: int) -> tuple[str, int]:
    """The side that a bin belongs to, as ``front``, and the number of its model point."""
    side, point = divmod(int(number), len(histogram.model.points))
    return histogram.side_names[side], point
