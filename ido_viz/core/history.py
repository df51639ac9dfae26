"""What a person did to a page, to take it back and to do it again."""

from __future__ import annotations

from dataclasses import dataclass, replace

from ido_viz.core.state import State

LONGEST = 200
"""So many changes can be taken back."""

AT_ONCE = 0.8
"""Changes within so many seconds of each other, as of a dragged slider, are one."""


@dataclass(frozen=True, slots=True)
class History:
    """The states before and after the present one.

    Args:
        now: the present state.
        before: earlier ones, the latest last.
        after: what was taken back, the latest last.
        changed_at: when the present state came about, seconds.
    """

    now: State
    before: tuple[State, ...] = ()
    after: tuple[State, ...] = ()
    changed_at: float = -AT_ONCE

    def with_state(self, state: State, at: float) -> History:
        """With another present state; one that only plays or steps is no change to take back."""
        if _still(state) == _still(self.now):
            return replace(self, now=state)
        if at - self.changed_at < AT_ONCE and self.before:
            return History(state, self.before, (), at)
        return History(state, (*self.before, self.now)[-LONGEST:], (), at)

    def undone(self) -> History:
        """With the last change taken back; itself where there is none."""
        if not self.before:
            return self
        return History(_stopped(self.before[-1]), self.before[:-1], (*self.after, self.now))

    def redone(self) -> History:
        """With what was taken back last; itself where there is none."""
        if not self.after:
            return self
        return History(_stopped(self.after[-1]), (*self.before, self.now), self.after[:-1])


def _still(state: State) -> State:
    return replace(state, iteration=0, playing=False, camera=())


def _stopped(state: State) -> State:
    return replace(state, playing=False)
