"""Why a method makes its next step: the shares of its bins, and what one model point sees."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ido import FrontBack, Histogram
from ido.attribution import Attribution, strongest
from ido.histograms import SIGMA2, azimuth, elevation
from ido.poses import PARAMETERS, transform
from ido.types import BoolArray, DoubleArray, FloatArray
from ido_viz.run import MethodRun, Run
from ido_viz.state import NO_POINT, State

SHOWN_BINS = 12
"""How many of the strongest bins are listed."""


@dataclass(frozen=True, slots=True, eq=False)
class Inspection:
    """What the inspected pane's method sees and makes of it.

    Args:
        side: the method's registration.
        pane: number of the pane, 0 for the left one.
        seen: its histogram, shape (n_bins,).
        shares: of every bin in the next update.
        values: the shares along the chosen number of x, or along the update itself; shape (n_bins,).
        point: number of the inspected model point; None for none.
        moved: the scene points at the pose, shape (S, 3).
    """

    side: MethodRun
    pane: int
    seen: FloatArray
    shares: Attribution
    values: DoubleArray
    point: int | None
    moved: FloatArray

    @property
    def of_points(self) -> DoubleArray:
        """The values of each model point's bins, added up; shape (M,)."""
        return self.values.reshape(-1, len(self.side.histogram.model.points)).sum(axis=0)

    @property
    def strongest(self) -> np.ndarray:
        """Numbers of the strongest bins, the strongest first."""
        return strongest(self.values, SHOWN_BINS)


def inspect(run: Run, state: State, iteration: int) -> Inspection | None:
    """Look into the inspected pane's method after so many iterations; None for a baseline, which has no bins."""
    pane = 0 if state.inspected_pane == "left" else 1
    side = run.sides[pane]
    if side.maps is None:
        return None
    k = side.clipped(iteration)
    D = side.maps.maps[side.map_number(iteration) - 1]
    seen = side.histogram(run.scene.points, side.trajectory.x[k])
    shares = Attribution.of(D, side.histogram, seen, against_reference=state.against_reference)
    direction = np.eye(6)[PARAMETERS.index(state.coloring)] if state.coloring in PARAMETERS else None
    known = state.inspected != NO_POINT and state.inspected < len(side.histogram.model.points)
    moved = transform(side.T_model_scene[k], run.scene.points.astype(np.float64))
    return Inspection(side, pane, seen, shares, shares.along(direction), state.inspected if known else None, moved)


def asked(histogram: Histogram, question: str) -> bool:
    """Whether a histogram asks a question of the paper's."""
    return isinstance(histogram, FrontBack) and question in (" / ".join(block) for block in histogram.blocks)


def answers(histogram: Histogram, moved: FloatArray, point: int, question: str) -> tuple[BoolArray, DoubleArray]:
    """What a model point says of moved scene points (S, 3): on the first side or not, and how much it counts (0 to 1).

    Only front and back weigh by distance; the other questions count every point alike.
    """
    m, n = (array[point].astype(np.float64) for array in (histogram.model.points, histogram.model.normals))
    if question == "front / back":
        offset = moved - m
        return offset @ n > 0, np.exp(-(offset**2).sum(axis=1) / SIGMA2)
    angle = elevation if question == "up / down" else azimuth
    return angle(moved) > angle(m[None])[0], np.ones(len(moved))


def point_on_ray(points: FloatArray, origin: FloatArray, direction: FloatArray, reach: float) -> int | None:
    """Number of the point (M, 3) nearest to a ray, if it is within reach of it; of nearly equal ones the first met."""
    direction = np.asarray(direction, dtype=np.float64) / np.linalg.norm(direction)
    offset = points - np.asarray(origin, dtype=np.float64)
    along = offset @ direction
    away = np.linalg.norm(offset - along[:, None] * direction, axis=1)
    hit = (away < reach) & (along > 0)
    if not hit.any():
        return None
    return int(np.argmin(np.where(hit, along + 10 * away, np.inf)))
