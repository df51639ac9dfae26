"""The order in which the bins of a histogram are drawn."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from ido.blocks import azimuth, elevation
from ido.histograms import Histogram
from ido.types import FloatArray


def bin_order(histogram: Histogram, order: str, contribution: FloatArray | None = None) -> np.ndarray:
    """Numbers of the bins from left to right, shape (n_bins,): sides stay together, each ordered within.

    By elevation, azimuth and model index, both sides of a block are in the same order of model points. By contribution
    they run from the smallest to the largest value of `contribution` (n_bins,); without it, by model index.
    """
    if order == "contribution" and contribution is not None:
        return _by_value(contribution, len(histogram.model.points))
    return _lasting_order(histogram, order)


@lru_cache(maxsize=64)  # a page asks for it with each frame
def _lasting_order(histogram: Histogram, order: str) -> np.ndarray:
    """An order that a histogram always has; not to be written to."""
    model = histogram.model.points.astype(np.float64)
    n_model = len(model)
    if order == "reference value":
        numbers = _by_value(histogram.reference, n_model)
    else:
        index = np.arange(n_model)
        keys = {"model index": index, "contribution": index, "elevation": elevation(model), "azimuth": azimuth(model)}
        numbers = _side_by_side(np.argsort(keys[order], kind="stable")[None], histogram.n_bins // n_model)
    numbers.flags.writeable = False
    return numbers


def _by_value(values: FloatArray, n_model: int) -> np.ndarray:
    within = np.argsort(values.reshape(-1, n_model), axis=1, kind="stable")
    return _side_by_side(within, len(within))


def _side_by_side(within: np.ndarray, n_sides: int) -> np.ndarray:
    """Orders of the model points, (n_sides, M) or one for all (1, M), as numbers of the bins."""
    return (within + within.shape[1] * np.arange(n_sides)[:, None]).reshape(-1)
