"""Every method by name: those of the paper, ready to register scenes of a shipped shape."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from functools import cache, partial
from typing import Protocol, cast

import numpy as np

from ido import poses
from ido.baselines import BCPD, CPD, ICP, KCCE, Baseline, GMMReg, Nothing
from ido.clouds import Model
from ido.extensions import LearnedMethod, OwnError, OwnMethod, UpdateMethod, checked_histogram, register_updates
from ido.global_registration import GlobalModel, GlobalRegistration, GlobalSettings, ManyStarts, polish
from ido.histograms import Histogram
from ido.maps import Maps
from ido.peers import FGR, GICP, KISS, RANSAC, Peer
from ido.peers.peer import register_once
from ido.registration import EPSILON, MAX_ITERATIONS, Trajectory, Watch, register
from ido.shipped import SHAPES, shipped_cloud, shipped_histograms, shipped_maps
from ido.types import FloatArray

LEARNED: dict[str, str] = {
    "DO": "front-back",
    "Improved DO": "triple-binary",
    "Improved DO (as printed)": "as-printed",
    "Improved DO (near / far)": "quadruple-binary",
}
"""Name of each learned method, and of the histogram that its maps are trained on."""

_TUNED: tuple[Baseline, ...] = (
    ICP(cutoff=0.3),
    CPD(normalisation="together", start=0.1, outliers=0.9),
    BCPD(start=0.2, outliers=0.3),
    GMMReg(normalisation="together", sigmas=(0.2, 0.1), evaluations=(100, 100)),
    KCCE(start=0.25),
)

BASELINES: dict[str, Baseline] = {
    Nothing.title: Nothing(),
    **{f"{b.title}, default": b for b in (ICP(), CPD(), BCPD(), GMMReg(), KCCE())},
    **{f"{b.title}, tuned": b for b in _TUNED},
}
"""Every baseline by name: with its authors' settings, and with settings that `ido experiment tune` chose."""


FROM_ANY_START: dict[str, GlobalSettings] = {
    "Global": GlobalSettings(),
    "Global (no cut plane)": GlobalSettings(cut_plane=False),
    "Global (no ball)": GlobalSettings(ball=False),
    "Global (volume unknown)": GlobalSettings(known_volume=False),
    "Global (plain)": GlobalSettings(cut_plane=False, ball=False, known_volume=False),
}
"""The global method by name: with all that it assumes of a scene, without each part of it, and without all."""

MANY_STARTS: dict[str, str] = {f"{name}, many starts": name for name in ("DO", "Improved DO")}
"""Learned methods from many starts, and which one each is."""

_TUNED_PEERS: tuple[Peer, ...] = (
    RANSAC(voxel=0.125, normal_gain=3.0),
    FGR(voxel=0.1, normal_gain=3.0),
    GICP(downsampling=0.07, cutoff=0.3),
    KISS(voxel=0.1, normal_gain=4.0, feature_gain=8.0),
)

PEERS: dict[str, Peer] = {
    **{f"{peer.title}, default": peer for peer in (RANSAC(), FGR(), GICP(), KISS())},
    **{f"{peer.title}, tuned": peer for peer in _TUNED_PEERS},
}
"""What people use today instead, by name: as its library has it, and with settings that `ido experiment tune` chose."""

POLISHED = ", polished"
"""Ends the name of any method whose last pose `ido.polish` has made better."""


class Registers(Protocol):
    """Registers one scene, points (S, 3) in model units, from where it lies."""

    def __call__(self, points: FloatArray, *, watch: Watch | None = None) -> Trajectory: ...


@dataclass(frozen=True, slots=True, eq=False)
class Method:
    """Something that registers scenes onto one model.

    Args:
        name: as it is shown.
        settings: all of them, plain values.
        register: registers one scene.
        model: what scenes are registered onto.
        maps: what was learned; None for a method that learns nothing.
        histogram: what its poses are seen through; None for a baseline, which has none of its own.
        registration: what tells all that was tried, of a method that registers from any start; None for others.
    """

    name: str
    settings: Mapping[str, object]
    register: Registers
    model: Model
    maps: Maps | None = None
    histogram: Histogram | None = None
    registration: GlobalRegistration | None = None

    @classmethod
    def learned(cls, name: str, maps: Maps, epsilon: float = EPSILON, max_iterations: int = MAX_ITERATIONS) -> Method:
        """The method that walks maps."""
        settings = {"histogram": maps.histogram.name, "epsilon": epsilon, "max_iterations": max_iterations}
        run = partial(register, maps, epsilon=epsilon, max_iterations=max_iterations)
        return cls(name, settings, run, maps.histogram.model, maps, maps.histogram)

    @classmethod
    def baseline(cls, name: str, baseline: Baseline, model: Model) -> Method:
        """A baseline on a model."""
        return cls(name, baseline.settings, partial(baseline.register, model.points), model)

    @classmethod
    def peer(cls, name: str, peer: Peer, cloud: FloatArray, model: Model) -> Method:
        """A peer, made ready for a cloud (N, 3) in model units; what it finds is shown on a model.

        Raises:
            PeerError: its library is not installed.
        """
        return cls(name, peer.settings, partial(register_once, peer.title, peer.onto(cloud)), model)

    @classmethod
    def from_any_start(
        cls, name: str, registration: GlobalRegistration, model: Model, maps: Maps | None = None
    ) -> Method:
        """The global method, or a learned one from many starts.

        Args:
            name: as it is shown.
            registration: with the starts that the maps lead to, where there are any.
            model: what its result is shown on, and what other methods register onto.
            maps: that the starts walk.
        """
        settings = {**asdict(registration.settings), "rotations": len(registration.model.search.rotations)}
        histogram = maps.histogram if maps else None
        return cls(name, settings, registration.register, model, maps, histogram, registration)

    def polished(self, model: GlobalModel) -> Method:
        """The same method, whose last pose `ido.polish` makes better."""

        def run(points: FloatArray, *, watch: Watch | None = None) -> Trajectory:
            track = self.register(points, watch=watch)
            last = track.T_model_scene[-1]
            end = polish(model, points, last)
            step = np.linalg.norm(poses.log(end @ poses.invert(last)))
            x, norms = np.vstack([track.x, poses.log(end)]), np.append(track.update_norms, step)
            return Trajectory(x, norms, track.stop, np.nan)

        settings = {**self.settings, "polished": True}
        return replace(self, name=self.name + POLISHED, settings=settings, register=run, registration=None)

    @classmethod
    def own(
        cls,
        name: str,
        own: OwnMethod,
        histogram: Histogram,
        epsilon: float = EPSILON,
        max_iterations: int = MAX_ITERATIONS,
    ) -> Method:
        """A method of one's own, by its maps or by its updates; see `ido.extensions`.

        Args:
            name: as it is shown.
            own: has either `maps` or `update`.
            histogram: what the poses of a method that has no histogram of its own are seen through.
            epsilon: it stops once an update is shorter than this.
            max_iterations: it makes so many updates at most.

        Raises:
            OwnError: it has neither or both, or what it has cannot be used.
        """
        has = {"maps", "update"} & set(dir(own))  # dir: a property that fails must tell why itself
        if len(has) != 1:
            found = "both" if has else "neither"
            raise OwnError(f"{name} needs either maps or a method update(points, x); it has {found}")
        if "maps" in has:
            maps = cast(LearnedMethod, own).maps
            if not isinstance(maps, Maps):
                raise OwnError(f"{name}: its maps must be ido.Maps, as ido.train gives them, not {type(maps).__name__}")
            n_bins = checked_histogram(maps.histogram, name).n_bins
            if maps.maps.shape[1:] != (6, n_bins) or not np.isfinite(maps.maps).all():
                raise OwnError(f"{name}: its maps must be finite, of the shape (6, {n_bins}) each")
            return cls.learned(name, maps, epsilon, max_iterations)
        its_own = getattr(own, "histogram", None)
        seen_through = checked_histogram(histogram if its_own is None else its_own, name)
        kind = f"{type(own).__module__}:{type(own).__qualname__}"
        settings = {"class": kind, "epsilon": epsilon, "max_iterations": max_iterations}
        updates = cast(UpdateMethod, own)
        run = partial(register_updates, updates, name=name, epsilon=epsilon, max_iterations=max_iterations)
        return cls(name, settings, run, seen_through.model, None, seen_through)


def method_names(shape: str) -> tuple[str, ...]:
    """The methods that register a shipped shape from where it lies, learned ones first."""
    learned = (name for name, histogram in LEARNED.items() if histogram in shipped_histograms(shape))
    return (*learned, *BASELINES)


def from_any_start(shape: str) -> tuple[str, ...]:
    """The methods that can register a shipped shape wherever it lies."""
    learned = method_names(shape)
    return (*FROM_ANY_START, *(name for name, one in MANY_STARTS.items() if one in learned))


def compared(shape: str) -> tuple[str, ...]:
    """All methods that the experiments compare on a shipped shape, installed or not."""
    return (*method_names(shape), *from_any_start(shape), *PEERS)


def is_installed(name: str) -> bool:
    """Whether a method can run here: the library of a peer may be missing."""
    return name not in PEERS or PEERS[name].is_installed()


@cache
def shipped_global_model(shape: str) -> GlobalModel:
    """What the global method registers onto, for a shipped shape; a second or two to make."""
    return GlobalModel.of(shipped_cloud(shape).points)


@cache
def shipped_method(shape: str, name: str) -> Method:
    """A method by name, for a shipped shape.

    Raises:
        ValueError: the shape or the method is unknown, or the library of a peer is not installed.
    """
    if shape not in SHAPES:
        raise ValueError(f"unknown shape {shape!r}; known: {', '.join(SHAPES)}")
    if name.endswith(POLISHED):
        return shipped_method(shape, name.removesuffix(POLISHED)).polished(shipped_global_model(shape))
    known = compared(shape)
    if name not in known:
        raise ValueError(f"{name!r} cannot register {shape!r}; known: {', '.join(known)}")
    if name in LEARNED:
        return Method.learned(name, shipped_maps(shape, LEARNED[name]))
    model = shipped_maps(shape, LEARNED["DO"]).histogram.model
    if name in FROM_ANY_START:
        registration = GlobalRegistration(shipped_global_model(shape), FROM_ANY_START[name])
        return Method.from_any_start(name, registration, model)
    if name in MANY_STARTS:
        maps = shipped_maps(shape, LEARNED[MANY_STARTS[name]])
        registration = GlobalRegistration(shipped_global_model(shape), starts=ManyStarts(maps))
        return Method.from_any_start(name, registration, model, maps)
    return method_of(shape, name, BASELINES[name] if name in BASELINES else PEERS[name])


def method_of(shape: str, name: str, its: Baseline | Peer) -> Method:
    """A baseline or a peer as method for a shipped shape: the first has its model points, the other the whole cloud.

    Raises:
        PeerError: the library of a peer is not installed.
    """
    model = shipped_maps(shape, LEARNED["DO"]).histogram.model
    if isinstance(its, Peer):
        return Method.peer(name, its, shipped_cloud(shape).points, model)
    return Method.baseline(name, its, model)
