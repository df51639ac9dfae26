"""`ido train`: what it writes and says, and what it loses when it is stopped: nothing."""

from __future__ import annotations

import errno
import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import psutil
import pytest
from command_line import BESIDE_ITS_OWN, IDO, TRAINING, fails

from ido import Cloud, Maps, cli, shipped_maps, train
from ido.files import CloudFile, save_cloud


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


def test_what_training_leaves_out_of_a_file_is_told(tmp_path: Path, bunny: Cloud, capfd: pytest.CaptureFixture[str]):
    save_cloud(tmp_path / "scan.ply", CloudFile(bunny.points.astype(float)[:600], faces=np.array([[0, 1, 2]])))
    args = ["train", str(tmp_path / "scan.ply"), "-o", str(tmp_path / "a.npz"), "--samples", "20", "--maps", "1"]
    assert cli.main(args) is None
    assert "note: scan.ply: 597 of 600 points belong to none of its 1 faces" in capfd.readouterr().err


@pytest.mark.skipif(sys.platform == "win32", reason="signals are not those of Windows")
def test_workers_of_a_killed_training_end(tmp_path: Path):
    args = ["train", "bunny", "-o", str(tmp_path / "a.npz"), "--samples", "4000", "--maps", "30", "--workers", "2"]
    command = [*IDO, *args]
    with subprocess.Popen(command, stderr=subprocess.DEVNULL) as training:
        parent = psutil.Process(training.pid)
        begun: list[psutil.Process] = []
        deadline = time.monotonic() + 60
        while len(begun) < 2 + BESIDE_ITS_OWN and time.monotonic() < deadline:
            begun = parent.children(recursive=True)
            time.sleep(0.1)
        assert len(begun) == 2 + BESIDE_ITS_OWN
        training.kill()
    _, alive = psutil.wait_procs(begun, timeout=60)
    assert alive == []


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
