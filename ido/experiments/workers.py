"""Who does the work of an experiment: processes on this machine, or a Dask cluster."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections.abc import Iterator
from concurrent.futures import BrokenExecutor, CancelledError, Executor, ProcessPoolExecutor
from contextlib import contextmanager

_ONE_THREAD = {
    f"{library}_NUM_THREADS": "1" for library in ("OMP", "OPENBLAS", "MKL", "BLIS", "VECLIB", "NUMEXPR", "NUMBA")
}
_DASK_CHUNKS = 1000  # in flight, enough for any cluster; they are small, and cancelled at once


@contextmanager
def local_executor(workers: int) -> Iterator[tuple[Executor, int]]:
    """Processes on this machine, of one thread each, and how many chunks to have in flight."""
    before = {name: os.environ.get(name) for name in _ONE_THREAD}
    os.environ.update(_ONE_THREAD)  # read by the libraries as a worker imports them
    spawn = multiprocessing.get_context("spawn")
    try:
        with ProcessPoolExecutor(workers, mp_context=spawn, initializer=_become_worker) as pool:
            yield pool, 2 * workers
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value


def _become_worker() -> None:
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
