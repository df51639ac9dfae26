"""The README's Python examples run as they are printed, and its plug-in is taken by the commands that it prints."""

from __future__ import annotations

import re
import shlex
import sys
import urllib.request
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import tyro

import ido_viz
from ido import cli, score
from ido_viz.__main__ import Options, start
from ido_viz.core.library import shipped_library
from ido_viz.core.run import compute, make_scene, register_side
from ido_viz.core.state import State
from ido_viz.files.downloads import run_npz

ROOT = Path(__file__).parent.parent
README = (ROOT / "README.md").read_text(encoding="utf-8")
EXAMPLES = re.findall(r"```python\n(.*?)```", README, re.DOTALL)
COMMANDS = re.findall(r"^\.venv/bin/(.*?)(?: +#.*)?$", README, re.MULTILINE)


def example(holding: str) -> str:
    """The one example that holds a text."""
    (found,) = (text for text in EXAMPLES if holding in text)
    return found


def run(text: str) -> None:
    exec(compile(text, "README example", "exec"), {"__name__": "example"})


@pytest.fixture
def my_module(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Iterator[Path]:
    """A folder with the README's module, in which a person works."""
    (tmp_path / "my_module.py").write_text(example("class PointToPlane"), encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", [str(tmp_path), *sys.path])
    yield tmp_path
    sys.modules.pop("my_module", None)


def test_the_first_example_registers_a_scene(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]):
    monkeypatch.chdir(ROOT)
    run(example("TripleBinary"))
    assert re.search(r"(converged|iteration limit) \d", capsys.readouterr().out)


def test_a_saved_run_is_read(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path):
    monkeypatch.chdir(tmp_path)
    Path("ido-bunny-0.npz").write_bytes(run_npz(compute(State(), shipped_library()), State()))
    run(example("load_run"))
    printed = capsys.readouterr().out
    assert re.fullmatch(r"DO converged \S+ \(\d+, 1028\)\nImproved DO converged \S+ \(\d+, 3084\)\n", printed)


def test_the_own_feature_trains_and_the_own_method_registers(my_module: Path, capsys: pytest.CaptureFixture[str]):
    run(example("from my_module import"))
    curve, last = capsys.readouterr().out.splitlines()
    errors = [float(value) for value in curve.strip("[] ").split()]
    assert len(errors) == 4 and sorted(errors, reverse=True) == errors
    stop, accuracy = last.split()
    assert stop == "converged" and float(accuracy) > 0.9


def test_the_explorer_takes_the_own_method(my_module: Path):
    (command,) = (line for line in COMMANDS if "--method" in line)
    library, state = start(tyro.cli(Options, args=shlex.split(command)[1:]))
    assert (state.left, state.right) == ("Point to plane", "Improved DO")
    for shape in library.subjects:
        assert {"Point to plane", "inside-outside (1000 scenes)"} <= set(library.methods(shape))
    scene = make_scene(state, library)
    side = register_side(state, library, state.left, scene)
    assert side.trajectory.converged
    assert score(scene, side.T_model_scene[-1]).accuracy > 0.9


def test_maps_of_the_own_feature_are_trained_and_explored(my_module: Path):
    """With less of everything than is printed, the rest of the commands as it is."""
    (train, explore) = (shlex.split(line)[1:] for line in COMMANDS if "mine.npz" in line)
    train = train[: train.index("--samples")]
    (my_module / "bunny.ply").write_bytes((ROOT / "assets" / "bunny.ply").read_bytes())
    assert cli.main([*train, "--samples", "20", "--maps", "2"]) is None
    library, state = start(tyro.cli(Options, args=explore))
    assert (state.shape, state.left) == ("bunny (your own)", "mine")
    assert "inside-outside (1000 scenes)" not in library.methods(state.shape)
    method = library.method(state, "mine")
    assert method.maps is not None and method.maps.maps.shape == (2, 6, 2 * 514)
    assert np.isfinite(method.register(make_scene(state, library).points[:50]).x).all()


def test_the_example_for_a_notebook_shows_a_page(monkeypatch: pytest.MonkeyPatch):
    pages: list[ido_viz.EmbeddedExplorer] = []
    real = ido_viz.show

    def show(**arguments: Any) -> ido_viz.EmbeddedExplorer:
        pages.append(real(**arguments))
        return pages[-1]

    monkeypatch.setattr(ido_viz, "show", show)
    run(example("ido_viz.show("))
    (page,) = pages
    try:
        assert urllib.request.urlopen(page.url, timeout=10).status == 200
    finally:
        page.stop()
