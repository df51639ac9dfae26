"""The shapes that a page offers, each with the methods that can register it: its learned maps, and all baselines."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache, partial
from pathlib import Path

import numpy as np

from ido import HISTOGRAMS, SHAPES, Cloud, FrontBack, Histogram, Maps, Model, load_cloud, shipped_cloud, shipped_maps
from ido.clouds import MODEL_POINTS
from ido.methods import BASELINES, LEARNED, Method
from ido.perturbation import OutlierKind
from ido_viz.background import Report
from ido_viz.plugins import Own, OwnClass, maps_of_own, own_of
from ido_viz.state import State, StateError

OVERFITTED = "DO (500 scenes)"
"""DO trained on a sixtieth of the paper's scenes, to show what comes of it; it is in none of the experiments."""


@dataclass(frozen=True, slots=True, eq=False)
class Subject:
    """A shape to register: its cloud and the maps learned for it are loaded when they are first asked for.

    All these maps of a shape share their model, and baselines register onto it too. `own` are a user's methods.
    """

    title: str
    cloud: Callable[[], Cloud]
    maps: Mapping[str, Callable[[], Maps]]
    up: tuple[float, float, float] = (0.0, 0.0, 1.0)
    outlier_kind: OutlierKind = "uniform"
    own: Mapping[str, Own] = field(default_factory=dict)
    seen_through: Histogram | None = None
    """How the poses of methods without a histogram are shown, where no maps are learned."""


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
        subject = self.subject(shape)
        return (*subject.maps, *subject.own, *BASELINES)

    def method(self, state: State, name: str, report: Report | None = None) -> Method:
        """A method for the state's shape, with the state's stopping rule unless it is a baseline.

        One of a user's own is made, or even trained, if it has not been yet; `report` is told how far that is.

        Raises:
            StateError: the shape or the method is unknown.
            BaseException: what making a user's own method raised, and what `report` raises.
        """
        subject = self.subject(state.shape)
        if name in subject.maps:
            return Method.learned(name, subject.maps[name](), state.epsilon, state.max_iterations)
        if name in subject.own:
            seen_through = self.first_histogram(state.shape)
            return subject.own[name].method(
                name, seen_through, state.epsilon, state.max_iterations, report or (lambda _: None)
            )
        if name in BASELINES:
            return Method.baseline(name, BASELINES[name], self.first_histogram(state.shape).model)
        raise self._unknown(state.shape, name)

    def _unknown(self, shape: str, name: str) -> StateError:
        known = ", ".join(self.methods(shape))
        return StateError(f"{name!r} cannot register {shape!r}; choose one of {known}")

    def quick(self, shape: str, name: str) -> bool:
        """Whether a method keeps up with a slider: the shape's learned ones do, a user's own are not trusted to.

        Raises:
            StateError: the shape or the method is unknown.
        """
        if name not in self.methods(shape):
            raise self._unknown(shape, name)
        return name in self.subject(shape).maps

    def first_histogram(self, shape: str) -> Histogram:
        """The histogram of a shape's first method: how the poses of methods without one are shown, too."""
        subject = self.subject(shape)
        return subject.seen_through or next(iter(subject.maps.values()))().histogram

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

    def with_own(
        self, cloud: Path, maps: Sequence[Path], classes: Mapping[str, OwnClass] | None = None
    ) -> tuple[Library, str]:
        """This library and a user's cloud, registered by the user's maps; and the name the cloud got.

        Args:
            cloud: its file.
            maps: files that `ido train` made of it.
            classes: the user's own, by name; maps may be of the features among them.

        Raises:
            CloudError: the cloud cannot be used.
            MapsError: a maps file cannot be used.
            StateError: maps were trained on another cloud.
        """
        own_cloud = Cloud.of(load_cloud(cloud))

        def loaded(path: Path, histograms: Mapping[str, type[Histogram]] = HISTOGRAMS) -> Maps:
            maps = Maps.load(path, histograms)
            same_place = np.allclose(maps.frame.centre, own_cloud.frame.centre, atol=1e-3 * own_cloud.frame.scale)
            if not (same_place and np.isclose(maps.frame.scale, own_cloud.frame.scale, rtol=1e-3)):
                raise StateError(f"{path.name} was trained on another cloud than {cloud.name}; train maps on it first")
            return maps

        learned: dict[str, Callable[[], Maps]] = {}
        own: dict[str, Own] = {}
        for path in maps:
            of_feature = maps_of_own(path, classes or {}, loaded)
            if of_feature is not None:
                own[path.stem] = of_feature
            else:
                learned[path.stem] = partial(_maps_itself, loaded(path))
        seen_through = None
        if not learned:
            seen_through = FrontBack(Model.of(own_cloud, min(MODEL_POINTS, len(own_cloud.points))))
        subject = Subject(cloud.name, lambda: own_cloud, learned, own=own, seen_through=seen_through)
        name = cloud.stem if cloud.stem not in self.subjects else f"{cloud.stem} (your own)"
        return Library({**self.subjects, name: subject}), name

    def with_methods(self, methods: Mapping[str, OwnClass]) -> Library:
        """This library with methods of one's own on every shape.

        Args:
            methods: by the name each is shown under: a class made with the shape's cloud (see `ido.own`), or a
                subclass of `ido.Histogram`, on which maps are trained at the size of `ido_viz.plugins.QUICK` when it
                is first shown, unless the shape has maps of it already.

        Raises:
            StateError: a name is taken.
        """
        subjects = {}
        for shape, subject in self.subjects.items():
            taken = [name for name in methods if name in self.methods(shape)]
            if taken:
                raise StateError(f"there is a method called {taken[0]!r} already")
            trained = {own.histogram for own in subject.own.values()} - {None}
            added = {
                name: own_of(found, subject.cloud, subject.outlier_kind)
                for name, found in methods.items()
                if found not in trained
            }
            subjects[shape] = replace(subject, own={**subject.own, **added})
        return Library(subjects)


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
