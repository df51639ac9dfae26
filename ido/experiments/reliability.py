"""How well stated probabilities agree with what turned out to be right."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ido.results import Results
from ido.types import DoubleArray, FloatArray, IntArray

RIGHT = 0.9
"""A pose of at least this PointAcc is right."""

SURE, DOUBTED = 0.95, 0.5
"""An answer of at least the first probability is sure, one below the second is doubted."""

EDGES = np.linspace(0, 1, 11)
"""Of the bins that probabilities are counted in."""


@dataclass(frozen=True, slots=True, eq=False)
class Reliability:
    """Probabilities in ten bins of equal width, against the share that was right in each.

    Args:
        counts: registrations in each bin, shape (10,).
        told: mean probability in each bin, shape (10,); NaN where it is empty.
        right: share of right poses in each bin, shape (10,); NaN where it is empty.
        sure: how many were sure, and how many of them were right.
        failures: how many were wrong, and how many of them were doubted.
    """

    counts: IntArray
    told: DoubleArray
    right: DoubleArray
    sure: tuple[int, int]
    failures: tuple[int, int]

    @classmethod
    def of(cls, probability: FloatArray, is_right: np.ndarray) -> Reliability:
        """Of n registrations: their probabilities (n,) and whether they were right (n,)."""
        place = np.clip(np.digitize(probability, EDGES) - 1, 0, len(EDGES) - 2)
        counts = np.bincount(place, minlength=len(EDGES) - 1)
        with np.errstate(invalid="ignore"):
            told, right = (np.bincount(place, values, len(counts)) / counts for values in (probability, is_right))
        sure, wrong = probability >= SURE, ~is_right
        return cls(
            counts,
            told,
            right,
            (int(sure.sum()), int((sure & is_right).sum())),
            (int(wrong.sum()), int((wrong & (probability < DOUBTED)).sum())),
        )

    @classmethod
    def of_results(cls, results: Results) -> Reliability | None:
        """Of the registrations that have a probability; None if there are none."""
        has = np.isfinite(results.probability)
        return cls.of(results.probability[has], results.accuracy[has] >= RIGHT) if has.any() else None

    @property
    def total(self) -> int:
        """The number of registrations."""
        return int(self.counts.sum())

    @property
    def share_right(self) -> float:
        """The share of all that was right."""
        return float(np.nansum(self.counts * self.right) / self.total)

    @property
    def error(self) -> float:
        """The expected calibration error: the mean distance of a bin's probability from its share that was right."""
        return float(np.nansum(self.counts * np.abs(self.told - self.right)) / self.total)


def wilson(share: FloatArray, count: FloatArray | IntArray) -> tuple[FloatArray, FloatArray]:
    """The 95% interval of shares of so many (Wilson 1927): its lower and upper ends."""
    z2 = 1.96**2
    middle = (share + z2 / (2 * count)) / (1 + z2 / count)
    half = np.sqrt(share * (1 - share) / count + z2 / (4 * count**2)) * 1.96 / (1 + z2 / count)
    return middle - half, middle + half
