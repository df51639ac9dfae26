"""When the next iteration is due while a run plays."""

from __future__ import annotations

import time

from ido_viz.core.pacing import Pacing
from ido_viz.core.run import Run

FRAME = 1 / 30
"""Seconds between frames while playing."""


class Clock:
    """Where a run that plays has got to.

    Args:
        position: where it begins, iterations.
    """

    def __init__(self, position: int) -> None:
        self.position = float(position)
        """Iterations done, with the fraction of the next."""
        self._ticked = time.perf_counter()  # up to when has been played; what lies ahead is waited for
        self._pacing: Pacing | None = None

    def follow(self, run: Run) -> None:
        """Play by the pace of another run."""
        if self._pacing is None or self._pacing.run is not run:
            self._pacing = Pacing(run)

    def start(self, position: float, wait: float = 0.0) -> None:
        """Set out from an iteration after so many seconds."""
        self.position, self._ticked = position, time.perf_counter() + wait

    @property
    def waits(self) -> bool:
        """Whether it has yet to set out."""
        return time.perf_counter() < self._ticked

    @property
    def next_frame(self) -> float:
        """Seconds until there is something new to draw."""
        return max(self._ticked + FRAME - time.perf_counter(), 0.0)

    def passed(self) -> float:
        """Seconds since it was asked last, or since it set out."""
        now = time.perf_counter()
        passed, self._ticked = max(now - self._ticked, 0.0), max(now, self._ticked)
        return passed

    def tick(self, speed: int, *, moves: bool) -> None:
        """Go on by the time that has passed since the last tick, if anything moves."""
        passed = self.passed()
        if moves and passed > 0 and self._pacing is not None:
            self.position = self._pacing.after(self.position, passed, speed)
