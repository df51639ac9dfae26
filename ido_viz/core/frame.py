"""All that is drawn of a run at one iteration, as a value: made once for the canvas, the panels and the files."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ido import Question, poses
from ido.bin_order import bin_order
from ido.scores import registered
from ido.types import BoolArray, FloatArray
from ido_viz.core.caption import Caption, caption_of
from ido_viz.core.inside import Inside, inside_of
from ido_viz.core.inspection import Inspection, inspect, inspected_number
from ido_viz.core.overlay import Overlay, overlay_of
from ido_viz.core.run import MethodRun, Run
from ido_viz.core.state import BEATS, LAST, NO_POINT, State
from ido_viz.core.verdict import Verdict


@dataclass(frozen=True, slots=True, eq=False)
class SideFrame:
    """One method at one of its poses.

    Args:
        pane: number of the pane, 0 for the left one.
        run: the method's whole registration.
        k: after how many of its iterations.
        T_model_scene: the pose, shape (4, 4); while it plays, on the way to the next one.
        arrived: which of the scene's points that are no outliers count as registered (PointAcc), shape (n,).
        seen: the histogram there, shape (n_bins,).
        order: of the bins from left to right, shape (n_bins,).
        map_order: of the bins of maps that belong to several iterations, shape (n_bins,).
        shown_map: number, from 1, of the map that is shown; 0 where there is none.
        marked: number of the model point that is looked into; `NO_POINT` for none, and where this method has others.
        inspection: what it sees and makes of it; None for a method without maps.
        overlay: what is laid over it; None for nothing.
        verdict: how it stands.
        caption: what is written of it.
    """

    pane: int
    run: MethodRun
    k: int
    T_model_scene: FloatArray
    arrived: BoolArray
    seen: FloatArray
    order: np.ndarray
    map_order: np.ndarray
    shown_map: int
    marked: int
    inspection: Inspection | None
    overlay: Overlay | None
    verdict: Verdict
    caption: Caption

    def on_the_way(self, share: float) -> SideFrame:
        """The same with the scene a share of the way to the next pose."""
        start, end = self.run.T_model_scene[self.k], self.run.T_model_scene[self.run.clipped(self.k + 1)]
        return replace(self, T_model_scene=poses.between(start, end, share))

    @property
    def accuracy(self) -> float:
        """PointAcc."""
        return float(self.run.scores.accuracy[self.k])

    @property
    def rmse(self) -> float:
        """PointRMSE, model units."""
        return float(self.run.scores.rmse[self.k])

    @property
    def next_norm(self) -> float:
        """Size of the next update; NaN where none was computed."""
        return float(self.run.norms[self.k])


@dataclass(frozen=True, slots=True, eq=False)
class Frame:
    """Both methods after so many iterations.

    Args:
        state: what the page shows.
        run: of the state's scene.
        k: the iteration that the state means.
        sides: the left and the right pane.
    """

    state: State
    run: Run
    k: int
    sides: tuple[SideFrame, SideFrame]
    inside: Inside | None = None
    """The slow motion of the next iteration of the side that is looked into; None for none."""
    held: bool = False
    """Whether the start is shown while it is still changed, before it plays."""

    def on_the_way(self, share: float) -> Frame:
        """The same with both scenes a share of the way to their next poses."""
        left, right = (side.on_the_way(share) for side in self.sides)
        return replace(self, sides=(left, right))

    @property
    def inspected(self) -> SideFrame:
        """The side that is looked into."""
        return self.sides[inspected_number(self.state)]

    @property
    def picked(self) -> int | None:
        """The model point that is looked into; None for none, and in the slow motion."""
        if self.inside is not None or self.inspected.inspection is None:
            return None
        return self.inspected.inspection.point

    @property
    def picked_scene_point(self) -> int | None:
        """The one scene point that the picked model point is asked about; None for none, or all."""
        seen = None if self.picked is None else self.inspected.inspection
        return None if seen is None else seen.scene_point

    @property
    def asked(self) -> tuple[int, Question] | None:
        """The model point of the inspected side that colours its scene, and its question; None for none."""
        if self.inside is not None:
            return (self.inside.point, self.inside.question) if self.inside.asks else None
        seen = self.inspected.inspection
        return None if seen is None or seen.point is None or seen.question is None else (seen.point, seen.question)


def frame_of(run: Run, state: State, *, held: bool = False) -> Frame:
    """The frame that a state shows of its run."""
    k = shown_iteration(run, state)
    sides = [_side_frame(run, state, k, 0), _side_frame(run, state, k, 1)]
    seen = sides[inspected_number(state)]
    inside = inside_of(seen.run, seen.k, seen.inspection, state.inside)
    if inside is not None and inside.beat == BEATS:
        sides[seen.pane] = seen.on_the_way(inside.share)
    return Frame(state, run, k, (sides[0], sides[1]), inside, held)


def frame_at(run: Run, state: State, position: float) -> Frame:
    """The frame of a position: an iteration, and a fraction of the way to the next."""
    k = min(int(position), run.iterations)
    frame = frame_of(run, replace(state, iteration=k))
    return frame.on_the_way(position - k) if position > k else frame


def shown_iteration(run: Run, state: State) -> int:
    """The iteration of a run that a state shows."""
    return run.iterations if state.iteration == LAST else min(state.iteration, run.iterations)


def _side_frame(run: Run, state: State, iteration: int, pane: int) -> SideFrame:
    side = run.sides[pane]
    k = side.clipped(iteration)
    inspection = inspect(run, state, iteration, pane)
    contribution = None if inspection is None else inspection.values
    overlay, verdict = overlay_of(run, state, iteration, pane), side.verdict(k)
    return SideFrame(
        pane=pane,
        run=side,
        k=k,
        T_model_scene=side.T_model_scene[k],
        arrived=registered(run.scene, side.T_model_scene[k]),
        seen=run.histogram(pane, k) if inspection is None else inspection.seen,
        order=bin_order(side.histogram, state.order, contribution),
        map_order=bin_order(side.histogram, state.order),
        shown_map=_shown_map(side, state, iteration),
        marked=_marked(run, state, side),
        inspection=inspection,
        overlay=overlay,
        verdict=verdict,
        caption=caption_of(side, k, overlay, verdict, state),
    )


def _marked(run: Run, state: State, side: MethodRun) -> int:
    inspected = run.sides[inspected_number(state)]
    same = np.array_equal(side.histogram.model.points, inspected.histogram.model.points)
    return state.inspected if same else NO_POINT


def _shown_map(side: MethodRun, state: State, iteration: int) -> int:
    if side.maps is None or not state.pinned_map:
        return side.map_number(iteration)
    return min(state.pinned_map, len(side.maps.maps))
