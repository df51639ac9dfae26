"""Methods and features of one's own: what a class must bring, how it is found, and how its updates are iterated.

A **method** is any class that is made with a cloud, ``Mine(cloud)``, and has either `update` (see `UpdateMethod`) or
`maps` (see `LearnedMethod`). A **feature** is a subclass of `ido.Histogram`. Neither needs to be registered anywhere:
the commands take ``module:Class``, and `ido.Method.own` takes the object itself.
"""

from __future__ import annotations

import importlib
import sys
from pathlib import Path
from typing import Protocol

import numpy as np

from ido.blocks import Block
from ido.histograms import HISTOGRAMS, Histogram, finite
from ido.maps import Maps
from ido.registration import EPSILON, MAX_ITERATIONS, Trajectory, Watch, iterate
from ido.types import DoubleArray, FloatArray


class OwnError(ValueError):
    """A method or feature of one's own cannot be used; the message names it and says why."""


class UpdateMethod(Protocol):
    """A method that says how the pose changes. The program iterates, records every pose, and stops.

    The class is made with the normalised cloud of the shape (`ido.Cloud`) that scenes are registered onto, once for
    each shape; `update` is then never called by two threads at once. It may have, besides:

    - ``name``, a text: as it is shown; the class's own name unless given;
    - ``histogram``, an `ido.Histogram`: what its poses are seen through; the shape's first one unless given.
    """

    def update(self, points: FloatArray, x: FloatArray, /) -> FloatArray:
        """The change Δx of the pose, shape (6,); the next one is x + Δx, unless ‖Δx‖ < ε ends the registration.

        Args:
            points: the scene where it lies, shape (S, 3), float64, model units, read-only;
                ``ido.poses.transform(ido.poses.exp(x), points)`` is where it is now.
            x: exponential coordinates [ρ, φ] of T_model_scene, shape (6,), float64. All zeros begin a registration.
        """
        ...


class LearnedMethod(Protocol):
    """A method that walks maps, as DO does: they are all it needs. It may have a ``name``, as `UpdateMethod` may.

    Where its class trains them itself, with `ido.train`, it does so when it is made with the cloud.
    """

    @property
    def maps(self) -> Maps:
        """The maps, in the frame of the cloud."""
        ...


OwnMethod = UpdateMethod | LearnedMethod


def register_updates(
    own: UpdateMethod,
    points: FloatArray,
    *,
    name: str = "",
    epsilon: float = EPSILON,
    max_iterations: int = MAX_ITERATIONS,
    watch: Watch | None = None,
) -> Trajectory:
    """Register one scene, points (S, 3) in model units, by x ← x + Δx from where it lies until ‖Δx‖ < ε.

    docs/method.md, Eq. 16.

    Args:
        own: gives the updates.
        points: the scene.
        name: of the method, for messages; its class's name unless given.
        epsilon: an update shorter than this is not made any more.
        max_iterations: so many updates at most.
        watch: called after each with how many there were; what it raises ends the registration.

    Raises:
        OwnError: an update is not 6 finite numbers.
        ValueError: coordinates are not finite.
    """
    name = name or type(own).__name__
    points = finite(points).astype(np.float64)
    points.flags.writeable = False  # or a method that moves them in place would spoil its next update

    def update(here: DoubleArray, done: int) -> DoubleArray:
        return _checked_update(own.update(points, here.copy()), name, done)

    return iterate(update, epsilon=epsilon, max_iterations=max_iterations, watch=watch)


def checked_histogram(histogram: object, name: str) -> Histogram:
    """The histogram, when its blocks and its reference fit together.

    Raises:
        OwnError: it is none, or its blocks or its `describe` do not fit.
    """
    if not isinstance(histogram, Histogram):
        raise OwnError(f"{name}: its histogram must be an ido.Histogram, not {histogram!r}")
    blocks = histogram.blocks
    if not (isinstance(blocks, tuple) and blocks and all(isinstance(block, Block) for block in blocks)):
        raise OwnError(f"{name}: blocks must be a tuple of ido.Block, as (ido.Block('front', 'back'),), not {blocks!r}")
    if any(type(side) is not str for block in blocks for side in block.sides):
        raise OwnError(f"{name}: the sides of its blocks must be named by texts, not {blocks!r}")
    reference = histogram.reference
    if reference.shape != (histogram.n_bins,):
        expected = f"({histogram.n_bins},), 2 bins for each block and model point"
        raise OwnError(f"{name}: describe gives the shape {reference.shape}; its blocks need {expected}")
    if not np.isfinite(reference).all():
        raise OwnError(f"{name}: describe gives numbers that are not finite")
    return histogram


def find_class(text: str) -> type:
    """The class that ``module:Class`` or ``path/to/file.py:Class`` names; modules are looked for here first.

    Raises:
        OwnError: the text, the file or the class is not there; and whatever importing the module raises.
    """
    module_name, _, class_name = text.rpartition(":")
    if not module_name or not class_name.isidentifier():
        raise OwnError(f"{text!r}: name a class as module:Class or path/to/file.py:Class")
    file = Path(module_name).resolve() if module_name.endswith(".py") else None
    if file and not file.is_file():
        raise OwnError(f"{module_name}: no such file")
    folder, name = (str(file.parent), file.stem) if file else (str(Path.cwd()), module_name)
    if folder not in sys.path:
        sys.path.insert(0, folder)
    importlib.invalidate_caches()
    try:
        module = importlib.import_module(name)
    except ModuleNotFoundError as error:
        if error.name and (name == error.name or name.startswith(f"{error.name}.")):  # not one that it imports
            raise OwnError(f"there is no module {name}, neither here ({folder}) nor installed") from error
        raise
    if file and Path(module.__file__ or "").resolve() != file:
        raise OwnError(f"{module_name}: another module is called {name}; give the file another name")
    if not hasattr(module, class_name):
        raise OwnError(f"{module_name} has no {class_name}")
    found = getattr(module, class_name)
    if not isinstance(found, type):
        raise OwnError(f"{text} is no class")
    return found


def histogram_class(text: str) -> type[Histogram]:
    """A histogram by its name, as ``front-back``, or one of one's own as ``module:Class``.

    Raises:
        OwnError: there is none, or it cannot be used; and whatever importing the module raises.
    """
    if text in HISTOGRAMS:
        return HISTOGRAMS[text]
    if ":" not in text:
        raise OwnError(f"unknown histogram {text!r}; known: {', '.join(HISTOGRAMS)}, or your own as module:Class")
    found = find_class(text)
    if not issubclass(found, Histogram):
        raise OwnError(f"{text} is no subclass of ido.Histogram")
    name = getattr(found, "name", None)
    if not isinstance(name, str) or not name:
        raise OwnError(f"{text} needs a name, a text")
    if name in HISTOGRAMS:
        raise OwnError(f"{text}: the name {name!r} is taken; maps files would mean the other one")
    return found


def _checked_update(update: object, name: str, done: int) -> DoubleArray:
    try:
        values = np.asarray(update, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise OwnError(f"{name}: update {done + 1} is not 6 numbers but {type(update).__name__}") from error
    if values.shape != (6,):
        raise OwnError(f"{name}: update {done + 1} has the shape {values.shape}, not (6,)")
    if not np.isfinite(values).all():
        raise OwnError(f"{name}: update {done + 1} is not finite: {values}")
    return values
