"""The run that a page shows: what keeps up with a slider is computed at once, the rest arrives from the background."""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import replace

from ido import Scene
from ido_viz.background import Job
from ido_viz.failures import headline, traceback_of
from ido_viz.library import Library
from ido_viz.run import MethodRun, Run, inputs, make_scene, register_side, waiting_side
from ido_viz.state import State

_PATIENCE = 0.4  # seconds before cancelling is offered


class LiveRun:
    """The run of the newest inputs that were begun.

    Args:
        library: the methods.
        changed: called on other threads when a look at `run` is worth while.
    """

    def __init__(self, library: Library, changed: Callable[[], None]) -> None:
        self._library = library
        self._changed = changed
        self._lock = threading.Lock()
        self._run: Run | None = None
        self._inputs: tuple[object, ...] | None = None
        self._jobs: dict[int, Job[MethodRun]] = {}  # under way, by side

    @property
    def run(self) -> Run | None:
        """With what the background has reached."""
        with self._lock:
            for side, job in list(self._jobs.items()):
                if job.ended or job.cancelled:  # what hangs may never get to see that it was cancelled
                    del self._jobs[side]
                if job.result is not None and not job.cancelled:
                    self._set(side, job.result)
                elif job.error is not None:
                    self._tell(side, f"failed: {headline(job.error)}", traceback_of(job.error))
                elif job.cancelled:
                    self._tell(side, "cancelled", "")
                else:
                    self._tell(side, job.progress)
            return self._run

    @property
    def waiting(self) -> bool:
        """Whether a side is still to come."""
        return bool(self._jobs)

    @property
    def slow(self) -> bool:
        """Whether a side takes so long that a person may want to cancel it."""
        return any(job.seconds > _PATIENCE for job in tuple(self._jobs.values()))

    def begin(self, state: State) -> bool:
        """Compute what is quick and begin what is not; whether the inputs had changed at all.

        Raises:
            StateError: the shape is unknown, or a method is not available for it.
        """
        if inputs(state) == self._inputs:
            return False
        scene = make_scene(state, self._library)
        names = (state.left, state.right)
        slow = [side for side, name in enumerate(names) if not self._library.quick(state.shape, name)]
        left, right = (
            replace(waiting_side(state, self._library, name, scene, "computing"), trace=self._last_trace(side, name))
            if side in slow
            else register_side(state, self._library, name, scene)
            for side, name in enumerate(names)
        )
        with self._lock:
            self._drop_jobs()
            self._run, self._inputs = Run(self._library.subject(state.shape), scene, (left, right)), inputs(state)
            self._jobs = {side: self._job(state, names[side], scene) for side in slow}
        return True

    def cancel(self) -> None:
        """Cancel what is under way; its side says so."""
        with self._lock:
            for job in self._jobs.values():
                job.cancel()
        self._changed()

    def close(self) -> None:
        """Cancel what is under way and forget it."""
        with self._lock:
            self._drop_jobs()

    def _job(self, state: State, name: str, scene: Scene) -> Job[MethodRun]:
        return Job(lambda watch: register_side(state, self._library, name, scene, watch=watch), self._changed)

    def _drop_jobs(self) -> None:
        for job in self._jobs.values():
            job.cancel()
        self._jobs = {}

    def _tell(self, side: int, waiting: str, trace: str | None = None) -> None:
        assert self._run is not None
        before = self._run.sides[side]
        told = replace(before, waiting=waiting, trace=before.trace if trace is None else trace)
        if (told.waiting, told.trace) != (before.waiting, before.trace):  # or it would be drawn for nothing
            self._set(side, told)

    def _set(self, side: int, result: MethodRun) -> None:
        assert self._run is not None
        left, right = self._run.sides
        self._run = replace(self._run, sides=(left, result) if side else (result, right))

    def _last_trace(self, side: int, name: str) -> str:
        """Where a side's method failed before: shown until it is known anew, or the page would jump at each change."""
        before = self._run.sides[side] if self._run else None
        return before.trace if before and before.method == name else ""
