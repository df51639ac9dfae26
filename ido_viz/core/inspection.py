"""Why a method makes its next step: the shares of its bins, and what one model point sees."""

from __future__ import annotations

from dataclasses import dataclass
from typing import get_args

import numpy as np

from ido import Question
from ido.attribution import Attribution, strongest
from ido.poses import PARAMETERS, log, transform
from ido.types import BoolArray, DoubleArray, FloatArray
from ido_viz.core.run import MethodRun, Run
from ido_viz.core.state import NO_POINT, Pane, State

SHOWN_BINS = 12
"""How many of the strongest bins are listed."""


@dataclass(frozen=True, slots=True, eq=False)
class Inspection:
    """What a method sees and makes of it.

    Args:
        side: the method's registration.
        pane: number of the pane, 0 for the left one.
        seen: its histogram, shape (n_bins,).
        shares: of every bin in the next update.
        values: the shares along the chosen number of x, along the way to the true pose, or along the update itself;
            shape (n_bins,).
        point: number of the inspected model point; None for none.
        scene_point: number of the scene point that it is asked about; None for all alike.
        question: the block that it is asked about; None where the histogram has no such block.
        moved: the scene points at the pose, shape (S, 3).
        is_outlier: which of the scene points belong to nothing, shape (S,).
        misleading: whether the values are those towards the true pose, so that the negative ones mislead.
    """

    side: MethodRun
    pane: int
    seen: FloatArray
    shares: Attribution
    values: DoubleArray
    point: int | None
    scene_point: int | None
    question: Question | None
    moved: FloatArray
    is_outlier: BoolArray
    misleading: bool

    @property
    def of_points(self) -> DoubleArray:
        """The values of each model point's bins, added up; shape (M,)."""
        return self.values.reshape(-1, len(self.side.histogram.model.points)).sum(axis=0)

    @property
    def strongest(self) -> np.ndarray:
        """Numbers of the strongest bins, the strongest first; towards the true pose, of the most misleading ones."""
        return strongest(np.minimum(self.values, 0.0) if self.misleading else self.values, SHOWN_BINS)

    @property
    def answers(self) -> tuple[BoolArray, DoubleArray] | None:
        """What the inspected point says of every scene point, and how much each counts; None where it is not asked."""
        if self.point is None or self.question is None:
            return None
        return self.question.of_point(self.side.histogram.model, self.point, self.moved)


def inspected_number(state: State) -> int:
    """Number of the pane that is looked into, 0 for the left one."""
    return get_args(Pane).index(state.inspected_pane)


def inspect(run: Run, state: State, iteration: int, pane: int) -> Inspection | None:
    """Look into a pane's method after so many iterations; None for a baseline, which has no bins."""
    side = run.sides[pane]
    if side.maps is None:
        return None
    k = side.clipped(iteration)
    D = side.maps.maps[side.map_number(iteration) - 1]
    seen = run.histogram(pane, k)
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
        next((block for block in side.histogram.questions if block.name == state.question), None),
        moved,
        run.scene.is_outlier,
        misleading,
    )


def _known(number: int, count: int) -> int | None:
    return number if NO_POINT < number < count else None
