"""What is asked of a page, as pure functions from its state to the next one."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, get_args

from ido import Perturbation
from ido_viz.core.basin import STARTS, start_of
from ido_viz.core.frame import SideFrame, shown_iteration
from ido_viz.core.inside import STEP, strongest_point
from ido_viz.core.inspection import inspect, inspected_number
from ido_viz.core.library import Subject
from ido_viz.core.run import MethodRun, Run
from ido_viz.core.state import BEATS, LAST, NO_POINT, NO_START, Pane, State


def still(state: State) -> State:
    """Neither playing nor in slow motion."""
    return replace(state, playing=False, inside=0.0)


def lent_by(state: State) -> int:
    """The model point that goes with the slow motion of a page that is opened, when that ends; `NO_POINT` for none."""
    return state.inspected if state.inside > 0 else NO_POINT


def held_at_start(state: State) -> State:
    """At the start, about to be played."""
    return replace(state, iteration=0, inside=0.0, playing=True)


def at_iteration(state: State, iteration: int, length: int) -> State:
    """At an iteration of a run of a length, 0 for one that is still computed; at the end it stays there for any run."""
    at_end = iteration == LAST or 0 < length <= iteration
    return replace(state, iteration=LAST if at_end else max(0, iteration))


def played(state: State, run: Run | None) -> State:
    """Playing on: from the start once it is at its end, or the slow motion of an iteration, then of the next one.

    After the slow motion of the last one it plays from the start.
    """
    shown = 0 if run is None else shown_iteration(run, state)
    if 0 < state.inside < BEATS:
        return replace(state, playing=True)
    if state.inside > 0 and run is not None and shown + 1 < _inspected(state, run).trajectory.iterations:
        return replace(state, playing=True, inside=STEP, iteration=shown + 1)
    if state.inside > 0:
        return replace(state, playing=True, inside=0.0, iteration=0)
    at_end = run is None or shown >= run.iterations
    return replace(state, playing=True, iteration=0 if at_end else shown)


def looked_inside(state: State, run: Run | None, position: float, *, playing: bool) -> State | None:
    """In the slow motion of an iteration, of a method with maps and a model point of it; None where none has maps."""
    if run is None or all(side.maps is None for side in run.sides):
        return None
    pane = inspected_number(state)
    pane = pane if run.sides[pane].maps is not None else 1 - pane
    k = max(0, min(shown_iteration(run, state), run.sides[pane].trajectory.iterations - 1))
    state = replace(state, inspected_pane=get_args(Pane)[pane], iteration=k, inside=position, playing=playing)
    inspection = inspect(run, state, k, pane)
    if inspection is not None and inspection.point is None:
        state = replace(state, inspected=strongest_point(inspection))
    return state


def with_seed(state: State, seed: int) -> State:
    """Another draw of the scene, not moved by hand."""
    return replace(state, perturbation=replace(state.perturbation, seed=seed), start=NO_START)


def with_paper_defaults(state: State, subject: Subject) -> State:
    """The paper's perturbation of a shape, with the same seed, not moved by hand."""
    perturbation = Perturbation(outlier_kind=subject.outlier_kind, seed=state.perturbation.seed)
    return replace(state, perturbation=perturbation, start=NO_START)


def with_method(state: State, method: str, pane: str) -> State:
    """A method in a pane."""
    return replace(state, left=method) if pane == "left" else replace(state, right=method)


def with_start(state: State, subject: Subject, number: int) -> State:
    """Begun at one of the basin's starts."""
    return replace(state, start=start_of(state, subject.up, min(number, STARTS - 1)), inside=0.0)


def with_bin(state: State, side: SideFrame, kind: str, place: float) -> State:
    """A model point and a question picked by a bin.

    Args:
        state: of the page.
        side: whose bin it is.
        kind: ``bin`` for one by its number, ``shown`` for one by its place in the histogram, else in a map.
        place: its number, or where it is from left to right, 0 to 1.
    """
    histogram = side.run.histogram
    count, n_model = histogram.n_bins, len(histogram.model.points)
    order = side.order if kind == "shown" else side.map_order
    number = min(int(place), count - 1) if kind == "bin" else int(order[min(int(place * count), count - 1)])
    block, bin_of_block = divmod(number, 2 * n_model)
    return replace(
        state,
        inspected_pane=get_args(Pane)[side.pane],
        inspected=bin_of_block % n_model,
        question=histogram.blocks[block].name,
    )


def within_run(changes: Mapping[str, Any], state: State, run: Run | None) -> dict[str, Any]:
    """Changes of a state's inspected points, brought into the range of a run's."""
    if run is None:
        return dict(changes)
    pane: Pane = changes.get("inspected_pane", state.inspected_pane)
    n_model = len(_inspected(replace(state, inspected_pane=pane), run).histogram.model.points)
    counts = {"inspected": n_model, "scene_point": len(run.scene.points)}
    return {
        name: int(min(max(value or 0, NO_POINT), counts[name] - 1)) if name in counts else value
        for name, value in changes.items()
    }


def _inspected(state: State, run: Run) -> MethodRun:
    """The method that is looked into."""
    return run.sides[inspected_number(state)]
