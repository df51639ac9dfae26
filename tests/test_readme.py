"""What the README prints works: its Python runs, its commands are taken, and the page is as its tour says."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import numpy as np
import pytest
import tyro

from ido import cli, load_run, score
from ido.methods import LEARNED
from ido_viz.command import Options, start
from ido_viz.core.frame import frame_of
from ido_viz.core.library import shipped_library
from ido_viz.core.run import compute, make_scene, register_side
from ido_viz.core.state import State
from ido_viz.files.downloads import run_npz

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")
EXAMPLES = re.findall(r"```python\n(.*?)```", README, re.DOTALL)
COMMANDS = re.findall(r"^\.venv/bin/(.*?)(?: +#.*)?$", README, re.MULTILINE)


@pytest.fixture(autouse=True)
def in_the_clone(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where a person types the commands."""
    monkeypatch.chdir(ROOT)


def commands(holding: str) -> list[list[str]]:
    """The arguments of each command that holds a text."""
    return [shlex.split(line)[1:] for line in COMMANDS if holding in line]


def test_the_python_example_registers_a_scene(capsys: pytest.CaptureFixture[str]):
    (text,) = EXAMPLES
    exec(compile(text, "README example", "exec"), {"__name__": "example"})
    assert re.search(r"(converged|iteration limit) \d", capsys.readouterr().out)


def test_the_two_commands_to_begin_with_stand_on_lines_of_their_own():
    begin = re.findall(r"^python3 -m venv \.venv && (.*)$", README, re.MULTILINE)
    assert begin == [
        ".venv/bin/pip install . && .venv/bin/ido-viz",
        ".venv/bin/pip install -e '.[test]' && .venv/bin/pytest",
    ]


def test_the_tour_begins_with_the_scene_and_the_methods_that_it_names():
    state = State()
    p = state.perturbation
    assert f"{p.points} points of the {state.shape} turned by {p.rotation:.0f}°, moved by {p.translation:g}" in README
    assert f"{p.incomplete:.0%} cut away and {p.outliers} outliers" in re.sub(r"\s+", " ", README)
    assert (state.left, state.right) == ("DO", "Improved DO")
    named = set(re.findall(r"\*(Improved DO \(.*?\))\*", README))
    assert named == {name for name in LEARNED if "(" in name}


def test_a_download_is_read(tmp_path: Path):
    state = State()
    (tmp_path / "ido-bunny-0.npz").write_bytes(run_npz(frame_of(compute(state, shipped_library()), state)))
    run = load_run(tmp_path / "ido-bunny-0.npz")
    assert [method.name for method in run.methods] == ["DO", "Improved DO"]
    assert [method.histograms.shape[1] for method in run.methods] == [2 * 514, 6 * 514]


def test_the_explorer_takes_the_own_method_and_feature():
    (command,) = commands("--method")
    library, state = start(tyro.cli(Options, args=command))
    assert (state.left, state.right) == ("Point to plane", "Improved DO")
    for shape in library.subjects:
        assert {"Point to plane", "inside-outside (1000 scenes)"} <= set(library.methods(shape))
    selection = library.select(state)
    scene = make_scene(selection.subject, state)
    side = register_side(selection.entries[0], selection, state, scene)
    assert side.trajectory.converged
    assert score(scene, side.T_model_scene[-1]).accuracy > 0.9


def test_maps_of_the_own_feature_are_trained_and_explored(tmp_path: Path):
    """With less of everything than is printed, and files in other folders; the rest of the commands as it is."""
    places = {"assets/bunny.ply": str(ROOT / "assets" / "bunny.ply"), "mine.npz": str(tmp_path / "mine.npz")}
    train, explore = ([places.get(arg, arg) for arg in command] for command in commands("mine.npz"))
    train = train[: train.index("--samples")]
    assert cli.main([*train, "--samples", "20", "--maps", "2"]) is None
    library, state = start(tyro.cli(Options, args=explore))
    assert (state.shape, state.left) == ("bunny (your own)", "mine")
    assert "inside-outside (1000 scenes)" not in library.methods(state.shape)
    method = library.entry(state.shape, "mine").make(state.epsilon, state.max_iterations, lambda _: None)
    assert method.maps is not None and method.maps.maps.shape == (2, 6, 2 * 514)
    scene = make_scene(library.subject(state.shape), state)
    assert np.isfinite(method.register(scene.points[:50]).x).all()


def test_commands_on_ones_own_cloud_are_taken():
    trained = [args[args.index("-o") + 1] for args in commands("ido train assets/bunny.ply")]
    assert trained == ["do.npz", "improved.npz", "mine.npz"]
    (explore,) = commands("--cloud assets/bunny.ply --maps do.npz")
    assert tyro.cli(Options, args=explore).maps == tuple(map(Path, trained[:2]))
