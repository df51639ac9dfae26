"""`ido sweep`, and what all commands have in common."""

from __future__ import annotations

import inspect
import os
import subprocess
from pathlib import Path

import pytest
from command_line import IDO, fails

from ido import Cloud, Maps, cli, load_cloud
from ido.experiments import mean_and_interval, sweep


def test_sweep_tells_every_method_and_sweep(folder: Path, capfd: pytest.CaptureFixture[str]):
    args = ("--scenes", "2", "--sweeps", "noise", "incomplete", "--epsilon", "0.05")
    maps = [str(folder / "maps.npz"), f"{folder}/./maps.npz"]
    assert cli.main(["sweep", str(folder / "cloud.ply"), "--maps", *maps, *args]) is None
    table = capfd.readouterr().out
    cloud, trained = Cloud.of(load_cloud(folder / "cloud.ply")), Maps.load(folder / "maps.npz")
    for name in ("noise", "incomplete"):
        results = sweep(cloud, trained, name, scenes=2, epsilon=0.05)
        mean, half = mean_and_interval(results[..., 0])
        row = next(line for line in table.splitlines() if name in line)
        assert row.count(f"{mean:.3f} ± {half:.3f} ({results[..., 1].mean():.3f})") == 2


def test_sweep_seeds_are_the_experiments_own():
    ours, theirs = (inspect.signature(f).parameters["seed"].default for f in (cli.sweep_command, sweep))
    assert ours == theirs


def test_a_table_is_shown_in_any_encoding(folder: Path):
    args = [
        "sweep",
        str(folder / "cloud.ply"),
        "--maps",
        str(folder / "maps.npz"),
        "--scenes",
        "2",
        "--sweeps",
        "noise",
    ]
    command = [*IDO, *args]
    done = subprocess.run(command, env=os.environ | {"PYTHONIOENCODING": "ascii"}, capture_output=True)
    assert done.returncode == 0
    assert b"noise" in done.stdout
    assert b" ? " in done.stdout


@pytest.mark.parametrize(
    ("args", "message"),
    [
        (("--scenes", "1"), "at least 2 scenes"),
        (("--epsilon", "inf"), "epsilon must be a number"),
        (("--seed", "-5"), "seed must lie between 0 and 4294967295"),
        (("--sweeps",), "name at least one"),
    ],
)
def test_sweep_refuses_settings_out_of_range(args: tuple[str, ...], message: str, capfd: pytest.CaptureFixture[str]):
    assert message in fails(capfd, "sweep", "bunny", "--maps", "bunny-front-back", *args)


def test_sweep_refuses_maps_of_another_cloud(capfd: pytest.CaptureFixture[str]):
    assert "trained on a cloud of another size" in fails(capfd, "sweep", "urban", "--maps", "bunny-front-back")


@pytest.mark.parametrize(
    "args", [[], ["fly"], ["train"], ["train", "bunny"], ["train", "bunny", "-o", "a.npz", "--histogram", "none"]]
)
def test_a_command_that_cannot_be_understood_exits_with_2(args: list[str], capfd: pytest.CaptureFixture[str]):
    with pytest.raises(SystemExit) as stopped:
        cli.main(args)
    assert stopped.value.code == 2
    assert capfd.readouterr().out == ""


@pytest.mark.parametrize("command", ["train", "register", "sweep"])
def test_help_explains_every_option(command: str, capfd: pytest.CaptureFixture[str]):
    with pytest.raises(SystemExit) as stopped:
        cli.main([command, "--help"])
    assert stopped.value.code == 0
    said = capfd.readouterr().out
    for name in inspect.signature(getattr(cli, f"{command}_command")).parameters:
        option = {"onto": "global"}.get(name, name).replace("_", "-")  # the word is Python's own
        assert name == "cloud" or f"--{option}" in said
    assert "bunny" in said
