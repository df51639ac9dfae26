"""How a method stands: still on its way, or where it ended."""

from __future__ import annotations

from enum import StrEnum

IN_PLACE = 0.95
"""PointAcc from which a scene counts as in place."""

NEARLY_IN_PLACE = 0.5
"""PointAcc from which it counts as nearly in place."""


class Verdict(StrEnum):
    """What is said of a method at a pose; the value is how it is said."""

    COMPUTING = "computing"
    CANCELLED = "cancelled"
    FAILED = "failed"
    STARTING = "at its start"
    MOVING = "moving"
    IN_PLACE = "in place"
    NEARLY_IN_PLACE = "nearly in place"
    WRONG_POSE = "wrong pose"

    @property
    def is_open(self) -> bool:
        """Whether it is not at its end yet."""
        return self in (Verdict.STARTING, Verdict.MOVING)

    @property
    def foretold(self) -> str:
        """How it is said of an end that is not shown yet."""
        return "will end in a wrong pose" if self is Verdict.WRONG_POSE else f"will end {self}"

    @classmethod
    def at_the_end(cls, accuracy: float) -> Verdict:
        """Where a registration ended, by its PointAcc."""
        if accuracy >= IN_PLACE:
            return cls.IN_PLACE
        return cls.NEARLY_IN_PLACE if accuracy >= NEARLY_IN_PLACE else cls.WRONG_POSE
