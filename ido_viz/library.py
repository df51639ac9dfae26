"""The shapes that a page offers, each with the methods that can register it: its learned maps, and all baselines."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache, partial
from pathlib import Path

import numpy as np

from ido import SHAPES, Cloud, Histogram, Maps, load_cloud, shipped_cloud, shipped_maps
from ido.methods import BASELINES, LEARNED, Method
from ido.perturbation import OutlierKind
from ido_viz.state import State, StateError

OVERFITTED = "DO (500 scenes)"
"""DO trained on a sixtieth of the paper's scenes, to show what comes of it; it is in none of the experiments."""


@dataclass(frozen=True, slots=True, eq=False)
class Subject:
    """A shape to register: its cloud and the maps learned for it are loaded when they are first asked for.

    All maps of a shape share their model, and baselines register onto it too.
    """

    title: str
    cloud: Callable[[], Cloud]
    maps: Mapping[str, Callable[[], Maps]]
    up: tuple[float, float, float] = (0.0, 0.0, 1.0)
    outlier_kind: OutlierKind = "uniform"


@dataclass(frozen=True, slots=True, eq=False)
class Library:
    """All subjects by name."""

    subjects: Mapping[str, Subject]

    def subject(self, name: str) -> Subject:
        """A subject by name.

        Raises:
            StateError: there is none of this name.
        """
        if name not in self.subjects:
            raise StateError(f"unknown shape {name!r}; known: {', '.join(self.subjects)}")
        return self.subjects[name]

    def methods(self, shape: str) -> tuple[str, ...]:
        """Names of the methods that can register a shape, learned ones first."""
        return (*self.subject(shape).maps, *BASELINES)

    def method(self, state: State, name: str) -> Method:
        """A method for the state's shape, with the state's stopping rule where it is a learned one.

        Raises:
            StateError: the shape or the method is unknown.
        """
        subject = self.subject(state.shape)
        if name in subject.maps:
            return Method.learned(name, subject.maps[name](), state.epsilon, state.max_iterations)
        if name in BASELINES:
            return Method.baseline(name, BASELINES[name], self.first_histogram(state.shape).model)
        known = ", ".join(self.methods(state.shape))
        raise StateError(f"{name!r} cannot register {state.shape!r}; choose one of {known}")

    def quick(self, shape: str, name: str) -> bool:
        """Whether a method keeps up with a slider: the learned ones do."""
        return name in self.subject(shape).maps

    def first_histogram(self, shape: str) -> Histogram:
        """The histogram of a shape's first method: how a baseline's poses are shown, too."""
        return next(iter(self.subject(shape).maps.values()))().histogram

    def at_shape(self, state: State, shape: str) -> State:
        """A state for another shape, with the outliers that suit it and methods that can register it."""
        subject, known = self.subject(shape), self.methods(shape)
        return replace(
            state,
            shape=shape,
            left=state.left if state.left in known else known[0],
            right=state.right if state.right in known else known[1],
            perturbation=replace(state.perturbation, outlier_kind=subject.outlier_kind),
        )

    def checked(self, state: State) -> State:
        """The state itself, when its shape and both its methods are known.

        Raises:
            StateError: one of them is not.
        """
        for method in (state.left, state.right):
            if method not in self.methods(state.shape):
                raise StateError(f"{method!r} cannot register {state.shape!r} here")
        return state

    def with_own(self, cloud: Path, maps: Sequence[Path]) -> tuple[Library, str]:
        """This library and a user's cloud, registered by the user's maps; and the name the cloud got.

        Raises:
            CloudError: the cloud cannot be used.
            MapsError: a maps file cannot be used.
            StateError: maps were trained on another cloud.
        """
        own = Cloud.of(load_cloud(cloud))
        learned: dict[str, Callable[[], Maps]] = {}
        for path in maps:
            loaded = Maps.load(path)
            same_place = np.allclose(loaded.frame.centre, own.frame.centre, atol=1e-3 * own.frame.scale)
            if not (same_place and np.isclose(loaded.frame.scale, own.frame.scale, rtol=1e-3)):
                raise StateError(f"{path.name} was trained on another cloud than {cloud.name}; train maps on it first")
            learned[path.stem] = partial(_maps_itself, loaded)
        subject = Subject(cloud.name, lambda: own, learned)
        name = cloud.stem if cloud.stem not in self.subjects else f"{cloud.stem} (your own)"
        return Library({**self.subjects, name: subject}), name


def _maps_itself(maps: Maps) -> Maps:
    return maps


@cache
def shipped_library() -> Library:
    """The shapes and methods that ship with the program."""
    overfitted = {"bunny": {OVERFITTED: partial(shipped_maps, "bunny", "front-back-500")}}
    return Library(
        {
            name: Subject(
                shape.title,
                partial(shipped_cloud, name),
                {
                    method: partial(shipped_maps, name, histogram)
                    for method, histogram in LEARNED.items()
                    if histogram in shape.histograms
                }
                | overfitted.get(name, {}),
                shape.up,
                shape.outlier_kind,
            )
            for name, shape in SHAPES.items()
        }
    )
