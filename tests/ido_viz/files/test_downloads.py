"""What a page offers for download equals what it shows: the run, its curves, an animation that needs no network.

The animation for slides and the charts have tests of their own.
"""

from __future__ import annotations

import base64
import contextlib
import csv
import io
import json
import re
import threading
import time
import zipfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from html.parser import HTMLParser
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import msgspec
import numpy as np
import pytest
import viser
import zstandard
from PIL import Image
from scipy.spatial.transform import Rotation

from ido import Perturbation, perturb, poses
from ido.methods import BASELINES
from ido.recording import load_run
from ido_viz.core.background import Report
from ido_viz.core.frame import Frame, frame_of
from ido_viz.core.library import shipped_library
from ido_viz.core.pacing import Pacing
from ido_viz.core.run import Run, compute, make_scene, register_side, waiting_side
from ido_viz.core.state import State, decode
from ido_viz.files import animation_html as animation
from ido_viz.files import downloads
from ido_viz.files.animation_html import MOST_FRAMES, animation_html
from ido_viz.files.downloads import COLUMNS, EXPORTS, DownloadFolder, curves_csv, file_name, recorded, run_npz

PATIENCE = 30.0  # seconds; only a failing test waits that long
LIBRARY = shipped_library()
SMALL = Perturbation(points=120, outliers=40, rotation=40.0, seed=3)
STATES = {
    "learned": State(perturbation=SMALL, speed=20),
    "baseline": State(perturbation=SMALL, right="GMMReg, tuned", max_iterations=7, dark=True, ghost=False),
}


@pytest.fixture(scope="module", params=STATES)
def state(request: pytest.FixtureRequest) -> State:
    return STATES[request.param]


@pytest.fixture(scope="module")
def run(state: State) -> Run:
    return compute(state, LIBRARY)


def settings_of(state: State, method: str) -> Mapping[str, object]:
    entry = LIBRARY.entry(state.shape, method)
    return entry.make(state.epsilon, state.max_iterations, lambda _: None).settings


# The run


def test_the_downloaded_run_equals_the_run_shown(run: Run, state: State, tmp_path: Path):
    (tmp_path / "run.npz").write_bytes(run_npz(frame_of(run, state)))
    loaded = load_run(tmp_path / "run.npz")
    assert (loaded.shape, loaded.perturbation) == (state.shape, state.perturbation)
    assert decode(loaded.code) == state
    for name in ("points", "is_outlier", "T_model_scene"):
        np.testing.assert_array_equal(getattr(loaded.scene, name), getattr(run.scene, name))
    for number, (method, side) in enumerate(zip(loaded.methods, run.sides, strict=True)):
        assert method.name == side.method
        assert method.settings == settings_of(state, side.method)
        assert method.histogram == side.histogram.name
        assert method.blocks == tuple(block.sides for block in side.histogram.blocks)
        assert method.trajectory.stop is side.trajectory.stop
        np.testing.assert_equal(method.trajectory.last_norm, side.trajectory.last_norm)
        np.testing.assert_array_equal(method.trajectory.x, side.trajectory.x)
        np.testing.assert_array_equal(method.trajectory.update_norms, side.trajectory.update_norms)
        np.testing.assert_array_equal(method.T_model_scene, side.T_model_scene)
        for name in ("accuracy", "rmse", "rotation", "translation"):
            np.testing.assert_array_equal(getattr(method.scores, name), getattr(side.scores, name))
        np.testing.assert_array_equal(method.histogram_iterations, np.arange(side.trajectory.iterations + 1))
        for k, histogram in enumerate(method.histograms):
            np.testing.assert_array_equal(histogram, run.histogram(number, k))


def test_a_scene_that_was_moved_by_hand_is_made_again_of_what_is_recorded(tmp_path: Path):
    state = State(perturbation=SMALL, max_iterations=2, start=(0.1, -0.2, 0.3, 0.5, 0.0, -0.4))
    run = compute(state, LIBRARY)
    (tmp_path / "run.npz").write_bytes(run_npz(frame_of(run, state)))
    loaded = load_run(tmp_path / "run.npz")
    again = perturb(run.subject.cloud(), loaded.perturbation).moved(poses.exp(np.array(loaded.moved)))
    np.testing.assert_array_equal(again.points, loaded.scene.points)
    np.testing.assert_array_equal(again.T_model_scene, loaded.scene.T_model_scene)


def test_the_settings_of_every_baseline_can_be_recorded(run: Run):
    for name in BASELINES:
        state = replace(State(perturbation=SMALL), left=name, right=name)
        selection = LIBRARY.select(state)
        side = register_side(selection.entries[0], selection, state, run.scene)
        one = recorded(Run(run.subject, run.scene, (side, side)), state).methods[0]
        assert one.settings == settings_of(state, name)


def test_the_default_run_is_below_three_megabytes():
    assert len(run_npz(frame_of(compute(State(), LIBRARY), State()))) < 3e6


# The curves


def test_the_curves_are_those_of_the_scores(run: Run):
    rows = list(csv.DictReader(io.StringIO(curves_csv(run))))
    assert tuple(rows[0]) == COLUMNS
    for pane, side in zip(("left", "right"), run.sides, strict=True):
        own = [row for row in rows if row["pane"] == pane]
        assert {row["method"] for row in own} == {side.method}
        assert [int(row["iteration"]) for row in own] == list(range(side.trajectory.iterations + 1))
        scores = side.scores
        for name, values in {
            "PointAcc": scores.accuracy,
            "PointRMSE": scores.rmse,
            "rotation error (degrees)": scores.rotation,
            "translation error": scores.translation,
            "update norm": side.norms,
            "histogram distance": side.distances,
        }.items():
            np.testing.assert_array_equal([float(row[name] or "nan") for row in own], values)
    assert len(rows) == sum(side.trajectory.iterations + 1 for side in run.sides)


# The animation


@dataclass(frozen=True)
class Recording:
    """What an animation's page plays."""

    seconds: float
    messages: list[tuple[float, dict[str, Any]]]

    @classmethod
    def of(cls, page: str) -> Recording:
        embedded = re.search(r'__VISER_EMBED_DATA__="([^"]*)"', page)
        assert embedded
        packed = base64.b64decode(embedded[1])[8:]
        unpacked = zstandard.ZstdDecompressor().decompressobj().decompress(packed)
        length = int.from_bytes(unpacked[:8], "little")
        content = msgspec.msgpack.decode(unpacked[8 : 8 + length])
        return cls(content["durationSeconds"], content["messages"])

    def titles(self, pane: str) -> list[tuple[float, list[str]]]:
        """Lines of a pane's title, and when they appear."""
        return [
            (seconds, message["updates"]["text"].split("\n"))
            for seconds, message in self.messages
            if message.get("name") == f"/{pane}-title" and "updates" in message
        ]

    def last(self, name: str, key: str, seconds: float) -> Any:
        """What a node's pose or visibility is at a time."""
        start = {"wxyz": (1, 0, 0, 0), "position": (0, 0, 0), "visible": True}[key]
        return [start, *(m[key] for t, m in self.messages if m.get("name") == name and key in m and t <= seconds)][-1]


@pytest.fixture(scope="module")
def page(run: Run, state: State) -> str:
    return animation_html(frame_of(run, state)).decode()


def test_the_animation_shows_every_iteration_with_its_pose_and_its_scores(run: Run, state: State, page: str):
    recording = Recording.of(page)
    times = Pacing(run).times * 15 / state.speed
    assert recording.seconds == pytest.approx(3 + times[-1])
    apart = times[-1] / round(times[-1] / 0.05)
    for pane, side in zip(("left", "right"), run.sides, strict=True):
        titles = recording.titles(pane)
        n = side.trajectory.iterations
        assert list(dict.fromkeys(title[1] for _, title in titles)) == [f"iteration {k} of {n}" for k in range(n + 1)]
        for seconds, title in titles:
            k = int(title[1].split()[1])
            assert title[0] == side.method
            assert title[2] == f"PointRMSE {side.scores.rmse[k]:.3f}"
            assert title[3] == f"PointAcc {side.scores.accuracy[k]:.2f}"
            reached = 0.0 if seconds == 0 else np.interp(seconds - 1 + apart, times, np.arange(run.iterations + 1))
            assert k == min(int(reached + 1e-6), n)
            share = reached - k if k < n else 0.0
            start, end = (poses.exp(side.trajectory.x[each]) for each in (k, min(k + 1, n)))
            turn = Rotation.from_matrix(end[:3, :3] @ start[:3, :3].T).as_rotvec() * share
            wxyz = recording.last(f"/{pane}/scene", "wxyz", seconds)
            R = Rotation.from_rotvec(turn).as_matrix() @ start[:3, :3]
            np.testing.assert_allclose(Rotation.from_quat(wxyz, scalar_first=True).as_matrix(), R, atol=1e-6)
            t = start[:3, 3] + share * (end[:3, 3] - start[:3, 3])
            np.testing.assert_allclose(recording.last(f"/{pane}/scene", "position", seconds), t, atol=1e-6)
        assert recording.last(f"/{pane}/ghost", "visible", recording.seconds) == state.ghost


def test_the_animation_moves_smoothly_from_iteration_to_iteration(run: Run, page: str):
    """In no step farther than in the largest update, and in many more steps than there are updates."""
    for pane, side in zip(("left", "right"), run.sides, strict=True):
        places = [
            m["position"]
            for _, m in Recording.of(page).messages
            if m.get("name") == f"/{pane}/scene" and "position" in m
        ]
        steps = np.linalg.norm(np.diff(np.array(places), axis=0), axis=1)
        updates = np.linalg.norm(np.diff(side.T_model_scene[:, :3, 3], axis=0), axis=1)
        assert len(steps) > 1.5 * run.iterations
        assert steps.max() < updates.max()


def test_the_camera_is_recorded(page: str):
    kinds = {message["type"] for _, message in Recording.of(page).messages}
    assert {"SetCameraPositionMessage", "SetCameraLookAtMessage"} <= kinds


class References(HTMLParser):
    """Addresses that a page would load, and its text outside scripts."""

    def __init__(self, source: str) -> None:
        super().__init__()
        self.addresses: list[str] = []
        self.text = ""
        self._in_script = False
        self.feed(source)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self._in_script = tag == "script"
        self.addresses += [value or "" for name, value in attrs if name in ("src", "href", "srcset", "data")]

    def handle_data(self, data: str) -> None:
        if not self._in_script:
            self.text += data


def test_the_page_needs_nothing_from_outside(page: str, state: State):
    references = References(page)
    assert all(address.startswith("data:") for address in references.addresses)
    assert set(re.findall(r"https?://[\w.]+", page)) <= {"http://www.w3.org"}  # names the kind of its icon
    assert f"darkMode:{'true' if state.dark else 'false'}" in page
    assert f"{state.left} and {state.right} on bunny" in references.text
    assert "rotation 40°" in references.text


def test_names_are_shown_as_they_are(run: Run, state: State):
    evil = '"><script>alert(1)</script>'
    sides = (replace(run.sides[0], method=evil), run.sides[1])
    page = animation_html(frame_of(replace(run, sides=sides), state)).decode()
    assert evil not in page
    assert Recording.of(page).titles("left")[0][1][0] == evil


def test_a_long_run_is_shown_in_few_frames(run: Run, state: State, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(animation, "MOST_FRAMES", 6)
    titles = Recording.of(animation_html(frame_of(run, state)).decode()).titles("left")
    n = run.sides[0].trajectory.iterations
    assert 2 <= len({seconds for seconds, _ in titles}) <= 6
    assert titles[0][1][1] == f"iteration 0 of {n}"
    assert titles[-1][1][1] == f"iteration {n} of {n}"
    assert MOST_FRAMES >= 100


def test_making_an_animation_prints_nothing_and_leaves_no_server(
    run: Run, state: State, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
):
    stopped: list[viser.ViserServer] = []
    stop = viser.ViserServer.stop
    monkeypatch.setattr(viser.ViserServer, "stop", lambda server: (stopped.append(server), stop(server)))
    animation_html(frame_of(run, state))
    assert len(stopped) == 1
    assert capsys.readouterr() == ("", "")

    def fail(*_: object) -> None:
        raise RuntimeError("no canvas")

    monkeypatch.setattr(animation, "_draw", fail)
    with pytest.raises(RuntimeError, match="no canvas"):
        animation_html(frame_of(run, state))
    assert len(stopped) == 2
    assert capsys.readouterr() == ("", "")


# The buttons


@dataclass
class Button:
    """Stands for a button of the page."""

    label: str
    visible: bool = False
    clicked: Callable[[Any], None] = print

    def on_click(self, clicked: Callable[[Any], None]) -> None:
        self.clicked = clicked

    def click(self) -> None:
        self.clicked(SimpleNamespace(target=self))


class Page:
    """Stands for a client."""

    def __init__(self, shown: Callable[[], Frame | None]) -> None:
        self.shown = shown
        self.buttons: list[Button] = []
        self.files: dict[str, bytes] = {}
        self.notes: list[str] = []
        self.progress = SimpleNamespace(content="")
        self.gui = SimpleNamespace(
            add_folder=lambda *_, **__: contextlib.nullcontext(),
            add_button=lambda label, **_: self._add(label),
            add_html=lambda _: self.progress,
        )
        self.folder = DownloadFolder(cast(viser.ClientHandle, self), lambda: self.shown())
        self.cancel = self.buttons.pop()

    def _add(self, label: str) -> Button:
        self.buttons.append(Button(label))
        return self.buttons[-1]

    def send_file_download(self, name: str, content: bytes, **_: object) -> None:
        self.files[name] = content

    def add_notification(self, title: str, body: str, **_: object) -> None:
        self.notes.append(f"{title}: {body}")

    def press(self, number: int) -> None:
        """Press a button, and wait until nothing is made any more."""
        self.buttons[number].click()
        self.wait("the end", lambda: not self.progress.content)

    def wait(self, what: str, until: Callable[[], bool]) -> None:
        deadline = time.monotonic() + PATIENCE
        while not until():
            assert time.monotonic() < deadline, f"waited in vain for {what}: {self.progress.content}"
            time.sleep(0.005)


def test_each_button_sends_its_file(state: State):
    state = replace(state, max_iterations=7)
    run = compute(state, LIBRARY)
    page = Page(lambda: frame_of(run, state))
    for number in range(len(EXPORTS)):
        page.press(number)
    endings = [".npz", ".csv", ".html", ".gif", ".zip"]
    assert [button.label.split()[-1].strip("()") for button in page.buttons] == endings
    assert list(page.files) == [f"ido-bunny-3{ending}" for ending in endings]
    npz, curves, html, gif, charts = page.files.values()
    assert json.loads(str(np.load(io.BytesIO(npz))["header"]))["format"] == "ido-run-1"
    assert curves.decode() == curves_csv(run)
    assert Recording.of(html.decode()).seconds > 3
    assert getattr(Image.open(io.BytesIO(gif)), "n_frames", 1) > run.iterations
    assert {"curves.svg", "README.txt"} <= set(zipfile.ZipFile(io.BytesIO(charts)).namelist())
    assert page.notes == []
    assert not page.cancel.visible


def test_what_is_shown_at_the_click_is_sent(run: Run, state: State):
    page = Page(lambda: frame_of(run, state))
    page.shown = lambda: frame_of(run, replace(state, perturbation=replace(SMALL, seed=77)))
    page.press(1)
    assert list(page.files) == ["ido-bunny-77.csv"]


def test_what_is_not_there_yet_is_not_sent(run: Run, state: State):
    selection = LIBRARY.select(replace(state, right="CPD, default"))
    scene = make_scene(selection.subject, state)
    waiting = waiting_side(selection.entries[1], selection, scene, "computing, iteration 12")
    page = Page(lambda: None)
    page.press(0)
    page.shown = lambda: frame_of(replace(run, sides=(run.sides[0], waiting)), state)
    for button in page.buttons:
        button.click()
    assert page.files == {}
    assert page.notes[0].startswith("Nothing to download yet")
    assert page.notes[1:] == ["Nothing to download yet: CPD, default: computing, iteration 12"] * len(EXPORTS)


def test_a_failure_is_told_and_the_button_works_again(run: Run, state: State):
    spoilt = replace(run, scene=replace(run.scene, points=run.scene.points * np.nan))
    page = Page(lambda: frame_of(spoilt, state))
    page.press(0)
    assert page.files == {}
    assert page.notes == ["The file could not be made: RunError: its rmse holds numbers that are not finite"]
    page.shown = lambda: frame_of(run, state)
    page.press(0)
    assert list(page.files) == ["ido-bunny-3.npz"]


def test_files_are_made_one_after_the_other_one_for_a_page_and_can_be_cancelled(
    run: Run, state: State, monkeypatch: pytest.MonkeyPatch
):
    go, made, at_once = threading.Event(), [], []

    def make(frame: Frame, report: Report) -> bytes:
        at_once.append(frame)
        try:
            assert len(at_once) == 1
            while not go.wait(0.01):
                report("held")
        finally:
            at_once.pop()
        made.append(frame)
        return b"whole"

    export = replace(EXPORTS[0], make=make)
    monkeypatch.setattr(downloads, "EXPORTS", (export,))
    first, second, third = (Page(lambda: frame_of(run, state)) for _ in range(3))
    first.buttons[0].click()
    first.wait("its turn", lambda: "held" in first.progress.content)
    first.buttons[0].click()
    assert first.notes == ["One file at a time: Wait for the one that is made, or cancel it."]
    second.buttons[0].click()
    second.wait("the queue", lambda: "waiting, 1 before it" in second.progress.content)
    third.buttons[0].click()
    third.wait("the queue", lambda: "waiting, 2 before it" in third.progress.content)
    assert second.cancel.visible
    second.cancel.click()
    second.wait("the end", lambda: not second.progress.content)
    third.wait("a step forward", lambda: "waiting, 1 before it" in third.progress.content)
    first.folder.cancel()  # as when the page is closed
    first.wait("the end", lambda: not first.progress.content)
    go.set()
    third.wait("the file", lambda: bool(third.files) and not third.progress.content)
    assert (first.files, second.files, len(made)) == ({}, {}, 1)
    second.press(0)
    assert list(second.files.values()) == [b"whole"]


@pytest.mark.parametrize(
    ("shape", "name"),
    [("bunny", "ido-bunny-0.csv"), ("bunny (your own)", "ido-bunny-your-own-0.csv"), ("../a:b*", "ido-a-b-0.csv")],
)
def test_file_names_suit_every_system(shape: str, name: str):
    assert file_name(State(shape=shape), ".csv") == name
