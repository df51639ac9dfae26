"""The experiment: which registrations are missing, the work on a few of them, and the run that shares it out."""

from __future__ import annotations

import hashlib
import math
import threading
import time
from collections.abc import Callable, Collection, Iterable
from concurrent.futures import Executor
from contextlib import suppress
from dataclasses import asdict, dataclass
from functools import cache, partial
from itertools import groupby

import numpy as np

from ido.experiments.beyond import ALL_LEVELS, BEYOND, beyond_scene, beyond_seed
from ido.experiments.families import COMPARED_METHODS
from ido.experiments.store import Key, Row, Settings
from ido.experiments.sweeps import LEVELS, level_scene
from ido.experiments.workers import share_out
from ido.global_registration import Confidence
from ido.methods import POLISHED, Method, compared, shipped_method
from ido.perturbation import Perturbation, Scene, perturb
from ido.scores import score
from ido.shipped import SHAPES, shipped_cloud

MOST_SCENES = 100
"""Scenes that a level can have. Seeds are spaced by it, so that fewer scenes are the first of them."""

SEED = 1_000_000
"""First seed of the scenes that are reported."""

FAILED = "failed"
"""Stop reason of a registration that raised an error."""

_TRIALS = 10  # of a chunk: seconds of work, and no more is lost by a kill
_one_at_a_time = threading.Lock()


@dataclass(frozen=True, slots=True)
class Chunk:
    """A few registrations of one method at one level; what a worker gets to do."""

    dataset: str
    method: str
    sweep: str
    level: float
    trials: tuple[int, ...]
    seed: int
    """First seed of the experiment."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Experiment:
    """The paper's experiment, or a part of it, or of the scenes beyond it.

    Args:
        datasets: shapes whose clouds are perturbed.
        sweeps: perturbations that are varied, or kinds of scenes beyond them.
        methods: each runs on the datasets that it has maps for.
        levels: of the sweeps, those that have them; None for all.
        scenes: scenes at each level, the same for all methods; fewer scenes are the first of more.
        seed: first seed.
        polish: whether each method runs a second time, with its last pose polished.

    Raises:
        ValueError: something is unknown or out of range, or nothing is left to run.
    """

    datasets: tuple[str, ...] = tuple(SHAPES)
    sweeps: tuple[str, ...] = tuple(LEVELS)
    methods: tuple[str, ...] = COMPARED_METHODS
    levels: tuple[float, ...] | None = None
    scenes: int = MOST_SCENES
    seed: int = SEED
    polish: bool = False

    def __post_init__(self) -> None:
        _check_names("dataset", self.datasets, SHAPES)
        _check_names("sweep", self.sweeps, ALL_LEVELS)
        _check_names("method", self.methods, COMPARED_METHODS)
        if not self.pairs:
            raise ValueError(f"no maps of {', '.join(self.methods)} are shipped for {', '.join(self.datasets)}")
        if self.levels is not None:
            _check_names(
                "level", self.levels, dict.fromkeys(level for sweep in self.sweeps for level in ALL_LEVELS[sweep])
            )
        if not 1 <= self.scenes <= MOST_SCENES:
            raise ValueError(f"scenes must lie between 1 and {MOST_SCENES}, not {self.scenes}")

    @property
    def pairs(self) -> list[tuple[str, str]]:
        """Each dataset with each method that can register it."""
        shapes = [shape for shape in SHAPES if shape in self.datasets]
        return [
            (shape, name + suffix)
            for shape in shapes
            for name in compared(shape)
            if name in self.methods
            for suffix in ("", POLISHED)[: 1 + self.polish]
        ]

    @property
    def keys(self) -> list[Key]:
        """Every registration. The first ten trials of everything come first, so that a run that is stopped early has
        something of all, and the time that is left can be told from the time that has passed."""
        levels = [
            (sweep, float(level))
            for sweep, its_levels in ALL_LEVELS.items()
            for level in its_levels
            if sweep in self.sweeps and (self.levels is None or level in self.levels)
        ]
        return [
            (dataset, method, sweep, level, trial)
            for first in range(0, self.scenes, _TRIALS)
            for sweep, level in levels
            for dataset, method in self.pairs
            for trial in range(first, min(first + _TRIALS, self.scenes))
        ]

    def missing(self, recorded: Collection[Key]) -> list[Chunk]:
        """What is to be done, in order, given what is recorded."""
        left = (key for key in self.keys if key not in recorded)
        return [
            Chunk(dataset, method, sweep, level, tuple(key[-1] for key in keys), self.seed)
            for (dataset, method, sweep, level, _), keys in groupby(left, _chunk_of)
        ]

    def dataset_settings(self) -> dict[str, Settings]:
        """How the scenes of each dataset are made, before a sweep varies them."""
        levels = {sweep: list(values) for sweep, values in LEVELS.items()}  # they decide which scenes are drawn
        return {
            shape: asdict(_base(shape))
            | {"seed": self.seed, "levels": levels, "fingerprint": _fingerprint(shipped_cloud(shape).points)}
            for shape in self.datasets
        }

    def method_settings(self) -> dict[tuple[str, str], Settings]:
        """Settings of each dataset and method, with a fingerprint of the model and maps."""
        return {pair: _settings(shipped_method(*pair)) for pair in self.pairs}


def _chunk_of(key: Key) -> Key:
    return (*key[:4], key[-1] // _TRIALS)


def _check_names(what: str, given: Collection[object], known: Collection[object]) -> None:
    if not given:
        raise ValueError(f"name at least one {what}")
    for name in given:
        if name not in known:
            raise ValueError(f"no such {what}: {name}; choose from {'; '.join(map(str, known))}")


def _base(shape: str) -> Perturbation:
    return Perturbation(outlier_kind=SHAPES[shape].outlier_kind)


def _settings(method: Method) -> Settings:
    learned = [method.maps.maps] if method.maps else []
    return {**method.settings, "fingerprint": _fingerprint(method.model.points, *learned)}


def _fingerprint(*arrays: np.ndarray) -> str:
    return hashlib.sha256(b"".join(array.tobytes() for array in arrays)).hexdigest()[:16]


def run_chunk(chunk: Chunk) -> list[Row]:
    """Make the scenes of a chunk and register each, timed; before the first of a method in this process, once untimed.

    Only one runs at a time in a process, whatever its number of threads, so that times can be compared. A method that
    raises an error has found no pose: its stop reason is `FAILED`, its accuracy 0, so that means over all scenes
    remain defined and nothing is gained by failing, and its errors are NaN.
    """
    with _one_at_a_time:
        method = _warmed_up(chunk.dataset, chunk.method)
        return [_register(chunk, trial, method) for trial in chunk.trials]


@cache
def _warmed_up(dataset: str, name: str) -> Method:
    method = shipped_method(dataset, name)
    with suppress(Exception):  # told when it happens to a scene that counts
        method.register(perturb(shipped_cloud(dataset), _base(dataset)).points)
    return method


def _register(chunk: Chunk, trial: int, method: Method) -> Row:
    scene, seed = _scene(chunk, trial)
    row = partial(Row, chunk.dataset, chunk.method, chunk.sweep, chunk.level, trial, seed)
    began = time.process_time()
    try:
        result = method.registration.run(scene.points) if method.registration else None
        track = result.trajectory if result else method.register(scene.points)
        seconds = time.process_time() - began
        found = score(scene, track.T_model_scene[-1])
        probability = Confidence.of(result).probability if result else math.nan
    except MemoryError:  # says nothing about the method
        raise
    except Exception:
        return row(0.0, math.nan, math.nan, math.nan, time.process_time() - began, 0, FAILED, math.nan)
    return row(
        float(found.accuracy),
        float(found.rmse),
        float(found.rotation),
        float(found.translation),
        seconds,
        track.iterations,
        str(track.stop),
        probability,
    )


def _scene(chunk: Chunk, trial: int) -> tuple[Scene, int]:
    """A scene and its seed."""
    if chunk.sweep in BEYOND:
        seed = beyond_seed(chunk.sweep, chunk.level, trial, MOST_SCENES, chunk.seed)
        return beyond_scene(chunk.dataset, chunk.sweep, chunk.level, seed), seed
    its = level_scene(_base(chunk.dataset), chunk.sweep, chunk.level, trial, MOST_SCENES, chunk.seed)
    return perturb(shipped_cloud(chunk.dataset), its), its.seed


def run(chunks: Iterable[Chunk], executor: Executor, in_flight: int, record: Callable[[list[Row]], None]) -> None:
    """Do chunks in any executor, and record each as soon as it is done, as `share_out` does.

    Args:
        chunks: what to do.
        executor: who does it.
        in_flight: chunks that are submitted at a time.
        record: called in this thread with the rows of a chunk.

    Raises:
        BrokenExecutor: workers were lost.
    """
    share_out(run_chunk, chunks, executor, in_flight, record)
