"""Files of clouds of every kind: points survive, and what is broken or foreign is refused by name."""

from __future__ import annotations

import gzip
import pickle
import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np
import open3d as o3d
import pytest
import trimesh
from cloud_files import VARIANTS, Variant

from ido import CloudError, CloudWarning, load_cloud
from ido.files import READERS, loading, read_cloud, save_cloud
from ido.files.cloud_file import MESH_SAMPLES
from ido.types import FloatArray

POINTS = np.random.default_rng(0).normal([300, -20, 5], [40, 10, 2], (60, 3))


def write_trimesh(path: Path, points: FloatArray) -> None:
    colors = np.full((len(points), 4), 255, dtype=np.uint8)  # before 5.2 trimesh writes no XYZ without
    trimesh.PointCloud(points, colors=colors).export(path)


def write_open3d(path: Path, points: FloatArray) -> None:
    assert o3d.io.write_point_cloud(path, o3d.geometry.PointCloud(o3d.utility.Vector3dVector(points)))


def write_open3d_ascii(path: Path, points: FloatArray) -> None:
    cloud = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(points))
    assert o3d.io.write_point_cloud(path, cloud, write_ascii=True)


def write_vertices(path: Path, points: FloatArray) -> None:
    rows = [" ".join(map(repr, map(float, point))) for point in points]
    head = f"OFF\n{len(points)} 0 0\n" if path.suffix == ".off" else ""
    path.write_text(head + "\n".join(("v " if path.suffix == ".obj" else "") + row for row in rows) + "\n")


def write_columns(path: Path, points: FloatArray) -> None:
    np.savetxt(path, np.column_stack([points, np.ones((len(points), 4))]), header="x y z and more")


def write_commas(path: Path, points: FloatArray) -> None:
    np.savetxt(path, points, delimiter=",")


def write_npz(path: Path, points: FloatArray) -> None:
    np.savez(path, points=points, other=points[:20] + 1)


def write_npz_other_name(path: Path, points: FloatArray) -> None:
    np.savez(path, xyz=points, intensity=points[:, 0])


@pytest.mark.parametrize(
    ("name", "write", "tolerance"),
    [
        ("a.ply", write_trimesh, 1e-4),  # float32
        ("a.ply", write_open3d, 0),
        ("a.ply", write_open3d_ascii, 1e-3),
        ("A.PLY", write_open3d, 0),
        ("a.pcd", write_open3d, 1e-4),
        ("a.pcd", write_open3d_ascii, 1e-4),
        ("a.xyz", write_open3d, 1e-9),
        ("a.xyz", write_trimesh, 1e-7),
        ("a.xyz", write_columns, 1e-12),
        ("a.xyz", write_commas, 1e-12),
        ("a.obj", write_vertices, 0),
        ("a.off", write_vertices, 0),
        ("a.npz", write_npz, 0),
        ("a.npz", write_npz_other_name, 0),
        ("saved.ply", save_cloud, 0),
        ("saved.xyz", save_cloud, 1e-9),
    ],
)
def test_points_survive_the_file(
    tmp_path: Path, name: str, write: Callable[[Path, FloatArray], None], tolerance: float
):
    write(tmp_path / name, POINTS)
    loaded = load_cloud(tmp_path / name)
    assert loaded.dtype == np.float64
    np.testing.assert_allclose(loaded, POINTS, rtol=0, atol=tolerance)


@pytest.mark.parametrize("suffix", [".ply", ".obj", ".stl", ".off"])
def test_meshes_are_sampled_evenly_by_area(tmp_path: Path, suffix: str):
    small, large = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]]), np.array([[5.0, 0, 0], [8, 0, 0], [5, 3, 0]])
    mesh = trimesh.Trimesh(np.concatenate([small, large]), [[0, 1, 2], [3, 4, 5]], process=False)
    mesh.export(tmp_path / f"two{suffix}")
    points = load_cloud(tmp_path / f"two{suffix}")
    on_small = points[:, 0] < 2
    assert len(points) == MESH_SAMPLES
    assert on_small.mean() == pytest.approx(0.1, abs=0.01)  # areas 1 : 9
    np.testing.assert_allclose(points[on_small].mean(axis=0), small.mean(axis=0), atol=0.02)
    np.testing.assert_allclose(points[~on_small].mean(axis=0), large.mean(axis=0), atol=0.03)
    np.testing.assert_array_equal(points, load_cloud(tmp_path / f"two{suffix}"))


def test_a_scene_of_several_meshes_keeps_their_places(tmp_path: Path):
    boxes = [trimesh.creation.box(), trimesh.creation.box().apply_translation([5, 0, 0])]
    trimesh.Scene(boxes).export(tmp_path / "boxes.obj")
    points = load_cloud(tmp_path / "boxes.obj")
    np.testing.assert_allclose(np.ptp(points, axis=0), [6, 1, 1], atol=0.01)


@pytest.mark.parametrize("name", ["cloud.doc", "cloud", "cloud.gz"])
def test_unknown_kinds_of_file_are_refused_and_the_known_ones_named(tmp_path: Path, name: str):
    (tmp_path / name).write_text("1 2 3\n" * 20)
    with pytest.raises(CloudError, match=r"unknown kind of file; give one of .*\.npz.*\.ply"):
        load_cloud(tmp_path / name)


SUFFIXES = [".ply", ".obj", ".stl", ".off", ".xyz", ".pcd", ".npz"]


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_missing_empty_and_garbage_files_are_refused_by_name(
    tmp_path: Path, suffix: str, capfd: pytest.CaptureFixture[str]
):
    contents = {"empty": b"", "text": b"this is no cloud\nat all\n", "noise": np.random.default_rng(4).bytes(5000)}
    with pytest.raises(CloudError, match="no such file"):
        load_cloud(tmp_path / f"missing{suffix}")
    for kind, content in contents.items():
        (tmp_path / f"{kind}{suffix}").write_bytes(content)
        with pytest.raises(CloudError, match=f"^{kind}{suffix}: "):
            load_cloud(tmp_path / f"{kind}{suffix}")
    assert capfd.readouterr().out == ""


def test_a_cut_off_binary_file_is_refused(tmp_path: Path):
    write_trimesh(tmp_path / "a.ply", POINTS)
    (tmp_path / "a.ply").write_bytes((tmp_path / "a.ply").read_bytes()[:-50])
    with pytest.raises(CloudError, match=r"^a\.ply: is cut off: its head promises 60 rows, it holds 56"):
        load_cloud(tmp_path / "a.ply")


@pytest.mark.parametrize("suffix", [".ply", ".xyz", ".pcd", ".npz"])
def test_a_file_with_nan_says_how_many(tmp_path: Path, suffix: str):
    holed = np.where(np.arange(60)[:, None] == 7, np.nan, POINTS)
    path = tmp_path / f"holed{suffix}"
    {".npz": write_npz, ".xyz": write_columns}.get(suffix, write_open3d)(path, holed)
    with pytest.raises(CloudError, match=rf"^holed\{suffix}: 1 of 60 points"):
        load_cloud(path)


class Bomb:
    """Loading its pickle creates a file."""

    def __init__(self, path: Path) -> None:
        self.path = path

    def __reduce__(self) -> tuple[Callable[[Path], None], tuple[Path]]:
        return Path.touch, (self.path,)


def test_pickles_are_never_loaded(tmp_path: Path):
    trace = tmp_path / "exploded"
    np.savez(tmp_path / "bomb.npz", points=np.array([[Bomb(trace)] * 3] * 20))
    with pytest.raises(CloudError, match="cannot be read as NPZ"):
        load_cloud(tmp_path / "bomb.npz")
    (tmp_path / "pickle.npz").write_bytes(pickle.dumps(Bomb(trace)))
    with pytest.raises(CloudError, match="not an NPZ file"):
        load_cloud(tmp_path / "pickle.npz")
    assert not trace.exists()


def test_an_npz_without_one_cloud_is_refused(tmp_path: Path):
    np.savez(tmp_path / "two.npz", a=POINTS, b=POINTS)
    np.savez(tmp_path / "none.npz", a=POINTS[:, :2])
    for name in ("two.npz", "none.npz"):
        with pytest.raises(CloudError, match="needs an array 'points'"):
            load_cloud(tmp_path / name)


def test_arrays_beside_the_points_are_their_columns(tmp_path: Path):
    colours = np.random.default_rng(5).integers(0, 256, (60, 3)).astype(np.uint8)
    np.savez(tmp_path / "a.npz", points=POINTS, colour=colours, seen=POINTS[:, 0] > 300, other=POINTS[:9])
    file = read_cloud(tmp_path / "a.npz")
    assert list(file.columns) == ["colour_0", "colour_1", "colour_2", "seen"]
    np.testing.assert_array_equal(np.column_stack([file.columns[f"colour_{i}"] for i in range(3)]), colours)
    for name in ("saved.ply", "saved.xyz"):
        save_cloud(tmp_path / name, file)
        again = read_cloud(tmp_path / name, whole=True)
        for column, values in file.columns.items():
            np.testing.assert_array_equal(again.columns[column].astype(values.dtype), values)


@pytest.mark.parametrize("variant", [variant for variant in VARIANTS if variant.name.startswith("scan.la")])
def test_the_dimensions_of_a_laser_scan_are_its_columns(tmp_path: Path, variant: Variant):
    file = read_cloud(variant.write(tmp_path), whole=True)
    np.testing.assert_array_equal(file.columns["intensity"], np.arange(60))
    assert {"red", "classification", "gps_time"} <= set(file.columns)
    assert read_cloud(variant.write(tmp_path)).columns == {}


@pytest.mark.parametrize("suffix", sorted(READERS))
def test_every_kind_may_be_packed(tmp_path: Path, suffix: str):
    variant = next(v for v in VARIANTS if v.name.endswith(suffix) and not v.refused) if suffix != ".stl" else None
    if variant:
        path = variant.write(tmp_path)
    else:
        path = tmp_path / "box.stl"
        trimesh.creation.box().export(str(path))
    packed = tmp_path / f"{path.name}.gz"
    packed.write_bytes(gzip.compress(path.read_bytes()))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", CloudWarning)
        np.testing.assert_array_equal(load_cloud(packed), load_cloud(path))


def test_what_unpacks_to_too_much_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(loading, "MOST_UNPACKED", 1 << 20)
    (tmp_path / "a.xyz.gz").write_bytes(gzip.compress(bytes(2 << 20)))
    with pytest.raises(CloudError, match=r"a\.xyz\.gz: unpacks to more than"):
        load_cloud(tmp_path / "a.xyz.gz")


def test_columns_of_a_text_keep_their_names_and_none_is_lost(tmp_path: Path):
    table = np.column_stack([POINTS, np.arange(180).reshape(60, 3)])
    rows = [" ".join(map(repr, map(float, row))) for row in table]
    for head, names in (("x y z i i t", ["i4", "i5", "t"]), ("# no names", ["column4", "column5", "column6"])):
        (tmp_path / "a.txt").write_text("\n".join([head, *rows]))
        file = read_cloud(tmp_path / "a.txt", whole=True)
        assert list(file.columns) == names
        np.testing.assert_array_equal(np.column_stack(list(file.columns.values())), table[:, 3:])


def test_columns_of_words_are_told_when_they_cannot_be_kept(tmp_path: Path):
    (tmp_path / "a.txt").write_text("\n".join(f"{x} {y} {z} wall" for x, y, z in POINTS))
    assert read_cloud(tmp_path / "a.txt").notes == ()
    file = read_cloud(tmp_path / "a.txt", whole=True)
    np.testing.assert_array_equal(file.points, POINTS)
    assert file.notes == ("its columns besides x, y and z are not all numbers and are not kept",)


def test_points_in_one_place_are_refused_whoever_asks(tmp_path: Path):
    (tmp_path / "a.xyz").write_text("400000.5 5400000.5 120\n" * 60)
    with pytest.raises(CloudError, match=r"^a\.xyz: all points of the cloud lie in one place"):
        load_cloud(tmp_path / "a.xyz")
