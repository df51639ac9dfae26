"""Work that loops without the interpreter's lock do side by side."""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import numpy as np


def in_parts(n: int, part: Callable[[int, int], object]) -> None:
    """Call `part` with the begin and the end of each part of 0 .. n, one for each processor, at the same time."""
    n_parts = min(os.cpu_count() or 1, n)
    edges = np.linspace(0, n, n_parts + 1).astype(int).tolist()
    if n_parts == 1:
        part(0, n)
    elif n_parts:
        with ThreadPoolExecutor(n_parts) as pool:
            list(pool.map(part, edges[:-1], edges[1:]))
