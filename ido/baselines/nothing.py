"""Doing nothing: what every method must beat."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from ido.baselines.baseline import Baseline, Record
from ido.registration import StopReason
from ido.types import DoubleArray


@dataclass(frozen=True, kw_only=True)
class Nothing(Baseline):
    """Leaves the scene where it lies."""

    title: ClassVar[str] = "Did nothing"
    max_iterations: int = 0

    def run(self, model: DoubleArray, scene: DoubleArray, record: Record) -> StopReason:
        return StopReason.CONVERGED
