"""Processes of one's own begin with the program loaded, where the system can do that."""

from __future__ import annotations

import sys
import tempfile
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import pytest

from ido.processes import process_context


@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere each process loads the program anew")
def test_a_process_begins_with_the_program_loaded():
    with ProcessPoolExecutor(1, process_context("ido")) as pool:
        assert pool.submit(eval, "'ido' in __import__('sys').modules").result()


def test_a_process_has_nothing_of_the_one_that_begins_it():
    sys.set_int_max_str_digits(1234)
    try:
        with ProcessPoolExecutor(1, process_context("ido")) as pool:
            assert pool.submit(sys.get_int_max_str_digits).result() != 1234
    finally:
        sys.set_int_max_str_digits(sys.int_info.default_max_str_digits)


@pytest.mark.parametrize("length", [70, 71, 200])
def test_a_folder_for_temporary_files_with_any_path_will_do(
    length: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    folder = tmp_path / ("x" * max(length - len(str(tmp_path)) - 1, 1))
    folder.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(folder))
    with ProcessPoolExecutor(1, process_context("ido")) as pool:
        assert pool.submit(sum, (1, 2)).result() == 3
