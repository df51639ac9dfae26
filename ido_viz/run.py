"""One pure function from a state to everything that its panes, charts and readouts show."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ido import Maps, Scene, Scores, Trajectory, perturb, register, score
from ido.types import FloatArray
from ido_viz.library import Library, Subject
from ido_viz.state import State


@dataclass(frozen=True, slots=True, eq=False)
class MethodRun:
    """One method's registration of the scene.

    Args:
        method: its name.
        maps: what it walks.
        trajectory: all poses.
        T_model_scene: the same as matrices, shape (n + 1, 4, 4).
        scores: of every pose, each of shape (n + 1,).
    """

    method: str
    maps: Maps
    trajectory: Trajectory
    T_model_scene: FloatArray
    scores: Scores

    def clipped(self, iteration: int) -> int:
        """The iteration, no further than this method got."""
        return min(iteration, self.trajectory.iterations)

    def map_number(self, iteration: int) -> int:
        """Number, from 1, of the map that makes the next update."""
        return min(self.clipped(iteration) + 1, len(self.maps.maps))


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
        return method.maps.histogram(self.scene.points, method.trajectory.x[method.clipped(iteration)])


def norms(side: MethodRun) -> FloatArray:
    """‖D h(x)‖ at every pose, shape (n + 1,): of the update made there, last of the one that was too small to make.

    The last is NaN at the iteration limit, where none was computed.
    """
    return np.append(side.trajectory.update_norms, side.trajectory.last_norm)


def inputs(state: State) -> tuple[object, ...]:
    """The part of a state that a run depends on: equal inputs, equal runs."""
    return (state.shape, state.perturbation, state.left, state.right, state.epsilon, state.max_iterations)


def compute(state: State, library: Library) -> Run:
    """Make the scene and register it with both methods.

    Raises:
        StateError: the shape is unknown, or a method is not available for it.
    """
    subject = library.subject(state.shape)
    scene = perturb(subject.cloud(), state.perturbation)
    left, right = (_register(state, library, method, scene) for method in (state.left, state.right))
    return Run(subject, scene, (left, right))


def _register(state: State, library: Library, method: str, scene: Scene) -> MethodRun:
    maps = library.maps(state.shape, method)
    trajectory = register(maps, scene.points, epsilon=state.epsilon, max_iterations=state.max_iterations)
    poses = trajectory.T_model_scene
    return MethodRun(method, maps, trajectory, poses, score(scene, poses))


def bin_order(maps: Maps, order: str) -> np.ndarray:
    """The order in which a histogram's bins are drawn, shape (n_bins,): sides stay together, each ordered within.

    Both sides of a block are in the same order of model points, but for the order by reference value.
    """
    model = maps.histogram.model.points.astype(np.float64)
    n_model = len(model)
    n_sides = maps.histogram.n_bins // n_model
    if order == "reference value":
        within = np.argsort(maps.histogram.reference.reshape(n_sides, n_model), axis=1, kind="stable")
    else:
        keys = {
            "model index": np.arange(n_model),
            "elevation": np.arctan2(model[:, 2], np.hypot(model[:, 0], model[:, 1])),
            "azimuth": np.arctan2(model[:, 1], model[:, 0]),
        }
        within = np.tile(np.argsort(keys[order], kind="stable"), (n_sides, 1))
    return (within + n_model * np.arange(n_sides)[:, None]).reshape(-1)
