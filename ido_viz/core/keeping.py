"""What is kept for a while for whoever comes back for it."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Generic, TypeVar

Value = TypeVar("Value")


class Keeping(Generic[Value]):
    """Values by keys that only their owners know.

    Args:
        seconds: how long each is kept.
        drop: called with a value for which nobody has come.
    """

    def __init__(self, seconds: float, drop: Callable[[Value], None]) -> None:
        self._seconds = seconds
        self._drop = drop
        self._lock = threading.Lock()
        self._kept: dict[str, tuple[Value, threading.Timer]] = {}

    def keep(self, key: str, value: Value) -> None:
        """Keep a value; one that is kept by this key already is dropped."""
        timer = threading.Timer(self._seconds, lambda: self._end(key, value))
        timer.daemon = True
        before = self.take(key)
        with self._lock:
            self._kept[key] = (value, timer)
        timer.start()
        if before is not None:
            self._drop(before)

    def take(self, key: str) -> Value | None:
        """The value of a key, which is then no longer kept; None if there is none."""
        with self._lock:
            found = self._kept.pop(key, None)
        if found is None:
            return None
        found[1].cancel()
        return found[0]

    def clear(self) -> None:
        """Drop all."""
        for key in list(self._kept):
            value = self.take(key)
            if value is not None:
                self._drop(value)

    def _end(self, key: str, value: Value) -> None:
        with self._lock:
            if key not in self._kept or self._kept[key][0] is not value:  # taken just now
                return
            del self._kept[key]
        self._drop(value)
