"""Checks of the lessons on how the methods see a scene."""

from __future__ import annotations

import numpy as np

from checks.helpers import (
    BOTH,
    LEFT,
    RIGHT,
    Check,
    both_in_place,
    from_line,
    in_its_place,
    page_of,
    rotation_error,
)
from ido.blocks import SIGMA2, azimuth, elevation
from ido.types import BoolArray, DoubleArray
from ido_viz.core.run import Run


def _off_line(run: Run, iteration: int) -> float:
    """How far the left side's dots are from the line after so many iterations."""
    return float(from_line(run.sides[LEFT], run.histogram(LEFT, iteration))[0])


def _off_line_in_place(run: Run) -> float:
    return float(from_line(run.sides[LEFT], in_its_place(run, LEFT))[0])


TAIL = page_of("histogram/in-front").inspected
"""Number of a model point on the bunny's tail."""

_IN_FRONT, _BEHIND, _FAR = (
    page_of(f"histogram/{claim}").scene_point for claim in ("in-front", "behind", "nothing-from-the-ears")
)
"""Scene points: two near the tail, and one at the ears."""


def _of_tail(run: Run) -> tuple[BoolArray, DoubleArray]:
    """Which scene points lie in front of the tail's point at the start, and what each of them weighs."""
    model = run.sides[LEFT].histogram.model
    offset = run.scene.points.astype(np.float64) - model.points[TAIL]
    return offset @ model.normals[TAIL] > 0, np.exp(-(offset**2).sum(axis=1) / SIGMA2)


def _weight(run: Run, scene_point: int) -> float:
    return float(_of_tail(run)[1][scene_point])


def _share_of_bin(run: Run, scene_point: int) -> float:
    """Share of a scene point in what its side of the tail's point adds up to."""
    front, weight = _of_tail(run)
    return float(weight[scene_point] / weight[front == front[scene_point]].sum())


EAR = page_of("binaries/few-points-count").inspected
"""Number of the model point at the tip of the bunny's ear."""


def _counts_near(run: Run, least: float) -> float:
    """Share of the scene points that count at least so much, of 1, for the ear's front and back."""
    ear = run.sides[RIGHT].histogram.model.points[EAR]
    return float((np.exp(-((run.scene.points - ear) ** 2).sum(axis=1) / SIGMA2) >= least).mean())


def _above(run: Run) -> BoolArray:
    ear = run.sides[RIGHT].histogram.model.points[[EAR]]
    return elevation(run.scene.points) > elevation(ear)


def _clockwise(run: Run) -> BoolArray:
    ear = run.sides[RIGHT].histogram.model.points[[EAR]]
    return azimuth(run.scene.points) > azimuth(ear)


def _pair_sums_are_equal(run: Run) -> bool:
    """Whether the two bins of every model point add up to the same, in both blocks of angles, at the start."""
    n_model = len(run.sides[RIGHT].histogram.model.points)
    pairs = run.histogram(RIGHT, 0).reshape(3, 2, n_model)[1:].sum(axis=1)
    return bool(np.allclose(pairs, pairs[:, :1], rtol=1e-4))


CHECKS: dict[str, Check] = {
    "histogram/in-front": lambda run: bool(_of_tail(run)[0][_IN_FRONT]),
    "histogram/weight-of-one-point": lambda run: f"{_weight(run, _IN_FRONT):.2f}" == "0.59",
    "histogram/behind": lambda run: not _of_tail(run)[0][_BEHIND],
    "histogram/adds-little": lambda run: f"{_weight(run, _BEHIND):.2f}" == "0.04",
    "histogram/a-thirtieth-of-the-bin": lambda run: 1 / 33 < _share_of_bin(run, _BEHIND) < 1 / 30,
    "histogram/nothing-from-the-ears": lambda run: _weight(run, _FAR) < 1e-6,
    "histogram/fifteen-weigh-something": lambda run: (
        len(run.scene.points) == 400 and int((_of_tail(run)[1] > 0.01).sum()) == 15
    ),
    "histogram/dots-gather-along-the-line": lambda run: _off_line(run, 0) < 0.45,
    "histogram/dots-do-not-lie-on-it": lambda run: _off_line(run, 0) > 0.1,
    "histogram/dots-leave-the-line": lambda run: _off_line(run, 0) > 2 * _off_line_in_place(run),
    "histogram/five-iterations-undo-most": lambda run: all(rotation_error(run, side, 5) < 6 for side in BOTH),
    "histogram/both-in-place": both_in_place,
    "histogram/dots-come-back": lambda run: _off_line(run, run.iterations) < 0.5 * _off_line(run, 0),
    "binaries/few-points-count": lambda run: _counts_near(run, 0.01) < 0.05,
    "binaries/most-are-above-the-ear": lambda run: float(_above(run).mean()) > 0.6,
    "binaries/less-than-half-clockwise": lambda run: float(_clockwise(run).mean()) < 0.45,
    "binaries/pairs-add-up-alike": _pair_sums_are_equal,
}
