"""Who does much work: processes on this machine, or a Dask cluster; and how it is shared out among them."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import (
    FIRST_COMPLETED,
    BrokenExecutor,
    CancelledError,
    Executor,
    Future,
    ProcessPoolExecutor,
    wait,
)
from contextlib import AbstractContextManager, contextmanager
from itertools import islice
from typing import TypeVar

from threadpoolctl import threadpool_limits

from ido.processes import process_context

Task = TypeVar("Task")
Result = TypeVar("Result")

_ONE_THREAD = {
    f"{library}_NUM_THREADS": "1" for library in ("OMP", "OPENBLAS", "MKL", "BLIS", "VECLIB", "NUMEXPR", "NUMBA")
}
_DASK_CHUNKS = 1000  # in flight, enough for any cluster; they are small, and cancelled at once


def executor_of(workers: int | None, dask: str | None) -> AbstractContextManager[tuple[Executor, int]]:
    """The executor that was asked for, and how many tasks to have in flight: a process for each core unless told.

    Raises:
        ValueError: both were asked for.
    """
    if dask is None:
        return local_executor(os.cpu_count() or 1 if workers is None else workers)
    if workers is not None:
        raise ValueError("--workers is for this machine; a Dask cluster brings its own")
    return dask_executor(dask)


def share_out(
    work: Callable[[Task], Result],
    tasks: Iterable[Task],
    executor: Executor,
    in_flight: int,
    record: Callable[[Result], None],
) -> None:
    """Do tasks in any executor, and record each result as soon as it is there.

    When it is stopped by Ctrl-C or an error, it does not begin any more, but waits for those that are being worked on
    and records them.

    Args:
        work: what is done with a task.
        tasks: what it is done with.
        executor: who does it.
        in_flight: tasks that are submitted at a time.
        record: called in this thread with each result.

    Raises:
        BrokenExecutor: workers were lost.
    """
    left = iter(tasks)
    submitted: set[Future[Result]] = set()
    try:
        while True:
            for task in islice(left, in_flight - len(submitted)):
                submitted.add(executor.submit(work, task))
            if not submitted:
                return
            for future in wait(submitted, return_when=FIRST_COMPLETED).done:
                record(future.result())
                submitted.remove(future)
    finally:
        running = [future for future in submitted if not future.cancel()]
        for future in wait(running).done:
            if not future.exception():
                record(future.result())


@contextmanager
def local_executor(workers: int) -> Iterator[tuple[Executor, int]]:
    """Processes on this machine, of one thread each, and how many chunks to have in flight."""
    with ProcessPoolExecutor(workers, process_context("ido"), _begin_in_one_thread) as pool:
        try:
            yield pool, 2 * workers
        finally:
            pool.shutdown(cancel_futures=True)


def _begin_in_one_thread() -> None:
    become_worker()
    os.environ.update(_ONE_THREAD)  # for libraries that are not loaded yet
    threadpool_limits(1)


def become_worker() -> None:
    """In a process: leave Ctrl-C to its parent, and end with it."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C reaches every process; only the parent acts on it
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    """A worker whose parent was killed would wait for work for ever."""
    if parent := multiprocessing.parent_process():
        parent.join()
        os._exit(1)


@contextmanager
def dask_executor(address: str) -> Iterator[tuple[Executor, int]]:
    """The workers of a Dask cluster, and how many chunks to have in flight.

    Raises:
        ValueError: the package `distributed` is not installed.
        OSError: there is no cluster at this address.
        BrokenExecutor: the cluster was lost, or the same chunk ended several workers.
    """
    try:
        from distributed import Client, KilledWorker
    except ImportError as error:
        raise ValueError("a Dask cluster needs one more package: pip install 'ido-explorer[dask]'") from error
    with Client(address) as client:
        try:
            yield client.get_executor(pure=False), _DASK_CHUNKS
        except (KilledWorker, CancelledError) as error:
            raise BrokenExecutor(f"the Dask cluster did not finish its work: {error}") from error
