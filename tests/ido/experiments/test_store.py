"""The results file: what goes in comes out, once, and nothing else gets in."""

from __future__ import annotations

import math
import sqlite3
import subprocess
import sys
from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest

from ido.experiments import Results
from ido.experiments.store import VERSION, Row, Store, StoreError

DATASETS = {"bunny": {"noise": 0.05, "seed": 1}}
METHODS = {("bunny", "DO"): {"epsilon": 0.001}, ("bunny", "ICP"): {"cutoff": math.inf, "sigmas": (1.0, 2.0)}}


def row(method: str = "DO", trial: int = 0, accuracy: float = 0.1 + 0.2) -> Row:
    nan = math.nan
    return Row(
        "bunny", method, "noise", 0.02, trial, 7 + trial, accuracy, 1e-300, nan, math.inf, 0.25, 31, "converged", nan
    )


def write(path: Path, *rows: Row) -> None:
    with Store.open(path, DATASETS, METHODS) as store:
        store.append(rows)


def test_rows_come_back_to_the_last_bit_as_the_columns_of_results(tmp_path: Path):
    assert Row._fields == tuple(field.name for field in fields(Results))
    path = tmp_path / "odd #1 name?.sqlite"
    write(path, row(trial=3), row("ICP"), row(trial=0, accuracy=1.0))
    with Store.view(path) as store:
        results = store.results()
        settings = store.methods()
    expected = [row(trial=0, accuracy=1.0), row(trial=3), row("ICP")]
    assert len(results) == 3
    for name, values in zip(Row._fields, zip(*expected, strict=True), strict=True):
        np.testing.assert_array_equal(getattr(results, name), values)
    assert results.accuracy.dtype == results.level.dtype == np.float64
    assert results.trial.dtype == results.iterations.dtype == np.int64
    assert results.where(method="ICP").seed.tolist() == [7]
    assert settings == {("bunny", "DO"): {"epsilon": 0.001}, ("bunny", "ICP"): {"cutoff": "inf", "sigmas": [1.0, 2.0]}}


def test_a_registration_is_kept_as_it_was_first_recorded(tmp_path: Path):
    path = tmp_path / "a.sqlite"
    write(path, row(accuracy=0.5))
    write(path, row(accuracy=0.7), row(trial=1))
    with Store.view(path) as store:
        assert store.results().accuracy.tolist() == [0.5, row().accuracy]
        assert store.recorded() == {row(trial=trial)[:5] for trial in (0, 1)}


def test_rows_are_written_all_or_none(tmp_path: Path):
    path = tmp_path / "a.sqlite"
    with pytest.raises(StoreError, match="FOREIGN KEY"), Store.open(path, DATASETS, METHODS) as store:
        store.append([row(), row("a method without settings")])
    with Store.view(path) as store:
        assert len(store.results()) == 0


def test_what_is_appended_can_be_read_at_once_and_a_second_run_is_refused(tmp_path: Path):
    path = tmp_path / "a.sqlite"
    with Store.open(path, DATASETS, METHODS) as store:
        for trial in range(3):
            store.append([row(trial=trial)])
            with Store.view(path) as reader:
                assert len(reader.recorded()) == trial + 1
        with pytest.raises(StoreError, match="another run is writing"), Store.open(path, DATASETS, METHODS):
            pass
        store.append([row(trial=3)])  # the refused one did no harm
    write(path, row(trial=4))  # and the lock ends with its run


def test_a_reader_in_the_midst_of_reading_holds_nobody_up(tmp_path: Path):
    path = tmp_path / "a.sqlite"
    write(path, *(row(trial=trial) for trial in range(5)))
    reader = sqlite3.connect(path, isolation_level=None)
    reader.execute("BEGIN")
    assert reader.execute("SELECT count(*) FROM registrations").fetchone() == (5,)
    write(path, row(trial=5))
    assert reader.execute("SELECT count(*) FROM registrations").fetchone() == (5,)  # as it was when it began
    reader.close()


def test_what_is_appended_survives_a_process_that_ends_without_closing(tmp_path: Path):
    path = tmp_path / "a.sqlite"
    program = """
import os, sys
from pathlib import Path
sys.path.insert(0, sys.argv[2])
from test_store import DATASETS, METHODS, Store, row
with Store.open(Path(sys.argv[1]), DATASETS, METHODS) as store:
    store.append([row(trial=1)])
    store._connection.execute("DELETE FROM registrations")  # begun, never committed
    os._exit(0)
"""
    subprocess.run([sys.executable, "-c", program, path, Path(__file__).parent], check=True)
    write(path, row(trial=2))
    with Store.view(path) as store:
        assert store.results().trial.tolist() == [1, 2]


@pytest.mark.parametrize(
    ("datasets", "methods", "message"),
    [
        (DATASETS, {("bunny", "DO"): {"epsilon": 0.005}}, "DO on bunny.*epsilon 0.001 there, 0.005 here"),
        (DATASETS, {("bunny", "DO"): {"epsilon": 0.001, "maps": 2}}, "DO on bunny.*maps None there, 2 here"),
        (DATASETS, {("bunny", "ICP"): {"cutoff": 1.0, "sigmas": (1.0, 2.0)}}, "ICP.*cutoff inf there, 1.0 here;?"),
        ({"bunny": {"noise": 0.05, "seed": 2}}, {}, "scenes of bunny.*seed 1 there, 2 here"),
    ],
)
def test_rows_of_other_settings_are_never_mixed_in(tmp_path: Path, datasets: dict, methods: dict, message: str):
    path = tmp_path / "a.sqlite"
    write(path, row())
    with pytest.raises(StoreError, match=f"{message}.*Choose another file"), Store.open(path, datasets, methods):
        pass
    more = {("bunny", "a new one"): {"epsilon": 0.005}}
    with Store.open(path, DATASETS | {"urban": {"seed": 9}}, METHODS | more) as store:  # the same and new ones are fine
        assert store.methods() == json_like(METHODS | more)


def json_like(methods: dict) -> dict:
    return methods | {("bunny", "ICP"): {"cutoff": "inf", "sigmas": [1.0, 2.0]}}


def foreign_database(path: Path) -> None:
    connection = sqlite3.connect(path)
    connection.execute("CREATE TABLE registrations (name TEXT)")
    connection.close()


def other_version(path: Path) -> None:
    write(path)
    connection = sqlite3.connect(path)
    connection.execute(f"PRAGMA user_version = {VERSION + 1}")
    connection.close()


def overwritten(path: Path) -> None:
    write(path, *(row(trial=trial) for trial in range(200)))
    content = bytearray(path.read_bytes())
    content[4096:] = b"\xa5" * (len(content) - 4096)  # all but the first page
    path.write_bytes(content)


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (lambda path: path.write_text("dataset,method\n" * 300), "not a results file"),
        (foreign_database, "not a results file"),
        (other_version, f"its version is {VERSION + 1}, this program writes version {VERSION}"),
        (overwritten, "damaged"),
        (lambda path: path.mkdir(), "unable to open"),
    ],
)
def test_a_file_that_is_no_results_file_is_refused_and_left_as_it_is(tmp_path: Path, spoil, message: str):
    path = tmp_path / "a.sqlite"
    spoil(path)
    before = path.read_bytes() if path.is_file() else b""
    with pytest.raises(StoreError, match=message), Store.open(path, DATASETS, METHODS):
        pass
    with pytest.raises(StoreError, match=f"{message}|no such file"), Store.view(path):
        pass
    assert (path.read_bytes() if path.is_file() else b"") == before


def test_a_file_that_was_never_written_to_is_begun_anew_but_holds_nothing_to_read(tmp_path: Path):
    path = tmp_path / "a.sqlite"
    with pytest.raises(StoreError, match="no such file"), Store.view(path):
        pass
    path.touch()  # a run that was killed before its first write
    with pytest.raises(StoreError, match="holds no results"), Store.view(path):
        pass
    write(path, row())
    with Store.view(path) as store:
        assert len(store.results()) == 1
    with pytest.raises(StoreError, match="missing: no such folder"):
        write(tmp_path / "missing" / "a.sqlite")
