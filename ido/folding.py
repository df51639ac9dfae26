"""Histograms without what follows from the rest of them, so that maps are learned in fewer dimensions.

Where every scene point counts 1, the two bins of each model point sum to the same number in all of a block: the size of
the scene, scaled. Turned by a rotation of its 2M bins, such a block is M differences, one sum, and M - 1 zeros. A ridge
regression does not change with a rotation, so it is solved without the zeros, and its map is turned back.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ido.histograms import BlockHistogram, Histogram
from ido.types import FloatArray

_HALF = np.float32(np.sqrt(0.5))


@dataclass(frozen=True, slots=True)
class Folding:
    """How the histograms of one kind are folded.

    Args:
        n_model: number of model points M.
        folded: whether each block is; one that is not keeps its 2M bins, one that is has M + 1 numbers.
    """

    n_model: int
    folded: tuple[bool, ...]

    @classmethod
    def of(cls, histogram: Histogram) -> Folding:
        """The folding of a histogram: of its blocks that count every point alike on both sides."""
        folded = [False] * len(histogram.blocks)
        if isinstance(histogram, BlockHistogram):
            weights = histogram.weights.reshape(len(folded), -1)
            folded = [
                question.counts_all and bool((its == 1).all())
                for question, its in zip(histogram.questions, weights, strict=True)
            ]
        return cls(len(histogram.model.points), tuple(folded))

    @property
    def n_numbers(self) -> int:
        """Of a folded histogram."""
        return sum(self.n_model + 1 if each else 2 * self.n_model for each in self.folded)

    def fold(self, h: FloatArray) -> FloatArray:
        """Histograms (B, n_bins) folded; shape (B, n_numbers), float32."""
        sides = h.reshape(len(h), len(self.folded), 2, self.n_model)
        out = np.empty((len(h), self.n_numbers), dtype=np.float32)
        at = 0
        for block, is_folded in enumerate(self.folded):
            first, second = sides[:, block, 0], sides[:, block, 1]
            out[:, at : at + self.n_model] = (first - second) * _HALF if is_folded else first
            at += self.n_model
            if is_folded:
                out[:, at] = (first[:, 0] + second[:, 0]) * np.sqrt(np.float32(self.n_model / 2))
                at += 1
            else:
                out[:, at : at + self.n_model] = second
                at += self.n_model
        return out

    def unfold(self, E: FloatArray) -> FloatArray:
        """The map D (6, n_bins), float32, that does with histograms what E (6, n_numbers) does with folded ones."""
        D = np.empty((len(E), len(self.folded), 2, self.n_model), dtype=np.float32)
        at = 0
        for block, is_folded in enumerate(self.folded):
            first = E[:, at : at + self.n_model]
            at += self.n_model
            if is_folded:
                difference, total = first * _HALF, E[:, at, None] / np.sqrt(np.float32(2 * self.n_model))
                D[:, block, 0], D[:, block, 1] = total + difference, total - difference
                at += 1
            else:
                D[:, block, 0], D[:, block, 1] = first, E[:, at : at + self.n_model]
                at += self.n_model
        return D.reshape(len(E), -1)
