"""What commands write: never over what they read, whole or not at all."""

from __future__ import annotations

import errno
import os
import sys
from pathlib import Path

import pytest
from command_line import TRAINING, fails

from ido import cli


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


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no such pipes")
def test_folders_and_pipes_are_called_what_they_are(folder: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]):
    (tmp_path / "folder.ply").mkdir()
    os.mkfifo(tmp_path / "pipe.ply")
    maps = str(folder / "maps.npz")
    assert "folder.ply: is a folder" in fails(capfd, "register", str(tmp_path / "folder.ply"), "--maps", maps)
    assert "pipe.ply: is a pipe or a device" in fails(capfd, "register", str(tmp_path / "pipe.ply"), "--maps", maps)
