"""What a person did to a page, to take it back and to do it again."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace

from ido_viz.core.changes import still
from ido_viz.core.state import State

LONGEST = 200
"""So many changes can be taken back."""

AT_ONCE = 0.8
"""Changes within so many seconds of each other are one."""

OF_ONE_HAND = 2.5
"""The same for changes of the same thing, as of a slider that is held still for a moment."""


@dataclass(frozen=True, slots=True)
class History:
    """The states before and after the present one.

    Args:
        now: the present state.
        before: earlier ones, the latest last.
        after: what was taken back, the latest last.
        changed_at: when the present state came about, seconds.
        changed: what changed then.
        gesture: number of what the hand did when it came about; 0 for not known.
    """

    now: State
    before: tuple[State, ...] = ()
    after: tuple[State, ...] = ()
    changed_at: float = -OF_ONE_HAND
    changed: frozenset[str] = frozenset()
    gesture: int = 0

    def with_state(self, state: State, at: float, gesture: int = 0) -> History:
        """With another present state; one that only plays or steps is no change to take back.

        Args:
            state: the present one.
            at: when it came about, seconds.
            gesture: number of what the hand does, from a button or key that goes down to the next; 0 for not known.
                All that comes of one is one change, however long it takes.
        """
        if _look(state) == _look(self.now):
            return self._seen_from(state)
        changed = _differences(self.now, state)
        near = at - self.changed_at < (OF_ONE_HAND if changed == self.changed else AT_ONCE)
        if self.before and (near or 0 < gesture == self.gesture):
            return History(state, self.before, (), at, changed, gesture)
        return History(state, (*self.before, self.now)[-LONGEST:], (), at, changed, gesture)

    def _seen_from(self, state: State) -> History:
        """With a present state that looks the same; what was seen from its old view is now seen from its new one."""
        before, after = (
            tuple(replace(each, camera=state.camera) if each.camera == self.now.camera else each for each in states)
            for states in (self.before, self.after)
        )
        return replace(self, now=state, before=before, after=after)

    def undone(self) -> History:
        """With the last change taken back; itself where there is none."""
        if not self.before:
            return self
        return History(still(self.before[-1]), self.before[:-1], (*self.after, self.now))

    def redone(self) -> History:
        """With what was taken back last; itself where there is none."""
        if not self.after:
            return self
        return History(still(self.after[-1]), (*self.before, self.now), self.after[:-1])


def _differences(one: State, other: State) -> frozenset[str]:
    """What two states differ in, by the names of fields, also those of the perturbation."""
    pairs = ((one, other), (one.perturbation, other.perturbation))
    return frozenset(
        field.name for a, b in pairs for field in fields(a) if getattr(a, field.name) != getattr(b, field.name)
    ) - {"iteration", "playing", "inside", "camera"}


def _look(state: State) -> State:
    return replace(still(state), iteration=0, camera=())
