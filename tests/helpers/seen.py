"""Waiting for what is told on other threads."""

from __future__ import annotations

import threading
from collections.abc import Callable

from tab import PATIENCE


class Seen:
    """Waits for the telling after which something is true."""

    def __init__(self) -> None:
        self._told = threading.Condition()

    def __call__(self) -> None:
        with self._told:
            self._told.notify_all()

    def wait(self, until: Callable[[], bool]) -> None:
        with self._told:
            assert self._told.wait_for(until, PATIENCE)
