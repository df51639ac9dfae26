"""The numbers that charts draw, on the page and in files."""

from __future__ import annotations

import numpy as np

from ido.types import DoubleArray, FloatArray
from ido_viz.core.frame import SideFrame
from ido_viz.core.run import MethodRun
from ido_viz.core.state import State

CURVES = ("PointRMSE", "PointAcc", "update norm", "histogram distance")
"""What is drawn over the iterations."""


def histogram_data(side: SideFrame, state: State) -> tuple[DoubleArray, ...]:
    """What is drawn of a histogram, each of shape (n_bins,): places, a second histogram, the blocks, the line, marks.

    Each block has an array of its own, with gaps elsewhere; all values are relative to the block's largest reference.
    The second histogram is the one that is laid over it; the marks are the bins of the inspected model point.
    """
    run, order = side.run, side.order
    reference = relative_blocks(run.histogram.reference, run)
    base = reference if state.difference else np.zeros_like(reference)
    values = (relative_blocks(side.seen, run) - base).reshape(-1)[order]
    if side.overlay is None:
        second = np.full(values.size, np.nan)
    else:
        second = (relative_blocks(side.overlay.seen, run) - base).reshape(-1)[order]
    n_model, n_blocks = len(run.histogram.model.points), len(reference)
    block_of = np.arange(values.size) * n_blocks // values.size
    separate = [np.where(block_of == b, values, np.nan) for b in range(n_blocks)]
    marked = np.where(order % n_model == side.marked, values, np.nan)
    line = (reference - base).reshape(-1)[order]
    columns = (np.arange(values.size), second, *separate, line, marked)
    return tuple(column.astype(np.float64) for column in columns)


def relative_blocks(histogram: FloatArray, side: MethodRun) -> FloatArray:
    """A histogram by blocks, each relative to the block's largest reference bin; shape (blocks, 2 M)."""
    n_blocks = len(side.histogram.blocks)
    largest = side.histogram.reference.reshape(n_blocks, -1).max(axis=1, keepdims=True)
    return histogram.reshape(n_blocks, -1) / np.where(largest > 0, largest, 1.0)


def curve(side: MethodRun, name: str) -> FloatArray:
    """One of the `CURVES` of a run over its iterations, shape (n + 1,); of the update norm, its logarithm."""
    if name == "update norm":
        return np.log10(np.maximum(side.norms, 1e-12))
    return {"PointRMSE": side.scores.rmse, "PointAcc": side.scores.accuracy, "histogram distance": side.distances}[name]


def padded(values: FloatArray, length: int) -> DoubleArray:
    """Values followed by gaps, to a length."""
    return np.concatenate([values, np.full(length - len(values), np.nan)]).astype(np.float64)
