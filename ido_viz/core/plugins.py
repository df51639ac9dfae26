"""Methods and features of the user's own: found by their names, made when they are first shown, shared by all tabs."""

from __future__ import annotations

import json
import threading
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from types import TracebackType

import numpy as np
from scipy.linalg import LinAlgError

from ido import (
    HISTOGRAMS,
    Cloud,
    Histogram,
    Maps,
    MapsError,
    Method,
    Model,
    OwnError,
    OwnMethod,
    TrainingSettings,
    Trajectory,
    train,
)
from ido.extensions import checked_histogram, find_class, histogram_class
from ido.npz import read_arrays
from ido.perturbation import OutlierKind
from ido.registration import Watch
from ido.types import FloatArray
from ido_viz.core.background import Report, Shared
from ido_viz.core.turns import POLL

QUICK = TrainingSettings(samples=1000, maps=10)
"""What maps of one's own feature are trained with when there are none: a thirtieth of the paper's scenes."""

QUICK_POINTS = 128
"""Model points of such a training, instead of 514."""

OwnClass = type[Histogram] | Callable[[Cloud], OwnMethod]
"""A feature, or what makes a method for a cloud: mostly its class."""

LoadMaps = Callable[[Path, Mapping[str, type[Histogram]]], Maps]
"""Reads a maps file that may name these histograms."""


class Own:
    """A method of one's own on one shape. It is made once, and registers one scene at a time.

    So a method that hangs keeps one thread busy, however often it is asked.

    Args:
        make: makes it; called on a thread of its own, with a function to report to.
        histogram: the feature that it is learned on, if it is known beforehand.
    """

    def __init__(self, make: Callable[[Report], OwnMethod], histogram: type[Histogram] | None = None) -> None:
        self.histogram = histogram
        self._made = Shared(make)
        self._turn = threading.Lock()

    def method(self, name: str, seen_through: Histogram, epsilon: float, max_iterations: int, report: Report) -> Method:
        """The method, made if need be; `report` is told how far that is, and what it raises ends the waiting.

        Raises:
            OwnError: what was made cannot be used.
            BaseException: what making it raised.
        """
        method = Method.own(name, self._made.get(report), seen_through, epsilon, max_iterations)

        def register(points: FloatArray, *, watch: Watch | None = None) -> Trajectory:
            while not self._turn.acquire(timeout=POLL):
                if watch:
                    watch(0)
            try:
                return method.register(points, watch=watch)
            finally:
                self._turn.release()

        return Method(method.name, method.settings, register, method.model, method.maps, method.histogram)


@dataclass(frozen=True, slots=True, eq=False)
class Learned:
    """A method that is nothing but its maps."""

    maps: Maps


@dataclass(frozen=True, slots=True, eq=False)
class Broken:
    """Stands for a class that could not be had: making it raises what went wrong."""

    error: BaseException
    traceback: TracebackType | None

    def __call__(self, _: Cloud | None = None) -> OwnMethod:
        raise self.error.with_traceback(self.traceback)  # or it would grow each time


def own_of(found: OwnClass, cloud: Callable[[], Cloud], outlier_kind: OutlierKind) -> Own:
    """A method of one's own on a shape: made by its class, or, of a feature, trained quickly."""
    if isinstance(found, type) and issubclass(found, Histogram):
        return Own(partial(_trained, found, cloud, outlier_kind), found)
    return Own(lambda report: _made(found, cloud()))


def _made(found: Callable[[Cloud], OwnMethod], cloud: Cloud) -> OwnMethod:
    method: OwnMethod | None = found(cloud)
    if method is None:
        raise OwnError(
            f"{getattr(found, '__name__', 'what makes the method')} returns nothing; it must return a method"
        )
    return method


def _trained(found: type[Histogram], cloud: Callable[[], Cloud], outlier_kind: OutlierKind, report: Report) -> Learned:
    """Maps of a feature at the size of `QUICK`."""
    settings = TrainingSettings(samples=QUICK.samples, maps=QUICK.maps, outlier_kind=outlier_kind)
    model = Model.of(cloud(), min(QUICK_POINTS, len(cloud().points)))
    histogram = checked_histogram(found(model), found.__name__)

    cannot = f"{found.__name__} cannot be trained: describe gives numbers that are not finite, or too large"

    def progress(done: int, error: float) -> None:
        if not np.isfinite(error):
            raise OwnError(cannot)
        report(f"training, map {min(done + 1, settings.maps)} of {settings.maps}")

    try:
        return Learned(train(cloud(), histogram, settings, progress=progress))
    except LinAlgError as error:
        raise OwnError(cannot) from error


def quick_name(name: str) -> str:
    """The name of a method that was trained at the size of `QUICK`, so that nobody takes it for more."""
    return f"{name} ({QUICK.samples} scenes)"


def classes_of(methods: Sequence[str], histograms: Sequence[str], taken: Collection[str]) -> dict[str, OwnClass]:
    """The classes that ``module:Class`` texts name, by the name that each is shown under: its own, if it is free.

    One that cannot be had is listed under its text; making it raises what went wrong.

    Args:
        methods: texts that name methods.
        histograms: texts that name features.
        taken: names that are in use.

    Raises:
        OwnError: a text names nothing at all, having no colon.
    """
    found: dict[str, OwnClass] = {}
    for text, find in (*((text, _method) for text in methods), *((text, _feature) for text in histograms)):
        if ":" not in text:
            raise OwnError(f"{text!r}: name a class as module:Class or path/to/file.py:Class")
        try:
            name, own = find(text)
        except (Exception, SystemExit) as error:  # whatever a module raises, it must not end the program
            name, own = text, Broken(error, error.__traceback__)
        found[text if name in taken or name in found else name] = own
    return found


def _method(text: str) -> tuple[str, OwnClass]:
    found = find_class(text)
    if issubclass(found, Histogram):
        raise OwnError(f"{text} is a histogram; give it with --histogram")
    name = getattr(found, "name", found.__name__)
    if not isinstance(name, str) or not name.strip():
        raise OwnError(f"{text}: its name must be a text, not {name!r}")
    return " ".join(name.split()), found


def _feature(text: str) -> tuple[str, OwnClass]:
    found = histogram_class(text)
    return quick_name(found.name), found


def maps_of_own(path: Path, classes: Mapping[str, OwnClass], load: LoadMaps) -> Own | None:
    """The method of a maps file that names one of these features; None when it names another one.

    It is loaded when it is shown, since that runs the feature. A name that no feature has, when one of the classes
    could not be had, is taken for that one's.

    Args:
        path: the file.
        classes: by the name that each is shown under.
        load: reads the file.
    """
    features = {c.name: c for c in classes.values() if isinstance(c, type) and issubclass(c, Histogram)}
    broken = next((c for c in classes.values() if isinstance(c, Broken)), None)
    named = _histogram_named(path)
    if named in features:
        return Own(lambda report: Learned(load(path, features)), features[named])
    if broken is None or named is None or named in HISTOGRAMS:
        return None
    return Own(lambda report: broken())


def _histogram_named(path: Path) -> str | None:
    """The name of the histogram in a maps file; None when there is none to be found."""
    try:
        named = json.loads(str(read_arrays(path, MapsError, "a maps file", "")["header"]))["histogram"]
    except (ValueError, KeyError, TypeError, RecursionError):  # loading it properly will tell what is wrong
        return None
    return named if isinstance(named, str) else None
