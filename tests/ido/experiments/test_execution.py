"""The run of an experiment: every registration once, however often it is stopped, whoever does the work."""

from __future__ import annotations

import os
import sqlite3
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import BrokenExecutor, Executor, Future, ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import psutil
import pytest

from ido import Confidence, Perturbation, cli, perturb, score, shipped_cloud
from ido.experiments import LEVELS, level_scene, workers
from ido.experiments import execution as engine
from ido.experiments.execution import FAILED, Chunk, Experiment, run, run_chunk
from ido.experiments.families import COMPARED_METHODS
from ido.experiments.store import Row, Store
from ido.experiments.workers import local_executor
from ido.methods import compared, shipped_method

SMALL = ("--sweeps", "noise", "--methods", "DO", "ICP, default", "--scenes", "3")
EXPERIMENT = Experiment(sweeps=("noise",), methods=("DO", "ICP, default"), scenes=3)


def rows_of(path: Path) -> list[tuple[Any, ...]]:
    """All rows in the order of their writing, the number of each first."""
    connection = sqlite3.connect(path)
    rows = connection.execute("SELECT rowid, * FROM registrations ORDER BY rowid").fetchall()
    connection.close()
    return rows


def untimed(rows: list[Any]) -> set[tuple[Any, ...]]:
    """Rows without their seconds, each of which must be positive; without a probability, as a file has them."""
    named = [Row(*row) for row in rows]
    assert all(row.seconds > 0 for row in named)
    return {row._replace(seconds=0.0, probability=_known(row.probability)) for row in named}


def _known(probability: float | None) -> Any:
    return None if probability is None or np.isnan(probability) else probability


@pytest.fixture(scope="module")
def expected() -> set[tuple[Any, ...]]:
    """What the small experiment finds, computed here and now."""
    return untimed([row for chunk in EXPERIMENT.missing(()) for row in run_chunk(chunk)])


class Here(Executor):
    """Does each chunk as it is submitted; at one of them something else happens."""

    def __init__(self, at: int = -1, happens: Callable[[], None] = lambda: None) -> None:
        self.left, self.happens = at, happens

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        if self.left == 0:
            self.happens()
        self.left -= 1
        future: Future[Any] = Future()
        future.set_result(fn(*args, **kwargs))
        return future


def ctrl_c() -> None:
    raise KeyboardInterrupt


def test_the_whole_paper_is_planned_by_default():
    keys = Experiment().keys
    n_levels = sum(map(len, LEVELS.values()))
    n_methods = sum(len(compared(shape)) for shape in ("bunny", "urban"))
    assert len(keys) == len(set(keys)) == n_levels * 100 * n_methods
    chunks = Experiment().missing(())
    assert [key for c in chunks for key in keys_of(c)] == keys
    assert max(len(chunk.trials) for chunk in chunks) == 10
    first_tenth = Experiment(scenes=10)
    assert chunks[: len(first_tenth.missing(()))] == first_tenth.missing(())  # something of all comes first


def keys_of(chunk: Chunk) -> list[tuple[Any, ...]]:
    return [(chunk.dataset, chunk.method, chunk.sweep, chunk.level, trial) for trial in chunk.trials]


def test_only_what_is_not_recorded_is_planned():
    whole = Experiment(sweeps=("noise",), methods=("DO",), scenes=23)
    rng = np.random.default_rng(0)
    recorded = {key for key in whole.keys if rng.random() < 0.5}
    planned = [key for chunk in whole.missing(recorded) for key in keys_of(chunk)]
    assert sorted(planned) == sorted(set(whole.keys) - recorded)
    assert whole.missing(set(whole.keys)) == []


def test_fewer_scenes_are_the_first_of_more_and_all_methods_meet_the_same():
    few, more = (
        {
            row[:6]
            for c in Experiment(sweeps=("incomplete",), methods=methods, scenes=n).missing(())
            for row in run_chunk(c)
        }
        for methods, n in ((("Did nothing",), 2), (("Did nothing", "DO"), 4))
    )
    assert few == {row for row in more if row[1] == "Did nothing" and row[4] < 2}
    seeds = {method: {(*row[2:6], row[0]) for row in more if row[1] == method} for method in ("Did nothing", "DO")}
    assert seeds["Did nothing"] == seeds["DO"]
    assert len({row[5] for row in more}) == 4 * len(LEVELS["incomplete"])  # every scene is a draw of its own


@pytest.mark.parametrize(("dataset", "kind"), [("bunny", "uniform"), ("urban", "structured")])
def test_a_row_tells_what_registering_its_scene_gives(dataset: str, kind: Any):
    (row,) = run_chunk(Chunk(dataset, "DO", "rotation", 30.0, (7,), 1_000_000))
    perturbation = level_scene(Perturbation(outlier_kind=kind), "rotation", 30, 7, 100, 1_000_000)
    scene = perturb(shipped_cloud(dataset), perturbation)
    track = shipped_method(dataset, "DO").register(scene.points)
    found = score(scene, track.T_model_scene[-1])
    assert row.seed == perturbation.seed == 1_040_107
    assert row[6:10] == (found.accuracy, found.rmse, found.rotation, found.translation)
    assert row[11:13] == (track.iterations, str(track.stop)) and np.isnan(row.probability)
    assert 0 < row.seconds < 5


def test_a_method_that_says_how_sure_it_is_has_its_probability_recorded():
    (row,) = run_chunk(Chunk("bunny", "Global", "noise", 0.0, (3,), 1_000_000))
    scene = perturb(shipped_cloud("bunny"), level_scene(Perturbation(), "noise", 0, 3, 100, 1_000_000))
    registration = shipped_method("bunny", "Global").registration
    assert registration
    result = registration.run(scene.points)
    assert row.probability == pytest.approx(Confidence.of(result).probability)
    assert row.accuracy == score(scene, result.T_model_scene).accuracy == 1.0
    assert row.iterations == result.trajectory.iterations


def work(seconds: float) -> None:
    """Keep this process busy for so much of its time."""
    end = time.process_time() + seconds
    while time.process_time() < end:
        pass


def test_seconds_are_those_of_the_registration_alone_and_without_the_first(monkeypatch: pytest.MonkeyPatch):
    real = shipped_method("bunny", "Did nothing")
    calls: list[int] = []

    def slow_at_first(points: Any) -> Any:
        calls.append(len(points))
        work(0.4 if len(calls) == 1 else 0.02)
        return real.register(points)

    def slow_scene(*args: Any) -> Any:
        work(0.2)
        return perturb(*args)

    monkeypatch.setattr(engine, "shipped_method", lambda *_: replace(real, register=slow_at_first))
    monkeypatch.setattr(engine, "perturb", slow_scene)
    engine._warmed_up.cache_clear()
    rows = run_chunk(Chunk("bunny", "Did nothing", "noise", 0.0, (0, 1, 2), 0))
    engine._warmed_up.cache_clear()
    assert len(calls) == 4
    assert all(0.02 <= row.seconds < 0.2 for row in rows)


def test_a_method_that_fails_is_recorded_as_such_and_the_run_goes_on(monkeypatch: pytest.MonkeyPatch):
    real = shipped_method("bunny", "Did nothing")

    def fails_on_large_scenes(points: Any) -> Any:
        if len(points) >= 1000:
            raise ValueError("too many points")
        return real.register(points)

    monkeypatch.setattr(engine, "shipped_method", lambda *_: replace(real, register=fails_on_large_scenes))
    engine._warmed_up.cache_clear()
    rows: list[Row] = []
    experiment = Experiment(datasets=("bunny",), sweeps=("points",), methods=("Did nothing",), scenes=2)
    run(experiment.missing(()), Here(), 1, rows.extend)
    engine._warmed_up.cache_clear()
    assert [row.stop for row in rows] == ["converged"] * 4 + [FAILED] * 6
    assert all(row.accuracy == 0 and np.isnan(row[7:10]).all() and row.seconds > 0 for row in rows[4:])


@pytest.mark.parametrize("in_flight", [2, 1000])
def test_threads_find_the_same_and_few_chunks_are_in_flight(in_flight: int, expected: set[tuple[Any, ...]]):
    rows: list[Row] = []
    submitted = 0

    class Counting(ThreadPoolExecutor):
        def submit(self, *args: Any, **kwargs: Any) -> Future[Any]:
            nonlocal submitted
            submitted += 1
            return super().submit(*args, **kwargs)

    def record(of_chunk: list[Row]) -> None:
        assert submitted - len(rows) // 3 <= in_flight
        rows.extend(of_chunk)

    with Counting(3) as executor:
        run(EXPERIMENT.missing(()), executor, in_flight, record)
    assert len(rows) == len(expected)
    assert untimed(rows) == expected


def kill_midway(command: list[str], path: Path) -> None:
    """Start a command and kill -9 it once it has recorded something."""
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    deadline = time.monotonic() + 60
    while not path.exists() or count(path) < 3:
        assert process.poll() is None and time.monotonic() < deadline
        time.sleep(0.005)
    workers = psutil.Process(process.pid).children(recursive=True)
    process.kill()
    process.wait()
    assert psutil.wait_procs(workers, timeout=20)[1] == []  # no worker outlives its parent


def count(path: Path) -> int:
    try:
        with Store.view(path) as store:
            return len(store.recorded())
    except ValueError:  # not yet begun
        return 0


def test_a_killed_run_goes_on_where_it_was_and_ends_like_one_that_was_not(
    tmp_path: Path, expected: set[tuple[Any, ...]], capfd: pytest.CaptureFixture[str]
):
    path = tmp_path / "a.sqlite"
    program = "import sys; from ido.cli import main; sys.exit(main())"
    arguments = ["experiment", "run", *SMALL, "--workers", "1", "--output", str(path)]
    kill_midway([sys.executable, "-c", program, *arguments], path)
    before = rows_of(path)
    assert 0 < len(before) < len(expected)
    assert cli.main(arguments) is None
    after = rows_of(path)
    assert after[: len(before)] == before  # with their seconds and numbers: nothing was written anew
    assert len(after) == len(expected)
    assert untimed([row[1:] for row in after]) == expected
    assert "bunny: mean PointAcc, 3 scenes a level" in capfd.readouterr().out


def test_ctrl_c_keeps_what_is_done_and_the_same_command_goes_on(
    tmp_path: Path,
    expected: set[tuple[Any, ...]],
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
):
    path = tmp_path / "a.sqlite"
    command = ["experiment", "run", *SMALL, "-o", str(path)]
    use(monkeypatch, Here(5, ctrl_c))
    assert cli.main(command) == 130
    said = capfd.readouterr()
    assert f"interrupted; what is done is kept in {path}; the same command goes on from there" in said.err
    assert said.out == ""
    before = rows_of(path)
    assert len(before) == 5 * 3  # one chunk is one method at one level; those submitted are recorded, too
    use(monkeypatch, Here())
    assert cli.main(command) is None
    after = rows_of(path)
    assert after[: len(before)] == before
    assert untimed([row[1:] for row in after]) == expected
    assert len(after) == len(expected)


def use(monkeypatch: pytest.MonkeyPatch, executor: Executor) -> None:
    @contextmanager
    def local(workers: int) -> Iterator[tuple[Executor, int]]:
        yield executor, 3

    monkeypatch.setattr(workers, "local_executor", local)


def test_a_lost_worker_is_one_clear_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
):
    def lost() -> None:
        raise BrokenExecutor("A process was terminated.")

    path = tmp_path / "a.sqlite"
    use(monkeypatch, Here(4, lost))
    assert cli.main(["experiment", "run", *SMALL, "-o", str(path)]) == 2
    said = capfd.readouterr().err
    assert f"error: A process was terminated; what is done is kept in {path}; the same command goes on" in said
    assert "Traceback" not in said
    assert len(rows_of(path)) == 4 * 3


def test_more_scenes_and_methods_are_added_and_the_table_shows_what_was_asked_for(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
):
    path = tmp_path / "a.sqlite"
    use(monkeypatch, Here())
    one = ["experiment", "run", "paper", "-o", str(path), "--sweeps", "noise", "outliers", "--datasets", "bunny"]
    assert cli.main([*one, "--scenes", "1", "--methods", "DO"]) is None
    before = rows_of(path)
    assert cli.main([*one, "--scenes", "2", "--methods", "DO", "Did nothing"]) is None
    assert rows_of(path)[: len(before)] == before
    capfd.readouterr()
    assert cli.main([*one, "--scenes", "2", "--levels", "0.02", "150", "--methods", "DO"]) is None
    table = capfd.readouterr().out
    with Store.view(path) as store:
        results = store.results()
    assert len(results) == 2 * 2 * 11
    means = [
        results.where(method="DO", sweep=sweep, level=level).accuracy.mean()
        for sweep, level in (("noise", 0.02), ("outliers", 150))
    ]
    line = next(line for line in table.splitlines() if line.startswith(" DO"))
    assert line.split() == ["DO", *(f"{mean:.3f}" for mean in means)]
    assert "Did nothing" not in table


@pytest.mark.parametrize(
    ("args", "message"),
    [
        (("--scenes", "0"), "scenes must lie between 1 and 100, not 0"),
        (("--scenes", "101"), "scenes must lie between 1 and 100, not 101"),
        (("--levels", "0.5"), "no such level: 0.5; choose from 0; 0.02;"),
        (("--levels", "0.02", "--sweeps", "points"), "no such level: 0.02; choose from 100; 400;"),
        (("--methods",), "name at least one method"),
        (("--sweeps",), "name at least one sweep"),
        (("--datasets", "urban", "--methods", "Improved DO (as printed)"), "are shipped for urban"),
        (("--workers", "0"), "workers must be greater than 0"),
        (("--workers", "1", "--dask", "tcp://127.0.0.1:1"), "--workers is for this machine"),
        (("-o", "missing/a.sqlite"), "missing: no such folder"),
    ],
)
def test_bad_input_is_one_clear_line_and_leaves_nothing_behind(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    args: tuple[str, ...],
    message: str,
    capfd: pytest.CaptureFixture[str],
):
    monkeypatch.chdir(tmp_path)
    assert cli.main(["experiment", "run", *args]) == 2
    said = capfd.readouterr()
    assert (said.out, said.err.count("\n")) == ("", 1)
    assert said.err.startswith("error: ")
    assert message in said.err
    assert list(tmp_path.iterdir()) == []


def test_a_file_of_other_settings_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: Any):
    path = tmp_path / "a.sqlite"
    use(monkeypatch, Here())
    command = ["experiment", "run", "-o", str(path), "--scenes", "1", "--levels", "0.02", "--methods", "DO"]
    assert cli.main(command) is None
    capfd.readouterr()
    real = shipped_method("bunny", "DO")
    assert real.maps
    other = replace(real, maps=replace(real.maps, maps=real.maps.maps * 2))
    monkeypatch.setattr(engine, "shipped_method", lambda *_: other)  # maps that were trained again
    assert cli.main(command) == 2
    said = capfd.readouterr().err
    assert "was recorded with other settings (fingerprint" in said
    assert "Choose another file" in said


def test_workers_compute_in_one_thread_and_this_process_keeps_its_own_number(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv("OMP_NUM_THREADS", "7")
    monkeypatch.delenv("OPENBLAS_NUM_THREADS", raising=False)
    with local_executor(1) as (executor, _):
        assert executor.submit(threads_of_libraries).result() == 0
    assert os.environ["OMP_NUM_THREADS"] == "7"
    assert "OPENBLAS_NUM_THREADS" not in os.environ


def threads_of_libraries() -> int:
    """Threads of this process that Python did not start, after a multiplication that is worth many."""
    assert (np.ones((600, 600)) @ np.ones((600, 600)))[0, 0] == 600
    return psutil.Process().num_threads() - threading.active_count()


def test_help_lists_the_command_and_explains_every_option(capfd: pytest.CaptureFixture[str]):
    said = []
    for args in (["--help"], ["experiment", "--help"], ["experiment", "run", "--help"]):
        with pytest.raises(SystemExit) as stopped:
            cli.main(args)
        assert stopped.value.code == 0
        said.append(capfd.readouterr().out)
    assert "experiment" in said[0]
    assert "run" in said[1]
    for option in ("output", "datasets", "sweeps", "methods", "levels", "scenes", "workers", "dask"):
        assert f"--{option}" in said[2]
    assert COMPARED_METHODS[-1].split()[0] in said[2]
