"""What ships with the program: two clouds, and maps trained on them at the paper's size."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from ido.clouds import Cloud, Orientation
from ido.files import load_cloud, read_cloud
from ido.histograms import HISTOGRAMS
from ido.maps import Maps
from ido.perturbation import OutlierKind
from ido.results import Results
from ido.types import FloatArray, IntArray


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


SHAPES: dict[str, Shape] = {
    "bunny": Shape("Stanford bunny", (0, 1, 0), "outward", "uniform"),
    "urban": Shape("Urban laser scan", (0, 0, 1), "up", "structured"),
}


def asset(name: str) -> Path:
    """A shipped file or folder: of the installed package, or of the clone or source archive that this code lies in."""
    package = Path(__file__).parent
    installed = package / "assets"
    return (installed if installed.is_dir() else package.parent / "assets") / name


@cache
def shipped_cloud(shape: str) -> Cloud:
    """A shipped cloud by name, `bunny` or `urban`."""
    return Cloud.of(load_cloud(asset(f"{shape}.ply")))


@cache
def shipped_surface(shape: str) -> tuple[FloatArray, IntArray] | None:
    """A shape's surface for pictures, in model units: vertices (V, 3) and faces (F, 3); None for one that has none."""
    file = asset(f"{shape}-surface.ply")
    if not file.is_file():
        return None
    mesh = read_cloud(file)
    assert mesh.faces is not None
    return shipped_cloud(shape).frame.to_model_units(mesh.points).astype(np.float32), mesh.faces


@cache
def shipped_histograms(shape: str) -> tuple[str, ...]:
    """Names of the histograms that maps of a shape are shipped for."""
    return tuple(name for name in HISTOGRAMS if asset(f"{shape}-{name}.npz").is_file())


@cache
def shipped_maps(shape: str, histogram: str) -> Maps:
    """Shipped maps by the names of their shape and histogram."""
    return Maps.load(asset(f"{shape}-{histogram}.npz"))


@cache
def shipped_results() -> Results:
    """What `ido experiment run paper` found when it was run for this version."""
    return Results.load(asset("results.npz"))
