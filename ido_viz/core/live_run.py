"""The run that a page shows: what keeps up with a slider is computed at once, the rest arrives from the background."""

from __future__ import annotations

import threading
from collections.abc import Callable
from contextlib import nullcontext
from dataclasses import replace

from ido import Scene
from ido_viz.core.background import SLOW, Job, Report, in_turn
from ido_viz.core.failures import headline, traceback_of
from ido_viz.core.library import Entry, Library, Selection
from ido_viz.core.run import MethodRun, Run, inputs, make_scene, register_side, waiting_side
from ido_viz.core.state import State
from ido_viz.core.verdict import Verdict

_PATIENCE = 0.4  # seconds before cancelling is offered


class LiveRun:
    """The run of the newest inputs that were begun.

    Args:
        library: the methods.
        changed: called on other threads when it is worth while to `collect`.
    """

    def __init__(self, library: Library, changed: Callable[[], None]) -> None:
        self._library = library
        self._changed = changed
        self._lock = threading.Lock()
        self._run: Run | None = None
        self._inputs: tuple[object, ...] | None = None
        self._jobs: dict[int, Job[MethodRun]] = {}  # under way, by side

    def collect(self) -> Run | None:
        """The run with what the background has reached by now; None before the first one was begun."""
        with self._lock:
            for side, job in list(self._jobs.items()):
                if job.ended or job.cancelled:  # what hangs may never get to see that it was cancelled
                    del self._jobs[side]
                if job.result is not None and not job.cancelled:
                    self._set(side, job.result)
                elif job.error is not None:
                    self._tell(side, Verdict.FAILED, f"failed: {headline(job.error)}", traceback_of(job.error))
                elif job.cancelled:
                    self._tell(side, Verdict.CANCELLED, "cancelled", "")
                else:
                    self._tell(side, Verdict.COMPUTING, job.progress)
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
        subject = self._library.subjects.get(state.shape)  # another one as soon as another map was learned on it
        if (subject, *inputs(state)) == self._inputs:
            return False
        selection = self._library.select(state)
        scene = make_scene(selection.subject, state)
        left, right = (
            register_side(entry, selection, state, scene)
            if entry.quick
            else replace(waiting_side(entry, selection, scene, "computing"), trace=self._last_trace(side, entry.name))
            for side, entry in enumerate(selection.entries)
        )
        with self._lock:
            self._drop_jobs()
            self._run, self._inputs = Run(selection.subject, scene, (left, right)), (subject, *inputs(state))
            self._jobs = {
                side: self._job(entry, selection, state, scene)
                for side, entry in enumerate(selection.entries)
                if not entry.quick
            }
        return True

    def cancel(self) -> None:
        """Cancel what is under way; its side says so."""
        with self._lock:
            for job in self._jobs.values():
                job.cancel()
        self._changed()

    def close(self) -> None:
        """Cancel what is under way and forget it; the same inputs are begun anew."""
        with self._lock:
            self._drop_jobs()
            self._inputs = None

    def _job(self, entry: Entry, selection: Selection, state: State, scene: Scene) -> Job[MethodRun]:
        def work(report: Report) -> MethodRun:
            with nullcontext() if entry.name in selection.subject.own else in_turn(SLOW, report):
                return register_side(entry, selection, state, scene, watch=report)

        return Job(work, self._changed)

    def _drop_jobs(self) -> None:
        for job in self._jobs.values():
            job.cancel()
        self._jobs = {}

    def _tell(self, side: int, pending: Verdict, waiting: str, trace: str | None = None) -> None:
        assert self._run is not None
        before = self._run.sides[side]
        told = replace(before, pending=pending, waiting=waiting, trace=before.trace if trace is None else trace)
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
