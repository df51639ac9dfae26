"""Work that may take a while, on a thread of its own: it tells how far it is, and can be cancelled."""

from __future__ import annotations

import os
import threading
import time
from collections.abc import Callable
from contextlib import AbstractContextManager
from types import TracebackType
from typing import Generic, TypeVar

from ido_viz.core.turns import POLL, Turns

Result = TypeVar("Result")

Report = Callable[[int | str], None]
"""Called by work with the number of its iterations so far, or with what it is at; what it raises ends the work."""

SLOW = Turns(os.cpu_count() or 1)
"""Of methods that do not keep up with a slider, for all pages; those of a user's own, which may hang, do without."""

_TELL = 0.25  # seconds between two tellings of how far it is


class Waiting(str):
    """What work that waits for its turn reports: how many come before it."""


def in_turn(turns: Turns, report: Report) -> AbstractContextManager[None]:
    """Work that waits for its turn, and tells how many come before; what the report raises gives it up."""
    return turns.turn(lambda before: report(Waiting(f"waiting, {before} before it")))


class CancelledError(Exception):
    """Raised in the work when it has been cancelled."""


class Job(Generic[Result]):
    """Runs `work` at once. `changed` is called, on the job's thread, now and then and when it has ended.

    Args:
        work: gets a function to report to; that is where it can be cancelled.
        changed: is to look at the job.
    """

    def __init__(self, work: Callable[[Report], Result], changed: Callable[[], None]) -> None:
        self._work = work
        self._changed = changed
        self._began = self._told = time.perf_counter()
        self._end = threading.Event()
        self.cancelled = False
        self.progress = "computing"
        self.result: Result | None = None
        self.error: BaseException | None = None
        self.traceback: TracebackType | None = None
        threading.Thread(target=self._run, name="job", daemon=True).start()

    def cancel(self) -> None:
        """Have it end at its next report, without a result."""
        self.cancelled = True

    def resume(self) -> None:
        """Take a cancelling back; it comes too late if the work has already ended for it."""
        self.cancelled = False

    def wait(self, seconds: float) -> bool:
        """Wait for the end, so long at most; whether it has come."""
        return self._end.wait(seconds)

    @property
    def ended(self) -> bool:
        """Whether the result or the error is there, or neither, when it was cancelled."""
        return self._end.is_set()

    @property
    def seconds(self) -> float:
        """Since it began."""
        return time.perf_counter() - self._began

    def _run(self) -> None:
        try:
            self.result = self._work(self._report)
        except CancelledError:
            pass
        except BaseException as error:  # told to whoever looks; a method of one's own may even call sys.exit
            self.error, self.traceback = error, error.__traceback__
        self._end.set()
        self._changed()

    def _report(self, done: int | str) -> None:
        if self.cancelled:
            raise CancelledError
        self.progress = f"computing, iteration {done}" if isinstance(done, int) else done
        if time.perf_counter() - self._told > _TELL:
            self._told = time.perf_counter()
            self._changed()


class Shared(Generic[Result]):
    """Work that is done once, when it is first asked for, for all who ask.

    Who waits may give up without harm to the others; when all have, the work is cancelled, and begins anew when
    somebody asks again. An error is kept like a result.
    """

    def __init__(self, work: Callable[[Report], Result]) -> None:
        self._work = work
        self._lock = threading.Lock()
        self._job: Job[Result] | None = None
        self._waiting = 0

    def get(self, report: Report) -> Result:
        """The result, waited for if need be.

        Args:
            report: told how far the work is while it is waited for; what it raises ends the waiting.

        Raises:
            BaseException: what the work raised.
        """
        while True:
            job = self._awaited(report)
            if job.error is not None:
                raise job.error.with_traceback(job.traceback)  # or it would grow with each who asks
            if job.result is not None:
                return job.result
            with self._lock:  # it had been cancelled before this one came
                if self._job is job:
                    self._job = None

    def _awaited(self, report: Report) -> Job[Result]:
        with self._lock:
            self._job = job = self._job or Job(self._work, lambda: None)
            job.resume()
            self._waiting += 1
        try:
            while not job.wait(POLL):
                report(job.progress)
            return job
        finally:
            with self._lock:
                self._waiting -= 1
                if self._waiting == 0:
                    job.cancel()
