"""What the commands take: clouds, maps and histograms by name."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, get_args

from tyro.conf import Positional, arg
from tyro.constructors import PrimitiveConstructorSpec

from ido.clouds import Orientation
from ido.extensions import OwnError, histogram_class
from ido.files import READERS, load_cloud
from ido.histograms import HISTOGRAMS
from ido.maps import Maps
from ido.perturbation import OutlierKind
from ido.shipped import SHAPES, asset, shipped_cloud, shipped_histograms, shipped_maps
from ido.types import FloatArray

SHIPPED_MAPS = [f"{shape}-{histogram}" for shape in SHAPES for histogram in shipped_histograms(shape)]
"""Names of the maps that ship with the program."""

MAPS_HELP = f"made by `ido train`, or shipped ones by name: {', '.join(SHIPPED_MAPS)}."

_KINDS = ", ".join(suffix[1:].upper() for suffix in READERS)

CloudName = Annotated[
    Positional[str],
    arg(metavar="CLOUD", help=f"File ({_KINDS}, each also as .gz) or shipped shape: {', '.join(SHAPES)}."),
]


def _histogram_name(args: list[str]) -> str:
    (text,) = args
    if text not in HISTOGRAMS and ":" not in text:
        raise OwnError(f"no histogram {text!r}")
    return text


HistogramName = Annotated[
    str,
    PrimitiveConstructorSpec(
        nargs=1,
        metavar=f"{{{','.join(HISTOGRAMS)},MODULE:CLASS}}",
        instance_from_str=_histogram_name,
        is_instance=lambda value: isinstance(value, str),
        str_from_instance=lambda value: [value],
    ),
]
"""One of ours, or one's own as ``module:Class``."""


def points_of(cloud: str, *, drop_invalid: bool = False) -> FloatArray:
    """Points (N, 3) of a file or a shipped shape, in its own units."""
    if cloud in SHAPES:
        shipped = shipped_cloud(cloud)
        return shipped.frame.to_user_units(shipped.points)
    return load_cloud(cloud, drop_invalid=drop_invalid)


def place_of(name: str) -> Path:
    """Where a cloud or maps lie, given by file or shipped name."""
    if name in SHAPES:
        return asset(f"{name}.ply")
    return asset(f"{name}.npz") if name in SHIPPED_MAPS else Path(name)


def maps_of(name: str, histogram: str | None = None) -> Maps:
    """Maps by file or shipped name; `histogram`, as ``module:Class``, is one of one's own that they may name."""
    if name in SHIPPED_MAPS:
        return shipped_maps(*name.split("-", 1))
    if not Path(name).suffix:
        raise ValueError(f"{name}: no such maps; give a .npz file or one of {', '.join(SHIPPED_MAPS)}")
    own = [histogram_class(histogram)] if histogram else []
    return Maps.load(name, {**HISTOGRAMS, **{h.name: h for h in own}})


def habits(cloud: str, kind: OutlierKind | None, normals: Orientation | None) -> tuple[OutlierKind, Orientation]:
    """What was asked for, else what is usual for a shipped shape, else the first choice."""
    shape = SHAPES.get(cloud)
    if shape is None:
        return kind or get_args(OutlierKind)[0], normals or get_args(Orientation)[0]
    return kind or shape.outlier_kind, normals or shape.orientation
