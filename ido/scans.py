"""Registering a scan from a file: its pose, how well it fits, and what was left out, as one JSON object."""

from __future__ import annotations

import json
import math
from dataclasses import asdict, dataclass
from typing import Any

from ido.files import CloudFile, UsedPoints, open_cloud
from ido.maps import Maps
from ido.quality import Quality, quality
from ido.registration import EPSILON, MAX_ITERATIONS, StopReason
from ido.shipped import SHAPES, shipped_cloud
from ido.types import FloatArray
from ido.user_units import Start, doubts, register_original, registered_points


@dataclass(frozen=True, slots=True, kw_only=True)
class ScanSettings:
    """How scans are registered.

    Args:
        start: where to start, as in `register_original`.
        epsilon: an update shorter than this ends the registration.
        max_iterations: so many updates at most.
        drop_invalid: leave out points with coordinates that are not finite, instead of refusing the file.

    Raises:
        ValueError: a value is out of range.
    """

    start: Start = "here"
    epsilon: float = EPSILON
    max_iterations: int = MAX_ITERATIONS
    drop_invalid: bool = False

    def __post_init__(self) -> None:
        if not (math.isfinite(self.epsilon) and self.epsilon >= 0):
            raise ValueError(f"epsilon must be a number of at least 0, not {self.epsilon}")
        if self.max_iterations < 1:
            raise ValueError(f"max-iterations must be at least 1, not {self.max_iterations}")


@dataclass(frozen=True, slots=True, eq=False)
class RegisteredScan:
    """A scan's pose and all that is said about it.

    Args:
        file: the whole file.
        used: the points that it gave.
        registered: how many of them were registered.
        T_model_scene: the pose in the user's units, shape (4, 4).
        iterations: number of updates.
        stop: why they ended.
        quality: how well the scan fits.
        doubts: why the pose may be wrong, those of `quality` among them.
    """

    file: CloudFile
    used: UsedPoints
    registered: int
    T_model_scene: FloatArray
    iterations: int
    stop: StopReason
    quality: Quality
    doubts: tuple[str, ...]

    @property
    def sure(self) -> bool:
        """Whether it converged and nothing is doubted."""
        return self.stop is StopReason.CONVERGED and not self.doubts


def register_scan(maps: Maps, cloud: str, settings: ScanSettings, *, whole: bool = False) -> RegisteredScan:
    """Register a file, or a shipped shape by name, onto the model of maps.

    Args:
        maps: to walk.
        cloud: the file, in the units of the cloud that the maps were trained on.
        settings: how.
        whole: whether the file's other columns are wanted.

    Raises:
        CloudError: the file cannot be used.
    """
    return registered_scan(maps, *opened(cloud, drop_invalid=settings.drop_invalid, whole=whole), settings)


def registered_scan(maps: Maps, file: CloudFile, used: UsedPoints, settings: ScanSettings) -> RegisteredScan:
    """Register what was read from a file onto the model of maps; see `register_scan`."""
    points = registered_points(used.points)
    T_model_scene, track = register_original(
        maps, points, start=settings.start, epsilon=settings.epsilon, max_iterations=settings.max_iterations
    )
    judged = quality(maps, points, T_model_scene)
    found = (*doubts(maps, points, settings.start), *judged.warnings)
    return RegisteredScan(file, used, len(points), T_model_scene, track.iterations, track.stop, judged, found)


def as_json(scan: RegisteredScan) -> dict[str, Any]:
    """The plain values of a registered scan, lengths in the user's units; what is not known is None."""
    fit, extent = asdict(scan.quality.fit), asdict(scan.quality.extent)
    return {
        "T_model_scene": scan.T_model_scene.tolist(),
        "iterations": scan.iterations,
        "stop": str(scan.stop),
        "converged": scan.stop is StopReason.CONVERGED,
        "quality": {
            "points_read": scan.used.read,
            "points_dropped": scan.used.invalid,
            "points_used": scan.registered,
            **{name: None if math.isnan(value) else value for name, value in fit.items()},
            **extent,
        },
        "warnings": list(scan.doubts),
    }


def as_text(scan: RegisteredScan) -> str:
    """One JSON object in standard JSON, which knows no NaN."""
    return json.dumps(as_json(scan), indent=2, allow_nan=False)


def opened(cloud: str, *, drop_invalid: bool, whole: bool) -> tuple[CloudFile, UsedPoints]:
    """A cloud file, or a shipped shape by name, and the points that it gives.

    Raises:
        CloudError: the file cannot be used.
    """
    if cloud not in SHAPES:
        return open_cloud(cloud, whole=whole, drop_invalid=drop_invalid)
    shipped = shipped_cloud(cloud)
    points = shipped.frame.to_user_units(shipped.points)
    return CloudFile(points), UsedPoints(points, len(points), 0, ())
