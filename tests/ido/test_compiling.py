"""Compiled loops: kept between starts, also when what was kept is damaged, and compiled without a place for them."""

from __future__ import annotations

import os
import subprocess
import sys
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from types import ModuleType

import pytest
from numba.core import config

LOCATOR = "UserProvidedCacheLocator"
"""The only place where numba is to look."""

SOURCE = """
from ido.compiling import compiled

@compiled()
def double(number):
    return 2 * number
"""

AT_ONCE = """
import importlib.util, pathlib, sys, time, types
place = importlib.util.find_spec("ido").submodule_search_locations
sys.modules["ido"] = types.ModuleType("ido")  # without its __init__, which imports all the rest
sys.modules["ido"].__path__ = place
import loops
print("ready", flush=True)
while not pathlib.Path("go").exists():
    time.sleep(0.001)
assert loops.double(21) == 42
print(sum(loops.double.stats.cache_misses.values()))
"""
"""A program that waits for a file before it needs the loop, and tells whether it compiled it."""


@pytest.fixture
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Where compiled loops are kept."""
    (tmp_path / "loops.py").write_text(SOURCE)
    monkeypatch.setattr(config, "CACHE_DIR", str(tmp_path / "kept"))
    return tmp_path / "kept"


def start(place: Path) -> ModuleType:
    """The loops, as a new start of the program sees them."""
    spec = spec_from_file_location("loops", place.parent / "loops.py")
    assert spec and spec.loader
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def loaded(module: ModuleType) -> int:
    """How many compiled loops came from the disk."""
    assert module.double(21) == 42
    return sum(module.double.stats.cache_hits.values())


@pytest.mark.parametrize("kind", ["*.nbi", "*.nbc", "*"])
def test_a_damaged_loop_is_compiled_again_and_replaced(place: Path, kind: str):
    assert [loaded(start(place)), loaded(start(place))] == [0, 1]
    damaged = [file for file in place.rglob(kind) if file.is_file()]
    assert damaged
    for file in damaged:
        file.write_bytes(file.read_bytes()[:50])
    assert [loaded(start(place)), loaded(start(place))] == [0, 1]


def test_of_processes_that_need_a_loop_at_the_same_time_one_compiles_it(place: Path):
    command = [sys.executable, "-c", AT_ONCE]
    settings = {"NUMBA_CACHE_DIR": str(place), "PYTHONPATH": os.pathsep.join([str(place.parent), *sys.path])}
    processes = [
        subprocess.Popen(command, cwd=place.parent, env=os.environ | settings, stdout=subprocess.PIPE, text=True)
        for _ in range(2)
    ]
    for process in processes:
        assert process.stdout and process.stdout.readline() == "ready\n"
    (place.parent / "go").touch()
    compiled = [int(process.communicate(timeout=60)[0]) for process in processes]
    assert sorted(compiled) == [0, 1]


def test_without_a_place_to_keep_loops_the_program_starts_and_says_so_once(tmp_path: Path):
    (tmp_path / "file").touch()
    nowhere = {
        "NUMBA_CACHE_LOCATOR_CLASSES": "UserProvidedCacheLocator",
        "NUMBA_CACHE_DIR": str(tmp_path / "file" / "x"),
    }
    command = [sys.executable, "-c", "import sys; from ido.cli import main; sys.exit(main(['--help']))"]
    done = subprocess.run(command, env=os.environ | nowhere, capture_output=True, text=True)
    assert done.returncode == 0
    assert "register" in done.stdout
    assert done.stderr.count("compiled loops cannot be kept on disk") == 1
    assert "Traceback" not in done.stderr
