"""`ido register --global`: scans in the user's units, from any start."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from ido import Cloud, Perturbation, cli, perturb, poses
from ido.clouds import Frame
from ido.files import save_cloud

FRAME = Frame(np.array([1000.0, -200.0, 50.0]), 37.0)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory, bunny: Cloud) -> Path:
    """A model cloud in the user's units, and a scan of it that lies far away."""
    folder = tmp_path_factory.mktemp("global")
    save_cloud(folder / "model.ply", FRAME.to_user_units(bunny.points))
    scene = perturb(bunny, Perturbation(rotation=160, translation=1, noise=0.02, outliers=50, seed=8))
    save_cloud(folder / "scan.ply", FRAME.to_user_units(scene.points) + 500.0)
    return folder


def test_a_scan_is_registered_from_any_start(folder: Path, bunny: Cloud, capfd: pytest.CaptureFixture[str]):
    args = ["register", str(folder / "scan.ply"), "--global", str(folder / "model.ply")]
    assert cli.main([*args, "--strict"]) is None
    found = json.loads(capfd.readouterr().out)
    scene = perturb(bunny, Perturbation(rotation=160, translation=1, noise=0.02, outliers=50, seed=8))
    shift = np.eye(4)
    shift[:3, 3] = -500.0
    T = FRAME.pose_in_user_units(scene.T_model_scene) @ shift
    points = FRAME.to_user_units(scene.points[~scene.is_outlier]) + 500.0
    away = poses.transform(np.array(found["T_model_scene"]), points) - poses.transform(T, points)
    assert np.linalg.norm(away, axis=1).max() < 0.1 * FRAME.scale
    assert found["confidence"]["probability"] > 0.95
    assert 0 < found["confidence"]["expected_error"] < 0.1 * FRAME.scale
    assert np.linalg.eigvalsh(np.array(found["confidence"]["covariance"])).min() > 0
    assert found["warnings"] == []


def test_the_model_of_maps_is_enough(capfd: pytest.CaptureFixture[str]):
    assert cli.main(["register", "bunny", "--global", "bunny-front-back"]) is None
    found = json.loads(capfd.readouterr().out)
    np.testing.assert_allclose(found["T_model_scene"], np.eye(4), atol=0.02)


def test_another_shape_is_doubted(folder: Path, capfd: pytest.CaptureFixture[str]):
    assert cli.main(["register", "urban", "--global", "bunny", "--strict"]) == 3
    said = capfd.readouterr()
    assert json.loads(said.out)["confidence"]["probability"] < 0.5
    assert "times as large as the model" in said.err


@pytest.mark.parametrize(
    ("args", "message"),
    [
        ((), "give either --maps FILE.npz, to walk maps, or --global MODEL"),
        (("--global", "bunny", "--maps", "bunny-front-back"), "give either"),
        (("--global", "bunny", "--epsilon", "0.1"), "--global needs none of them"),
        (("--global", "missing.ply"), "no such file"),
    ],
)
def test_what_does_not_fit_together_is_refused(args: tuple[str, ...], message: str, capfd: pytest.CaptureFixture[str]):
    assert cli.main(["register", "bunny", *args]) == 2
    assert message in capfd.readouterr().err
