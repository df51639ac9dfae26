"""The maps file: an exact round trip, and a clear error for everything that is not such a file."""

from __future__ import annotations

import json
import pickle
import sys
from collections.abc import Callable
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ido import HISTOGRAMS, FrontBack, Maps, MapsError, TrainingSettings
from ido.types import FloatArray

Arrays = dict[str, np.ndarray]


class Renamed(FrontBack):
    """Somebody's own histogram."""

    name = "renamed"


@pytest.fixture
def saved(small_maps: Maps, tmp_path: Path) -> Path:
    small_maps.save(tmp_path / "saved.npz")
    return tmp_path / "saved.npz"


def rewrite(path: Path, change: Callable[[Arrays], Any], header: dict[str, Any] | None = None) -> Path:
    """A copy of a maps file with changed arrays or header entries, without a checksum as older ones are."""
    with np.load(path) as file:
        arrays = dict(file)
    whole = json.loads(str(arrays["header"])) | (header or {})
    arrays["header"] = np.array(json.dumps({name: value for name, value in whole.items() if name != "checksum"}))
    change(arrays)
    changed = path.with_name("changed.npz")
    np.savez(changed, **arrays)  # pyright: ignore[reportArgumentType] (its `allow_pickle` is no array)
    return changed


def assert_same(first: Maps, second: Maps) -> None:
    np.testing.assert_array_equal(first.maps, second.maps)
    np.testing.assert_array_equal(first.histogram.model.points, second.histogram.model.points)
    np.testing.assert_array_equal(first.histogram.model.normals, second.histogram.model.normals)
    np.testing.assert_array_equal(first.frame.centre, second.frame.centre)
    for name, values in asdict(first.curves).items():
        other = getattr(second.curves, name)
        if name == "residuals":  # stored as float16
            np.testing.assert_allclose(values, other, rtol=1e-3, atol=1e-6)
        else:
            np.testing.assert_array_equal(values, other)
    assert type(first.histogram) is type(second.histogram)
    assert (first.frame.scale, first.settings, first.version) == (second.frame.scale, second.settings, second.version)


def test_round_trip_is_exact(small_maps: Maps, saved: Path):
    loaded = Maps.load(saved)
    assert_same(loaded, small_maps)
    assert loaded.complete
    assert loaded.maps.dtype == loaded.curves.residuals.dtype == np.float32
    x, points = np.full(6, 0.1), small_maps.histogram.model.points
    np.testing.assert_array_equal(loaded.histogram(points, x), small_maps.histogram(points, x))


def test_settings_survive(small_maps: Maps, tmp_path: Path):
    settings = TrainingSettings(samples=7, maps=8, ridge=0.125, first_ridge=0.5, outlier_kind="structured", seed=2**40)
    replace(small_maps, settings=settings).save(tmp_path / "a.npz")
    assert Maps.load(tmp_path / "a.npz").settings == settings


def test_fewer_maps_than_asked_for_are_incomplete(small_maps: Maps, saved: Path):
    def cut(arrays: Arrays) -> None:
        arrays["maps"] = arrays["maps"][:3]
        for name in arrays:
            if name.startswith("curves_"):
                arrays[name] = arrays[name][:4]

    assert small_maps.complete
    assert not Maps.load(rewrite(saved, cut)).complete


def test_the_file_holds_no_pickle_and_says_what_it_is(saved: Path):
    with np.load(saved, allow_pickle=False) as file:
        arrays = dict(file)
    header = json.loads(str(arrays["header"]))
    assert header["format"] == "ido-maps-1"
    assert header["histogram"] == "front-back"
    assert header["settings"]["maps"] == len(arrays["maps"])
    assert all(array.dtype != object for array in arrays.values())


def test_a_histogram_of_ones_own_is_known_when_given(small_maps: Maps, tmp_path: Path):
    own = replace(small_maps, histogram=Renamed(small_maps.histogram.model))
    own.save(tmp_path / "own.npz")
    with pytest.raises(MapsError, match=r"own\.npz: its histogram 'renamed' is unknown; known: front-back"):
        Maps.load(tmp_path / "own.npz")
    assert_same(Maps.load(tmp_path / "own.npz", HISTOGRAMS | {"renamed": Renamed}), own)


@pytest.mark.parametrize("share", [0.0, 0.01, 0.3, 0.7, 0.99, 0.9999])
def test_a_cut_off_file_is_refused(saved: Path, share: float):
    content = saved.read_bytes()
    saved.write_bytes(content[: int(share * len(content))])
    with pytest.raises(MapsError, match=r"saved\.npz: "):
        Maps.load(saved)


def test_a_flipped_byte_is_noticed_or_harmless(small_maps: Maps, saved: Path):
    content, refused = saved.read_bytes(), 0
    for position in np.random.default_rng(0).integers(0, len(content), 60):
        damaged = bytearray(content)
        damaged[position] ^= 0xFF
        saved.write_bytes(damaged)
        try:
            assert_same(Maps.load(saved), small_maps)  # the byte says nothing, such as a date
        except MapsError:
            refused += 1
    assert refused > 40


def test_a_file_without_a_checksum_is_read_as_before(small_maps: Maps, saved: Path):
    assert_same(Maps.load(rewrite(saved, lambda arrays: None)), small_maps)


def test_whatever_is_changed_of_the_header_or_the_numbers_is_noticed(saved: Path):
    with np.load(saved) as file:
        arrays = dict(file)
    text, rng = str(arrays["header"]), np.random.default_rng(1)

    def refused(**changed: np.ndarray) -> bool:
        np.savez(saved, **{**arrays, **changed})  # pyright: ignore[reportArgumentType]
        try:
            Maps.load(saved)
        except MapsError:
            return True
        return False

    assert not refused()
    for position in rng.integers(1, len(text) - 1, 80):
        letter = chr(rng.integers(33, 127))
        spoilt = text[:position] + letter + text[position + 1 :]
        assert spoilt == text or refused(header=np.array(spoilt)), spoilt
    for name in arrays.keys() - {"header"}:
        other = arrays[name].copy()
        other.reshape(-1)[rng.integers(other.size)] += 0.5
        assert refused(**{name: other}), name


def test_other_files_are_refused(tmp_path: Path):
    with pytest.raises(MapsError, match="no such file; make one with `ido train`"):
        Maps.load(tmp_path / "missing.npz")
    with pytest.raises(MapsError, match="is a folder; name a file in it"):
        Maps.load(tmp_path)
    for name, content in {"text": b"hello", "pickle": pickle.dumps([1])}.items():
        (tmp_path / f"{name}.npz").write_bytes(content)
        with pytest.raises(MapsError, match=rf"{name}\.npz: not a maps file"):
            Maps.load(tmp_path / f"{name}.npz")
    np.savez(tmp_path / "foreign.npz", points=np.zeros((20, 3)))
    with pytest.raises(MapsError, match=r"foreign\.npz: not a maps file of this program"):
        Maps.load(tmp_path / "foreign.npz")


class Bomb:
    """Loading its pickle creates a file."""

    def __init__(self, path: Path) -> None:
        self.path = path

    def __reduce__(self) -> tuple[Callable[[Path], None], tuple[Path]]:
        return Path.touch, (self.path,)


@pytest.mark.parametrize("name", ["header", "maps", "centre", "curves_mean"])
def test_pickles_are_never_loaded(saved: Path, tmp_path: Path, name: str):
    trace = tmp_path / "exploded"
    bombed = rewrite(saved, lambda arrays: arrays.update({name: np.array([Bomb(trace)], dtype=object)}))
    with pytest.raises(MapsError, match=r"changed\.npz: damaged"):
        Maps.load(bombed)
    assert not trace.exists()


@pytest.mark.parametrize(
    ("header", "message"),
    [
        ({"format": "ido-maps-9"}, "its format is 'ido-maps-9', this program reads 'ido-maps-1'"),
        ({"format": None}, "its format is None"),
        ({"histogram": "unheard-of"}, "its histogram 'unheard-of' is unknown; known: front-back"),
        ({"histogram": ["front-back"]}, "not a maps file"),
        ({"settings": {"samples": 1}}, "at least 2 samples"),
        ({"settings": {"ridge": -1}}, "the ridge must be a positive number"),
        ({"settings": {"outlier_kind": "spiral"}}, "outlier_kind must be one of"),
        ({"settings": {"colour": 1}}, "not a maps file"),
        ({"settings": 7}, "not a maps file"),
    ],
)
def test_a_header_that_makes_no_sense_is_refused(saved: Path, header: dict[str, Any], message: str):
    with pytest.raises(MapsError, match=message):
        Maps.load(rewrite(saved, lambda arrays: None, header))


@pytest.mark.parametrize("text", ["", "{", "[]", "7", "null", "[" * 100_000])
def test_a_broken_header_is_refused(saved: Path, text: str):
    with pytest.raises(MapsError, match="not a maps file"):
        Maps.load(rewrite(saved, lambda arrays: arrays.update(header=np.array(text))))


NAMES = ["maps", "model_points", "model_normals", "centre", "scale", "curves_mean", "curves_residuals"]


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_numbers_that_are_not_finite_are_refused(saved: Path, name: str, value: float):
    def spoil(arrays: Arrays) -> None:
        arrays[name] = arrays[name].copy()
        arrays[name].flat[0] = value

    with pytest.raises(MapsError, match=f"its {name} holds numbers that are not finite"):
        Maps.load(rewrite(saved, spoil))


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("change", [lambda a: a[None], lambda a: a.astype(str), lambda a: np.zeros(0)])
def test_parts_of_another_shape_or_kind_are_refused(saved: Path, name: str, change: Callable[[FloatArray], FloatArray]):
    def alter(arrays: Arrays) -> None:
        arrays[name] = change(arrays[name])

    with pytest.raises(MapsError):
        Maps.load(rewrite(saved, alter))


@pytest.mark.parametrize("name", [name for name in NAMES if name != "scale"])
def test_parts_of_another_length_are_refused(saved: Path, name: str):
    def shorten(arrays: Arrays) -> None:
        arrays[name] = arrays[name][1:]

    with pytest.raises(MapsError, match="has the shape"):
        Maps.load(rewrite(saved, shorten))


@pytest.mark.parametrize("name", [*NAMES, "header", "curves_deviation"])
def test_a_missing_part_is_refused(saved: Path, name: str):
    with pytest.raises(MapsError, match=name):
        Maps.load(rewrite(saved, lambda arrays: arrays.pop(name)))


@pytest.mark.parametrize("scale", [0.0, -1.0])
def test_a_scale_that_is_not_positive_is_refused(saved: Path, scale: float):
    with pytest.raises(MapsError, match="no scale"):
        Maps.load(rewrite(saved, lambda arrays: arrays.update(scale=np.array(scale))))


def test_a_failed_save_leaves_the_old_file_alone(small_maps: Maps, saved: Path, monkeypatch: pytest.MonkeyPatch):
    before = saved.read_bytes()

    def full_disk(file: Any, **arrays: Any) -> None:
        file.write(b"half a file")
        raise OSError("No space left on device")

    monkeypatch.setattr(np, "savez_compressed", full_disk)
    with pytest.raises(OSError, match="No space left"):
        replace(small_maps, maps=small_maps.maps * 2).save(saved)
    assert saved.read_bytes() == before
    assert list(saved.parent.iterdir()) == [saved]


def test_saving_replaces_the_old_file_and_leaves_nothing_else(small_maps: Maps, saved: Path):
    replace(small_maps, maps=small_maps.maps * 2).save(saved)
    np.testing.assert_array_equal(Maps.load(saved).maps, small_maps.maps * 2)
    assert list(saved.parent.iterdir()) == [saved]


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no such permissions")
def test_a_saved_file_has_the_usual_permissions(saved: Path):
    (saved.parent / "usual").touch()
    assert saved.stat().st_mode == (saved.parent / "usual").stat().st_mode


@pytest.mark.parametrize(
    "values",
    [
        {"samples": 1},
        {"maps": 0},
        {"ridge": 0},
        {"first_ridge": 0},
        {"first_ridge": float("inf")},
        {"ridge": float("nan")},
        {"seed": -1},
        {"outlier_kind": "spiral"},
    ],
)
def test_settings_out_of_range_are_refused(values: dict[str, Any]):
    with pytest.raises(ValueError):
        TrainingSettings(**values)
