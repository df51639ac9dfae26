"""`ido register`: the pose in the user's units, its quality, and what it refuses."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from command_line import FRAME, fails

from ido import Maps, cli, load_cloud, poses, shipped_maps
from ido.files import CloudFile, read_cloud, save_cloud
from ido.types import FloatArray


def test_register_prints_the_pose_in_the_users_units(
    folder: Path, T_scene_model: FloatArray, capfd: pytest.CaptureFixture[str]
):
    args = ("register", str(folder / "scene.pcd"), "--maps", str(folder / "maps.npz"), "--epsilon", "0.01")
    assert cli.main(args) is None
    said = capfd.readouterr()
    result = json.loads(said.out)
    assert said.err == ""
    assert list(result) == ["T_model_scene", "iterations", "stop", "converged", "quality", "warnings"]
    assert result["warnings"] == []
    assert result["converged"] is True
    assert result["stop"] == "converged"
    assert result["iterations"] >= 6
    T = np.array(result["T_model_scene"])
    scene = load_cloud(folder / "scene.pcd")
    error = poses.transform(T, scene) - poses.transform(np.linalg.inv(T_scene_model), scene)
    assert np.linalg.norm(error, axis=1).max() < 0.1 * FRAME.scale
    np.testing.assert_allclose(T[:3, :3] @ T[:3, :3].T, np.eye(3), atol=1e-9)


def test_the_quality_is_that_of_the_moved_cloud(
    folder: Path, T_scene_model: FloatArray, capfd: pytest.CaptureFixture[str]
):
    assert cli.main(["register", str(folder / "scene.pcd"), "--maps", str(folder / "maps.npz")]) is None
    result = json.loads(capfd.readouterr().out)
    scene = load_cloud(folder / "scene.pcd")
    model = FRAME.to_user_units(Maps.load(folder / "maps.npz").histogram.model.points)
    moved = poses.transform(np.array(result["T_model_scene"]), scene)
    distances = np.linalg.norm(moved[:, None] - model, axis=2)
    from_model, near = distances.min(axis=1), 0.1 * FRAME.scale
    found = result["quality"]
    assert found["points_read"] == found["points_used"] == len(scene) == 1500
    assert found["points_dropped"] == 0
    assert found["near_share"] == pytest.approx((from_model <= near).mean())
    assert found["near_rmse"] == pytest.approx(np.sqrt((from_model[from_model <= near] ** 2).mean()))
    assert found["covered_share"] == pytest.approx((distances.min(axis=0) <= near).mean())
    np.testing.assert_allclose(found["spread"], np.linalg.svd(scene - scene.mean(axis=0))[1] / np.sqrt(1499), rtol=1e-6)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (np.diag([2.0, 2, 2]), "fits better when it is made 0."),
        (np.diag([1 / 2.54] * 3), "fits better when it is made 2."),
        (np.diag([-1.0, 1, 1]), "fits better when it is mirrored along x"),
        (np.diag([1.0, 1, 0.001]), "lie in a plane"),
        (np.diag([1.0, 0, 0]), "lie on a line"),
    ],
)
def test_a_cloud_that_cannot_fit_is_warned_about_and_fails_when_strict(
    folder: Path,
    T_scene_model: FloatArray,
    tmp_path: Path,
    change: FloatArray,
    message: str,
    capfd: pytest.CaptureFixture[str],
):
    scene = FRAME.to_model_units(load_cloud(folder / "scene.pcd"))
    save_cloud(tmp_path / "changed.ply", FRAME.to_user_units(scene @ change))
    replace(shipped_maps("bunny", "triple-binary"), frame=FRAME).save(tmp_path / "maps.npz")
    args = ["register", str(tmp_path / "changed.ply"), "--maps", str(tmp_path / "maps.npz"), "--start", "centre"]
    assert cli.main(args) is None
    said = capfd.readouterr()
    warnings = json.loads(said.out)["warnings"]
    assert any(message in warning for warning in warnings)
    assert said.err.count("warning: ") == len(warnings)
    assert cli.main([*args, "--strict"]) == 3


def test_strict_is_content_with_a_good_fit(folder: Path, T_scene_model: FloatArray):
    args = ("--maps", str(folder / "maps.npz"), "--epsilon", "0.01", "--strict")
    assert cli.main(["register", str(folder / "scene.pcd"), *args]) is None
    assert cli.main(["register", str(folder / "scene.pcd"), *args, "--max-iterations", "1"]) == 3


def test_dropped_points_are_told_and_stay_in_the_moved_cloud_with_all_columns(
    folder: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]
):
    points = load_cloud(folder / "cloud.ply")[:2000].copy()
    points[7, 1] = points[9, 2] = np.nan
    rng = np.random.default_rng(0)
    columns = {"red": rng.integers(0, 256, 2000).astype(np.uint8), "intensity": rng.random(2000).astype(np.float32)}
    save_cloud(tmp_path / "scan.ply", CloudFile(points, columns))
    args = ["register", str(tmp_path / "scan.ply"), "--maps", str(folder / "maps.npz"), "--moved"]
    moved = str(tmp_path / "moved.ply")
    assert "2 of 2000 points have coordinates that are not finite" in fails(capfd, *args, moved)
    assert cli.main([*args, moved, "--drop-invalid"]) is None
    said = capfd.readouterr()
    assert "note: 2 of 2000 points have coordinates that are not finite and are dropped" in said.err
    result = json.loads(said.out)
    assert (result["quality"]["points_read"], result["quality"]["points_dropped"]) == (2000, 2)
    written = read_cloud(moved)
    expected = poses.transform(np.array(result["T_model_scene"]), points)
    np.testing.assert_allclose(written.points, expected, atol=1e-6)
    for name, values in columns.items():
        np.testing.assert_array_equal(written.columns[name], values)


@pytest.mark.parametrize("suffix", [".ply", ".xyz"])
def test_register_writes_the_pose_and_the_whole_moved_cloud(
    folder: Path, tmp_path: Path, suffix: str, capfd: pytest.CaptureFixture[str]
):
    pose, moved, cloud = tmp_path / "pose.json", tmp_path / f"moved{suffix}", str(folder / "cloud.ply")
    files = ("-o", str(pose), "--moved", str(moved))
    assert cli.main(["register", cloud, "--maps", str(folder / "maps.npz"), "--max-iterations", "7", *files]) is None
    assert capfd.readouterr().out == ""
    result = json.loads(pose.read_text())
    assert result["iterations"] <= 7
    assert result["converged"] == (result["stop"] == "converged")
    expected = poses.transform(np.array(result["T_model_scene"]), load_cloud(cloud))
    assert len(expected) > 30_000
    np.testing.assert_allclose(load_cloud(moved), expected, atol=1e-6)


def test_a_far_cloud_is_warned_about_and_found_from_the_centre(
    folder: Path, T_scene_model: FloatArray, tmp_path: Path, capfd: pytest.CaptureFixture[str]
):
    shift = np.array([9000.0, 0, -500])
    far, maps = str(tmp_path / "far.xyz"), str(folder / "maps.npz")
    scene = load_cloud(folder / "scene.pcd")
    save_cloud(far, scene + shift)
    assert cli.main(["register", far, "--maps", maps]) is None
    said = capfd.readouterr()
    np.testing.assert_allclose(json.loads(said.out)["T_model_scene"], np.eye(4), atol=1e-9)
    assert said.err.startswith("warning: ")
    assert "--start centre" in said.err
    assert "units" in said.err
    assert cli.main(["register", far, "--maps", maps, "--start", "centre", "--epsilon", "0.01"]) is None
    said = capfd.readouterr()
    assert said.err == ""
    T = np.array(json.loads(said.out)["T_model_scene"])
    error = poses.transform(T, scene + shift) - poses.transform(np.linalg.inv(T_scene_model), scene)
    assert np.linalg.norm(error, axis=1).max() < 0.1 * FRAME.scale


def test_shipped_names_work(capfd: pytest.CaptureFixture[str]):
    assert cli.main(["register", "bunny", "--maps", "bunny-triple-binary", "--max-iterations", "60"]) is None
    T = np.array(json.loads(capfd.readouterr().out)["T_model_scene"])
    scale = shipped_maps("bunny", "triple-binary").frame.scale
    np.testing.assert_allclose(T[:3, :3], np.eye(3), atol=0.02)
    np.testing.assert_allclose(T[:3, 3], 0, atol=0.03 * scale)


def test_a_broken_cloud_or_maps_file_is_one_clear_line(folder: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]):
    cloud, maps, broken = str(folder / "cloud.ply"), str(folder / "maps.npz"), tmp_path / "[red]odd[b] name.ply"
    broken.write_text("no\ncloud\n")
    assert "[red]odd[b] name.ply: is cut off, or not what its name says" in fails(
        capfd, "register", str(broken), "--maps", maps
    )
    assert "no such file" in fails(capfd, "register", "missing.ply", "--maps", maps)
    assert "unknown kind of file" in fails(capfd, "register", "horse", "--maps", maps)
    assert "no such file; make one with" in fails(capfd, "register", cloud, "--maps", "missing.npz")
    assert "no such maps; give a .npz file or one of bunny-" in fails(capfd, "register", cloud, "--maps", "bunny-x")
    assert "not a maps file" in fails(capfd, "register", cloud, "--maps", cloud)
    assert "no such file" in fails(capfd, "sweep", "missing.ply", "--maps", maps)
    save_cloud(tmp_path / "few.xyz", np.random.default_rng(0).normal(size=(20, 3)))
    few = fails(capfd, "train", str(tmp_path / "few.xyz"), "-o", str(tmp_path / "few.npz"))
    assert "the cloud has 20 points, a model needs at least 514" in few


@pytest.mark.parametrize(
    ("args", "message"),
    [
        (("--epsilon", "nan"), "epsilon must be a number"),
        (("--epsilon", "-1"), "epsilon must be a number"),
        (("--max-iterations", "0"), "max-iterations must be at least 1"),
        (("-o", "missing/pose.json"), "missing: no such folder"),
        (("--moved", "moved.las"), "must end in .ply or .xyz"),
        (("--moved", "missing/moved.ply"), "missing: no such folder"),
    ],
)
def test_register_refuses_settings_out_of_range(args: tuple[str, str], message: str, capfd: pytest.CaptureFixture[str]):
    assert message in fails(capfd, "register", "bunny", "--maps", "bunny-front-back", *args)
