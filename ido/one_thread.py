"""Importing Open3D with one thread, for results that do not depend on which of several is faster."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def on_one_processor() -> Iterator[None]:
    """Bind this thread to one processor meanwhile, where the system can do that.

    Open3D's threads are TBB's, which no variable bounds: they are as many as the processors of the process that imports
    it. So imported here for the first time in a process, it has one.
    """
    if not hasattr(os, "sched_setaffinity"):
        yield
        return
    processors = os.sched_getaffinity(0)
    os.sched_setaffinity(0, {min(processors)})
    try:
        yield
    finally:
        os.sched_setaffinity(0, processors)
