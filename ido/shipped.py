"""What ships with the program: two clouds, and maps trained on them at the paper's size."""

from __future__ import annotations

import importlib.resources
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from ido.clouds import Cloud, Orientation, load_cloud
from ido.maps import Maps
from ido.perturbation import OutlierKind
from ido.results import Results


@dataclass(frozen=True, slots=True)
class Shape:
    """A shipped cloud and how it is used."""

    title: str
    up: tuple[float, float, float]
    """The direction that is up in the pictures."""
    orientation: Orientation
    """Of the model's normals."""
    outlier_kind: OutlierKind
    """Of the paper's experiments on this kind of cloud."""
    histograms: tuple[str, ...]
    """Names of the histograms that maps are shipped for."""


SHAPES: dict[str, Shape] = {
    "bunny": Shape("Stanford bunny", (0, 1, 0), "outward", "uniform", ("front-back", "triple-binary", "as-printed")),
    "urban": Shape("Urban laser scan", (0, 0, 1), "up", "structured", ("front-back", "triple-binary")),
}


def _asset(name: str) -> Path:
    path = importlib.resources.files("ido.assets") / name
    if not isinstance(path, Path):
        raise FileNotFoundError(f"{name}: the package must be unpacked on disk")
    return path


@cache
def shipped_cloud(shape: str) -> Cloud:
    """A shipped cloud by name, `bunny` or `urban`."""
    return Cloud.of(load_cloud(_asset(f"{shape}.ply")))


@cache
def shipped_maps(shape: str, histogram: str) -> Maps:
    """Shipped maps by the names of their shape and histogram."""
    return Maps.load(_asset(f"{shape}-{histogram}.npz"))


@cache
def shipped_results() -> Results:
    """What `ido experiment run paper` found when it was run for this version."""
    return Results.load(_asset("results.npz"))
