"""The examples run as they are, and say what they should."""

from __future__ import annotations

import runpy
import sys
import urllib.request
from collections.abc import Callable
from pathlib import Path

import nbformat
import numpy as np
import pytest

from ido.extensions import find_class, histogram_class

ROOT = Path(__file__).parents[1]
EXAMPLES = ROOT / "assets" / "examples"
Run = Callable[[str], list[str]]
README = (ROOT / "README.md").read_text(encoding="utf-8")


@pytest.fixture
def run(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Run:
    """Runs an example by the number that its name begins with, and gives what it prints, line by line."""

    def run_one(number: str) -> list[str]:
        (file,) = EXAMPLES.glob(f"{number}_*.py")
        monkeypatch.setattr(sys, "argv", [str(file)])
        runpy.run_path(str(file), run_name="__main__")
        return capsys.readouterr().out.splitlines()

    return run_one


def number_after(text: str, line: str) -> float:
    return float(line.split(text)[1].split()[0].rstrip("°,"))


def test_they_are_numbered_and_the_readme_links_to_each():
    files = sorted(file.name for file in EXAMPLES.iterdir() if file.suffix in (".py", ".ipynb"))
    assert [name[:2] for name in files] == [f"{number:02}" for number in range(1, len(files) + 1)]
    assert all(f"(assets/examples/{name})" in README for name in files)


def test_a_file_is_registered_in_its_own_units(run: Run):
    first, *_, last = run("01")
    assert first.startswith("1500 points: converged")
    assert number_after("turns by ", last) == pytest.approx(40, abs=1)


def test_maps_of_a_small_training_register_what_they_were_trained_for(run: Run):
    lines = run("02")
    errors = [number_after(": ", line) for line in lines if line.startswith("training error")]
    assert len(errors) == 7 and sorted(errors, reverse=True) == errors
    accuracy = {line.split(":")[0]: number_after("PointAcc ", line) for line in lines if line.startswith("turned")}
    assert accuracy["turned by  30°"] > 0.9
    assert accuracy["turned by 180°"] < 0.3


def test_methods_are_scored(run: Run):
    head, *lines = run("03")
    assert head == "580 points, 300 of them outliers"
    accuracy = {line[:25].strip(): number_after("PointAcc ", line) for line in lines}
    assert min(accuracy[name] for name in ("DO", "Improved DO", "Improved DO (near / far)")) > 0.9
    assert max(accuracy[name] for name in ("ICP, tuned", "Did nothing")) < 0.1


def test_the_own_method_registers_small_turns(run: Run):
    accuracy = [number_after("PointAcc ", line) for line in run("04")]
    assert min(accuracy[:3]) > 0.9 > accuracy[3]


def test_the_own_feature_is_the_same_both_ways_and_can_be_learned(run: Run):
    same, curve, last = run("05")
    assert same == "both give the same bins: True"
    errors = [float(value) for value in curve.split("[")[1].rstrip("]").split()]
    assert len(errors) == 5 and sorted(errors, reverse=True) == errors
    assert number_after("error ", last) > 2 * number_after("-> ", last)


def test_the_page_with_both_opens(run: Run, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]):
    answers: list[int] = []

    def enter(_: str) -> str:
        url = capsys.readouterr().out.split()[1].rstrip(";")
        answers.append(urllib.request.urlopen(url, timeout=10).status)
        return ""

    monkeypatch.setattr("builtins.input", enter)
    run("06")
    assert answers == [200]


def test_what_is_named_on_the_command_line_is_found():
    assert find_class(f"{EXAMPLES / '04_own_method.py'}:PointToPlane").name == "Point to plane"  # type: ignore[attr-defined]
    assert histogram_class(f"{EXAMPLES / '05_own_feature.py'}:InsideOutsideAsked").name == "inside-outside-asked"


def test_a_question_of_ones_own_draws_its_surface_through_the_model_point():
    asked = histogram_class(f"{EXAMPLES / '05_own_feature.py'}:InsideOutsideAsked").blocks[0]
    point = np.array([0.3, 0.0, 0.4])
    surface = asked.surface(point, np.array([0.0, 0.0, 1.0]))  # type: ignore[attr-defined]
    assert np.linalg.norm(surface.vertices, axis=1) == pytest.approx(0.5)


def test_the_notebook_is_valid_and_has_no_output():
    (file,) = EXAMPLES.glob("*.ipynb")
    notebook = nbformat.read(file, as_version=4)
    nbformat.validate(notebook)
    assert all(not cell.get("outputs") for cell in notebook.cells)
