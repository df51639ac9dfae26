"""The experiment on a Dask cluster of real processes, one of which is killed midway."""

from __future__ import annotations

import os
import signal
import sqlite3
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ido import Maps, Perturbation, cli, perturb, shipped_cloud
from ido.experiments import commands
from ido.experiments.execution import Experiment, run_chunk
from ido.experiments.store import Row, Store
from ido.files import save_cloud

dask = pytest.importorskip("dask")
distributed = pytest.importorskip("distributed")

SMALL = ("--datasets", "bunny", "--sweeps", "noise", "outliers", "--methods", "DO", "ICP, default", "--scenes", "2")


@pytest.fixture(scope="module")
def cluster() -> Iterator[Any]:
    options = {"n_workers": 2, "threads_per_worker": 1, "processes": True, "dashboard_address": None}
    with distributed.LocalCluster(**options) as cluster:
        yield cluster


def worker_pids(cluster: Any) -> set[int]:
    with distributed.Client(cluster.scheduler_address) as client:
        return set(client.run(os.getpid).values())


@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="Windows has no kill -9")
def test_a_killed_worker_loses_nothing_and_nothing_is_recorded_twice(
    cluster: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    path = tmp_path / "a.sqlite"
    before, killed = worker_pids(cluster), []
    append = Store.append

    def append_and_kill(store: Store, rows: list[Row]) -> None:
        append(store, rows)
        if rows and len(killed) == 0:
            killed.append(min(before))
            os.kill(killed[0], signal.SIGKILL)

    monkeypatch.setattr(commands.Store, "append", append_and_kill)
    assert cli.main(["experiment", "run", *SMALL, "--dask", cluster.scheduler_address, "-o", str(path)]) is None
    assert len(killed) == 1
    assert killed[0] not in worker_pids(cluster)
    connection = sqlite3.connect(path)
    rows = [Row(*row) for row in connection.execute("SELECT * FROM registrations")]
    connection.close()
    experiment = Experiment(datasets=("bunny",), sweeps=("noise", "outliers"), methods=("DO", "ICP, default"), scenes=2)
    expected = [row for chunk in experiment.missing(()) for row in run_chunk(chunk)]
    assert len(rows) == len(expected)
    assert all(row.probability is None for row in rows)  # these methods give none, NaN where they are computed
    found, here = ({row._replace(seconds=0, probability=None) for row in its} for its in (rows, expected))
    assert found == here


def test_no_cluster_at_an_address_is_one_clear_line(tmp_path: Path, capfd: pytest.CaptureFixture[str]):
    path = tmp_path / "a.sqlite"
    with dask.config.set({"distributed.comm.timeouts.connect": "1s"}):
        assert cli.main(["experiment", "run", "--dask", "tcp://127.0.0.1:1", "-o", str(path)]) == 2
    said = capfd.readouterr().err
    assert "error: " in said
    assert "127.0.0.1:1" in said
    assert "Traceback" not in said
    assert not path.exists()


def test_a_folder_of_scans_is_registered_on_the_cluster_as_it_is_here(cluster: Any, tmp_path: Path):
    (tmp_path / "scans").mkdir()
    bunny = shipped_cloud("bunny")
    for seed in range(3):
        scene = perturb(bunny, Perturbation(seed=seed))
        save_cloud(tmp_path / "scans" / f"{seed}.ply", bunny.frame.to_user_units(scene.points))
    found = []
    for name, who in (("here", ("--workers", "1")), ("there", ("--dask", cluster.scheduler_address))):
        output = tmp_path / f"{name}.jsonl"
        args = ["register", str(tmp_path / "scans"), "--maps", "bunny-front-back", "-o", str(output), *who]
        assert cli.main(args) is None
        found.append(sorted(output.read_text().splitlines()))
    assert len(found[0]) == 4
    assert found[0] == found[1]


def test_maps_that_a_cluster_helped_to_learn_are_those_that_are_learned_here(cluster: Any, tmp_path: Path):
    learned = []
    for name, who in (("here", ()), ("there", ("--dask", cluster.scheduler_address))):
        output = tmp_path / f"{name}.npz"
        args = [
            "train",
            "bunny",
            "-o",
            str(output),
            "--histogram",
            "front-back",
            "--samples",
            "60",
            "--maps",
            "2",
            *who,
        ]
        assert cli.main(args) is None
        learned.append(Maps.load(output).maps)
    np.testing.assert_allclose(learned[0], learned[1], rtol=0, atol=1e-5 * np.abs(learned[0]).max())
