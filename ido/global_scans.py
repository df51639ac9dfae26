"""Registering a scan from a file onto a cloud from any start: its pose, how sure it is and why, as one JSON object."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ido.arguments import SHIPPED_MAPS, maps_of, points_of
from ido.clouds import Cloud, CloudError, Frame, checked_points
from ido.files import CloudFile, UsedPoints
from ido.global_registration import Confidence, GlobalModel, GlobalRegistration, surface_of
from ido.maps import Maps, MapsError
from ido.methods import shipped_global_model
from ido.scans import opened
from ido.shipped import SHAPES, shipped_cloud
from ido.types import FloatArray

SURE = 0.95
"""A pose of at least this probability is taken for right under --strict, when nothing speaks against it."""

OTHER_SIZE = 5.0
"""A cloud that is more times larger or smaller than the model is doubted."""


@dataclass(frozen=True, slots=True, eq=False)
class GlobalScan:
    """A scan's pose from any start, and how sure it is; all in the user's units.

    Args:
        file: the whole file.
        used: the points that it gave.
        searched: how many of them were searched with; all are used at the end.
        T_model_scene: the pose, shape (4, 4).
        confidence: in model units.
        frame: of the model.
        doubts: why the pose may be wrong.
    """

    file: CloudFile
    used: UsedPoints
    searched: int
    T_model_scene: FloatArray
    confidence: Confidence
    frame: Frame
    doubts: tuple[str, ...]

    @property
    def sure(self) -> bool:
        """Whether it is probable enough, and nothing speaks against it."""
        return self.confidence.probability >= SURE and not self.doubts


def global_target(name: str, histogram: str | None = None) -> tuple[Frame, GlobalModel]:
    """What is registered onto: a cloud or maps, by file or shipped name; and its frame in the user's units.

    Raises:
        ValueError: it cannot be used.
    """
    if name in SHAPES:
        return shipped_cloud(name).frame, shipped_global_model(name)
    maps = _maps(name, histogram)
    if maps:
        return maps.frame, GlobalModel.of(surface_of(maps.histogram.model))
    cloud = Cloud.of(points_of(name))
    return cloud.frame, GlobalModel.of(cloud.points)


def _maps(name: str, histogram: str | None) -> Maps | None:
    """Maps by file or shipped name; None for what may be a cloud."""
    if name not in SHIPPED_MAPS and Path(name).suffix.lower() != ".npz":
        return None
    try:
        return maps_of(name, histogram)
    except MapsError:
        if name in SHIPPED_MAPS or histogram:
            raise
        return None  # a cloud can be an .npz, too


def register_globally(
    target: tuple[Frame, GlobalModel], cloud: str, *, drop_invalid: bool = False, whole: bool = False
) -> GlobalScan:
    """Register a file, or a shipped shape by name, onto a target, wherever it lies.

    Args:
        target: of `global_target`.
        cloud: the file, in the units of the target.
        drop_invalid: leave out points with coordinates that are not finite, instead of refusing the file.
        whole: whether the file's other columns are wanted.

    Raises:
        CloudError: the file cannot be used.
    """
    frame, model = target
    file, used = opened(cloud, drop_invalid=drop_invalid, whole=whole)
    points = frame.to_model_units(checked_points(used.points))
    try:
        result = GlobalRegistration(model).run(points)
    except ValueError as error:  # too few points, or all in one place
        raise CloudError(f"{Path(cloud).name}: {error}") from error
    confidence = Confidence.of(result)
    found = (*_of_size(points, model.planes.sample), *confidence.reasons)
    return GlobalScan(
        file, used, result.searched, frame.pose_in_user_units(result.T_model_scene), confidence, frame, found
    )


def _of_size(points: FloatArray, model: FloatArray) -> list[str]:
    """Sizes are those of the middle halves, which few outliers do not change."""
    size, own = (float(np.subtract(*np.percentile(part, (75, 25), axis=0)).max()) for part in (points, model))
    ratio = size / own
    if 1 / OTHER_SIZE < ratio < OTHER_SIZE:
        return []
    return [f"the cloud is {ratio:.3g} times as large as the model; is it in the model's units?"]


def as_json(scan: GlobalScan) -> dict[str, Any]:
    """The plain values of a scan, lengths in the user's units."""
    evidence, scale = scan.confidence.evidence, scan.frame.scale
    units = np.array([scale, scale, scale, 1, 1, 1])
    return {
        "T_model_scene": scan.T_model_scene.tolist(),
        "confidence": {
            "probability": scan.confidence.probability,
            "expected_error": scale * evidence.error,
            "covariance": (evidence.covariance * np.outer(units, units)).tolist(),
            "explained_points": evidence.explained,
            "explained_share": evidence.share,
            "covered_share": evidence.covered,
            "margin": None if math.isinf(evidence.margin) else evidence.margin,
            "noise": scale * evidence.sigma,
            "equal_poses": [scan.frame.pose_in_user_units(T).tolist() for T in scan.confidence.equals],
        },
        "quality": {
            "points_read": scan.used.read,
            "points_dropped": scan.used.invalid,
            "points_searched": scan.searched,
            "points_used": len(scan.used.points),
        },
        "warnings": list(scan.doubts),
    }


def as_text(scan: GlobalScan) -> str:
    """One JSON object in standard JSON."""
    return json.dumps(as_json(scan), indent=2, allow_nan=False)
