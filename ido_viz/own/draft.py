"""A cloud of one's own before training: its file, its size and unit, what is up, and the model with its normals."""

from __future__ import annotations

import gzip
import re
import tempfile
import zlib
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np

from ido import Cloud, CloudError, Model
from ido.clouds import MODEL_POINTS, Frame
from ido.files import READERS, open_cloud
from ido.files.cloud_file import CloudFile, UsedPoints
from ido.types import FloatArray

MOST_POINTS = 30_000
"""Points that a cloud is kept with; of more, so many are drawn."""

MOST_UNPACKED = 512 << 20
"""Bytes that an upload packed with gzip may unpack to."""

_STEP = 1 << 24  # bytes unpacked at a time

LONGEST_NAME = 60
"""Letters."""

UNITS = ("units", "mm", "cm", "m", "in", "ft")
"""What the numbers of a file may be in; ``units`` for not known."""

UPS: dict[str, tuple[float, float, float]] = {
    "+z": (0.0, 0.0, 1.0),
    "+y": (0.0, 1.0, 0.0),
    "+x": (1.0, 0.0, 0.0),
    "-z": (0.0, 0.0, -1.0),
    "-y": (0.0, -1.0, 0.0),
    "-x": (-1.0, 0.0, 0.0),
}
"""Directions that may be up, by their names."""

Facing = Literal["outward", "inward", "up", "down"]
"""Where normals point to: away from the model's middle or towards it, up or down."""


@dataclass(frozen=True, slots=True, eq=False)
class Draft:
    """A cloud that can be trained on.

    Args:
        name: as it will be listed.
        in_file: normalised, its frame in the file's numbers.
        bare: the model, its normals outward.
        read: points or vertices in the file.
        notes: what of the file is not used, and why.
        unit: what the file's numbers, times `factor`, are in.
        factor: what the file's numbers are multiplied by.
        up: name of the direction that is up in pictures.
        facing: where the normals point to.
    """

    name: str
    in_file: Cloud
    bare: Model
    read: int
    notes: tuple[str, ...] = ()
    unit: str = UNITS[0]
    factor: float = 1.0
    up: str = "+z"
    facing: Facing = "outward"

    @property
    def size(self) -> FloatArray:
        """Length of the bounding box along x, y and z, in the unit; shape (3,)."""
        return np.ptp(self.in_file.points, axis=0).astype(np.float64) * self.cloud.frame.scale

    @property
    def cloud(self) -> Cloud:
        """Normalised, its frame in the unit."""
        frame = self.in_file.frame
        return Cloud(self.in_file.points, Frame(frame.centre * self.factor, frame.scale * self.factor))

    @property
    def model(self) -> Model:
        """The model, its normals as they are wanted."""
        normals, up = self.bare.normals, np.array(UPS[self.up], dtype=np.float32)
        if self.facing in ("up", "down"):
            normals = np.where((normals @ up)[:, None] < 0, -normals, normals)
        return Model(self.bare.points, -normals if self.facing in ("inward", "down") else normals)


def read_draft(path: Path, name: str | None = None) -> Draft:
    """The draft of a file.

    Args:
        path: the file.
        name: what it is called; the file's own name unless given.

    Raises:
        CloudError: the file cannot be used, or it is too small for a model.
    """
    return draft_of(*open_cloud(path), name=name or shown_name(path.stem))


def draft_of(file: CloudFile, used: UsedPoints, name: str) -> Draft:
    """The draft of a file's points.

    Raises:
        CloudError: there are too few of them for a model.
    """
    points, notes = used.points, [*used.notes]
    if file.faces is not None and len(points) != len(file.points):
        notes.append(f"a mesh of {len(file.faces):,} faces, from which {len(points):,} points are drawn")
    if len(points) > MOST_POINTS:
        notes.append(f"of {len(points):,} points {MOST_POINTS:,} are used, drawn at random, always the same ones")
        points = np.random.default_rng(0).choice(points, MOST_POINTS, replace=False)
    cloud = Cloud.of(points)
    model = Model.of(cloud, min(MODEL_POINTS, len(np.unique(cloud.points, axis=0))))
    return Draft(name, cloud, model, used.read, tuple(notes))


def open_upload(name: str, content: bytes, folder: Path) -> tuple[CloudFile, UsedPoints]:
    """What an uploaded file holds; its name decides how it is read, and nothing else.

    Args:
        name: as the browser gives it.
        content: of the file.
        folder: where it may lie while it is read.

    Raises:
        CloudError: the file cannot be used.
    """
    suffixes = [suffix.lower() for suffix in Path(name).suffixes][-2:]
    ending = "".join(suffixes if suffixes[-1:] == [".gz"] else suffixes[-1:])
    if ending.removesuffix(".gz") not in READERS:
        kinds = ", ".join(suffix[1:].upper() for suffix in READERS)
        raise CloudError(f"{shown_name(name)}: cannot be read; upload one of {kinds}, or one of these packed with gzip")
    with tempfile.TemporaryDirectory(dir=folder, prefix="upload-") as place:
        path = Path(place) / f"file{ending}"
        path.write_bytes(content)
        try:
            if ending.endswith(".gz"):
                _check_unpacked(path)
            return open_cloud(path, whole=True)
        except CloudError as error:
            raise CloudError(str(error).replace(path.name, shown_name(name))) from error


def _check_unpacked(path: Path) -> None:
    """See that a packed file does not unpack to more than the server may be asked to read."""
    size = 0
    try:
        with gzip.open(path) as file:
            while part := file.read(_STEP):
                size += len(part)
                if size > MOST_UNPACKED:
                    raise CloudError(f"{path.name}: unpacks to more than {MOST_UNPACKED >> 20} MB; thin it first")
    except (OSError, EOFError, zlib.error) as error:
        raise CloudError(f"{path.name}: is damaged or cut off ({error})") from error


def shown_name(text: str) -> str:
    """A name as a person may read it: printable, on one line, at most `LONGEST_NAME` letters; never empty."""
    printable = "".join(letter if letter.isprintable() else " " for letter in text)
    return " ".join(printable.split())[:LONGEST_NAME].strip() or "cloud"


def file_name(name: str, ending: str) -> str:
    """A name for a file about something, in letters that every system takes; the ending as it is."""
    return f"ido-{re.sub(r'[^A-Za-z0-9]+', '-', shown_name(name)).strip('-') or 'cloud'}{ending}"
