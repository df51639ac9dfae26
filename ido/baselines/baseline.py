"""What all baselines share: a model, a scene, and a pose after each iteration."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import ClassVar

import numpy as np

from ido import poses
from ido.histograms import finite
from ido.registration import StopReason, Trajectory, Watch
from ido.types import DoubleArray, FloatArray

Record = Callable[[FloatArray], None]
"""Takes T_model_scene, shape (4, 4), after an iteration."""

_FARTHEST = 1e3  # model units; no real pose lies beyond


class _DivergedError(Exception):
    pass


@dataclass(frozen=True, kw_only=True)
class Baseline(ABC):
    """A rigid registration method that learns nothing. Its settings are its fields.

    Args:
        max_iterations: limit of the iterations.
    """

    title: ClassVar[str]
    max_iterations: int = 150

    @abstractmethod
    def run(self, model: DoubleArray, scene: DoubleArray, record: Record) -> StopReason:
        """Register a scene (S, 3) onto a model (M, 3), both in model units; every iteration's pose is recorded."""

    def register(self, model: FloatArray, points: FloatArray, *, watch: Watch | None = None) -> Trajectory:
        """Register one scene, points (S, 3) in model units, onto a model (M, 3), from where it lies.

        Args:
            model: the fixed cloud.
            points: the cloud to move.
            watch: called after each iteration with how many there were; what it raises ends the registration.

        Returns:
            poses from the first (identity) to the last. An update norm is that of the exponential coordinates of the
            motion from one pose to the next.

        Raises:
            ValueError: coordinates are not finite, or there are fewer than 3 points.
        """
        scene = finite(points).astype(np.float64)
        if len(scene) < 3:
            raise ValueError(f"{self.title} needs at least 3 points, not {len(scene)}")
        track: list[FloatArray] = [np.eye(4)]

        def record(T: FloatArray) -> None:
            if not (np.isfinite(T).all() and np.abs(T).max() < _FARTHEST):
                raise _DivergedError
            track.append(T)
            if watch:
                watch(len(track) - 1)

        try:
            stop = self.run(np.asarray(model, dtype=np.float64), scene, record)
        except _DivergedError:
            stop = StopReason.DIVERGED
        T = np.stack(track)
        motions = poses.log(T[1:] @ poses.invert(T[:-1])) if len(T) > 1 else np.empty((0, 6))
        return Trajectory(poses.log(T), np.linalg.norm(motions, axis=1), stop, np.nan)

    @property
    def settings(self) -> dict[str, float | int | str | list[float]]:
        """All settings by name, plain values."""
        return {name: list(value) if isinstance(value, tuple) else value for name, value in asdict(self).items()}
