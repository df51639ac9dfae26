"""LAS and LAZ files, as laser scanners' software writes them."""

from __future__ import annotations

import importlib
import struct
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ido.clouds import CloudError
from ido.files.cloud_file import CloudFile, check_count
from ido.types import FloatArray

if TYPE_CHECKING:
    from laspy import LasHeader

_CHUNK = 1_000_000  # points that are unpacked at a time
_FIRST_LAYERED = 6  # from this point format on, each packed chunk says how many points it has


def read_las(path: Path, *, whole: bool) -> CloudFile:
    """Points and, if the whole file is wanted, its other dimensions.

    A note tells of points that do not reach as far as the head says.

    Raises:
        CloudError: cut off, or it holds more points than its head promises.
    """
    import laspy

    with laspy.open(path) as file:
        head = file.header
        count = check_count(head.point_count)
        _check_number(path, head)
        others = [name for name in head.point_format.dimension_names if name not in "XYZ"] if whole else []
        points: list[np.ndarray] = []
        columns: dict[str, list[np.ndarray]] = {name: [] for name in others}
        for chunk in file.chunk_iterator(_CHUNK):
            points.append(np.column_stack([np.array(axis) for axis in (chunk.x, chunk.y, chunk.z)]))
            for name in others:
                columns[name].append(np.array(chunk[name]))
    if sum(map(len, points)) != count:
        raise _cut_off(count, sum(map(len, points)))
    joined = {name: np.concatenate(parts) for name, parts in columns.items() if parts}
    xyz = np.concatenate([*points, np.empty((0, 3))])
    return CloudFile(xyz, joined, notes=_bounds(head, xyz))


def _check_number(path: Path, head: LasHeader) -> None:
    """See that the number of points is that which the head promises, as far as can be known before they are read."""
    by_return = int(np.sum(head.number_of_points_by_return))
    if by_return > head.point_count:
        raise _too_many(head.point_count, by_return)
    there = _packed_points(path, head) if head.are_points_compressed else _plain_points(path, head)
    if there < head.point_count:
        raise _cut_off(head.point_count, there)
    if there > head.point_count:
        raise _too_many(head.point_count, there)


def _plain_points(path: Path, head: LasHeader) -> int:
    """How many points there is room for, up to what follows them."""
    start = head.offset_to_point_data
    after = (head.start_of_waveform_data_packet_record, head.start_of_first_evlr if head.number_of_evlrs else 0)
    end = min([path.stat().st_size, *(place for place in after if place >= start)])
    return (end - start) // head.point_format.size


def _packed_points(path: Path, head: LasHeader) -> int:
    """How many points the packed chunks hold. Those of old formats do not say it; they are as full as is promised."""
    lazrs: Any = importlib.import_module("lazrs")  # which has no types

    place = head.vlrs.index("LasZipVlr")
    packing = lazrs.LazVlr(head.vlrs[place].record_data)
    with path.open("rb") as file:
        file.seek(head.offset_to_point_data)
        chunks = lazrs.read_chunk_table(file, packing)
        if not chunks or packing.uses_variable_size_chunks():
            return sum(points for points, _ in chunks)
        size, before = packing.chunk_size(), len(chunks) - 1
        last = min(max(head.point_count - before * size, 1), size)
        if head.point_format.id >= _FIRST_LAYERED:
            start = head.offset_to_point_data + 8 + sum(length for _, length in chunks[:-1])
            file.seek(start + head.point_format.size)  # the first point of a chunk stands before its number of points
            last = struct.unpack("<I", file.read(4))[0]
        return before * size + last


def _bounds(head: LasHeader, points: FloatArray) -> tuple[str, ...]:
    """A note when the points do not fill the bounds that the head gives, as it is when some are missing."""
    if not len(points):
        return ()
    found, said = np.array([points.min(0), points.max(0)]), np.array([head.mins, head.maxs])
    if not said.any() or np.abs(found - said).max() <= 2 * np.max(head.scales):
        return ()
    return ("its points do not fill the bounds that its head gives, so some may be missing; write it anew if you can",)


def _cut_off(count: int, there: int) -> CloudError:
    return CloudError(f"is cut off: its head promises {count} points, it holds {there}")


def _too_many(count: int, there: int) -> CloudError:
    return CloudError(
        f"holds {there} points, its head promises {count}; which are meant cannot be known, write it anew"
    )
