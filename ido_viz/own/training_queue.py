"""Trainings wait for each other: one at a time, one for each person, in the order in which they came."""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable, Hashable
from dataclasses import dataclass, field
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess

from ido.processes import process_context

MOST_WAITING = 20
"""Trainings of all people together."""

_POLL = 0.1
_log = logging.getLogger(__name__)


class QueueError(ValueError):
    """A training cannot be begun; the message says why and what to do."""


@dataclass(frozen=True, slots=True)
class Told:
    """How far a process is.

    Args:
        maps: learned so far, of each method.
        errors: mean training error of each method after them, in the order of `TRAINED`.
        written: whether the file holds them.
    """

    maps: int
    errors: tuple[float, ...]
    written: bool


@dataclass(slots=True, eq=False)
class QueuedJob:
    """A piece of work for a process of its own.

    Args:
        title: the cloud's name.
        work: what the process does; called there with a connection to tell by, so it must be picklable.
        maps: how many it will learn; 0 for work that is none of a person's, which gives way to trainings, and is then
            begun anew.
        expected: seconds that it should take.
        told: called with all that it tells.
        ended: called at its end; the process's own or by its death.
        owner: whose it is; None for nobody's, when its page is gone.
    """

    title: str
    work: Callable[[Connection], None]
    maps: int = 0
    expected: float = 0.0
    told: Callable[[Told], None] = lambda _: None
    ended: Callable[[QueuedJob], None] = lambda _: None
    owner: Hashable | None = None
    cancelled: bool = False
    failure: str = ""
    """Why it did not end well; empty as long as it may."""
    running: bool = False
    over: bool = False
    history: list[Told] = field(default_factory=list)
    times: list[float] = field(default_factory=list)
    """When each of the history was told, seconds."""


class TrainingQueue:
    """Runs jobs, one after the other.

    Args:
        changed: called on other threads when something of a job has changed.
    """

    def __init__(self, changed: Callable[[], None]) -> None:
        self._changed = changed
        self._jobs: list[QueuedJob] = []
        self._awake = threading.Condition()
        self._closed = False
        self._thread = threading.Thread(target=self._serve, name="trainings", daemon=True)
        self._thread.start()

    @property
    def trainings(self) -> tuple[QueuedJob, ...]:
        """Those that run or wait, in the order in which they will run."""
        return tuple(sorted((job for job in self._jobs if job.maps), key=lambda job: not job.running))

    def of(self, owner: Hashable) -> QueuedJob | None:
        """A person's training that runs or waits."""
        return next((job for job in self._jobs if job.owner == owner and job.maps), None)

    def submit(self, job: QueuedJob) -> None:
        """Have a job done as soon as it is its turn.

        Raises:
            QueueError: its owner has one already, or too many wait.
        """
        with self._awake:
            if job.maps and self.of(job.owner) is not None:
                raise QueueError("you have a training already; wait for its end, or cancel it")
            if job.maps and len(self.trainings) >= MOST_WAITING:
                raise QueueError(f"{MOST_WAITING} trainings wait already; try again later")
            self._jobs.append(job)
            self._awake.notify()
        self._changed()

    def cancel(self, job: QueuedJob) -> None:
        """End a job, or have it never begin."""
        with self._awake:
            job.cancelled = True
            waits = job in self._jobs and not job.running
            if waits:
                self._jobs.remove(job)
        if waits:
            self._end(job)

    def leave(self, owner: Hashable) -> None:
        """Keep a person's job although the page is gone; from now on everybody may cancel it."""
        with self._awake:
            for job in self._jobs:
                if job.owner == owner:
                    job.owner = None
        self._changed()

    def close(self) -> None:
        """End the running job, and begin no other."""
        with self._awake:
            self._closed = True
            self._awake.notify()
        self._thread.join()

    def _serve(self) -> None:
        while True:
            with self._awake:
                while not self._jobs and not self._closed:
                    self._awake.wait()
                if self._closed:
                    return
                job = min(self._jobs, key=lambda each: not each.maps)  # the first, trainings before the rest
                job.running = True
            self._changed()
            finished = True
            try:
                finished = self._run(job)
            except Exception as error:  # the queue must outlive whatever goes wrong with one
                _log.exception("job failed")
                job.failure = f"{type(error).__name__}: {error}"
            with self._awake:
                job.running = False
                if finished:
                    self._jobs.remove(job)
            if finished:
                self._end(job)

    def _end(self, job: QueuedJob) -> None:
        try:
            job.ended(job)
        except Exception as error:
            _log.exception("what was learned is lost")
            job.failure = f"{type(error).__name__}: {error}"
        job.over = True
        self._changed()

    def _in_the_way(self, job: QueuedJob) -> bool:
        """Whether trainings wait for what is none."""
        return not job.maps and bool(self.trainings)

    def _run(self, job: QueuedJob) -> bool:
        """Run a job in a process; whether it is over, or must be begun anew."""
        context = process_context("ido")
        here, there = context.Pipe(duplex=False)
        process = context.Process(target=_work, args=(job.work, there), name="training", daemon=True)
        process.start()
        there.close()
        with here:
            self._listen(job, here)
        stopped = job.cancelled or self._closed or self._in_the_way(job)
        if stopped:
            process.kill()
        process.join()
        if not (stopped or job.failure):
            job.failure = _death_of(process)
        return job.cancelled or not stopped

    def _listen(self, job: QueuedJob, here: Connection) -> None:
        while not (job.cancelled or self._closed or self._in_the_way(job)):
            if not here.poll(_POLL):
                continue
            try:
                told = here.recv()
            except (EOFError, OSError):  # the process has ended, one way or the other
                return
            if isinstance(told, str):
                job.failure = told
                continue
            job.history.append(told)
            job.times.append(time.monotonic())
            job.told(told)
            self._changed()


def _work(work: Callable[[Connection], None], told: Connection) -> None:
    """In the process: do the work, and tell what goes wrong."""
    try:
        work(told)
    except BaseException as error:
        told.send(f"{type(error).__name__}: {error}")
        raise SystemExit(1) from None


def _death_of(process: BaseProcess) -> str:
    """Why a process ended; empty when it ended well."""
    code = process.exitcode or 0
    if code < 0:
        return f"its process was ended from outside (signal {-code}), perhaps because memory ran out"
    return f"its process ended early (exit code {code})" if code else ""
