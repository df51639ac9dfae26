"""Turns: so many threads at once, those that wait in the order in which they came."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager

POLL = 0.1
"""Seconds between two tellings of who waits."""


class Turns:
    """Lets so many threads work at once; a semaphore does not keep the order, so that some would wait for ever.

    Args:
        at_once: how many.
    """

    def __init__(self, at_once: int) -> None:
        self._at_once = at_once
        self._at_work = 0
        self._lock = threading.Lock()
        self._waiting: deque[threading.Event] = deque()

    @contextmanager
    def turn(self, waiting: Callable[[int], None] = lambda _: None) -> Iterator[None]:
        """Wait for one's turn, and have it until the end of the block.

        Args:
            waiting: called now and then with how many come before; what it raises gives the turn up.
        """
        mine = self._begin()
        try:
            while not mine.wait(POLL):
                waiting(self._before(mine))
        except BaseException:
            self._end(mine)
            raise
        try:
            yield
        finally:
            self._end(mine)

    def _begin(self) -> threading.Event:
        mine = threading.Event()
        with self._lock:
            if self._at_work < self._at_once:
                self._at_work += 1
                mine.set()
            else:
                self._waiting.append(mine)
        return mine

    def _before(self, mine: threading.Event) -> int:
        with self._lock:
            return self._at_work + self._waiting.index(mine) if mine in self._waiting else 0

    def _end(self, mine: threading.Event) -> None:
        with self._lock:
            if not mine.is_set():  # given up
                self._waiting.remove(mine)
            elif self._waiting:
                self._waiting.popleft().set()
            else:
                self._at_work -= 1
