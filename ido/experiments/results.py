"""What an experiment found, one entry for each registration, as columns."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from ido.types import FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Results:
    """Columns of equal length n; entry i of each is registration i.

    Args:
        dataset: name of the shape, ``bunny`` or ``urban``; str.
        method: name of the method, one of `ido.methods`; str.
        sweep: which perturbation was varied, one of `LEVELS`; str.
        level: its value; float64.
        trial: number of the scene at its level, from 0; int64.
        seed: of the scene's perturbation; int64.
        accuracy: PointAcc; float64.
        rmse: PointRMSE, model units; float64.
        rotation: rotation error, degrees; float64.
        translation: translation error, model units; float64.
        seconds: wall time of the registration; float64.
        iterations: int64.
        stop: why it ended, a `StopReason`; str.
    """

    dataset: np.ndarray
    method: np.ndarray
    sweep: np.ndarray
    level: FloatArray
    trial: np.ndarray
    seed: np.ndarray
    accuracy: FloatArray
    rmse: FloatArray
    rotation: FloatArray
    translation: FloatArray
    seconds: FloatArray
    iterations: np.ndarray
    stop: np.ndarray

    def __len__(self) -> int:
        return len(self.dataset)

    def where(self, **equal: str | float) -> Results:
        """The entries whose columns have these values."""
        chosen = np.ones(len(self), dtype=bool)
        for name, value in equal.items():
            chosen &= getattr(self, name) == value
        return Results(*(getattr(self, field.name)[chosen] for field in fields(self)))
