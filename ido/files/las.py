"""LAS and LAZ files, as laser scanners' software writes them."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ido.clouds import CloudError
from ido.files.cloud_file import CloudFile, check_count

_CHUNK = 1_000_000  # points that are unpacked at a time


def read_las(path: Path, *, whole: bool) -> CloudFile:
    """Points and, if the whole file is wanted, its other dimensions.

    Raises:
        CloudError: cut off.
    """
    import laspy

    with laspy.open(path) as file:
        count = check_count(file.header.point_count)
        if not file.header.are_points_compressed:
            left = path.stat().st_size - file.header.offset_to_point_data
            if left < count * file.header.point_format.size:
                raise CloudError(f"is cut off: its head promises {count} points")
        others = [name for name in file.header.point_format.dimension_names if name not in "XYZ"] if whole else []
        points: list[np.ndarray] = []
        columns: dict[str, list[np.ndarray]] = {name: [] for name in others}
        for chunk in file.chunk_iterator(_CHUNK):
            points.append(np.column_stack([np.array(axis) for axis in (chunk.x, chunk.y, chunk.z)]))
            for name in others:
                columns[name].append(np.array(chunk[name]))
    if sum(map(len, points)) != count:
        raise CloudError(f"is cut off: its head promises {count} points, it holds {sum(map(len, points))}")
    joined = {name: np.concatenate(parts) for name, parts in columns.items() if parts}
    return CloudFile(np.concatenate([*points, np.empty((0, 3))]), joined)
