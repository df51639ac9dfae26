"""The file of a recorded run: an exact round trip, and a clear error for everything that is not such a file."""

from __future__ import annotations

import io
import json
import pickle
from collections.abc import Callable
from dataclasses import asdict, fields, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ido import Cloud, Maps, Perturbation, Scene, StopReason, Trajectory, perturb, poses, register, score
from ido.baselines import ICP
from ido.recording import MOST_HISTOGRAMS, RecordedMethod, RecordedRun, RunError, chosen_iterations, load_run

Arrays = dict[str, np.ndarray]

PERTURBATION = Perturbation(points=90, outliers=20, rotation=30.0, seed=5)
SETTINGS = {"epsilon": 0.01, "limits": [1, 2], "fixed": True, "cutoff": float("inf")}


@pytest.fixture(scope="module")
def scene(bunny: Cloud) -> Scene:
    return perturb(bunny, PERTURBATION)


@pytest.fixture(scope="module")
def run(small_maps: Maps, scene: Scene) -> RecordedRun:
    """DO, and a baseline, whose last norm is NaN."""
    histogram = small_maps.histogram
    learned = register(small_maps, scene.points, epsilon=0.01, max_iterations=40)
    baseline = ICP().register(histogram.model.points, scene.points)
    return RecordedRun(
        shape="bunny",
        perturbation=PERTURBATION,
        scene=scene,
        methods=(
            RecordedMethod.of("DO", SETTINGS, learned, scene, histogram),
            RecordedMethod.of("ICP, default", ICP().settings, baseline, scene, histogram),
        ),
        code="ido1-abc",
    )


@pytest.fixture
def saved(run: RecordedRun, tmp_path: Path) -> Path:
    run.save(tmp_path / "saved.npz")
    return tmp_path / "saved.npz"


def assert_same_method(one: RecordedMethod, other: RecordedMethod) -> None:
    for name in ("name", "settings", "histogram", "blocks"):
        assert getattr(one, name) == getattr(other, name)
    assert one.trajectory.stop is other.trajectory.stop
    np.testing.assert_equal(one.trajectory.last_norm, other.trajectory.last_norm)
    arrays = [
        *((getattr(one.trajectory, name), getattr(other.trajectory, name)) for name in ("x", "update_norms")),
        *((getattr(one.scores, f.name), getattr(other.scores, f.name)) for f in fields(one.scores)),
        *((getattr(one.model, f.name), getattr(other.model, f.name)) for f in fields(one.model)),
        *(
            (getattr(one, name), getattr(other, name))
            for name in ("T_model_scene", "reference", "histogram_iterations", "histograms")
        ),
    ]
    for first, second in arrays:
        np.testing.assert_array_equal(first, second)
        assert first.dtype == second.dtype


def assert_same(one: RecordedRun, other: RecordedRun) -> None:
    for name in ("shape", "perturbation", "code", "version"):
        assert getattr(one, name) == getattr(other, name)
    for field in fields(one.scene):
        np.testing.assert_array_equal(getattr(one.scene, field.name), getattr(other.scene, field.name))
    assert len(one.methods) == len(other.methods)
    for first, second in zip(one.methods, other.methods, strict=True):
        assert_same_method(first, second)


def rewrite(path: Path, change: Callable[[Arrays], Any], header: dict[str, Any] | None = None) -> Path:
    """A copy of a run's file with changed arrays or header entries."""
    with np.load(path) as file:
        arrays = dict(file)
    if header:
        arrays["header"] = np.array(json.dumps(json.loads(str(arrays["header"])) | header))
    change(arrays)
    changed = path.with_name("changed.npz")
    np.savez(changed, **arrays)  # pyright: ignore[reportArgumentType] (its `allow_pickle` is no array)
    return changed


# What is recorded


def test_every_pose_score_and_histogram_equals_a_computation_of_its_own(
    run: RecordedRun, small_maps: Maps, scene: Scene
):
    for method in run.methods:
        n = method.trajectory.iterations
        assert n > 5
        np.testing.assert_array_equal(method.histogram_iterations, np.arange(n + 1))
        for k in range(n + 1):
            T = poses.exp(method.trajectory.x[k])
            np.testing.assert_array_equal(method.T_model_scene[k], T)
            for name, value in asdict(score(scene, T)).items():
                assert getattr(method.scores, name)[k] == pytest.approx(value, abs=1e-12)
            seen = small_maps.histogram.describe(poses.transform(T, scene.points.astype(np.float64)))
            np.testing.assert_allclose(method.histograms[k], seen, atol=1e-5)
        np.testing.assert_array_equal(method.reference, small_maps.histogram.reference)
    assert run.methods[0].trajectory.stop is StopReason.CONVERGED
    assert np.isnan(run.methods[1].trajectory.last_norm)


def test_what_was_recorded_explains_each_update(run: RecordedRun, small_maps: Maps):
    method = run.methods[0]
    for k, histogram in enumerate(method.histograms[:-1]):
        update = small_maps.maps[min(k, len(small_maps.maps) - 1)] @ histogram
        np.testing.assert_allclose(method.trajectory.x[k] - method.trajectory.x[k + 1], update, atol=1e-6)


def test_of_a_long_run_few_histograms_are_recorded_with_their_iterations(small_maps: Maps, scene: Scene):
    n = 1000
    x = np.linspace(np.zeros(6), np.full(6, 0.3), n + 1)
    long = Trajectory(x, np.full(n, 0.1), StopReason.MAX_ITERATIONS, np.nan)
    method = RecordedMethod.of("long", {}, long, scene, small_maps.histogram)
    assert len(method.histograms) == len(method.histogram_iterations) == MOST_HISTOGRAMS
    for k, histogram in zip(method.histogram_iterations, method.histograms, strict=True):
        np.testing.assert_array_equal(histogram, small_maps.histogram(scene.points, x[k]))
    assert len(method.T_model_scene) == len(method.scores.rmse) == n + 1


@pytest.mark.parametrize("n", [0, 1, 9, 10, 11, 12, 19, 20, 21, 5000])
@pytest.mark.parametrize("most", [10, 11])
def test_the_first_iterations_and_the_last_are_chosen(n: int, most: int):
    chosen = chosen_iterations(n, most)
    assert len(chosen) == min(n + 1, most)
    assert (chosen[0], chosen[-1]) == (0, n)
    assert (np.diff(chosen) > 0).all()
    np.testing.assert_array_equal(chosen[:5], np.arange(min(n + 1, 5)))
    if n >= most:
        assert np.ptp(np.diff(chosen[most // 2 :])) <= 1


# The round trip


def test_round_trip_is_exact(run: RecordedRun, saved: Path):
    assert_same(load_run(saved), run)
    assert_same(load_run(str(saved)), run)


def test_an_open_file_takes_the_same_bytes(run: RecordedRun, saved: Path):
    file = io.BytesIO()
    run.save(file)
    (saved.parent / "other.npz").write_bytes(file.getvalue())
    assert_same(load_run(saved.parent / "other.npz"), run)


def test_the_file_holds_no_pickle_and_says_what_it_is(run: RecordedRun, saved: Path):
    with np.load(saved, allow_pickle=False) as file:
        arrays = dict(file)
    header = json.loads(str(arrays["header"]))
    assert (header["format"], header["code"], header["version"]) == ("ido-run-1", "ido1-abc", run.version)
    assert [method["name"] for method in header["methods"]] == ["DO", "ICP, default"]
    assert all(array.dtype != object for array in arrays.values())
    for name in arrays:
        assert name.removeprefix("method0_").removeprefix("method1_") in header["about"] + "header"


def test_saving_replaces_the_old_file_and_leaves_nothing_else(run: RecordedRun, saved: Path):
    replace(run, shape="hare").save(saved)
    assert load_run(saved).shape == "hare"
    assert list(saved.parent.iterdir()) == [saved]


def test_a_failed_save_leaves_the_old_file_alone(run: RecordedRun, saved: Path, monkeypatch: pytest.MonkeyPatch):
    before = saved.read_bytes()

    def full_disk(*_: Any) -> None:
        raise OSError("No space left on device")

    monkeypatch.setattr(Path, "replace", full_disk)
    with pytest.raises(OSError, match="No space left"):
        replace(run, shape="hare").save(saved)
    assert saved.read_bytes() == before
    assert list(saved.parent.iterdir()) == [saved]


# What is refused


@pytest.mark.parametrize("share", [0.0, 0.01, 0.3, 0.7, 0.99, 0.9999])
def test_a_cut_off_file_is_refused(saved: Path, share: float):
    content = saved.read_bytes()
    saved.write_bytes(content[: int(share * len(content))])
    with pytest.raises(RunError, match=r"saved\.npz: "):
        load_run(saved)


def test_a_flipped_byte_is_noticed_or_harmless(run: RecordedRun, saved: Path):
    content, refused = saved.read_bytes(), 0
    for position in np.random.default_rng(0).integers(0, len(content), 60):
        damaged = bytearray(content)
        damaged[position] ^= 0xFF
        saved.write_bytes(damaged)
        try:
            assert_same(load_run(saved), run)  # the byte says nothing, such as a date
        except RunError:
            refused += 1
    assert refused > 40


def test_other_files_are_refused(small_maps: Maps, tmp_path: Path):
    with pytest.raises(RunError, match="no such file; save one with the page's button"):
        load_run(tmp_path / "missing.npz")
    with pytest.raises(RunError, match="is a folder; name a file in it"):
        load_run(tmp_path)
    for name, content in {"text": b"hello", "pickle": pickle.dumps([1])}.items():
        (tmp_path / f"{name}.npz").write_bytes(content)
        with pytest.raises(RunError, match=rf"{name}\.npz: not a recorded run"):
            load_run(tmp_path / f"{name}.npz")
    np.savez(tmp_path / "foreign.npz", points=np.zeros((20, 3)))
    with pytest.raises(RunError, match=r"foreign\.npz: not a recorded run of this program"):
        load_run(tmp_path / "foreign.npz")
    small_maps.save(tmp_path / "maps.npz")
    with pytest.raises(RunError, match=r"maps\.npz: its format is 'ido-maps-1', this program reads 'ido-run-1'"):
        load_run(tmp_path / "maps.npz")


class Bomb:
    """Loading its pickle creates a file."""

    def __init__(self, path: Path) -> None:
        self.path = path

    def __reduce__(self) -> tuple[Callable[[Path], None], tuple[Path]]:
        return Path.touch, (self.path,)


@pytest.mark.parametrize("name", ["header", "points", "method1_x"])
def test_pickles_are_never_loaded(saved: Path, tmp_path: Path, name: str):
    trace = tmp_path / "exploded"
    bombed = rewrite(saved, lambda arrays: arrays.update({name: np.array([Bomb(trace)], dtype=object)}))
    with pytest.raises(RunError, match=r"changed\.npz: damaged"):
        load_run(bombed)
    assert not trace.exists()


METHOD = {"name": "DO", "settings": {}, "stop": "converged", "histogram": "front-back", "blocks": [["front", "back"]]}


@pytest.mark.parametrize(
    ("header", "message"),
    [
        ({"format": "ido-run-2"}, "its format is 'ido-run-2', this program reads 'ido-run-1'"),
        ({"perturbation": {"noise": -1}}, "noise must lie between"),
        ({"perturbation": {"colour": 1}}, "not a recorded run"),
        ({"methods": 7}, "not a recorded run"),
        ({"moved": [1.0, 2.0]}, r"its moved holds float64 of the shape \(2,\)"),
        ({"moved": [1.0, 2.0, 3.0, 4.0, 5.0, float("nan")]}, "its moved holds numbers that are not finite"),
        ({"moved": ["far"]}, "not a recorded run"),
        ({"moved": "123456"}, "its moved is no list: '123456'"),
        ({"methods": [METHOD | {"stop": "bored"}]}, "not a recorded run"),
        ({"methods": [METHOD | {"settings": 3}]}, "method 0: its settings are not plain values"),
        ({"methods": [METHOD | {"blocks": []}]}, "method 0: its reference holds"),
        ({"methods": [METHOD | {"blocks": [["front"]]}]}, "not a recorded run"),
        ({"methods": [METHOD, METHOD, METHOD]}, "not a recorded run"),
    ],
)
def test_a_header_that_makes_no_sense_is_refused(saved: Path, header: dict[str, Any], message: str):
    with pytest.raises(RunError, match=message):
        load_run(rewrite(saved, lambda arrays: None, header))


@pytest.mark.parametrize("text", ["", "{", "[]", "7", "null", "[" * 100_000])
def test_a_broken_header_is_refused(saved: Path, text: str):
    with pytest.raises(RunError, match="not a recorded run"):
        load_run(rewrite(saved, lambda arrays: arrays.update(header=np.array(text))))


NUMBERS = [
    "points",
    "true_pose",
    "method0_x",
    "method0_update_norms",
    "method0_T_model_scene",
    "method1_accuracy",
    "method1_rmse",
    "method1_rotation",
    "method1_translation",
    "method0_reference",
    "method0_histograms",
    "method0_model_points",
    "method0_model_normals",
]
ARRAYS = [*NUMBERS, "is_outlier", "method0_histogram_iterations"]


@pytest.mark.parametrize("name", NUMBERS)
@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_numbers_that_are_not_finite_are_refused(saved: Path, name: str, value: float):
    def spoil(arrays: Arrays) -> None:
        arrays[name] = arrays[name].copy()
        arrays[name].flat[-1] = value

    with pytest.raises(RunError, match=f"its {name.split('_', 1)[-1] if 'method' in name else name} holds numbers"):
        load_run(rewrite(saved, spoil))


@pytest.mark.parametrize("name", ARRAYS)
@pytest.mark.parametrize(
    "change",
    [lambda a: a[None], lambda a: a.astype(str), lambda a: np.zeros(0), lambda a: a[1:]],
    ids=["another axis", "text", "empty", "one less"],
)
def test_parts_of_another_shape_or_kind_are_refused(saved: Path, name: str, change: Callable[[np.ndarray], np.ndarray]):
    with pytest.raises(RunError):
        load_run(rewrite(saved, lambda arrays: arrays.update({name: change(arrays[name])})))


@pytest.mark.parametrize("name", [*ARRAYS, "header", "method1_last_norm"])
def test_a_missing_part_is_refused(saved: Path, name: str):
    with pytest.raises(RunError, match=name.split("_", 1)[-1] if "method" in name else name):
        load_run(rewrite(saved, lambda arrays: arrays.pop(name)))


@pytest.mark.parametrize(
    "change",
    [lambda k: k + 1, lambda k: k - 1, lambda k: k[::-1], lambda k: 0 * k],
    ids=["later", "earlier", "backwards", "the first"],
)
def test_iterations_that_were_not_there_are_refused(saved: Path, change: Callable[[np.ndarray], np.ndarray]):
    name = "method1_histogram_iterations"
    with pytest.raises(RunError, match="method 1: its histogram_iterations do not rise"):
        load_run(rewrite(saved, lambda arrays: arrays.update({name: change(arrays[name])})))


def test_what_could_not_be_read_back_cannot_be_recorded(run: RecordedRun):
    method = run.methods[0]
    with pytest.raises(RunError, match="its settings are not plain values"):
        replace(method, settings={"sigmas": (0.2, 0.1)})
    with pytest.raises(RunError, match="its settings are not plain values"):
        replace(method, settings={"model": method.model})
    with pytest.raises(RunError, match="its histograms holds float32 of the shape"):
        replace(method, histograms=method.histograms[1:])
