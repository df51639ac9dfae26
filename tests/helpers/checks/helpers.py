"""What the checks of claims are made of: pages of the content, their runs, and what can be measured in a run."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache, lru_cache
from typing import Any

import numpy as np

from ido import poses
from ido.experiments import LEVELS
from ido.experiments.paper import PAPER_TABLES
from ido.shipped import shipped_results
from ido.types import FloatArray
from ido_viz.core.library import shipped_library
from ido_viz.core.run import MethodRun, Run, compute
from ido_viz.core.state import State, with_values
from ido_viz.core.verdict import Verdict
from ido_viz.teach.lessons import lesson
from ido_viz.teach.presets import presets

Check = Callable[[Run], bool]
"""Whether a claim holds for the run of its page."""

LEFT, RIGHT = 0, 1
BOTH = (LEFT, RIGHT)


def page_of(claim: str, **values: Any) -> State:
    """The page that a claim, ``lesson/id``, is made on, with some values changed."""
    name, wanted = claim.split("/")
    (found,) = (step.shown for step in lesson(name).steps if wanted in [each.id for each in step.claims])
    return with_values(found, values)


def page_of_preset(name: str, **values: Any) -> State:
    """The page of a preset by its id, with some values changed."""
    (found,) = (preset.state for preset in presets() if preset.id == name)
    return with_values(found, values)


@cache
def run_of(state: State) -> Run:
    """The run of a page; the iteration shown and the view make no difference to it."""
    return compute(state, shipped_library())


def ends(verdict: Verdict, *sides: int) -> Check:
    """Whether the sides end so."""
    return lambda run: all(run.sides[side].verdict(run.iterations) is verdict for side in sides)


both_in_place, both_wrong = ends(Verdict.IN_PLACE, *BOTH), ends(Verdict.WRONG_POSE, *BOTH)


def all_of(*checks: Check) -> Check:
    """Whether all of several things hold."""
    return lambda run: all(check(run) for check in checks)


def at(state: State, check: Check) -> Check:
    """Whether something holds for the run of another state."""
    return lambda _: check(run_of(state))


def rotation_error(run: Run, side: int, iteration: int) -> float:
    """Rotation still to go after so many iterations, degrees."""
    its = run.sides[side]
    return float(its.scores.rotation[its.clipped(iteration)])


def from_line(side: MethodRun, histogram: FloatArray) -> FloatArray:
    """How far each block of a histogram is from the reference line, as a share of the line's own length; (blocks,)."""
    reference = blocks_of(side, side.histogram.reference)
    return np.linalg.norm(blocks_of(side, histogram) - reference, axis=1) / np.linalg.norm(reference, axis=1)


def in_its_place(run: Run, side: int) -> FloatArray:
    """The histogram of the scene where it belongs."""
    moved = poses.transform(run.scene.T_model_scene, run.scene.points)
    return run.sides[side].histogram(moved, np.zeros(6))


def change_by_outliers(run: Run, side: int) -> FloatArray:
    """How much the outliers change each block, of length 1, of the histogram at the start; shape (blocks,)."""
    its, start = run.sides[side], np.zeros(6)
    without = its.histogram(run.scene.points[~run.scene.is_outlier], start)
    return np.linalg.norm(blocks_of(its, its.histogram(run.scene.points, start) - without), axis=1)


def blocks_of(side: MethodRun, values: FloatArray) -> FloatArray:
    """Values of all bins, or of all columns of a map, by block: shape (blocks, ...)."""
    return values.reshape(len(side.histogram.blocks), -1)


def map_size(run: Run, side: int, number: int) -> float:
    """Root of the summed squares of a map's entries; maps are numbered from 1."""
    return float(np.linalg.norm(map_of(run.sides[side], number)))


def angle_share(run: Run, side: int, number: int) -> float:
    """Share of a map's summed squares that belongs to the questions about angles."""
    of_blocks = (map_of(run.sides[side], number) ** 2).sum(axis=0).reshape(len(run.sides[side].histogram.blocks), -1)
    return float(of_blocks[1:].sum() / of_blocks.sum())


def front_share(run: Run, side: int, number: int) -> float:
    """Share of front in what a map makes of front and back, the bins' own weights counted in."""
    its = run.sides[side]
    sides = (map_of(its, number) ** 2).sum(axis=0).reshape(-1, len(its.histogram.model.points))
    weights = getattr(its.histogram, "weights", np.ones(sides.shape))
    front, back = (sides * weights.astype(np.float64) ** 2).sum(axis=1)[:2]
    return float(front / (front + back))


def map_of(side: MethodRun, number: int) -> FloatArray:
    """A map of a side that has some, shape (6, n_bins)."""
    assert side.maps is not None
    return side.maps.maps[number - 1].astype(np.float64)


def training_error(run: Run, side: int, maps_done: int = -1) -> float:
    """Mean training error of a side's maps after so many of them, by default after the last."""
    maps = run.sides[side].maps
    assert maps is not None
    return float(maps.curves.mean[maps_done])


@lru_cache
def mean(method: str, sweep: str = "", level: float | None = None, shape: str = "bunny") -> float:
    """Mean PointAcc of a method in the shipped results: of all the paper's sweeps, of one, or at one of its levels.

    Raises:
        ValueError: there are none.
    """
    rows = shipped_results().where(dataset=shape, method=method).among(sweep=list(LEVELS))
    chosen = np.full(len(rows), True) if not sweep else rows.sweep == sweep
    if level is not None:
        chosen &= np.isclose(rows.level, level)
    if not chosen.any():
        raise ValueError(f"no results of {method} in {sweep} at {level}")
    return float(np.mean([rows.accuracy[chosen & (rows.sweep == name)].mean() for name in set(rows.sweep[chosen])]))


def means(*expected: tuple[str, str], sweep: str = "", level: float | None = None) -> Check:
    """Whether the methods' means on the bunny are those written, such as ``("DO", "0.81")``."""
    return lambda _: all(f"{mean(method, sweep, level):.2f}" == written for method, written in expected)


def paper_says(sweep: str, *expected: tuple[str, str]) -> Check:
    """Whether the paper's Table I, of the bunny, prints these figures."""
    return lambda _: all(f"{PAPER_TABLES[0].values[sweep][method]:.3f}" == written for method, written in expected)
