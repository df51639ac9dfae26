"""The order in which the bins of a histogram are drawn."""

from __future__ import annotations

import numpy as np

from ido.blocks import azimuth, elevation
from ido.histograms import Histogram
from ido.types import FloatArray


def bin_order(histogram: Histogram, order: str, contribution: FloatArray | None = None) -> np.ndarray:
    """Numbers of the bins from left to right, shape (n_bins,): sides stay together, each ordered within.

    By elevation, azimuth and model index, both sides of a block are in the same order of model points. By contribution
    they run from the smallest to the largest value of `contribution` (n_bins,); without it, by model index.
    """
    model = histogram.model.points.astype(np.float64)
    n_model = len(model)
    n_sides = histogram.n_bins // n_model
    by_bin = histogram.reference if order == "reference value" else contribution if order == "contribution" else None
    if by_bin is not None:
        within = np.argsort(by_bin.reshape(n_sides, n_model), axis=1, kind="stable")
    else:
        index = np.arange(n_model)
        keys = {"model index": index, "contribution": index, "elevation": elevation(model), "azimuth": azimuth(model)}
        within = np.tile(np.argsort(keys[order], kind="stable"), (n_sides, 1))
    return (within + n_model * np.arange(n_sides)[:, None]).reshape(-1)
