"""The basin of a method: from which turns of a scene it is registered, one start after the other in the background."""

from __future__ import annotations

import logging
from collections.abc import Callable, Sequence
from contextlib import nullcontext
from dataclasses import replace

import numpy as np

from ido import poses, score
from ido.perturbation import start_pose
from ido.types import DoubleArray
from ido_viz.core.background import SLOW, CancelledError, Job, Report, in_turn
from ido_viz.core.failures import headline
from ido_viz.core.geometry import upright
from ido_viz.core.library import Library
from ido_viz.core.run import make_scene
from ido_viz.core.state import State

ANGLES = (30, 60, 90, 120, 150, 180)
"""Degrees that a scene is turned by from where it belongs."""

AXES = 32
"""Of each angle."""

STARTS = len(ANGLES) * AXES
"""Start i is turned by ``ANGLES[i // AXES]`` about axis ``i % AXES``."""

_DIGITS = 6  # of a start; so that a page's code stays short

_log = logging.getLogger(__name__)


def axes() -> DoubleArray:
    """Axes spread evenly over the sphere, from upright to upside down, of an upright model (Fibonacci); (AXES, 3)."""
    number = np.arange(AXES) + 0.5
    z = 1 - 2 * number / AXES
    around = np.pi * (3 - np.sqrt(5)) * number
    across = np.sqrt(1 - z**2)
    return np.stack([across * np.cos(around), across * np.sin(around), z], axis=1)


def start_of(state: State, up: tuple[float, float, float], number: int) -> tuple[float, ...]:
    """The `State.start` that turns a state's scene as a start of the basin says, and leaves its shift as it is.

    Args:
        state: whose scene.
        up: of its shape.
        number: of the start.
    """
    return starts_of(state, up)[number]


def starts_of(state: State, up: tuple[float, float, float]) -> list[tuple[float, ...]]:
    """All of them, as by `start_of`."""
    turns = np.deg2rad(ANGLES)[:, None, None] * upright(up).inv().apply(axes())
    T_scene_model = poses.exp(np.concatenate([np.zeros((STARTS, 3)), turns.reshape(STARTS, 3)], axis=1))
    begun = start_pose(state.perturbation)
    T_scene_model[:, :3, 3] = begun[:3, 3]
    return [tuple(x) for x in np.round(poses.log(T_scene_model @ poses.invert(begun)), _DIGITS).tolist()]


def turn_of(state: State, up: tuple[float, float, float]) -> DoubleArray:
    """How a state's scene is turned from where it belongs: the axis of an upright model times the degrees, (3,)."""
    T_scene_model = start_pose(state.perturbation)
    if state.start:
        T_scene_model = poses.exp(np.array(state.start)) @ T_scene_model
    turn = poses.log(T_scene_model)[3:]
    return upright(up).apply(np.rad2deg(turn))


class Basin:
    """What is known so far of the scene that a basin was last mapped for, by method.

    Args:
        library: the methods.
        changed: called on another thread when a look is worth while.
    """

    def __init__(self, library: Library, changed: Callable[[], None]) -> None:
        self._library = library
        self._changed = changed
        self._job: Job[None] | None = None
        self._of: tuple[object, ...] | None = None
        self._found: dict[str, DoubleArray] = {}
        self._failures: dict[str, str] = {}

    @property
    def running(self) -> bool:
        """Whether starts are still to come."""
        return self._job is not None and not self._job.ended and not self._job.cancelled

    @property
    def begun(self) -> bool:
        """Whether there is anything to see."""
        return self._of is not None

    def fits(self, state: State) -> bool:
        """Whether what is known is of the state's scene; what a hand did to it makes no difference."""
        return self._of == self._inputs(state)

    def accuracies(self, method: str) -> DoubleArray:
        """PointAcc that a method ends with from each start, shape (STARTS,); NaN where it is not known yet."""
        found = self._found.get(method)
        return np.full(STARTS, np.nan) if found is None else found.copy()

    def failure(self, method: str) -> str:
        """Why a method has no basin; empty when nothing went wrong."""
        return self._failures.get(method, "")

    def begin(self, state: State) -> None:
        """Map the basins of both panes' methods; what is known of the same scene is kept."""
        self.cancel()
        if not self.fits(state):
            self._of, self._found, self._failures = self._inputs(state), {}, {}  # one that is still ending has its own
        selection = self._library.select(state)
        quick_first = [entry.name for entry in sorted(selection.entries, key=lambda entry: not entry.quick)]
        names = tuple(dict.fromkeys(quick_first))
        for name in names:
            self._found.setdefault(name, np.full(STARTS, np.nan))
        found, failures = self._found, self._failures
        self._job = Job(lambda report: self._fill(state, names, found, failures, report), self._changed)

    def cancel(self) -> None:
        """Leave it at what is known."""
        if self._job is not None:
            self._job.cancel()

    def _inputs(self, state: State) -> tuple[object, ...]:
        subject = self._library.subjects.get(state.shape)  # another one as soon as another map was learned on it
        return (subject, state.shape, state.perturbation, state.epsilon, state.max_iterations)

    def _fill(
        self,
        state: State,
        names: Sequence[str],
        found: dict[str, DoubleArray],
        failures: dict[str, str],
        report: Report,
    ) -> None:
        for name in names:
            failures.pop(name, None)
            try:
                self._fill_one(state, name, found[name], report)
            except CancelledError:
                raise
            except BaseException as error:  # the other one is still of interest; one of one's own may call sys.exit
                _log.exception("%s failed", name)
                failures[name] = headline(error)

    def _fill_one(self, state: State, name: str, accuracies: DoubleArray, report: Report) -> None:
        method = self._library.entry(state.shape, name).make(state.epsilon, state.max_iterations, report)
        subject = self._library.subject(state.shape)
        starts = starts_of(state, subject.up)
        for number in np.random.default_rng(0).permutation(STARTS).tolist():  # so that all angles fill evenly
            if np.isnan(accuracies[number]):
                scene = make_scene(subject, replace(state, start=starts[number]))
                with (
                    nullcontext() if name in subject.own else in_turn(SLOW, report)
                ):  # other pages' work between starts
                    track = method.register(scene.points, watch=report)
                accuracies[number] = float(score(scene, track.T_model_scene[-1]).accuracy)
                report(number)
