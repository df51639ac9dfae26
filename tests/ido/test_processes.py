"""Processes of one's own begin with the program loaded, where the system can do that."""

from __future__ import annotations

import os
import subprocess
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


BEGIN_ONE = """
from concurrent.futures import ProcessPoolExecutor
from ido.processes import process_context
with ProcessPoolExecutor(1, process_context("ido")) as pool:
    print(pool.submit(sum, (1, 2)).result())
"""


@pytest.mark.parametrize("length", [70, 71])  # the longest path that has room for a socket beside it, and a longer one
def test_a_folder_for_temporary_files_with_any_path_will_do(length: int):
    with tempfile.TemporaryDirectory() as above:
        folder = Path(above, "x" * max(length - len(above) - 1, 1))
        folder.mkdir()
        command = [sys.executable, "-c", BEGIN_ONE]
        environment = os.environ | {"TMPDIR": str(folder)}
        assert subprocess.run(command, env=environment, capture_output=True, check=True, timeout=60).stdout == b"3\n"
