"""Learned maps and the file that holds them: one self-describing .npz, never a pickle."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import get_args

import numpy as np

from ido.clouds import Frame, Model
from ido.disk import write_whole
from ido.histograms import HISTOGRAMS, Histogram
from ido.npz import packed, read_arrays
from ido.perturbation import RANGES, OutlierKind
from ido.types import FloatArray

FORMAT = "ido-maps-1"
_HEADER = {"format", "histogram", "settings", "version"}


class MapsError(ValueError):
    """A maps file cannot be used; the message says why and what to do."""


@dataclass(frozen=True, slots=True, kw_only=True)
class TrainingSettings:
    """How maps are trained; the defaults are the paper's.

    Args:
        samples: number of training scenes N.
        maps: number of maps K.
        ridge: λ of the regression.
        first_ridge: λ of the first map, from which it falls to `ridge` in the middle of the maps; None for `ridge`
            everywhere. A larger one keeps few scenes from being learned by heart (docs/method.md, "Training").
        outlier_kind: kind of the training outliers.
        seed: draws the training scenes.
        rotation: largest angle of the training scenes, degrees.
        translation: longest shift of the training scenes, model units.

    Raises:
        ValueError: a value is out of range.
    """

    samples: int = 30_000
    maps: int = 30
    ridge: float = 2e-4
    first_ridge: float | None = None
    outlier_kind: OutlierKind = "uniform"
    seed: int = 0
    rotation: float = RANGES["rotation"].train[1]
    translation: float = RANGES["translation"].train[1]

    def __post_init__(self) -> None:
        if self.samples < 2 or self.maps < 1:
            raise ValueError("training needs at least 2 samples and 1 map")
        for ridge in (self.ridge, *(() if self.first_ridge is None else (self.first_ridge,))):
            if not (np.isfinite(ridge) and ridge > 0):
                raise ValueError(f"the ridge must be a positive number, not {ridge}")
        if self.outlier_kind not in get_args(OutlierKind):
            raise ValueError(f"outlier_kind must be one of {get_args(OutlierKind)}, not {self.outlier_kind!r}")
        if self.seed < 0:
            raise ValueError(f"seed must not be negative, not {self.seed}")
        for name in ("rotation", "translation"):
            if not 0 <= getattr(self, name) <= RANGES[name].high:
                raise ValueError(
                    f"{name} must lie between 0 and {RANGES[name].high:g} in training, not {getattr(self, name)}"
                )

    def ridge_of(self, k: int) -> float:
        """λ of map k, counted from 0: it falls by the same factor from map to map until the middle one."""
        if self.first_ridge is None:
            return self.ridge
        share = min(2 * k / (self.maps - 1), 1.0) if self.maps > 1 else 1.0
        return self.first_ridge ** (1 - share) * self.ridge**share

    @property
    def ranges(self) -> dict[str, tuple[float, float]]:
        """Lowest and highest value of each perturbation of the training scenes: the paper's but for the pose's."""
        own = {"rotation": (0.0, self.rotation), "translation": (0.0, self.translation)}
        return {name: own.get(name, allowed.train) for name, allowed in RANGES.items()}


@dataclass(frozen=True, slots=True, eq=False)
class TrainingCurves:
    """The training error ‖x* - x_k‖² after k = 0 .. K maps.

    Args:
        mean: shape (K + 1,).
        deviation: standard deviation over the samples, shape (K + 1,).
        translation: mean of the part in ρ, shape (K + 1,).
        rotation: mean of the part in φ, shape (K + 1,).
        residuals: x* - x_k of up to 600 random samples, shape (K + 1, n, 6), float32.
    """

    mean: FloatArray
    deviation: FloatArray
    translation: FloatArray
    rotation: FloatArray
    residuals: FloatArray

    @property
    def always_falls(self) -> bool:
        """Whether Theorem 1 held: the mean error fell at every map."""
        return bool((np.diff(self.mean) < 0).all())


@dataclass(frozen=True, slots=True, eq=False)
class Maps:
    """A trained method: everything that registering needs, and how it came to be.

    Args:
        maps: D_1 .. D_K, shape (K, 6, n_bins), float32.
        histogram: the histogram, with its model.
        frame: of the cloud it was trained on.
        settings: as trained.
        curves: the training error.
        version: of the library that trained them.
    """

    maps: FloatArray
    histogram: Histogram
    frame: Frame
    settings: TrainingSettings
    curves: TrainingCurves
    version: str

    @property
    def complete(self) -> bool:
        """False when training was interrupted before the last map."""
        return len(self.maps) == self.settings.maps

    def save(self, path: str | Path) -> None:
        """Write to one .npz; a file that is already there is replaced only when the new one is whole."""
        write_whole(path, packed(self.arrays()))

    def arrays(self) -> dict[str, np.ndarray]:
        """The arrays of the file, by name."""
        header = {
            "format": FORMAT,
            "histogram": self.histogram.name,
            "settings": asdict(self.settings),
            "version": self.version,
        }
        arrays = {
            "maps": self.maps.astype(np.float32),
            "model_points": self.histogram.model.points,
            "model_normals": self.histogram.model.normals,
            "centre": self.frame.centre,
            "scale": np.array(self.frame.scale),
            **{f"curves_{name}": values for name, values in asdict(self.curves).items()},
        }
        arrays["curves_residuals"] = self.curves.residuals.astype(np.float16)
        return {"header": np.array(json.dumps(header | {"checksum": _checksum(header, arrays)})), **arrays}

    @classmethod
    def load(cls, path: str | Path, histograms: Mapping[str, type[Histogram]] = HISTOGRAMS) -> Maps:
        """Read a file that `save` wrote.

        Args:
            path: the .npz.
            histograms: the histograms it may name; pass your own besides `HISTOGRAMS` to load maps trained on it.

        Raises:
            MapsError: missing, truncated, damaged or foreign file, or one whose parts do not fit together.
        """
        arrays, name = read_arrays(path, MapsError, "a maps file", "make one with `ido train`"), Path(path).name
        try:
            return cls.of_arrays(arrays, histograms)
        except MapsError as error:
            raise MapsError(f"{name}: {error}") from error

    @classmethod
    def of_arrays(
        cls, arrays: Mapping[str, np.ndarray], histograms: Mapping[str, type[Histogram]] = HISTOGRAMS
    ) -> Maps:
        """What `arrays` gave; others among them are left alone.

        Raises:
            MapsError: they do not fit together, or are none of ours.
        """
        try:
            return cls._of(arrays, histograms)
        except MapsError:
            raise
        except (KeyError, TypeError, ValueError, AttributeError, RecursionError) as error:
            raise MapsError(f"not a maps file of this program ({error})") from error

    @classmethod
    def _of(cls, arrays: Mapping[str, np.ndarray], histograms: Mapping[str, type[Histogram]]) -> Maps:
        header = json.loads(str(arrays["header"]))
        if header["format"] != FORMAT:
            raise MapsError(f"its format is {header['format']!r}, this program reads {FORMAT!r}")
        if header["histogram"] not in histograms:
            raise MapsError(f"its histogram {header['histogram']!r} is unknown; known: {', '.join(histograms)}")
        model = Model(_float32(arrays["model_points"]), _float32(arrays["model_normals"]))
        histogram = histograms[header["histogram"]](model)
        n_model, n_maps = len(model.points), len(arrays["maps"])
        curves = {name: arrays[f"curves_{name}"] for name in TrainingCurves.__slots__}
        shapes = {
            "model_points": (n_model, 3),
            "model_normals": (n_model, 3),
            "maps": (n_maps, 6, histogram.n_bins),
            "centre": (3,),
            "scale": (),
            **{f"curves_{name}": (n_maps + 1,) for name in curves},
            "curves_residuals": (n_maps + 1, curves["residuals"].size // (n_maps + 1) // 6, 6),
        }
        for name, shape in shapes.items():
            if arrays[name].shape != shape:
                raise MapsError(f"its {name} has the shape {arrays[name].shape}, not {shape}")
            if not np.isfinite(arrays[name]).all():
                raise MapsError(f"its {name} holds numbers that are not finite")
        if n_maps == 0 or not arrays["scale"] > 0:
            raise MapsError("it holds no maps, or no scale")
        known = {name: array for name, array in arrays.items() if name in shapes}
        checksum = header.pop("checksum", None)  # older files have none
        if set(header) != _HEADER or checksum not in (None, _checksum(header, known)):
            raise MapsError("it was changed or damaged since it was written; train the maps again, or take a copy")
        curves["residuals"] = _float32(curves["residuals"])
        return cls(
            _float32(arrays["maps"]),
            histogram,
            Frame(arrays["centre"], float(arrays["scale"])),
            TrainingSettings(**header["settings"]),
            TrainingCurves(**curves),
            str(header["version"]),
        )


def _checksum(header: Mapping[str, object], arrays: Mapping[str, np.ndarray]) -> str:
    """SHA-256 of all that a file holds, the checksum itself left out."""
    digest = hashlib.sha256(json.dumps(header, sort_keys=True).encode())
    for name in sorted(arrays):
        digest.update(f"{name} {arrays[name].dtype.str} {arrays[name].shape}".encode())
        digest.update(np.ascontiguousarray(arrays[name]).tobytes())
    return digest.hexdigest()


def _float32(array: np.ndarray) -> FloatArray:
    return array.astype(np.float32, copy=False)
