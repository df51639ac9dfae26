"""All methods on one scene, registered one after the other in the background."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable
from contextlib import nullcontext
from dataclasses import dataclass

import numpy as np

from ido import Method, Scene, score
from ido.registration import Watch
from ido_viz.core.background import SLOW, CancelledError, Job, Report, Waiting, in_turn
from ido_viz.core.library import Library
from ido_viz.core.run import make_scene, scene_inputs
from ido_viz.core.state import State

_log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class Row:
    """What one method made of the scene."""

    method: str
    accuracy: float
    rmse: float
    seconds: float
    iterations: int
    failure: str = ""


SORTS: dict[str, Callable[[Row], tuple[float, ...]]] = {
    "PointAcc": lambda row: (-round(row.accuracy, 3), row.rmse),  # of equal ones the nearer first
    "PointRMSE": lambda row: (row.rmse,),
    "time": lambda row: (row.seconds,),
    "iterations": lambda row: (row.iterations,),
}
"""What the table can be sorted by, best first."""


class Comparison:
    """The rows that are there so far, of the scene that a comparison was last begun for.

    Args:
        library: the methods.
        changed: called on another thread when a look is worth while.
    """

    def __init__(self, library: Library, changed: Callable[[], None]) -> None:
        self._library = library
        self._changed = changed
        self._job: Job[None] | None = None
        self._of: tuple[object, ...] | None = None
        self._rows: list[Row] = []
        self.methods: tuple[str, ...] = ()

    @property
    def rows(self) -> tuple[Row, ...]:
        """Those that are there, in the order of the methods."""
        return tuple(self._rows)

    @property
    def running(self) -> bool:
        """Whether rows are still to come."""
        return self._job is not None and not self._job.ended

    @property
    def waiting(self) -> str:
        """That it waits for other pages' work, and for how much; empty if it does not."""
        progress = self._job.progress if self._job is not None and self.running else ""
        return progress if isinstance(progress, Waiting) else ""

    def fits(self, state: State) -> bool:
        """Whether the rows are of the state's scene."""
        return self._of == self._inputs(state)

    def begin(self, state: State) -> None:
        """Register the state's scene with every method, the one after the other."""
        self.cancel()
        self._of, self.methods = self._inputs(state), self._library.methods(state.shape)
        self._rows = rows = []  # of this comparison alone; one that is still ending has its own
        self._job = Job(lambda report: self._fill(state, rows, report), self._changed)

    def cancel(self) -> None:
        """Leave it at the rows that are there."""
        if self._job is not None:
            self._job.cancel()

    def _inputs(self, state: State) -> tuple[object, ...]:
        subject = self._library.subjects.get(state.shape)  # another one as soon as another map was learned on it
        return (subject, *scene_inputs(state), state.epsilon, state.max_iterations)

    def _fill(self, state: State, rows: list[Row], report: Report) -> None:
        subject = self._library.subject(state.shape)
        scene = make_scene(subject, state)
        for name in subject.methods:
            try:
                with nullcontext() if name in subject.own else in_turn(SLOW, report):
                    report("")
                    method = self._library.entry(state.shape, name).make(state.epsilon, state.max_iterations, report)
                    rows.append(measured(method, scene, report))
            except CancelledError:
                raise
            except BaseException as error:  # the others are still of interest; one of one's own may call sys.exit
                _log.exception("%s failed", name)
                rows.append(Row(name, 0.0, np.inf, np.inf, 0, failure=type(error).__name__))
            self._changed()


def measured(method: Method, scene: Scene, watch: Watch) -> Row:
    """One method's row; its time is without what only the first registration takes."""
    method.register(scene.points[:10], watch=watch)  # loads and compiles
    began = time.perf_counter()
    track = method.register(scene.points, watch=watch)
    seconds = time.perf_counter() - began
    scores = score(scene, track.T_model_scene[-1])
    return Row(method.name, float(scores.accuracy), float(scores.rmse), seconds, track.iterations)
