"""The command line, run as a user runs it: on files in the user's own units."""

from __future__ import annotations

import errno
import inspect
import json
import os
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import open3d as o3d
import psutil
import pytest

from ido import Cloud, Maps, Perturbation, cli, load_cloud, perturb, poses, shipped_maps, train
from ido.clouds import Frame
from ido.experiments import mean_and_interval, sweep
from ido.files import CloudFile, read_cloud, save_cloud
from ido.types import FloatArray

FRAME = Frame(np.array([1000.0, -200.0, 50.0]), 37.0)
"""The user's units: the bunny is 74 units long and lies far from the origin."""

IDO = (sys.executable, "-c", "import sys; from ido.cli import main; sys.exit(main(sys.argv[1:]))")
"""The command in a process of its own."""

TRAINING = ("--histogram", "front-back", "--samples", "500", "--maps", "6")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory, bunny: Cloud) -> Path:
    """A user's folder: the cloud, and maps trained on it."""
    folder = tmp_path_factory.mktemp("user")
    save_cloud(folder / "cloud.ply", FRAME.to_user_units(bunny.points))
    assert cli.main(["train", str(folder / "cloud.ply"), "-o", str(folder / "maps.npz"), *TRAINING]) is None
    return folder


@pytest.fixture
def T_scene_model(folder: Path, bunny: Cloud) -> FloatArray:
    """The true pose of `scene.pcd`, which it writes, in the user's units: 20 degrees and a tenth of the size."""
    p = Perturbation(noise=0.005, points=1500, outliers=0, incomplete=0, rotation=20, translation=0.1)
    scene = perturb(bunny, p)
    points = o3d.utility.Vector3dVector(FRAME.to_user_units(scene.points))
    assert o3d.io.write_point_cloud(folder / "scene.pcd", o3d.geometry.PointCloud(points))
    return np.linalg.inv(FRAME.pose_in_user_units(scene.T_model_scene))


def fails(capfd: pytest.CaptureFixture[str], *args: str) -> str:
    """The one line on standard error of a command that must fail with exit code 2."""
    assert cli.main(args) == 2
    said = capfd.readouterr()
    assert said.out == ""
    assert said.err.startswith("error: ")
    assert said.err.count("\n") == 1
    assert "Traceback" not in said.err
    return said.err


def test_train_writes_maps_and_says_how_it_went(folder: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]):
    output = tmp_path / "again.npz"
    assert cli.main(["train", str(folder / "cloud.ply"), "-o", str(output), *TRAINING, "--workers", "1"]) is None
    said = capfd.readouterr().err
    assert "6 maps trained in" in said
    assert "Theorem 1 held" in said
    assert f"written to {output}" in said
    first, again = Maps.load(folder / "maps.npz"), Maps.load(output)
    np.testing.assert_array_equal(first.maps, again.maps)  # the same seed; a process pool changes nothing
    assert (first.settings.samples, first.settings.outlier_kind, first.histogram.name) == (500, "uniform", "front-back")
    assert first.frame.scale == pytest.approx(37)


def test_a_shipped_shape_brings_its_own_habits(tmp_path: Path):
    assert cli.main(["train", "urban", "-o", str(tmp_path / "a.npz"), "--samples", "60", "--maps", "1"]) is None
    maps = Maps.load(tmp_path / "a.npz")
    assert maps.settings.outlier_kind == "structured"
    assert (maps.histogram.model.normals[:, 2] >= 0).all()
    assert maps.histogram.name == "triple-binary"


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


def test_sweep_tells_every_method_and_sweep(folder: Path, capfd: pytest.CaptureFixture[str]):
    args = ("--scenes", "2", "--sweeps", "noise", "incomplete", "--epsilon", "0.05")
    maps = [str(folder / "maps.npz"), f"{folder}/./maps.npz"]
    assert cli.main(["sweep", str(folder / "cloud.ply"), "--maps", *maps, *args]) is None
    table = capfd.readouterr().out
    cloud, trained = Cloud.of(load_cloud(folder / "cloud.ply")), Maps.load(folder / "maps.npz")
    for name in ("noise", "incomplete"):
        results = sweep(cloud, trained, name, scenes=2, epsilon=0.05)
        mean, half = mean_and_interval(results[..., 0])
        row = next(line for line in table.splitlines() if name in line)
        assert row.count(f"{mean:.3f} ± {half:.3f} ({results[..., 1].mean():.3f})") == 2


def test_sweep_seeds_are_the_experiments_own():
    ours, theirs = (inspect.signature(f).parameters["seed"].default for f in (cli.sweep_command, sweep))
    assert ours == theirs


def interrupt_at(monkeypatch: pytest.MonkeyPatch, k: int) -> None:
    """Ctrl-C arrives when k maps are finished."""

    def interrupted(*args: Any, progress: Any, **options: Any) -> Maps:
        def pressed(done: int, error: float) -> None:
            progress(done, error)
            if done == k:
                raise KeyboardInterrupt

        return train(*args, progress=pressed, **options)

    monkeypatch.setattr(cli, "train", interrupted)


def test_an_interrupted_training_saves_the_finished_maps_and_says_so(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
):
    interrupt_at(monkeypatch, 2)
    output = tmp_path / "part.npz"
    assert cli.main(["train", str(folder / "cloud.ply"), "-o", str(output), *TRAINING]) == 130
    said = capfd.readouterr().err
    assert "interrupted: only 2 of 6 maps were trained" in said
    assert f"written to {output}" in said
    maps = Maps.load(output)
    assert not maps.complete
    np.testing.assert_array_equal(maps.maps, Maps.load(folder / "maps.npz").maps[:2])


@pytest.mark.skipif(sys.platform == "win32", reason="signals are not those of Windows")
def test_a_training_that_is_told_to_end_saves_the_finished_maps(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
):
    def told(*args: Any, progress: Any, **options: Any) -> Maps:
        def at(done: int, error: float) -> None:
            progress(done, error)
            if done == 3:
                os.kill(os.getpid(), signal.SIGTERM)

        return train(*args, progress=at, **options)

    monkeypatch.setattr(cli, "train", told)
    before = signal.getsignal(signal.SIGTERM)
    output = tmp_path / "part.npz"
    assert cli.main(["train", str(folder / "cloud.ply"), "-o", str(output), *TRAINING]) == 130
    assert "only 3 of 6 maps were trained" in capfd.readouterr().err
    assert len(Maps.load(output).maps) == 3
    assert signal.getsignal(signal.SIGTERM) is before


def test_a_disk_that_is_full_at_the_end_loses_no_training(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
):
    (tmp_path / "full").mkdir()
    (tmp_path / "home").mkdir()
    (tmp_path / "here").mkdir()
    save = Maps.save

    def saved(maps: Maps, path: Path) -> None:
        if path.parent.name in ("full", "here"):
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(path))
        save(maps, path)

    monkeypatch.setattr(Maps, "save", saved)
    monkeypatch.setattr(Path, "home", lambda: tmp_path / "home")
    monkeypatch.chdir(tmp_path / "here")
    output = tmp_path / "full" / "bunny.npz"
    assert cli.main(["train", str(folder / "cloud.ply"), "-o", str(output), *TRAINING]) == 2
    said = capfd.readouterr().err
    (place,) = (tmp_path / "home").iterdir()
    assert f"{output}: No space left on device" in said
    assert f"written to {place}" in said
    np.testing.assert_array_equal(Maps.load(place).maps, Maps.load(folder / "maps.npz").maps)


def test_interrupted_before_the_first_map_nothing_is_written(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
):
    interrupt_at(monkeypatch, 0)
    assert cli.main(["train", str(folder / "cloud.ply"), "-o", str(tmp_path / "a.npz"), *TRAINING]) == 130
    assert "before the first map was finished; nothing was written" in capfd.readouterr().err
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("histogram", ["front-back", "triple-binary", "as-printed"])
def test_a_risen_error_is_told(histogram: str):
    maps = shipped_maps("bunny", histogram)
    assert "Theorem 1 held: the training error fell at every map" in cli.training_summary(maps, 1.0)
    maps.curves.mean[3:5] = maps.curves.mean[2]
    shipped_maps.cache_clear()
    assert "did not fall at map 3, 4" in cli.training_summary(maps, 1.0)[-1]


@pytest.mark.parametrize(
    ("output", "message"),
    [
        ("maps", "must end in .npz"),
        ("maps.zip", "must end in .npz"),
        ("missing/maps.npz", "missing: no such folder"),
        ("cloud.ply/maps.npz", "cloud.ply: no such folder"),
        ("folder.npz", "is a folder"),
    ],
)
def test_train_refuses_a_bad_output_before_it_reads_anything(
    folder: Path, tmp_path: Path, output: str, message: str, capfd: pytest.CaptureFixture[str]
):
    (tmp_path / "folder.npz").mkdir()
    (tmp_path / "cloud.ply").touch()
    assert message in fails(capfd, "train", str(tmp_path / "missing.ply"), "-o", str(tmp_path / output))


@pytest.mark.skipif(sys.platform == "win32", reason="Windows folders have no such permission")
def test_train_refuses_a_folder_it_may_not_write_to(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
):
    monkeypatch.setattr("os.access", lambda path, mode: False)  # the superuser may write anywhere
    assert "no permission to write there" in fails(capfd, "train", "bunny", "-o", str(tmp_path / "a.npz"))


@pytest.mark.parametrize(
    ("setting", "message"),
    [
        (("--samples", "1"), "at least 2 samples"),
        (("--samples", str(10**15)), "not enough memory"),
        (("--maps", "0"), "1 map"),
        (("--ridge", "0"), "ridge must be a positive number"),
        (("--ridge", "nan"), "ridge must be a positive number"),
        (("--seed", "-1"), "seed must not be negative"),
        (("--workers", "0"), "workers must be greater than 0"),
    ],
)
def test_train_refuses_settings_out_of_range(
    tmp_path: Path, setting: tuple[str, str], message: str, capfd: pytest.CaptureFixture[str]
):
    assert cli.main(["train", "bunny", "-o", str(tmp_path / "a.npz"), *setting]) == 2
    said = capfd.readouterr().err
    assert message in said
    assert "Traceback" not in said
    assert not (tmp_path / "a.npz").exists()


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


def test_what_training_leaves_out_of_a_file_is_told(tmp_path: Path, bunny: Cloud, capfd: pytest.CaptureFixture[str]):
    save_cloud(tmp_path / "scan.ply", CloudFile(bunny.points.astype(float)[:600], faces=np.array([[0, 1, 2]])))
    args = ["train", str(tmp_path / "scan.ply"), "-o", str(tmp_path / "a.npz"), "--samples", "20", "--maps", "1"]
    assert cli.main(args) is None
    assert "note: scan.ply: 597 of 600 points belong to none of its 1 faces" in capfd.readouterr().err


@pytest.mark.parametrize("way", ["its name", "another path", "a link", "a hard link"])
@pytest.mark.parametrize("option", ["-o", "--moved"])
def test_register_never_overwrites_what_it_reads(
    folder: Path, tmp_path: Path, way: str, option: str, capfd: pytest.CaptureFixture[str]
):
    cloud, maps = tmp_path / "scan.ply", tmp_path / "maps.ply"  # an ending that both options take
    cloud.write_bytes((folder / "cloud.ply").read_bytes())
    maps.write_bytes((folder / "maps.npz").read_bytes())
    for target, name in ((cloud, "the cloud itself"), (maps, "the maps file itself")):
        before = target.read_bytes()
        output = tmp_path / "output.ply"
        match way:
            case "its name":
                output = target
            case "another path":
                output = tmp_path / ".." / tmp_path.name / target.name
            case "a link":
                output.symlink_to(target)
            case _:
                output.hardlink_to(target)
        args = ("register", str(cloud), "--maps", str(maps), option, str(output), "--force")
        assert f"{option} is {name}" in fails(capfd, *args)
        assert target.read_bytes() == before
        (tmp_path / "output.ply").unlink(missing_ok=True)


def test_two_outputs_are_two_files(folder: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]):
    args = ("register", "bunny", "--maps", str(folder / "maps.npz"), "-o", str(tmp_path / "a.ply"))
    assert "--moved is -o itself" in fails(capfd, *args, "--moved", f"{tmp_path}/./a.ply")
    assert list(tmp_path.iterdir()) == []


def test_files_that_are_there_are_replaced_only_with_force(
    folder: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]
):
    for name in ("pose.json", "moved.xyz", "maps.npz"):
        (tmp_path / name).write_text("precious")
    register = ["register", str(folder / "cloud.ply"), "--maps", str(folder / "maps.npz"), "--max-iterations", "1"]
    for command, name in (
        ([*register, "-o"], "pose.json"),
        ([*register, "--moved"], "moved.xyz"),
        (["train", "bunny", *TRAINING[:2], "--samples", "20", "--maps", "1", "-o"], "maps.npz"),
    ):
        output = tmp_path / name
        assert "is there already; name another file, or replace it with --force" in fails(capfd, *command, str(output))
        assert output.read_text() == "precious"
        assert cli.main([*command, str(output), "--force"]) is None
        assert b"precious" not in output.read_bytes()
        capfd.readouterr()


@pytest.mark.parametrize("output", ["pose.json", "moved.ply", "moved.xyz"])
def test_a_full_disk_is_told_and_leaves_what_was_there(
    folder: Path, tmp_path: Path, output: str, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
):
    def full(file: int) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    (tmp_path / output).write_text("precious")
    monkeypatch.setattr("os.fsync", full)
    option = "-o" if output == "pose.json" else "--moved"
    args = ("register", str(folder / "cloud.ply"), "--maps", str(folder / "maps.npz"), "--force")
    assert "No space left on device" in fails(capfd, *args, option, str(tmp_path / output))
    assert [(file.name, file.read_text()) for file in tmp_path.iterdir()] == [(output, "precious")]


def test_a_table_is_shown_in_any_encoding(folder: Path):
    args = [
        "sweep",
        str(folder / "cloud.ply"),
        "--maps",
        str(folder / "maps.npz"),
        "--scenes",
        "2",
        "--sweeps",
        "noise",
    ]
    command = [*IDO, *args]
    done = subprocess.run(command, env=os.environ | {"PYTHONIOENCODING": "ascii"}, capture_output=True)
    assert done.returncode == 0
    assert b"noise" in done.stdout
    assert b" ? " in done.stdout


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no such pipes")
def test_folders_and_pipes_are_called_what_they_are(folder: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]):
    (tmp_path / "folder.ply").mkdir()
    os.mkfifo(tmp_path / "pipe.ply")
    maps = str(folder / "maps.npz")
    assert "folder.ply: is a folder" in fails(capfd, "register", str(tmp_path / "folder.ply"), "--maps", maps)
    assert "pipe.ply: is a pipe or a device" in fails(capfd, "register", str(tmp_path / "pipe.ply"), "--maps", maps)


@pytest.mark.skipif(sys.platform == "win32", reason="signals are not those of Windows")
def test_workers_of_a_killed_training_end(tmp_path: Path):
    args = ["train", "bunny", "-o", str(tmp_path / "a.npz"), "--samples", "4000", "--maps", "30", "--workers", "2"]
    command = [*IDO, *args]
    with subprocess.Popen(command, stderr=subprocess.DEVNULL) as training:
        parent = psutil.Process(training.pid)
        workers: list[psutil.Process] = []
        deadline = time.monotonic() + 60
        while len(workers) < 2 and time.monotonic() < deadline:
            workers = [child for child in parent.children() if "spawn_main" in " ".join(child.cmdline())]
            time.sleep(0.1)
        assert len(workers) == 2
        training.kill()
    _, alive = psutil.wait_procs(workers, timeout=60)
    assert alive == []


@pytest.mark.parametrize(
    ("args", "message"),
    [
        (("--scenes", "1"), "at least 2 scenes"),
        (("--epsilon", "inf"), "epsilon must be a number"),
        (("--seed", "-5"), "seed must lie between 0 and 4294967295"),
        (("--sweeps",), "name at least one"),
    ],
)
def test_sweep_refuses_settings_out_of_range(args: tuple[str, ...], message: str, capfd: pytest.CaptureFixture[str]):
    assert message in fails(capfd, "sweep", "bunny", "--maps", "bunny-front-back", *args)


def test_sweep_refuses_maps_of_another_cloud(capfd: pytest.CaptureFixture[str]):
    assert "trained on a cloud of another size" in fails(capfd, "sweep", "urban", "--maps", "bunny-front-back")


@pytest.mark.parametrize(
    "args", [[], ["fly"], ["train"], ["train", "bunny"], ["train", "bunny", "-o", "a.npz", "--histogram", "none"]]
)
def test_a_command_that_cannot_be_understood_exits_with_2(args: list[str], capfd: pytest.CaptureFixture[str]):
    with pytest.raises(SystemExit) as stopped:
        cli.main(args)
    assert stopped.value.code == 2
    assert capfd.readouterr().out == ""


@pytest.mark.parametrize("command", ["train", "register", "sweep"])
def test_help_explains_every_option(command: str, capfd: pytest.CaptureFixture[str]):
    with pytest.raises(SystemExit) as stopped:
        cli.main([command, "--help"])
    assert stopped.value.code == 0
    said = capfd.readouterr().out
    for name in inspect.signature(getattr(cli, f"{command}_command")).parameters:
        option = {"onto": "global"}.get(name, name).replace("_", "-")  # the word is Python's own
        assert name == "cloud" or f"--{option}" in said
    assert "bunny" in said
