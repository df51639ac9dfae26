"""What all peers share: they are made ready for a cloud once, and give one pose for a scene."""

from __future__ import annotations

import importlib
import importlib.util
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import asdict, dataclass
from types import ModuleType
from typing import ClassVar

import numpy as np

from ido import poses
from ido.histograms import finite
from ido.registration import StopReason, Trajectory, Watch
from ido.types import DoubleArray, FloatArray

Found = tuple[DoubleArray, StopReason]
"""T_model_scene, shape (4, 4), and what the library says of it."""

Finder = Callable[[DoubleArray], Found]
"""Finds the pose of a scene, points (S, 3) in model units."""

PEERS_EXTRA = "pip install 'ido-explorer[peers]'"
"""Installs the libraries of all peers."""

LEAST_POINTS = 3
"""A scene has at least so many points."""


class PeerError(ValueError):
    """The library of a peer is not installed; the message says what to do."""


@dataclass(frozen=True, kw_only=True)
class Peer(ABC):
    """A registration method of a public library. Its settings are its fields, lengths in model units."""

    title: ClassVar[str]
    package: ClassVar[str]

    @abstractmethod
    def onto(self, cloud: FloatArray) -> Finder:
        """Made ready for a cloud (N, 3) in model units, once for all scenes.

        Raises:
            PeerError: its library is not installed.
        """

    @classmethod
    def is_installed(cls) -> bool:
        """Whether its library can be imported."""
        return importlib.util.find_spec(cls.package) is not None

    @classmethod
    def library(cls) -> ModuleType:
        """Its library.

        Raises:
            PeerError: it is not installed.
        """
        try:
            return importlib.import_module(cls.package)
        except ImportError as error:
            raise PeerError(f"{cls.title} needs one more package: {PEERS_EXTRA}") from error

    @property
    def settings(self) -> dict[str, object]:
        """All settings by name, plain values."""
        return asdict(self)


def register_once(title: str, find: Finder, points: FloatArray, *, watch: Watch | None = None) -> Trajectory:
    """Register one scene, points (S, 3) in model units: a trajectory from where it lies to the pose found.

    Args:
        title: of the peer.
        find: finds the pose.
        points: the scene.
        watch: called once, after the registration.

    Raises:
        ValueError: coordinates are not finite, or there are fewer than 3 points.
    """
    scene = finite(points).astype(np.float64)
    if len(scene) < LEAST_POINTS:
        raise ValueError(f"{title} needs at least {LEAST_POINTS} points, not {len(scene)}")
    T, stop = find(scene)
    if watch:
        watch(1)
    x = poses.log(np.stack([np.eye(4), T]))
    return Trajectory(x, np.linalg.norm(x[1:], axis=1), stop, np.nan)
