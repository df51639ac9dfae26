"""The file of a kept cloud: it comes back as it was, other programs read it, and hostile ones are refused."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from ido import Maps, MapsError
from ido.npz import packed, read_arrays
from ido_viz.own.kept import TRAINED, KeptCloud


@pytest.fixture(scope="module")
def file(kept: KeptCloud, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("kept") / "tiny.npz"
    kept.save(path)
    return path


def test_it_comes_back_as_it_was(kept: KeptCloud, file: Path):
    back = KeptCloud.load(file)
    assert (back.name, back.unit, back.up, list(back.maps)) == ("tiny", "mm", "+y", list(TRAINED))
    np.testing.assert_array_equal(back.cloud.points, kept.cloud.points)
    np.testing.assert_array_equal(back.cloud.frame.centre, kept.cloud.frame.centre)
    for method, maps in kept.maps.items():
        np.testing.assert_array_equal(back.maps[method].maps, maps.maps)
        assert back.maps[method].settings == maps.settings
        assert back.maps[method].settings.rotation == 120.0


def test_it_is_a_maps_file_of_improved_do_for_other_programs(kept: KeptCloud, file: Path):
    maps = Maps.load(file)
    assert maps.histogram.name == "triple-binary"
    np.testing.assert_array_equal(maps.maps, kept.maps["Improved DO"].maps)


def test_a_file_of_the_command_line_is_taken_with_its_model_as_the_cloud(kept: KeptCloud, tmp_path: Path):
    maps = kept.maps["DO"]
    maps.save(tmp_path / "plain.npz")
    back = KeptCloud.load(tmp_path / "plain.npz", "plain")
    assert (back.name, list(back.maps)) == ("plain", ["DO"])
    np.testing.assert_array_equal(back.cloud.points, maps.histogram.model.points)


def test_it_is_a_shape_of_the_page(kept: KeptCloud):
    subject = kept.subject()
    assert subject.methods[:2] == ("DO", "Improved DO")
    assert subject.up == (0.0, 1.0, 0.0)
    assert subject.cloud() is kept.cloud


HEAD = {"name": "x", "unit": "mm", "up": "+y", "methods": ["DO", "Improved DO"]}


@pytest.mark.parametrize(
    "changes",
    [
        {"kept": np.array("no JSON")},
        {"kept": np.array(json.dumps([1]))},
        {"kept": np.array(json.dumps({**HEAD, "unit": "<b>"}))},
        {"kept": np.array(json.dumps({**HEAD, "up": "sideways"}))},
        {"kept": np.array(json.dumps({**HEAD, "methods": []}))},
        {"kept": np.array(json.dumps({**HEAD, "methods": ["Improved DO", "DO", "Improved DO (as printed)"]}))},
        {"kept": np.array(json.dumps({**HEAD, "methods": ["../x"]}))},
        {"kept_cloud": np.full((1000, 3), np.nan, dtype=np.float32)},
        {"kept_cloud": np.full((1000, 3), 1e9, dtype=np.float32)},
        {"kept_cloud": np.zeros((3, 3), dtype=np.float32)},
        {"kept_cloud": np.zeros(3, dtype=np.float32)},
        {"kept_cloud": np.zeros((1000, 3))},
        {"maps": np.zeros((2, 6, 7), dtype=np.float32)},
        {"front-back/model_points": np.zeros((64, 3), dtype=np.float32)},
        {"front-back/header": np.array("{}")},
    ],
    ids=range(15),
)
def test_a_file_that_does_not_fit_together_is_refused(file: Path, tmp_path: Path, changes: dict[str, np.ndarray]):
    arrays = read_arrays(file, MapsError, "a maps file", "")
    (tmp_path / "bad.npz").write_bytes(packed(arrays | changes))
    with pytest.raises(MapsError):
        KeptCloud.load(tmp_path / "bad.npz")


def test_a_file_that_unpacks_to_too_much_is_refused_before_it_is(file: Path, tmp_path: Path):
    arrays = read_arrays(file, MapsError, "a maps file", "")
    (tmp_path / "bomb.npz").write_bytes(packed(arrays | {"more": np.zeros(300 << 20, dtype=np.uint8)}))
    assert (tmp_path / "bomb.npz").stat().st_size < 4 << 20
    with pytest.raises(MapsError, match="at most 200 MB"):
        KeptCloud.load(tmp_path / "bomb.npz")


@pytest.mark.parametrize("content", [b"", b"PK", b"no zip at all"])
def test_a_file_that_is_none_is_refused(tmp_path: Path, content: bytes):
    (tmp_path / "none.npz").write_bytes(content)
    with pytest.raises(MapsError):
        KeptCloud.load(tmp_path / "none.npz")
