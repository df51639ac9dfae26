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
from ido.shipped import shipped_histograms, shipped_surface
from ido.types import FloatArray, IntArray
from ido_viz.core.background import Report
from ido_viz.core.from_any_start import method_from_any_start, names_from_any_start
from ido_viz.core.plugins import Own, OwnClass, maps_of_own, own_of
from ido_viz.core.state import State, StateError

OVERFITTED = "DO (500 scenes)"
"""DO trained on a sixtieth of the paper's scenes, to show what comes of it; it is in none of the experiments."""


@dataclass(frozen=True, slots=True, eq=False)
class Entry:
    """A method as a shape offers it.

    Args:
        name: as it is shown.
        quick: whether it keeps up with a slider: learned ones do, a user's own are not trusted to.
        make: makes it with a stopping rule, ε and the most iterations, which those that learn nothing do without. One
            of a user's own is made, or even trained, if it has not been yet, and so are the fields of the global one;
            the report is told how far that is, and what it raises ends it.
    """

    name: str
    quick: bool
    make: Callable[[float, int, Report], Method]


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
    surface: Callable[[], tuple[FloatArray, IntArray] | None] = lambda: None
    """Vertices and faces of its surface for the picture, model units; None for a cloud that has none."""
    seen_through: Histogram | None = None
    """How the poses of methods without a histogram are shown, where no maps are learned."""

    @property
    def methods(self) -> tuple[str, ...]:
        """Names of the methods that can register it, learned ones first."""
        return (*self.maps, *self.own, *names_from_any_start(self.maps), *BASELINES)

    @property
    def first_histogram(self) -> Histogram:
        """The histogram of the first method: how the poses of methods without one are shown, too."""
        return self.seen_through or next(iter(self.maps.values()))().histogram

    def entry(self, name: str) -> Entry | None:
        """One of its methods by name; None if it has none of this name."""
        if name in self.maps:
            return Entry(name, True, partial(_learned, name, self.maps[name]))
        if name in self.own:
            return Entry(name, False, partial(_own, name, self.own[name], self))
        if name in names_from_any_start(self.maps):
            return Entry(name, False, partial(_from_any_start, name, self))
        if name in BASELINES:
            return Entry(name, False, partial(_baseline, name, self))
        return None


def _learned(name: str, maps: Callable[[], Maps], epsilon: float, max_iterations: int, _: Report) -> Method:
    return Method.learned(name, maps(), epsilon, max_iterations)


def _own(name: str, own: Own, subject: Subject, epsilon: float, max_iterations: int, report: Report) -> Method:
    return own.method(name, subject.first_histogram, epsilon, max_iterations, report)


def _from_any_start(name: str, subject: Subject, epsilon: float, max_iterations: int, report: Report) -> Method:
    return method_from_any_start(name, subject.cloud, subject.maps, subject.first_histogram.model, report)


def _baseline(name: str, subject: Subject, epsilon: float, max_iterations: int, report: Report) -> Method:
    return Method.baseline(name, BASELINES[name], subject.first_histogram.model)


@dataclass(frozen=True, slots=True, eq=False)
class Selection:
    """What a state chooses of a library: a shape, and the methods of the left and the right pane."""

    subject: Subject
    entries: tuple[Entry, Entry]


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
            raise StateError(f"there is no shape {name!r} on this server; there are: {', '.join(self.subjects)}")
        return self.subjects[name]

    def methods(self, shape: str) -> tuple[str, ...]:
        """Names of the methods that can register a shape, learned ones first."""
        return self.subject(shape).methods

    def entry(self, shape: str, name: str) -> Entry:
        """A method by name.

        Raises:
            StateError: the shape or the method is unknown.
        """
        entry = self.subject(shape).entry(name)
        if entry is None:
            known = ", ".join(self.methods(shape))
            raise StateError(f"{name!r} cannot register {shape!r}; choose one of {known}")
        return entry

    def select(self, state: State) -> Selection:
        """The shape and the methods of a state.

        Raises:
            StateError: one of them is unknown.
        """
        left, right = (self.entry(state.shape, name) for name in (state.left, state.right))
        return Selection(self.subject(state.shape), (left, right))

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
        self.select(state)
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
            methods: by the name each is shown under: a class made with the shape's cloud (see `ido.extensions`), or a
                subclass of `ido.Histogram`, on which maps are trained at the size of `plugins.QUICK` when it
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
                    if histogram in shipped_histograms(name)
                }
                | overfitted.get(name, {}),
                shape.up,
                shape.outlier_kind,
                surface=partial(shipped_surface, name),
            )
            for name, shape in SHAPES.items()
        }
    )
