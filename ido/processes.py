"""How processes of one's own begin: with the program loaded already, where the system can do that."""

from __future__ import annotations

import multiprocessing
import os
import sys
import tempfile
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from multiprocessing.context import ForkServerContext, SpawnContext  # Windows has one of them

_LONGEST_FOLDER = 70
"""Bytes of the path of the folder for temporary files; it has a socket in it, whose path has 107 at most."""


def process_context(loaded: str) -> ForkServerContext | SpawnContext:
    """What begins processes that have nothing of this one but what they are given.

    On Linux, as by default in Python from 3.14 on, they are forked from a process that does nothing else and has loaded
    the program once for all of them: the module that was asked for first.

    Args:
        loaded: name of the module that they need.
    """
    if sys.platform != "linux" or len(os.fsencode(tempfile.gettempdir())) > _LONGEST_FOLDER:
        return multiprocessing.get_context("spawn")
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload([loaded])
    return context
