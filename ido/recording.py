"""Recorded runs: a scene, what methods made of it and what they saw, in one self-describing .npz, never a pickle."""

from __future__ import annotations

import importlib.metadata
import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from ido.clouds import Model
from ido.disk import write_whole
from ido.histograms import Histogram
from ido.npz import packed, read_arrays
from ido.perturbation import Perturbation, Scene
from ido.registration import StopReason, Trajectory
from ido.scores import Scores, score
from ido.types import FloatArray

FORMAT = "ido-run-1"

MOST_HISTOGRAMS = 200
"""Of a longer registration, histograms are recorded at this many iterations."""

_ABOUT = """\
A recorded run of IDO Explorer; in Python, ido.load_run(path) reads it. n updates, S scene points, M model points.
points (S, 3), is_outlier (S,), true_pose (4, 4): the scene and the pose that moves it onto the model, model units;
the header's `perturbation` made it, and its `moved` (6,), if there is any, is how a hand moved it after that
method0_, method1_, ...: the methods in the order of the header's `methods`; of each
  x (n + 1, 6): exponential coordinates [rho, phi] of all poses; T_model_scene (n + 1, 4, 4): the same as matrices
  update_norms (n,): size of each update; last_norm: of the one too small to be made, NaN where none was computed
  accuracy, rmse, rotation, translation (n + 1,): PointAcc, PointRMSE (model units), errors (degrees, model units)
  reference (bins,), histograms (h, bins), histogram_iterations (h,): what it saw after so many updates
  model_points, model_normals (M, 3); the header's `blocks` name the sides of the bins, M bins each, in order"""


class RunError(ValueError):
    """A recorded run or its file cannot be used; the message says why."""


@dataclass(frozen=True, slots=True, eq=False)
class RecordedMethod:
    """One method's registration of a recorded scene, with n updates; M model points.

    Args:
        name: of the method.
        settings: all of them, plain values as in JSON.
        trajectory: all poses as exponential coordinates, sizes of the updates, why it ended.
        T_model_scene: the same poses as matrices, shape (n + 1, 4, 4).
        scores: of every pose, each of shape (n + 1,).
        histogram: name of the histogram; of a baseline, which has none, the one it was watched through.
        blocks: the histogram's sides, M bins each: the first pair has the bins 0 .. 2 M - 1.
        reference: histogram of the model against itself, shape (n_bins,).
        histogram_iterations: after how many updates each histogram was recorded, rising, shape (h,).
        histograms: shape (h, n_bins).
        model: what the scene was registered onto.

    Raises:
        RunError: parts do not fit together, or hold numbers that are not finite.
    """

    name: str
    settings: Mapping[str, Any]
    trajectory: Trajectory
    T_model_scene: FloatArray
    scores: Scores
    histogram: str
    blocks: tuple[tuple[str, str], ...]
    reference: FloatArray
    histogram_iterations: np.ndarray
    histograms: FloatArray
    model: Model

    def __post_init__(self) -> None:
        n, n_recorded, n_model = self.trajectory.iterations, len(self.histogram_iterations), len(self.model.points)
        n_bins = 2 * len(self.blocks) * n_model
        _check("x", self.trajectory.x, (n + 1, 6))
        _check("update_norms", self.trajectory.update_norms, (n,))
        _check("T_model_scene", self.T_model_scene, (n + 1, 4, 4))
        for name, values in asdict(self.scores).items():
            _check(name, values, (n + 1,))
        _check("model_points", self.model.points, (n_model, 3))
        _check("model_normals", self.model.normals, (n_model, 3))
        _check("reference", self.reference, (n_bins,))
        _check("histogram_iterations", self.histogram_iterations, (n_recorded,), kind="i")
        _check("histograms", self.histograms, (n_recorded, n_bins))
        bounded = np.concatenate([[-1], self.histogram_iterations, [n + 1]])
        if not (np.diff(bounded) > 0).all():
            raise RunError(f"its histogram_iterations do not rise from 0 or more to {n} or less")
        if not isinstance(self.settings, Mapping) or _through_json(self.settings) != self.settings:
            raise RunError(f"its settings are not plain values: {self.settings!r}")

    @classmethod
    def of(
        cls, name: str, settings: Mapping[str, Any], trajectory: Trajectory, scene: Scene, histogram: Histogram
    ) -> RecordedMethod:
        """Record a registration of a scene, watched through a histogram at up to `MOST_HISTOGRAMS` iterations."""
        T_model_scene = trajectory.T_model_scene
        iterations = chosen_iterations(trajectory.iterations, MOST_HISTOGRAMS)
        return cls(
            name,
            settings,
            trajectory,
            T_model_scene,
            score(scene, T_model_scene),
            histogram.name,
            tuple(block.sides for block in histogram.blocks),
            histogram.reference,
            iterations,
            np.stack([histogram(scene.points, x) for x in trajectory.x[iterations]]),
            histogram.model,
        )


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class RecordedRun:
    """A scene and what methods made of it.

    Args:
        shape: name of the shape.
        perturbation: made the scene.
        scene: S points, which of them are outliers, and the true pose.
        methods: in the order of the panes; two panes may show the same method.
        moved: how the scene was moved by hand after that, exponential coordinates (6 numbers); empty for not at all.
        code: of the page that it was saved from, for `ido-viz --state`; empty where there was none.
        version: of the library that recorded it.

    Raises:
        RunError: parts do not fit together, or hold numbers that are not finite.
    """

    shape: str
    perturbation: Perturbation
    scene: Scene
    methods: tuple[RecordedMethod, ...]
    moved: tuple[float, ...] = ()
    code: str = ""
    version: str = field(default_factory=lambda: importlib.metadata.version("ido-explorer"))

    def __post_init__(self) -> None:
        n_points = len(self.scene.points)
        _check("points", self.scene.points, (n_points, 3))
        _check("is_outlier", self.scene.is_outlier, (n_points,), kind="b")
        _check("true_pose", self.scene.T_model_scene, (4, 4))
        if self.moved:
            _check("moved", np.array(self.moved, dtype=np.float64), (6,))

    def save(self, file: str | Path | BinaryIO) -> None:
        """Write one compressed .npz to a path or to an open binary file.

        It is written whole or not at all: a file that is already there is replaced only when the new one is whole.
        """
        header = {
            "format": FORMAT,
            "about": _ABOUT,
            "shape": self.shape,
            "perturbation": asdict(self.perturbation),
            "moved": self.moved,
            "code": self.code,
            "version": self.version,
            "methods": [_method_header(method) for method in self.methods],
        }
        arrays = {
            "header": np.array(json.dumps(header)),
            "points": self.scene.points,
            "is_outlier": self.scene.is_outlier,
            "true_pose": self.scene.T_model_scene,
        }
        for i, method in enumerate(self.methods):
            arrays |= {f"method{i}_{name}": values for name, values in _method_arrays(method).items()}
        if isinstance(file, str | Path):
            write_whole(file, packed(arrays))
        else:
            file.write(packed(arrays))


def load_run(path: str | Path) -> RecordedRun:
    """Read a file that `RecordedRun.save` or the page's button *Run (.npz)* wrote.

    Raises:
        RunError: missing, cut-off, damaged or foreign file, one of another version, or one whose parts do not fit
            together.
    """
    arrays = read_arrays(path, RunError, "a recorded run", "save one with the page's button Run (.npz)")
    name = Path(path).name
    try:
        return _run_of(arrays)
    except RunError as error:
        raise RunError(f"{name}: {error}") from error
    except (KeyError, TypeError, ValueError, AttributeError, RecursionError) as error:
        raise RunError(f"{name}: not a recorded run of this program ({error})") from error


def chosen_iterations(n: int, most: int) -> np.ndarray:
    """At most so many of the iterations 0 .. n, rising, the first and the last among them, int64.

    All where there are no more; otherwise the first half of them one by one, where poses move most, then evenly spaced.
    """
    if n < most:
        return np.arange(n + 1)
    first = np.arange(most // 2)
    return np.concatenate([first, np.linspace(len(first), n, most - len(first)).astype(np.int64)])


def _run_of(arrays: Mapping[str, np.ndarray]) -> RecordedRun:
    header = json.loads(str(arrays["header"]))
    if header["format"] != FORMAT:
        raise RunError(f"its format is {header['format']!r}, this program reads {FORMAT!r}")
    return RecordedRun(
        shape=str(header["shape"]),
        perturbation=Perturbation(**header["perturbation"]),
        scene=Scene(arrays["points"], arrays["is_outlier"], arrays["true_pose"]),
        methods=tuple(_method_of(i, entry, arrays) for i, entry in enumerate(header["methods"])),
        moved=tuple(float(value) for value in _listed(header.get("moved", []))),  # files of before have none
        code=str(header["code"]),
        version=str(header["version"]),
    )


def _listed(values: object) -> list[Any]:
    if not isinstance(values, list):
        raise RunError(f"its moved is no list: {values!r:.100}")
    return values


def _method_header(method: RecordedMethod) -> dict[str, Any]:
    return {
        "name": method.name,
        "settings": dict(method.settings),
        "stop": str(method.trajectory.stop),
        "histogram": method.histogram,
        "blocks": method.blocks,
    }


def _method_arrays(method: RecordedMethod) -> dict[str, np.ndarray]:
    return {
        "x": method.trajectory.x,
        "update_norms": method.trajectory.update_norms,
        "last_norm": np.array(method.trajectory.last_norm),
        "T_model_scene": method.T_model_scene,
        **asdict(method.scores),
        "reference": method.reference,
        "histogram_iterations": method.histogram_iterations,
        "histograms": method.histograms,
        "model_points": method.model.points,
        "model_normals": method.model.normals,
    }


def _method_of(number: int, entry: Mapping[str, Any], arrays: Mapping[str, np.ndarray]) -> RecordedMethod:
    prefix = f"method{number}_"
    own = {name.removeprefix(prefix): values for name, values in arrays.items() if name.startswith(prefix)}
    try:
        return RecordedMethod(
            str(entry["name"]),
            entry["settings"],
            Trajectory(own["x"], own["update_norms"], StopReason(entry["stop"]), float(own["last_norm"])),
            own["T_model_scene"],
            Scores(*(own[name] for name in Scores.__slots__)),
            str(entry["histogram"]),
            tuple((str(first), str(second)) for first, second in entry["blocks"]),
            own["reference"],
            own["histogram_iterations"],
            own["histograms"],
            Model(own["model_points"], own["model_normals"]),
        )
    except RunError as error:
        raise RunError(f"method {number}: {error}") from error


def _check(name: str, values: np.ndarray, shape: tuple[int, ...], kind: str = "f") -> None:
    if values.dtype.kind != kind or values.shape != shape:
        wanted = {"f": "floating-point numbers", "i": "whole numbers", "b": "truth values"}[kind]
        raise RunError(f"its {name} holds {values.dtype} of the shape {values.shape}, not {wanted} of {shape}")
    if kind == "f" and not np.isfinite(values).all():
        raise RunError(f"its {name} holds numbers that are not finite")


def _through_json(settings: Mapping[str, Any]) -> object:
    try:
        return json.loads(json.dumps(dict(settings)))
    except (TypeError, ValueError):
        return None
