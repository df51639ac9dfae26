"""What is read and written, against other libraries that read and write the same formats."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import open3d as o3d
import pytest
import trimesh
from plyfile import PlyData, PlyElement
from pypcd4.pypcd4 import Encoding, PointCloud

from ido import CloudWarning
from ido.files import CloudFile, read_cloud, save_cloud, used_points
from ido.poses import exp, transform

RNG = np.random.default_rng(0)
POINTS = RNG.normal([4e5, 5.4e6, 120], [40, 10, 2], (300, 3))
"""Coordinates of a map, which need 64 bits."""

KINDS = ("i1", "u1", "i2", "u2", "i4", "u4", "f4", "f8")


def columns(kinds: tuple[str, ...] = KINDS) -> dict[str, np.ndarray]:
    """A column of each type, with the smallest and the largest number that it holds."""
    found = {}
    for kind in kinds:
        dtype = np.dtype(kind)
        limits = np.finfo(dtype) if dtype.kind == "f" else np.iinfo(dtype)
        found[f"of_{kind}"] = np.resize(np.array([limits.min, limits.max, 7, 1], dtype=dtype), len(POINTS))
    return found


def rows() -> np.ndarray:
    """Points and a column of each type as structured rows, x, y and z in capitals and not in front."""
    named = {**columns(), **dict(zip("XYZ", POINTS.T, strict=True))}
    table = np.empty(len(POINTS), dtype=[(name, values.dtype) for name, values in named.items()])
    for name, values in named.items():
        table[name] = values
    return table


def assert_all_there(file: CloudFile, expected: dict[str, np.ndarray]) -> None:
    np.testing.assert_array_equal(file.points, POINTS)
    assert list(file.columns) == list(expected)
    for name, values in expected.items():
        np.testing.assert_array_equal(file.columns[name], values)


@pytest.mark.parametrize("order", ["<", ">"])
@pytest.mark.parametrize("of_text", [False, True])
def test_ply_of_every_type(tmp_path: Path, order: str, of_text: bool):
    PlyData([PlyElement.describe(rows(), "vertex")], text=of_text, byte_order=order).write(tmp_path / "a.ply")
    assert_all_there(read_cloud(tmp_path / "a.ply", whole=True), columns())


@pytest.mark.parametrize("of_text", [False, True])
def test_ply_faces_of_any_number_of_corners_become_triangles(tmp_path: Path, of_text: bool):
    square = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (2, 2, 0)], [(axis, "f4") for axis in "xyz"])
    faces = np.empty(2, dtype=[("flag", "u1"), ("vertex_index", "O")])
    faces["flag"] = 9
    faces["vertex_index"] = [np.array([0, 1, 2, 3], "i4"), np.array([2, 4, 3], "i4")]
    edges = np.array([(0, 1)], [("vertex1", "i4"), ("vertex2", "i4")])
    elements = [PlyElement.describe(square, "vertex"), PlyElement.describe(faces, "face")]
    PlyData([*elements, PlyElement.describe(edges, "edge")], text=of_text, byte_order="<").write(tmp_path / "a.ply")
    file = read_cloud(tmp_path / "a.ply")
    np.testing.assert_array_equal(file.faces, [[0, 1, 2], [0, 2, 3], [2, 4, 3]])
    assert file.notes == ("1 rows of the kind 'edge' are not used",)
    samples = used_points(file).points
    inside = (samples[:, 0] <= 1) & (samples[:, 1] <= 1)
    assert inside.mean() == pytest.approx(1 / 1.5, abs=0.02)  # the areas of the square and of the triangle


@pytest.mark.parametrize("encoding", list(Encoding)[:3])
def test_pcd_of_every_type(tmp_path: Path, encoding: Encoding):
    kinds = KINDS[2:] if encoding is Encoding.ASCII else (*KINDS, "i8", "u8")  # its text of bytes is not numbers
    others = columns(kinds)
    named = {**others, "x": POINTS[:, 0], "y": POINTS[:, 1], "z": POINTS[:, 2]}
    if encoding is Encoding.ASCII:
        named = {name: values.astype("f8") for name, values in named.items()}
    cloud = PointCloud.from_points(list(named.values()), list(named), [values.dtype for values in named.values()])
    cloud.save(tmp_path / "a.pcd", encoding=encoding)
    file = read_cloud(tmp_path / "a.pcd", whole=True)
    np.testing.assert_allclose(file.points, POINTS, rtol=1e-9 if encoding is Encoding.ASCII else 0)
    for name in others:
        np.testing.assert_allclose(file.columns[name], named[name], rtol=1e-9 if encoding is Encoding.ASCII else 0)


@pytest.mark.parametrize(("ascii", "compressed"), [(True, False), (False, False), (False, True)])
def test_pcd_as_open3d_writes_it(tmp_path: Path, ascii: bool, compressed: bool):
    near = POINTS - POINTS.mean(axis=0)  # it writes 32 bits
    cloud = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(near))
    cloud.normals = o3d.utility.Vector3dVector(near / np.linalg.norm(near, axis=1, keepdims=True))
    assert o3d.io.write_point_cloud(tmp_path / "a.pcd", cloud, write_ascii=ascii, compressed=compressed)
    file = read_cloud(tmp_path / "a.pcd", whole=True)
    np.testing.assert_allclose(file.points, near, atol=1e-4)
    read = np.column_stack([file.columns[f"normal_{axis}"] for axis in "xyz"])
    np.testing.assert_allclose(read, np.asarray(cloud.normals), atol=1e-6)


def test_pcd_fields_of_several_numbers_and_room_between_fields(tmp_path: Path):
    row = np.dtype([("room", "u1", 3), ("x", "f8"), ("y", "f8"), ("z", "f8"), ("histogram", "f4", 2)])
    table = np.zeros(len(POINTS), row)
    table["x"], table["y"], table["z"] = POINTS.T
    table["histogram"] = RNG.random((len(POINTS), 2))
    head = (
        "VERSION 0.7\nFIELDS _ x y z histogram\nSIZE 1 8 8 8 4\nTYPE U F F F F\nCOUNT 3 1 1 1 2\n"
        f"WIDTH {len(POINTS)}\nHEIGHT 1\nPOINTS {len(POINTS)}\nDATA binary\n"
    )
    (tmp_path / "a.pcd").write_bytes(head.encode() + table.tobytes())
    expected = {f"histogram_{i}": table["histogram"][:, i] for i in range(2)}
    assert_all_there(read_cloud(tmp_path / "a.pcd", whole=True), expected)


def test_ply_that_is_written_is_read_by_others(tmp_path: Path):
    triangles = np.array([[0, 1, 2], [2, 3, 4]])
    save_cloud(tmp_path / "a.ply", CloudFile(POINTS, columns(), triangles))
    read = PlyData.read(tmp_path / "a.ply")
    for axis, values in zip("xyz", POINTS.T, strict=True):
        np.testing.assert_array_equal(read["vertex"][axis], values)
    for name, values in columns().items():
        np.testing.assert_array_equal(read["vertex"][name], values)
        assert read["vertex"][name].dtype == values.dtype
    np.testing.assert_array_equal(np.stack(list(read["face"]["vertex_indices"])), triangles)
    np.testing.assert_array_equal(np.asarray(o3d.io.read_point_cloud(tmp_path / "a.ply").points), POINTS)
    assert len(trimesh.load_mesh(tmp_path / "a.ply", process=False).faces) == 2


def test_xyz_that_is_written_names_its_columns_and_is_read_again(tmp_path: Path):
    others = columns(("u1", "i4", "f4", "f8"))
    save_cloud(tmp_path / "a.xyz", CloudFile(POINTS, others))
    assert (tmp_path / "a.xyz").read_text().splitlines()[0] == "# x y z of_u1 of_i4 of_f4 of_f8"
    file = read_cloud(tmp_path / "a.xyz", whole=True)
    np.testing.assert_allclose(file.points, POINTS, rtol=1e-11)
    for name, values in others.items():
        np.testing.assert_array_equal(file.columns[name].astype(values.dtype), values)


def test_a_moved_file_keeps_its_order_and_turns_its_normals():
    normals = RNG.normal(size=(len(POINTS), 3)).astype(np.float32)
    turned = dict(zip(("nx", "ny", "nz"), normals.T, strict=True))
    T = exp(np.array([3.0, -2, 1, 0.4, -0.8, 0.3]))
    moved = CloudFile(POINTS, {**turned, "time": np.arange(len(POINTS))}).moved(T)
    np.testing.assert_allclose(moved.points, transform(T, POINTS), rtol=1e-12)
    ends = transform(T, POINTS + normals) - transform(T, POINTS)
    np.testing.assert_allclose(np.column_stack([moved.columns[name] for name in turned]), ends, atol=1e-6)
    np.testing.assert_array_equal(moved.columns["time"], np.arange(len(POINTS)))


def test_what_a_format_has_no_room_for_is_told(tmp_path: Path):
    times = np.arange(len(POINTS), dtype=np.uint64) + 1_700_000_000_123_456_789
    file = CloudFile(POINTS, {"time": times, "number": np.arange(len(POINTS))}, np.array([[0, 1, 2]]))
    with pytest.warns(CloudWarning, match="time is rounded to 53 bits"):
        save_cloud(tmp_path / "a.ply", file)
    written = read_cloud(tmp_path / "a.ply", whole=True)
    np.testing.assert_allclose(written.columns["time"], times, rtol=1e-15)
    np.testing.assert_array_equal(written.columns["number"], file.columns["number"])
    with pytest.warns(CloudWarning, match="1 faces are not written"):
        save_cloud(tmp_path / "a.xyz", file)
    digits = [int(line.split()[3]) for line in (tmp_path / "a.xyz").read_text().splitlines()[1:]]
    assert digits == times.tolist()


def test_faces_that_are_none_are_told(tmp_path: Path):
    lines = np.empty(2, dtype=[("vertex_indices", "O")])
    lines["vertex_indices"] = [np.array([0, 1], "i4"), np.array([2, 3], "i4")]
    vertices = np.array(list(map(tuple, POINTS)), [(axis, "f8") for axis in "xyz"])
    PlyData([PlyElement.describe(vertices, "vertex"), PlyElement.describe(lines, "face")]).write(tmp_path / "a.ply")
    file = read_cloud(tmp_path / "a.ply")
    assert file.faces is None
    assert file.notes == ("2 faces without a list of three corners or more are not used",)
