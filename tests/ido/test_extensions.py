"""Methods and features of one's own in `ido`: iterated as by hand, found by name, refused with a reason."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ido import (
    Cloud,
    FrontBack,
    Maps,
    Method,
    Model,
    OwnError,
    Perturbation,
    Scene,
    StopReason,
    cli,
    perturb,
    register,
    register_updates,
)
from ido.extensions import find_class, histogram_class
from ido.types import FloatArray

MODULE = '''
import numpy as np
import ido

class Shells(ido.Histogram):
    """Points of the scene within and without a ball around each model point."""
    name = "shells"
    blocks = (ido.Block("near", "far"),)

    def describe(self, moved):
        away = np.linalg.norm(moved[None] - self.model.points[:, None], axis=2)
        return np.concatenate([(away < 0.2).mean(axis=1), ((away >= 0.2) & (away < 0.4)).mean(axis=1)])

class Nameless(Shells):
    name = ""

class Namesake(ido.FrontBack):
    pass

def function(cloud): ...
'''


class Drift:
    """Halves what is left of the way to a place."""

    def __init__(self, cloud: Cloud | None = None) -> None:
        self.goal = np.array([0.1, -0.2, 0.3, 0.4, -0.5, 0.6])

    def update(self, points: FloatArray, x: FloatArray, /) -> FloatArray:
        return 0.5 * (self.goal - x) + 1e-3 * np.tile(points.mean(axis=0), 2)


@pytest.fixture(scope="module")
def scene(bunny: Cloud) -> Scene:
    return perturb(bunny, Perturbation(points=120, outliers=20, rotation=30.0, seed=4))


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """Where a person works, with a module."""
    (tmp_path / "shells_module.py").write_text(MODULE, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", list(sys.path))
    before = set(sys.modules)
    yield tmp_path
    for name in set(sys.modules) - before:
        if str(tmp_path) in str(getattr(sys.modules[name], "__file__", "")):
            del sys.modules[name]


def test_updates_are_iterated_as_by_hand(scene: Scene):
    epsilon, seen = 1e-3, []
    track = register_updates(Drift(), scene.points, epsilon=epsilon, watch=seen.append)
    x, expected = np.zeros(6), [np.zeros(6)]
    while np.linalg.norm(step := Drift().update(scene.points.astype(np.float64), x)) >= epsilon:
        x = x + step
        expected.append(x)
    np.testing.assert_array_equal(track.x, expected)
    np.testing.assert_allclose(track.update_norms, np.linalg.norm(np.diff(expected, axis=0), axis=1), rtol=1e-12)
    assert track.last_norm == pytest.approx(np.linalg.norm(step))
    assert track.stop is StopReason.CONVERGED
    assert seen == list(range(1, track.iterations + 1))


def test_the_limit_is_kept_and_running_away_is_told(scene: Scene):
    track = register_updates(Drift(), scene.points, epsilon=0.0, max_iterations=4)
    assert (track.iterations, track.stop) == (4, StopReason.MAX_ITERATIONS)
    assert np.isnan(track.last_norm)

    class Explodes(Drift):
        def update(self, points: FloatArray, x: FloatArray, /) -> FloatArray:
            return 3.0 * x + 1.0

    track = register_updates(Explodes(), scene.points)
    assert track.stop is StopReason.DIVERGED
    assert (np.linalg.norm(track.x, axis=1) < 1e3).all()


@pytest.mark.parametrize(
    ("update", "message"),
    [
        (np.full(6, np.nan), r"Odd: update 1 is not finite"),
        (np.array([0, 0, 0, 0, 0, np.inf]), r"not finite"),
        (np.zeros(5), r"Odd: update 1 has the shape \(5,\), not \(6,\)"),
        (np.zeros((6, 1)), r"shape \(6, 1\)"),
        (None, r"shape \(\)|not 6 numbers"),
        (["a"] * 6, r"not 6 numbers but list"),
    ],
)
def test_what_is_no_update_is_refused_by_the_methods_name(scene: Scene, update: Any, message: str):
    class Odd(Drift):
        def update(self, points: FloatArray, x: FloatArray, /) -> FloatArray:
            return update

    with pytest.raises(OwnError, match=message):
        register_updates(Odd(), scene.points)


def test_a_method_cannot_spoil_its_scene_or_its_trajectory(scene: Scene):
    class Mover(Drift):
        def update(self, points: FloatArray, x: FloatArray, /) -> FloatArray:
            x += 5.0
            return np.full(6, 1e-2)

    np.testing.assert_allclose(register_updates(Mover(), scene.points, max_iterations=2).x[:, 0], [0, 0.01, 0.02])

    class Spoiler(Drift):
        def update(self, points: FloatArray, x: FloatArray, /) -> FloatArray:
            points += 1.0
            return x

    with pytest.raises(ValueError, match="read-only"):
        register_updates(Spoiler(), scene.points)


def test_a_method_with_maps_registers_as_they_do(small_maps: Maps, scene: Scene):
    class Walks:
        maps = small_maps

    method = Method.own("Walks", Walks(), small_maps.histogram, 0.002, 50)
    expected = register(small_maps, scene.points, epsilon=0.002, max_iterations=50)
    np.testing.assert_array_equal(method.register(scene.points).x, expected.x)
    assert method.maps is small_maps and method.histogram is small_maps.histogram


def test_a_method_with_updates_is_seen_through_its_own_histogram_or_another(small_maps: Maps, small_model: Model):
    other = small_maps.histogram
    assert Method.own("Drift", Drift(), other).histogram is other

    class Seen(Drift):
        histogram = FrontBack(small_model)

    assert Method.own("Seen", Seen(), other).histogram is Seen.histogram


def test_a_method_that_is_none_is_refused(small_maps: Maps):
    other = small_maps.histogram

    class Both(Drift):
        maps = small_maps

    class NoMaps:
        maps = 3

    class BadHistogram(Drift):
        histogram = "front-back"

    class BadBlocks(FrontBack):
        blocks = ("front", "back")  # type: ignore[assignment]

    class BadShape(FrontBack):
        def __call__(self, points: FloatArray, x: FloatArray) -> FloatArray:
            return np.ones(7, dtype=np.float32)

    for own, message in (
        (object(), "Mine needs either maps or a method update.*neither"),
        (Both(), "both"),
        (NoMaps(), "must be ido.Maps.*int"),
        (BadHistogram(), "must be an ido.Histogram"),
    ):
        with pytest.raises(OwnError, match=message):
            Method.own("Mine", own, other)  # type: ignore[arg-type]
    for broken, message in ((BadBlocks, "tuple of ido.Block"), (BadShape, r"gives the shape \(7,\)")):
        with pytest.raises(OwnError, match=message):
            Method.own("Mine", Drift(), broken(other.model))


def test_a_property_that_fails_tells_why_itself(small_maps: Maps):
    class Late:
        @property
        def maps(self) -> Maps:
            raise AttributeError("no attribute 'weights'")

    with pytest.raises(AttributeError, match="weights"):
        Method.own("Late", Late(), small_maps.histogram)


def test_a_class_is_found_by_module_and_by_file(folder: Path):
    by_module, by_file = find_class("shells_module:Shells"), find_class("shells_module.py:Shells")
    assert by_module is by_file
    assert histogram_class("shells_module:Shells") is by_module
    assert histogram_class("front-back") is FrontBack
    (folder / "below").mkdir()
    (folder / "below" / "deep.py").write_text("class Deep: ...", encoding="utf-8")
    assert find_class(f"{folder}/below/deep.py:Deep").__name__ == "Deep"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("shells_module", "name a class as module:Class"),
        (":Shells", "name a class as"),
        ("shells_module:", "name a class as"),
        ("shells_module:Other", "shells_module has no Other"),
        ("shells_module:function", "is no class"),
        ("elsewhere_module:Shells", "there is no module elsewhere_module"),
        ("elsewhere.py:Shells", "no such file"),
    ],
)
def test_what_is_not_there_is_told(folder: Path, text: str, message: str):
    with pytest.raises(OwnError, match=message):
        find_class(text)


def test_errors_of_a_module_are_its_own(folder: Path):
    (folder / "needs_module.py").write_text("import missing_dependency", encoding="utf-8")
    with pytest.raises(ModuleNotFoundError, match="missing_dependency"):
        find_class("needs_module:Any")
    (folder / "json.py").write_text("class Any: ...", encoding="utf-8")
    with pytest.raises(OwnError, match="another module is called json"):
        find_class("json.py:Any")
    assert json.loads("[]") == []


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("none", "unknown histogram 'none'; known: front-back"),
        ("shells_module:Nameless", "needs a name"),
        ("shells_module:Namesake", "name 'front-back' is taken"),
        ("pathlib:Path", "no subclass of ido.Histogram"),
    ],
)
def test_what_is_no_histogram_is_refused(folder: Path, text: str, message: str):
    with pytest.raises(OwnError, match=message):
        histogram_class(text)


def test_the_commands_train_and_register_with_an_own_histogram(
    folder: Path, bunny: Cloud, capfd: pytest.CaptureFixture[str]
):
    np.savez(folder / "cloud.npz", points=bunny.points[::20])
    own = ("--histogram", "shells_module:Shells")
    size = ("--samples", "40", "--maps", "2")
    assert cli.main(["train", "cloud.npz", "-o", "maps.npz", *own, *size]) is None
    assert cli.main(["train", "cloud.npz", "-o", "again.npz", *own, *size, "--workers", "1"]) is None
    known = {"shells": histogram_class("shells_module:Shells")}
    maps, again = (Maps.load(folder / name, known) for name in ("maps.npz", "again.npz"))
    np.testing.assert_array_equal(maps.maps, again.maps)
    assert isinstance(maps.histogram, known["shells"])
    capfd.readouterr()
    command = ["register", "cloud.npz", "--maps", "maps.npz", "--max-iterations", "3"]
    assert cli.main([*command, *own]) is None
    assert json.loads(capfd.readouterr().out)["iterations"] <= 3
    assert cli.main(command) == 2  # a file names its histogram, but never imports it
    assert "histogram 'shells' is unknown" in capfd.readouterr().err
    assert cli.main([*command, "--histogram", "shells_module:Other"]) == 2
    assert "has no Other" in capfd.readouterr().err
