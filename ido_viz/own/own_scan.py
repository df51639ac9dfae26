"""A scan of one's own, with no truth known: where a learned method puts it, and how well it lies there."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ido import Maps
from ido.files.cloud_file import CloudFile, UsedPoints
from ido.poses import transform
from ido.scans import RegisteredScan, ScanSettings, registered_scan
from ido.types import FloatArray
from ido.user_units import Start, registered_points
from ido_viz.core.library import Subject


@dataclass(frozen=True, slots=True, eq=False)
class OwnScan:
    """A scan on a model.

    Args:
        name: of its file.
        method: that registered it.
        unit: that lengths are in.
        scan: the pose, its quality and its doubts.
        placed: what was registered, where it was moved to, points (S, 3) in model units.
        distance: of its histogram there from the reference line (docs/method.md, Eq. 20).
    """

    name: str
    method: str
    unit: str
    scan: RegisteredScan
    placed: FloatArray
    distance: float


@dataclass(slots=True)
class LastScan:
    """The scan that a page has registered last; it outlives the page, which may be reloaded.

    Args:
        found: what came of it; None before the first.
        subject: onto which it was registered.
        on_model: whether it is shown there, instead of the panes.
    """

    found: OwnScan | None = None
    subject: Subject | None = None
    on_model: bool = False


def registered_own(
    maps: Maps, method: str, unit: str, name: str, file: CloudFile, used: UsedPoints, start: Start
) -> OwnScan:
    """Register a scan.

    Args:
        maps: of the method.
        method: its name.
        unit: of the maps' cloud.
        name: of the scan's file.
        file: as it was read, in the unit.
        used: its points.
        start: where to start.
    """
    scan = registered_scan(maps, file, used, ScanSettings(start=start))
    points = transform(scan.T_model_scene, registered_points(used.points))
    placed = maps.frame.to_model_units(points).astype(np.float32)
    histogram = maps.histogram
    away = float(np.linalg.norm(histogram(placed, np.zeros(6)) - histogram.reference))
    return OwnScan(name, method, unit, scan, placed, away / (float(np.linalg.norm(histogram.reference)) or 1.0))
