"""What the tests of the command line share: a user's folder, and a scan in it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import open3d as o3d
import pytest
from command_line import FRAME, TRAINING

from ido import Cloud, Perturbation, cli, perturb
from ido.files import save_cloud
from ido.types import FloatArray


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory, bunny: Cloud) -> Path:
    """A user's folder: the cloud, and maps trained on it."""
    folder = tmp_path_factory.mktemp("user")
    save_cloud(folder / "cloud.ply", FRAME.to_user_units(bunny.points))
    assert cli.main(["train", str(folder / "cloud.ply"), "-o", str(folder / "maps.npz"), *TRAINING]) is None
    return folder


@pytest.fixture
def T_scene_model(folder: Path, bunny: Cloud) -> FloatArray:
    """The true pose of `scene.pcd`, which it writes, in the user's units: 20 degrees and a tenth of the size."""
    p = Perturbation(noise=0.005, points=1500, outliers=0, incomplete=0, rotation=20, translation=0.1)
    scene = perturb(bunny, p)
    points = o3d.utility.Vector3dVector(FRAME.to_user_units(scene.points))
    assert o3d.io.write_point_cloud(folder / "scene.pcd", o3d.geometry.PointCloud(points))
    return np.linalg.inv(FRAME.pose_in_user_units(scene.T_model_scene))
