"""What an experiment found, one entry for each registration, as columns."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, fields
from pathlib import Path

import numpy as np

from ido.disk import write_whole
from ido.npz import packed, read_arrays
from ido.types import FloatArray

_TEXT = ("dataset", "method", "sweep", "stop")
_EXACT = {"level": np.float64, "trial": np.int32, "iterations": np.int32, "seed": np.int64}  # others: float32


class ResultsError(ValueError):
    """A results file cannot be used; the message says why."""


@dataclass(frozen=True, slots=True, eq=False)
class Results:
    """Columns of equal length n; entry i of each is registration i.

    Args:
        dataset: name of the shape, ``bunny`` or ``urban``; str.
        method: name of the method, one of `ido.methods`; str.
        sweep: which perturbation was varied, one of `LEVELS`, or the kind of a scene beyond; str.
        level: its value; float64.
        trial: number of the scene at its level, from 0; int64.
        seed: of the scene's perturbation; int64.
        accuracy: PointAcc; float64.
        rmse: PointRMSE, model units; float64.
        rotation: rotation error, degrees; float64.
        translation: translation error, model units; float64.
        seconds: CPU time of the registration; float64.
        iterations: int64.
        stop: why it ended, a `StopReason`; str.
        probability: that its pose is right, from what the method knew; NaN where it gives none; float64.
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
    probability: FloatArray

    def __len__(self) -> int:
        return len(self.dataset)

    def where(self, **equal: str | float) -> Results:
        """The entries whose columns have these values."""
        chosen = np.ones(len(self), dtype=bool)
        for name, value in equal.items():
            chosen &= getattr(self, name) == value
        return Results(*(getattr(self, field.name)[chosen] for field in fields(self)))

    def among(self, **values: Collection[str | float]) -> Results:
        """The entries whose columns have one of these values each."""
        chosen = np.ones(len(self), dtype=bool)
        for name, its in values.items():
            chosen &= np.isin(getattr(self, name), list(its))
        return Results(*(getattr(self, field.name)[chosen] for field in fields(self)))

    @classmethod
    def merged(cls, parts: Sequence[Results]) -> Results:
        """All registrations of several results, ordered as they are named; of one that several have, the first's."""
        columns = [np.concatenate([getattr(part, field.name) for part in parts]) for field in fields(cls)]
        keys = list(zip(*(column.tolist() for column in columns[:5]), strict=True))
        first = {key: i for i, key in reversed(list(enumerate(keys)))}
        order = [first[key] for key in sorted(first)]
        return cls(*(column[order] for column in columns))

    def save(self, path: str | Path) -> None:
        """Write a compressed .npz, whole or not at all; scores and times are rounded to float32."""
        arrays: dict[str, np.ndarray] = {}
        for field in fields(self):
            column = getattr(self, field.name)
            if field.name in _TEXT:
                names, codes = np.unique(column, return_inverse=True)
                arrays[f"{field.name}_names"], arrays[field.name] = names.astype(str), codes.astype(np.uint16)
            else:
                arrays[field.name] = column.astype(_EXACT.get(field.name, np.float32))
        write_whole(path, packed(arrays))

    @classmethod
    def load(cls, path: str | Path) -> Results:
        """Read a file that `save` wrote.

        Raises:
            ResultsError: missing, damaged or foreign file.
        """
        arrays = read_arrays(
            path,
            ResultsError,
            "a results file",
            "assets/scripts/make_results.py makes one of what `ido experiment run` found",
        )
        try:
            return cls(*(_column(arrays, field.name) for field in fields(cls)))
        except (KeyError, IndexError, TypeError, ValueError) as error:
            raise ResultsError(f"{Path(path).name}: damaged, or not a results file ({error})") from error


def _column(arrays: Mapping[str, np.ndarray], name: str) -> np.ndarray:
    column = arrays[name]
    if name in _TEXT:
        return arrays[f"{name}_names"][column]
    return column.astype(np.int64 if column.dtype.kind == "i" else np.float64)
