"""One pure function from a state to everything that its panes, charts and readouts show."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ido import Histogram, Maps, Scene, Scores, StopReason, Trajectory, perturb, score
from ido.runs import chosen_iterations
from ido.types import FloatArray
from ido_viz.background import Report
from ido_viz.library import Library, Subject
from ido_viz.state import State

MOST_DISTANCES = 100
"""At so many iterations at most, the distance to the reference line is measured."""


@dataclass(frozen=True, slots=True, eq=False)
class MethodRun:
    """One method's registration of the scene.

    Args:
        method: its name.
        maps: what it walks; None for a method that learns nothing.
        histogram: what its poses are seen through: its own, else the shape's first.
        trajectory: all poses.
        T_model_scene: the same as matrices, shape (n + 1, 4, 4).
        scores: of every pose, each of shape (n + 1,).
        distances: of the histogram from the reference line at every pose, see `distances`; shape (n + 1,).
        settings: all of the method's, plain values.
        waiting: why there is nothing but the start yet; empty once there is.
        trace: where it failed, if it did.
    """

    method: str
    maps: Maps | None
    histogram: Histogram
    trajectory: Trajectory
    T_model_scene: FloatArray
    scores: Scores
    distances: FloatArray
    settings: Mapping[str, object] = field(default_factory=dict)
    waiting: str = ""
    trace: str = ""

    def clipped(self, iteration: int) -> int:
        """The iteration, no further than this method got."""
        return min(iteration, self.trajectory.iterations)

    def map_number(self, iteration: int) -> int:
        """Number, from 1, of the map that makes the next update; 0 for a baseline."""
        return 0 if self.maps is None else min(self.clipped(iteration) + 1, len(self.maps.maps))


@dataclass(frozen=True, slots=True, eq=False)
class Run:
    """A scene and both methods' registrations of it."""

    subject: Subject
    scene: Scene
    sides: tuple[MethodRun, MethodRun]

    @property
    def iterations(self) -> int:
        """Iterations of the longer of the two."""
        return max(side.trajectory.iterations for side in self.sides)

    def histogram(self, side: int, iteration: int) -> FloatArray:
        """The histogram that a side sees after so many iterations, shape (n_bins,)."""
        method = self.sides[side]
        return method.histogram(self.scene.points, method.trajectory.x[method.clipped(iteration)])


def norms(side: MethodRun) -> FloatArray:
    """Size of the update at every pose, shape (n + 1,): of the one made there, last of the one too small to make.

    The last is NaN where none was computed: at the iteration limit, and of baselines.
    """
    return np.append(side.trajectory.update_norms, side.trajectory.last_norm)


def distances(histogram: Histogram, scene: Scene, trajectory: Trajectory) -> FloatArray:
    """‖h(x) - h_ref‖ / ‖h_ref‖ at every pose of a trajectory, shape (n + 1,); undivided where h_ref is zero.

    Of a long one, measured at `MOST_DISTANCES` iterations, the first ones one by one, and in between as on a line.
    """
    measured = chosen_iterations(trajectory.iterations, MOST_DISTANCES)
    seen = np.stack([histogram(scene.points, x) for x in trajectory.x[measured]])
    length = float(np.linalg.norm(histogram.reference))
    away = np.linalg.norm(seen - histogram.reference, axis=1) / (length if length > 0 else 1.0)
    return np.interp(np.arange(trajectory.iterations + 1), measured, away)


def inputs(state: State) -> tuple[object, ...]:
    """The part of a state that a run depends on: equal inputs, equal runs."""
    return (state.shape, state.perturbation, state.left, state.right, state.epsilon, state.max_iterations)


def compute(state: State, library: Library) -> Run:
    """Make the scene and register it with both methods.

    Raises:
        StateError: the shape is unknown, or a method is not available for it.
    """
    scene = make_scene(state, library)
    left, right = (register_side(state, library, method, scene) for method in (state.left, state.right))
    return Run(library.subject(state.shape), scene, (left, right))


def warm_up(state: State, library: Library) -> None:
    """Load and compile what the page of a state needs first, but run nothing of the user's own."""
    scene = make_scene(state, library)
    for name in (state.left, state.right):
        if library.quick(state.shape, name):
            register_side(state, library, name, scene)
        else:
            waiting_side(state, library, name, scene, "")


def make_scene(state: State, library: Library) -> Scene:
    """The scene of a state."""
    return perturb(library.subject(state.shape).cloud(), state.perturbation)


def register_side(state: State, library: Library, name: str, scene: Scene, *, watch: Report | None = None) -> MethodRun:
    """One method's registration of a scene.

    Raises:
        StateError: the shape is unknown, or the method is not available for it.
        BaseException: what a method of the user's own raised, and what `watch` raises.
    """
    method = library.method(state, name, watch)
    trajectory = method.register(scene.points, watch=watch)
    histogram = library.first_histogram(state.shape) if method.histogram is None else method.histogram
    return _side(name, scene, trajectory, histogram, maps=method.maps, settings=method.settings)


def waiting_side(state: State, library: Library, name: str, scene: Scene, waiting: str) -> MethodRun:
    """What is shown of a method as long as its registration is not there: the scene where it lies."""
    start = Trajectory(np.zeros((1, 6)), np.zeros(0), StopReason.MAX_ITERATIONS, np.nan)
    return _side(name, scene, start, library.first_histogram(state.shape), waiting=waiting)


def _side(name: str, scene: Scene, trajectory: Trajectory, histogram: Histogram, **rest: Any) -> MethodRun:
    poses = trajectory.T_model_scene
    away = distances(histogram, scene, trajectory)
    return MethodRun(
        method=name,
        histogram=histogram,
        trajectory=trajectory,
        T_model_scene=poses,
        scores=score(scene, poses),
        distances=away,
        **{"maps": None, **rest},
    )


def bin_order(histogram: Histogram, order: str, contribution: FloatArray | None = None) -> np.ndarray:
    """The order in which a histogram's bins are drawn, shape (n_bins,): sides stay together, each ordered within.

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
        keys = {
            "model index": np.arange(n_model),
            "contribution": np.arange(n_model),
            "elevation": np.arctan2(model[:, 2], np.hypot(model[:, 0], model[:, 1])),
            "azimuth": np.arctan2(model[:, 1], model[:, 0]),
        }
        within = np.tile(np.argsort(keys[order], kind="stable"), (n_sides, 1))
    return (within + n_model * np.arange(n_sides)[:, None]).reshape(-1)
