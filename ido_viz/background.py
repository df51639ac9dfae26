"""Work that may take a while, on a thread of its own: it tells how far it is, and can be cancelled."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import Generic, TypeVar

from ido.registration import Watch

Result = TypeVar("Result")

_TELL = 0.25  # seconds between two tellings of how far it is


class CancelledError(Exception):
    """Raised in the work when it has been cancelled."""


class Job(Generic[Result]):
    """Runs `work` at once. `changed` is called, on the job's thread, now and then and when it has ended.

    Args:
        work: gets a function to call with the number of its iterations so far; that is where it can be cancelled.
        changed: is to look at the job.
    """

    def __init__(self, work: Callable[[Watch], Result], changed: Callable[[], None]) -> None:
        self._work = work
        self._changed = changed
        self._cancelled = False
        self._began = self._told = time.perf_counter()
        self.iterations = 0
        self.ended = False
        self.result: Result | None = None
        self.error: Exception | None = None
        threading.Thread(target=self._run, name="job", daemon=True).start()

    def cancel(self) -> None:
        """Have it end at its next iteration, without a result."""
        self._cancelled = True

    @property
    def seconds(self) -> float:
        """Since it began."""
        return time.perf_counter() - self._began

    def _run(self) -> None:
        try:
            self.result = self._work(self._watch)
        except CancelledError:
            pass
        except Exception as error:  # told to whoever looks at the job
            self.error = error
        self.ended = True
        self._changed()

    def _watch(self, iterations: int) -> None:
        self.iterations = iterations
        if self._cancelled:
            raise CancelledError
        if time.perf_counter() - self._told > _TELL:
            self._told = time.perf_counter()
            self._changed()
