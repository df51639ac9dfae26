"""A folder of scans: a row for each, however often the run is stopped, and none mixed with those of other settings."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, Future
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ido import Cloud, Perturbation, cli, load_cloud, perturb, poses, shipped_maps
from ido.experiments import workers
from ido.files import save_cloud
from ido.scores import ACCURACY_THRESHOLD
from ido.user_units import register_original

NAMES = ["a.ply", "b.xyz", "c.ply"]


class Here(Executor):
    """Does each task as it is submitted; before one of them something else happens."""

    def __init__(self, at: int = -1, happens: Callable[[], None] = lambda: None) -> None:
        self.left, self.happens = at, happens

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        if self.left == 0:
            self.happens()
        self.left -= 1
        future: Future[Any] = Future()
        future.set_result(fn(*args, **kwargs))
        return future


def interrupt() -> None:
    raise KeyboardInterrupt


@pytest.fixture
def folder(tmp_path: Path, bunny: Cloud) -> Path:
    """Scans with a file that is none, and one that cannot be used."""
    folder = tmp_path / "scans"
    folder.mkdir()
    for seed, name in enumerate(NAMES):
        scene = perturb(bunny, Perturbation(seed=seed, outliers=0, incomplete=0, rotation=30))
        save_cloud(folder / name, bunny.frame.to_user_units(scene.points))
    (folder / "notes.md").write_text("no scan")
    return folder


@pytest.fixture
def use(monkeypatch: pytest.MonkeyPatch) -> Callable[[Executor], None]:
    """Lets an executor do the work."""

    def use(executor: Executor) -> None:
        @contextmanager
        def local(workers: int) -> Iterator[tuple[Executor, int]]:
            yield executor, 1

        monkeypatch.setattr(workers, "local_executor", local)

    return use


def command(folder: Path, *more: str) -> list[str]:
    output = str(folder.parent / "poses.jsonl")
    return ["register", str(folder), "--maps", "bunny-front-back", "--epsilon", "0.01", "-o", output, *more]


def rows(folder: Path) -> list[dict[str, Any]]:
    """The rows after the first."""
    _, *found = [json.loads(line) for line in (folder.parent / "poses.jsonl").read_text().splitlines()]
    return found


def test_every_scan_has_the_row_that_it_has_alone(folder: Path, use: Callable[[Executor], None]):
    use(Here())
    assert cli.main(command(folder)) is None
    found = rows(folder)
    assert [row["file"] for row in found] == NAMES
    for row in found:
        T, track = register_original(
            shipped_maps("bunny", "front-back"), load_cloud(folder / row["file"]), epsilon=0.01
        )
        np.testing.assert_allclose(row["T_model_scene"], T, atol=1e-9)
        assert (row["iterations"], row["converged"]) == (track.iterations, True)
        assert row["quality"]["near_share"] > 0.8


def test_processes_find_the_same(folder: Path, use: Callable[[Executor], None]):
    assert cli.main(command(folder, "--workers", "1")) is None
    alone = {row["file"]: row for row in rows(folder)}
    (folder.parent / "poses.jsonl").unlink()
    use(Here())
    assert cli.main(command(folder)) is None
    assert {row["file"]: row for row in rows(folder)} == alone


@pytest.mark.parametrize("at", [0, 1, 2])
def test_a_stopped_run_goes_on_and_ends_as_one_that_was_not(
    folder: Path, at: int, use: Callable[[Executor], None], capfd: pytest.CaptureFixture[str]
):
    use(Here(at, interrupt))
    assert cli.main(command(folder)) == 130
    assert "the same command goes on from there" in " ".join(capfd.readouterr().err.split())
    before = (folder.parent / "poses.jsonl").read_bytes()
    assert len(rows(folder)) == at
    with (folder.parent / "poses.jsonl").open("ab") as file:
        file.write(b'{"file": "c.ply", "by')  # as a kill leaves it
    use(Here())
    assert cli.main(command(folder)) is None
    assert (folder.parent / "poses.jsonl").read_bytes().startswith(before)
    assert [row["file"] for row in rows(folder)] == NAMES
    use(Here(0, interrupt))  # nothing is left to do
    assert cli.main(command(folder)) is None


def test_a_file_that_cannot_be_used_is_a_row_with_its_error(
    folder: Path, use: Callable[[Executor], None], capfd: pytest.CaptureFixture[str]
):
    (folder / "b.xyz").write_text("1,5 2,5 3,5\n" * 20)
    use(Here())
    assert cli.main(command(folder)) == 2
    assert "error: b.xyz: line 1: " in capfd.readouterr().err
    assert [row["file"] for row in rows(folder) if "error" in row] == ["b.xyz"]
    assert [row["file"] for row in rows(folder)] == NAMES


def test_doubtful_scans_are_told_and_counted_when_strict(
    folder: Path, use: Callable[[Executor], None], capfd: pytest.CaptureFixture[str]
):
    save_cloud(folder / "b.xyz", load_cloud(folder / "b.xyz") * 2.54)
    use(Here())
    assert cli.main(command(folder, "--strict")) == 3
    said = capfd.readouterr().err
    assert "warning: b.xyz: the fit is poor" in said
    assert "3 scans, 0 of them not usable, 1 doubtful" in said


def test_a_folder_from_any_start_has_the_rows_that_its_scans_have_alone_and_goes_on_after_a_stop(
    folder: Path, bunny: Cloud, use: Callable[[Executor], None], capfd: pytest.CaptureFixture[str]
):
    far = perturb(bunny, Perturbation(seed=9, rotation=150, translation=1, incomplete=0.2))
    save_cloud(folder / "a.ply", bunny.frame.to_user_units(far.points))
    save_cloud(folder / "b.xyz", np.random.default_rng(0).uniform(-0.1, 0.1, (300, 3)))  # no bunny in it
    save_cloud(folder / "c.ply", np.eye(3))
    output = folder.parent / "poses.jsonl"
    args = ["register", str(folder), "--global", "bunny", "-o", str(output)]
    use(Here(1, interrupt))
    assert cli.main(args) == 130
    assert [row["file"] for row in rows(folder)] == ["a.ply"]
    before = output.read_bytes()
    capfd.readouterr()
    use(Here())
    assert cli.main([*args, "--strict"]) == 2
    said = " ".join(capfd.readouterr().err.split())
    assert output.read_bytes().startswith(before)
    right, doubtful, unusable = rows(folder)
    assert "c.ply: a cloud needs at least 10 points; this has 3" in unusable["error"] and unusable["error"] in said
    assert "warning: b.xyz: " in said and "3 scans, 1 of them not usable, 1 doubtful" in said
    assert doubtful["confidence"]["probability"] < 0.5 and right["confidence"]["probability"] > 0.95
    moved = poses.transform(np.array(right["T_model_scene"]), bunny.frame.to_user_units(far.points))
    belongs = poses.transform(far.T_model_scene, far.points)
    away = np.linalg.norm(bunny.frame.to_model_units(moved) - belongs, axis=1)
    assert (away[~far.is_outlier] < ACCURACY_THRESHOLD).mean() >= 0.9, "right, as the probability is meant"
    assert cli.main(["register", str(folder / "a.ply"), "--global", "bunny"]) is None
    alone = json.loads(capfd.readouterr().out)
    assert {name: right[name] for name in alone} == alone
    (folder / "c.ply").unlink()
    assert cli.main([*args, "--strict", "--force"]) == 3
    assert cli.main([*args[:3], "urban", *args[4:]]) == 2
    assert "was made with another model" in capfd.readouterr().err


@pytest.mark.parametrize(
    ("more", "message"),
    [
        (("--start", "centre"), "other maps or settings"),
        (("--maps", "bunny-triple-binary"), "other maps or settings"),
        (("--drop-invalid",), "other maps or settings"),
    ],
)
def test_rows_of_other_settings_are_never_mixed(
    folder: Path,
    more: tuple[str, ...],
    message: str,
    use: Callable[[Executor], None],
    capfd: pytest.CaptureFixture[str],
):
    use(Here())
    assert cli.main(command(folder)) is None
    before = (folder.parent / "poses.jsonl").read_bytes()
    assert cli.main(command(folder, *more)) == 2
    assert message in capfd.readouterr().err
    assert (folder.parent / "poses.jsonl").read_bytes() == before
    assert cli.main(command(folder, *more, "--force")) is None
    assert len(rows(folder)) == 3


def test_a_scan_that_changed_since_is_told(
    folder: Path, use: Callable[[Executor], None], capfd: pytest.CaptureFixture[str]
):
    use(Here())
    assert cli.main(command(folder)) is None
    os.utime(folder / "a.ply", (1, 1))
    assert cli.main(command(folder)) == 2
    assert "a.ply has changed since" in capfd.readouterr().err


def test_what_a_folder_needs_is_told(folder: Path, capfd: pytest.CaptureFixture[str]):
    output = folder.parent / "poses.jsonl"
    maps = ["--maps", "bunny-front-back"]
    (folder.parent / "empty").mkdir()
    for args, message in (
        (["register", str(folder), *maps], "give -o FILE.jsonl"),
        (["register", str(folder), *maps, "-o", str(output), "--moved", "a.ply"], "no --moved"),
        (["register", str(folder), *maps, "-o", "a.json"], "must end in .jsonl"),
        (["register", str(folder.parent / "empty"), *maps, "-o", str(output)], "holds no clouds"),
        (["register", "bunny", *maps, "--workers", "2"], "for a folder of scans"),
        (command(folder, "--workers", "1", "--dask", "tcp://nowhere"), "--workers is for this machine"),
    ):
        assert cli.main(args) == 2
        assert message in capfd.readouterr().err
    output.write_text("my notes\n")
    assert cli.main(command(folder)) == 2
    assert "no file of poses" in capfd.readouterr().err
    assert output.read_text() == "my notes\n"
