"""A file that is cut off anywhere, or goes on after its end, never gives fewer or other points in silence."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
import trimesh
from cloud_files import VARIANTS, Variant, las, made, text

from ido import CloudError
from ido.files import CloudFile, read_cloud

_MESH = trimesh.creation.icosphere(1)
_CORNERS = [" ".join(f"{value:.3f}" for value in vertex) for vertex in _MESH.vertices]
_FACES = [f"3 {a} {b} {c}" for a, b, c in _MESH.faces]

UNCOUNTED = (".asc", ".csv", ".obj", ".txt", ".xyz")
"""Kinds that do not say how many points they have."""

MESHES = (
    Variant("binary.stl", "", made("a.stl", lambda path: _MESH.export(str(path), "stl"))),
    Variant("text.stl", "", made("a.stl", lambda path: _MESH.export(str(path), "stl_ascii"))),
    Variant("solids.stl", "", made("a.stl", lambda path: _MESH.export(str(path), "stl_ascii")) * 2),
    Variant("mesh.off", "", text("OFF", f"{len(_CORNERS)} {len(_FACES)} 0", *_CORNERS, *_FACES)),
    Variant("mesh.ply", "", made("a.ply", lambda path: _MESH.export(str(path)))),
    Variant("mesh-text.ply", "", made("a.ply", lambda path: _MESH.export(str(path), encoding="ascii"))),
)
COUNTED = [v for v in (*VARIANTS, *MESHES) if not (v.refused or v.name.endswith((*UNCOUNTED, ".gz")))]


def read(folder: Path, name: str, content: bytes) -> CloudFile:
    return read_cloud(Variant(name, "", content).write(folder))


def sizes(file: CloudFile) -> tuple[int, int]:
    return len(file.points), 0 if file.faces is None else len(file.faces)


def places(content: bytes) -> Iterator[int]:
    """Where a file is cut: all over it, and at each of its last bytes."""
    yield from range(0, len(content), max(len(content) // 40, 1))
    yield from range(max(len(content) - 40, 0), len(content))


@pytest.mark.parametrize("variant", COUNTED, ids=lambda variant: variant.name)
def test_a_file_cut_anywhere_is_refused_or_has_all_points_and_faces(variant: Variant, tmp_path: Path):
    whole = sizes(read(tmp_path, variant.name, variant.content))
    refused = 0
    for place in places(variant.content):
        try:
            assert sizes(read(tmp_path, variant.name, variant.content[:place])) == whole, f"cut at {place}"
        except CloudError:
            refused += 1
    assert refused > 30


@pytest.mark.parametrize("variant", MESHES, ids=lambda variant: variant.name)
def test_a_mesh_that_goes_on_after_its_end_is_refused(variant: Variant, tmp_path: Path):
    with pytest.raises(CloudError):
        read(tmp_path, variant.name, variant.content + variant.content[-100:])


@pytest.mark.parametrize(("point_format", "version", "place"), [(3, "1.2", 107), (7, "1.4", 247)])
@pytest.mark.parametrize("name", ["a.las", "a.laz"])
@pytest.mark.parametrize("count", [0, 1, 59, 61, 120, 50_001])
def test_another_number_in_the_head_of_a_laser_scan_is_refused(
    point_format: int, version: str, place: int, name: str, count: int, tmp_path: Path
):
    whole = las(name, point_format, version)
    assert len(read(tmp_path, name, whole).points) == 60
    with pytest.raises(CloudError):
        read(tmp_path, name, whole[:place] + count.to_bytes(4, "little") + whole[place + 4 :])


def test_what_stands_behind_the_points_of_a_laser_scan_is_not_taken_for_points(tmp_path: Path):
    import laspy

    scan = laspy.read(Variant("a.las", "", las("a.las", 6, "1.4")).write(tmp_path))
    assert scan.evlrs is not None
    scan.evlrs.append(laspy.VLR("ido", 7, record_data=bytes(5000)))
    scan.write(str(tmp_path / "b.las"))
    np.testing.assert_array_equal(read_cloud(tmp_path / "b.las").points, read_cloud(tmp_path / "a.las").points)


@pytest.mark.parametrize("head", ["OFF\n4 1 0", "OFF 4 1 0", "4 1 0", "COFF\n# a remark\n4 1 0", "NOFF\n\n4 1 6"])
def test_an_off_file_may_begin_in_many_ways_and_its_rows_may_hold_more(head: str, tmp_path: Path):
    file = read(
        tmp_path, "a.off", text(head, "0 0 0 9 9 9", "1 0 0 9 9 9", "1 1 0", "0 1 0 # corner", "4 0 1 2 3 255 0 0")
    )
    np.testing.assert_array_equal(file.points, [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)])
    assert file.faces is not None
    np.testing.assert_array_equal(file.faces, [(0, 1, 2), (0, 2, 3)])


def test_an_obj_face_of_two_corners_is_refused_by_its_line(tmp_path: Path):
    with pytest.raises(CloudError, match="line 4: a face needs three corners"):
        read(tmp_path, "a.obj", text("v 0 0 0", "v 1 0 0", "v 1 1 0", "f 1 2"))
