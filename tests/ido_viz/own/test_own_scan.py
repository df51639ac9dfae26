"""A scan of one's own: its pose is in the units of the cloud, and its figures are those of the command."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from ido import Cloud, FrontBack, Maps, Model, TrainingSettings, load_cloud, poses, train
from ido.clouds import Frame
from ido.files import save_cloud
from ido.scans import ScanSettings, as_json, register_scan
from ido_viz.own.draft import open_upload
from ido_viz.own.own_scan import OwnScan, registered_own
from ido_viz.own.own_scan_folder import moved_ply, pose_of, scan_html

MILLIMETRES = Frame(np.array([100.0, -50.0, 20.0]), 40.0)


@pytest.fixture(scope="module")
def maps(bunny: Cloud, full_model: Model) -> Maps:
    cloud = Cloud(bunny.points, MILLIMETRES)
    return train(cloud, FrontBack(full_model), TrainingSettings(samples=800, maps=6, rotation=40.0))


@pytest.fixture(scope="module")
def found(bunny: Cloud, maps: Maps, tmp_path_factory: pytest.TempPathFactory) -> OwnScan:
    """A turned part of the bunny, in millimetres."""
    original = MILLIMETRES.to_user_units(bunny.points[bunny.points[:, 0] > -0.5][::40])
    T = MILLIMETRES.pose_in_user_units(poses.exp(np.array([0.05, 0.0, -0.05, 0.0, 0.3, 0.1])))
    folder = tmp_path_factory.mktemp("scan")
    save_cloud(folder / "scan.xyz", poses.transform(T, original))
    content = (folder / "scan.xyz").read_bytes()
    file, used = open_upload("scan.xyz", content, folder)
    found = registered_own(maps, "DO", "mm", "scan.xyz", file, used, "here")
    expected = register_scan(maps, str(folder / "scan.xyz"), ScanSettings())
    assert as_json(found.scan) == as_json(expected)
    away = poses.transform(found.scan.T_model_scene @ T, original) - original
    assert np.sqrt((away**2).sum(axis=1).mean()) < 4.0  # millimetres, a twentieth of its size
    return found


def test_the_placed_scan_lies_on_the_model(found: OwnScan, bunny: Cloud):
    assert found.scan.quality.fit.near_share > 0.9
    assert np.abs(found.placed).max() < 1.2


def test_the_histogram_s_distance_is_smaller_than_where_the_scan_lay(found: OwnScan, maps: Maps):
    histogram, lay = maps.histogram, maps.frame.to_model_units(found.scan.file.points)
    before = np.linalg.norm(histogram(lay, np.zeros(6)) - histogram.reference) / np.linalg.norm(histogram.reference)
    assert 0 < found.distance < before


def test_what_is_downloaded_is_the_pose_and_all_points_moved_by_it(found: OwnScan, tmp_path: Path):
    told = json.loads(json.dumps(pose_of(found), allow_nan=False))
    assert (told["unit"], told["method"], told["file"]) == ("mm", "DO", "scan.xyz")
    T = np.array(told["T_model_scene"])
    (tmp_path / "moved.ply").write_bytes(moved_ply(found, tmp_path))
    moved = load_cloud(tmp_path / "moved.ply")
    np.testing.assert_allclose(moved, poses.transform(T, found.scan.file.points), atol=1e-9)
    assert {path.name for path in tmp_path.iterdir()} == {"moved.ply"}


def test_figures_doubts_and_names_are_shown_as_text(found: OwnScan):
    doubtful = replace(found.scan, doubts=("the <b>fit</b> is poor",))
    text = scan_html(replace(found, name="<img src=x>.xyz", scan=doubtful))
    assert "&lt;img src=x&gt;" in text and "&lt;b&gt;fit" in text and "look at it before you use it" in text
    assert f"{found.scan.quality.fit.near_share:.0%}" in text and " mm" in text
