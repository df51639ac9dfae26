"""What the commands take: clouds, maps and histograms by name, and files to write."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Annotated, get_args

from tyro.conf import Positional, arg
from tyro.constructors import PrimitiveConstructorSpec

from ido.clouds import Orientation, load_cloud
from ido.extensions import OwnError, histogram_class
from ido.histograms import HISTOGRAMS
from ido.maps import Maps
from ido.perturbation import OutlierKind
from ido.shipped import SHAPES, shipped_cloud, shipped_histograms, shipped_maps
from ido.types import FloatArray

SHIPPED_MAPS = [f"{shape}-{histogram}" for shape in SHAPES for histogram in shipped_histograms(shape)]
"""Names of the maps that ship with the program."""

MAPS_HELP = f"made by `ido train`, or shipped ones by name: {', '.join(SHIPPED_MAPS)}."

CloudName = Annotated[
    Positional[str],
    arg(metavar="CLOUD", help=f"File (PLY, PCD, XYZ, NPZ, OBJ, STL, OFF) or shipped shape: {', '.join(SHAPES)}."),
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


def points_of(cloud: str) -> FloatArray:
    """Points (N, 3) of a file or a shipped shape, in its own units."""
    if cloud in SHAPES:
        shipped = shipped_cloud(cloud)
        return shipped.frame.to_user_units(shipped.points)
    return load_cloud(cloud)


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


def check_output(path: Path, *suffixes: str) -> None:
    """See that a file can be written, before the work begins.

    Raises:
        ValueError: its name has another ending, or its folder cannot be written to.
    """
    if suffixes and path.suffix.lower() not in suffixes:
        raise ValueError(f"{path}: the name must end in {' or '.join(suffixes)}")
    if not path.parent.is_dir():
        raise ValueError(f"{path.parent}: no such folder")
    if path.is_dir():
        raise ValueError(f"{path}: is a folder")
    if not os.access(path.parent, os.W_OK):
        raise ValueError(f"{path.parent}: no permission to write there")
