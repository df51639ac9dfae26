"""One pure function from a state to both registrations of its scene."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from ido import Histogram, Maps, Scene, Scores, StopReason, Trajectory, perturb, poses, score
from ido.global_registration import Confidence
from ido.perturbation import start_pose
from ido.recording import chosen_iterations
from ido.types import FloatArray
from ido_viz.core.background import Report
from ido_viz.core.library import Entry, Library, Selection, Subject
from ido_viz.core.race import Race
from ido_viz.core.state import State
from ido_viz.core.verdict import Verdict

MOST_DISTANCES = 100
"""At so many iterations at most, the distance to the reference line is measured."""


@dataclass(frozen=True, eq=False)
class MethodRun:
    """One method's registration of the scene.

    Args:
        scene: what it registered.
        method: its name.
        maps: what it walks; None for a method that learns nothing.
        histogram: what its poses are seen through: its own, else the shape's first.
        trajectory: all poses.
        T_model_scene: the same as matrices, shape (n + 1, 4, 4).
        scores: of every pose, each of shape (n + 1,).
        settings: all of the method's, plain values.
        race: of the starts of a method from any start; None for others.
        confidence: how sure it is of its pose; None for others.
        pending: why there is nothing but the start yet: it is computed, was cancelled or failed; None once there is.
        waiting: the same in words; empty once there is.
        trace: where it failed, if it did.
    """

    scene: Scene
    method: str
    maps: Maps | None
    histogram: Histogram
    trajectory: Trajectory
    T_model_scene: FloatArray
    scores: Scores
    settings: Mapping[str, object] = field(default_factory=dict)
    race: Race | None = None
    confidence: Confidence | None = None
    pending: Verdict | None = None
    waiting: str = ""
    trace: str = ""

    @cached_property
    def distances(self) -> FloatArray:
        """Of the histogram from the reference line at every pose, see `distances`; shape (n + 1,).

        Measured when it is first asked for, since it takes as long as the registration itself.
        """
        return distances(self.histogram, self.scene, self.trajectory)

    @property
    def norms(self) -> FloatArray:
        """Size of the update at every pose, shape (n + 1,): of the one made there, last of the one too small to make.

        The last is NaN where none was computed: at the iteration limit, and of baselines.
        """
        return np.append(self.trajectory.update_norms, self.trajectory.last_norm)

    def clipped(self, iteration: int) -> int:
        """The iteration, no further than this method got."""
        return min(iteration, self.trajectory.iterations)

    def map_number(self, iteration: int) -> int:
        """Number, from 1, of the map that makes the next update; 0 for a baseline."""
        return 0 if self.maps is None else min(self.clipped(iteration) + 1, len(self.maps.maps))

    def verdict(self, iteration: int) -> Verdict:
        """How the method stands after so many iterations; nothing of its place before the end."""
        if self.pending is not None:
            return self.pending
        if iteration < self.trajectory.iterations:
            return Verdict.MOVING if iteration else Verdict.STARTING
        return Verdict.at_the_end(float(self.scores.accuracy[-1]))


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


def distances(histogram: Histogram, scene: Scene, trajectory: Trajectory) -> FloatArray:
    """‖h(x) - h_ref‖ / ‖h_ref‖ at every pose of a trajectory, shape (n + 1,); undivided where h_ref is zero.

    Of a long one, measured at `MOST_DISTANCES` iterations, the first ones one by one, and in between as on a line.
    docs/method.md, Eq. 20.
    """
    measured = chosen_iterations(trajectory.iterations, MOST_DISTANCES)
    seen = np.stack([histogram(scene.points, x) for x in trajectory.x[measured]])
    length = float(np.linalg.norm(histogram.reference))
    away = np.linalg.norm(seen - histogram.reference, axis=1) / (length if length > 0 else 1.0)
    return np.interp(np.arange(trajectory.iterations + 1), measured, away)


def scene_inputs(state: State) -> tuple[object, ...]:
    """The part of a state that its scene depends on."""
    return (state.shape, state.perturbation, state.start)


def inputs(state: State) -> tuple[object, ...]:
    """The part of a state that a run depends on: equal inputs, equal runs."""
    return (*scene_inputs(state), state.left, state.right, state.epsilon, state.max_iterations)


def compute(state: State, library: Library) -> Run:
    """Make the scene and register it with both methods.

    Raises:
        StateError: the shape is unknown, or a method is not available for it.
    """
    selection = library.select(state)
    scene = make_scene(selection.subject, state)
    left, right = (register_side(entry, selection, state, scene) for entry in selection.entries)
    return Run(selection.subject, scene, (left, right))


def warm_up(state: State, library: Library) -> None:
    """Load and compile what the page of a state needs first, but run nothing of the user's own."""
    selection = library.select(state)
    scene = make_scene(selection.subject, state)
    for entry in selection.entries:
        if entry.quick:
            register_side(entry, selection, state, scene)
        else:
            waiting_side(entry, selection, scene, "")


def make_scene(subject: Subject, state: State) -> Scene:
    """The scene of a state, moved by hand if it was."""
    scene = perturb(subject.cloud(), state.perturbation)
    return scene.moved(poses.exp(np.array(state.start))) if state.start else scene


def start_size(state: State) -> tuple[float, float]:
    """How far a state's scene is turned and shifted from where it belongs: degrees, model units."""
    if not state.start:
        return state.perturbation.rotation, state.perturbation.translation
    T_scene_model = poses.exp(np.array(state.start)) @ start_pose(state.perturbation)
    turn = Rotation.from_matrix(T_scene_model[:3, :3]).magnitude()
    return float(np.rad2deg(turn)), float(np.linalg.norm(T_scene_model[:3, 3]))


def register_side(
    entry: Entry, selection: Selection, state: State, scene: Scene, *, watch: Report | None = None
) -> MethodRun:
    """One method's registration of a scene.

    Raises:
        BaseException: what a method of the user's own raised, and what `watch` raises.
    """
    method = entry.make(state.epsilon, state.max_iterations, watch or (lambda _: None))
    histogram = selection.subject.first_histogram if method.histogram is None else method.histogram
    if method.registration is None:
        trajectory = method.register(scene.points, watch=watch)
        side = _side(entry.name, scene, trajectory, histogram, maps=method.maps, settings=method.settings)
    else:
        tried = method.registration.run(scene.points, watch=watch)
        side = _side(
            entry.name,
            scene,
            tried.trajectory,
            histogram,
            settings=method.settings,
            race=Race.of(tried),
            confidence=Confidence.of(tried),
        )
    if not entry.quick:
        _ = side.distances  # here, where what a histogram of one's own raises is told of
    return side


def waiting_side(entry: Entry, selection: Selection, scene: Scene, waiting: str) -> MethodRun:
    """What is shown of a method as long as its registration is not there: the scene where it lies."""
    start = Trajectory(np.zeros((1, 6)), np.zeros(0), StopReason.MAX_ITERATIONS, np.nan)
    seen_through = selection.subject.first_histogram
    return _side(entry.name, scene, start, seen_through, pending=Verdict.COMPUTING, waiting=waiting)


def _side(name: str, scene: Scene, trajectory: Trajectory, histogram: Histogram, **rest: Any) -> MethodRun:
    track = trajectory.T_model_scene
    return MethodRun(
        scene=scene,
        method=name,
        histogram=histogram,
        trajectory=trajectory,
        T_model_scene=track,
        scores=score(scene, track),
        **{"maps": None, **rest},
    )
