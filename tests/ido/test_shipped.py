"""Shipped files are found where they lie: beside the code in a clone or source archive, in it once installed."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from ido import shipped

ROOT = Path(__file__).parents[2]

FIND = """
import ido
from ido_viz.teach.lessons import lessons
print(ido.__file__, len(ido.shipped_maps("bunny", "front-back").maps), len(lessons()) > 0)
"""


@pytest.fixture
def packages(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder in which the code seems to lie."""
    monkeypatch.setattr(shipped, "__file__", str(tmp_path / "ido" / "shipped.py"))
    return tmp_path


def test_in_a_clone_or_source_archive_they_lie_beside_the_code(packages: Path):
    (packages / "assets").mkdir()
    assert shipped.asset("bunny.ply") == packages / "assets" / "bunny.ply"


def test_once_installed_they_lie_in_the_package_whatever_lies_beside_it(packages: Path):
    (packages / "ido" / "assets").mkdir(parents=True)
    (packages / "assets").mkdir()  # another project's
    assert shipped.asset("bunny.ply") == packages / "ido" / "assets" / "bunny.ply"


def found_by(*options: str, folder: Path) -> list[str]:
    command = [sys.executable, *options, "-c", FIND]
    return subprocess.run(command, cwd=folder, check=True, capture_output=True, text=True).stdout.rsplit(maxsplit=2)


def test_python_started_in_the_clone_finds_them():
    """The folder `ido` goes before an installed package there."""
    assert found_by(folder=ROOT) == [str(ROOT / "ido" / "__init__.py"), "30", "True"]


def test_what_is_installed_finds_them(tmp_path: Path):
    """Without the folder it is started in, nor one that the environment names."""
    assert found_by("-I", folder=tmp_path)[1:] == ["30", "True"]
