"""What an experiment found, one entry for each registration, as columns."""

from __future__ import annotations

import zipfile
from dataclasses import dataclass, fields
from pathlib import Path

import numpy as np

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

    def save(self, path: str | Path) -> None:
        """Write a compressed .npz, without pickles; scores and times are rounded to float32."""
        arrays: dict[str, np.ndarray] = {}
        for field in fields(self):
            column = getattr(self, field.name)
            if field.name in _TEXT:
                names, codes = np.unique(column, return_inverse=True)
                arrays[f"{field.name}_names"], arrays[field.name] = names.astype(str), codes.astype(np.uint16)
            else:
                arrays[field.name] = column.astype(_EXACT.get(field.name, np.float32))
        np.savez_compressed(Path(path), allow_pickle=False, **arrays)

    @classmethod
    def load(cls, path: str | Path) -> Results:
        """Read a file that `save` wrote.

        Raises:
            ResultsError: missing, damaged or foreign file.
        """
        path = Path(path)
        if not path.is_file():
            raise ResultsError(f"{path}: no such file")
        if not zipfile.is_zipfile(path):
            raise ResultsError(f"{path.name}: not a results file, or cut off")
        try:
            with np.load(path, allow_pickle=False) as file:
                return cls(*(_column(file, field.name) for field in fields(cls)))
        except Exception as error:  # zlib, zipfile and NumPy each raise their own
            raise ResultsError(f"{path.name}: damaged, or not a results file ({error})") from error


def _column(file: np.lib.npyio.NpzFile, name: str) -> np.ndarray:
    column = file[name]
    if name in _TEXT:
        return file[f"{name}_names"][column]
    return column.astype(np.int64 if column.dtype.kind == "i" else np.float64)
