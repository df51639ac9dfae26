"""Why a method makes its next step: the shares of its bins, and what one model point sees."""

from __future__ import annotations

from dataclasses import dataclass
from typing import get_args

import numpy as np

from ido import FrontBack, Histogram
from ido.attribution import Attribution, strongest
from ido.histograms import SIGMA2, azimuth, elevation
from ido.poses import PARAMETERS, log, transform
from ido.types import BoolArray, DoubleArray, FloatArray
from ido_viz.run import MethodRun, Run
from ido_viz.state import NO_POINT, Pane, State

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
        values: the shares along the chosen number of x, along the way to the true pose, or along the update itself;
            shape (n_bins,).
        point: number of the inspected model point; None for none.
        scene_point: number of the scene point that it is asked about; None for all alike.
        moved: the scene points at the pose, shape (S, 3).
        misleading: whether the values are those towards the true pose, so that the negative ones mislead.
    """

    side: MethodRun
    pane: int
    seen: FloatArray
    shares: Attribution
    values: DoubleArray
    point: int | None
    scene_point: int | None
    moved: FloatArray
    misleading: bool

    @property
    def of_points(self) -> DoubleArray:
        """The values of each model point's bins, added up; shape (M,)."""
        return self.values.reshape(-1, len(self.side.histogram.model.points)).sum(axis=0)

    @property
    def strongest(self) -> np.ndarray:
        """Numbers of the strongest bins, the strongest first; towards the true pose, of the most misleading ones."""
        return strongest(np.minimum(self.values, 0.0) if self.misleading else self.values, SHOWN_BINS)


Inspections = tuple[Inspection | None, Inspection | None]
"""Of both panes; None for a baseline, which has no bins."""


def inspected_number(state: State) -> int:
    """Number of the pane that is looked into, 0 for the left one."""
    return get_args(Pane).index(state.inspected_pane)


def inspect_both(run: Run, state: State, iteration: int) -> Inspections:
    """Look into both panes' methods after so many iterations."""
    return _inspect(run, state, iteration, 0), _inspect(run, state, iteration, 1)


def inspect(run: Run, state: State, iteration: int) -> Inspection | None:
    """Look into the inspected pane's method after so many iterations; None for a baseline, which has no bins."""
    return _inspect(run, state, iteration, inspected_number(state))


def _inspect(run: Run, state: State, iteration: int, pane: int) -> Inspection | None:
    side = run.sides[pane]
    if side.maps is None:
        return None
    k = side.clipped(iteration)
    D = side.maps.maps[side.map_number(iteration) - 1]
    seen = side.histogram(run.scene.points, side.trajectory.x[k])
    shares = Attribution.of(D, side.histogram, seen, against_reference=state.against_reference)
    misleading = state.coloring == "towards the truth"
    direction = None
    if misleading:
        direction = log(run.scene.T_model_scene[None])[0] - side.trajectory.x[k]
    elif state.coloring in PARAMETERS:
        direction = np.eye(6)[PARAMETERS.index(state.coloring)]
    moved = transform(side.T_model_scene[k], run.scene.points.astype(np.float64))
    return Inspection(
        side,
        pane,
        seen,
        shares,
        shares.along(direction),
        _known(state.inspected, len(side.histogram.model.points)),
        _known(state.scene_point, len(moved)),
        moved,
        misleading,
    )


def _known(number: int, count: int) -> int | None:
    return number if NO_POINT < number < count else None


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
