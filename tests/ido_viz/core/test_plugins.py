"""Methods and features of the user's own in the explorer: shown like all others; when they break, the rest works."""

from __future__ import annotations

import sys
import threading
from collections.abc import Callable, Iterator
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest
import tyro
from tab import PATIENCE, PAUSED, Tab

from ido import (
    Block,
    Cloud,
    FrontBack,
    Histogram,
    Maps,
    Method,
    Model,
    OwnError,
    TrainingSettings,
    shipped_cloud,
    train,
)
from ido.blocks import FrontOrBack
from ido.types import FloatArray
from ido_viz.__main__ import main
from ido_viz.command import Options, start
from ido_viz.core import plugins
from ido_viz.core.background import CancelledError, Job, Shared
from ido_viz.core.comparison import Comparison
from ido_viz.core.failures import headline, traceback_of
from ido_viz.core.frame import frame_of
from ido_viz.core.inspection import inspect
from ido_viz.core.library import Library, shipped_library
from ido_viz.core.plugins import Own, OwnClass
from ido_viz.core.run import Run, compute, distances, warm_up
from ido_viz.core.state import State, StateError, encode
from ido_viz.core.verdict import Verdict
from ido_viz.panels.readout import readout_html

Methods = dict[str, OwnClass]
OpenOwn = Callable[[Methods], tuple[Library, Callable[[State], Tab]]]

GOAL = np.array([0.05, 0.1, -0.1, 0.2, 0.3, -0.1])


class Drift:
    """Goes half of what is left of the way to a place."""

    def __init__(self, cloud: Cloud) -> None:
        self.cloud = cloud

    def update(self, points: FloatArray, x: FloatArray, /) -> FloatArray:
        return 0.5 * (GOAL - x)


class AheadOrBehind(FrontOrBack):
    """The same question by other names, one of them hostile."""

    __slots__ = ()

    def __init__(self) -> None:
        Block.__init__(self, "<i>ahead</i>", "behind")


class Narrow(FrontBack):
    """A feature of one's own."""

    name = "narrow"
    blocks = (AheadOrBehind(),)

    def describe(self, moved: FloatArray) -> FloatArray:
        return super().describe(moved) ** 2

    def __call__(self, points: FloatArray, x: FloatArray) -> FloatArray:
        return Histogram.__call__(self, points, x)

    batch = Histogram.batch


@pytest.fixture(autouse=True)
def small_training(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(plugins, "QUICK", TrainingSettings(samples=30, maps=3))
    monkeypatch.setattr(plugins, "QUICK_POINTS", 40)


@pytest.fixture
def open_own(open_tab: Callable[..., Tab], monkeypatch: pytest.MonkeyPatch) -> OpenOwn:
    """A library with methods of one's own, and tabs of it."""

    def with_library(methods: Methods) -> tuple[Library, Callable[[State], Tab]]:
        library = shipped_library().with_methods(methods)
        monkeypatch.setattr("tab.shipped_library", lambda: library)

        def open_one(state: State) -> Tab:
            tab = open_tab(state, calm=False)
            tab.wait("a first frame", lambda: bool(tab.frames))
            return tab

        return library, open_one

    return with_library


def ready(tab: Tab, side: int = 0) -> None:
    tab.wait("the method", lambda: tab.shown.run.sides[side].waiting == "")


# Shown like all others


def test_an_own_method_is_shown_and_stepped(open_own: OpenOwn):
    _, open_one = open_own({"Drift": Drift})
    tab = open_one(replace(PAUSED, left="Drift", max_iterations=6))
    ready(tab)
    side = tab.shown.run.sides[0]
    x = np.zeros(6)
    for k in range(7):
        np.testing.assert_allclose(side.trajectory.x[k], x, atol=1e-12)
        x = x + 0.5 * (GOAL - x)
    assert side.maps is None
    assert side.settings["max_iterations"] == 6
    tab.actions.step(1)
    assert tab.settle().iteration == 1
    tab.set(rotation=50.0)
    tab.wait("another scene", lambda: tab.shown.state.perturbation.rotation == 50.0)
    ready(tab)


def test_own_methods_are_on_offer_for_every_shape_and_compared(open_own: OpenOwn):
    library, _ = open_own({"Drift": Drift, "narrow (30 scenes)": Narrow})
    for shape in library.subjects:
        methods = library.methods(shape)
        assert {"Drift", "narrow (30 scenes)"} < set(methods)
        assert methods.index("DO") < methods.index("Drift") < methods.index("Did nothing")
        assert not library.entry(shape, "Drift").quick
    ended = threading.Event()

    def look() -> None:
        if len(comparison.rows) == len(comparison.methods):
            ended.set()

    comparison = Comparison(library, look)
    comparison.begin(PAUSED)
    assert ended.wait(PATIENCE)
    rows = {row.method: row for row in comparison.rows}
    assert not rows["Drift"].failure and not rows["narrow (30 scenes)"].failure
    assert rows["Drift"].iterations == compute(replace(PAUSED, left="Drift"), library).sides[0].trajectory.iterations


@pytest.mark.parametrize("state", [PAUSED, replace(PAUSED, shape="urban", right="DO")])
def test_the_shares_of_an_own_feature_add_up_to_its_update(state: State):
    library = shipped_library().with_methods({"Mine": Narrow})
    run = compute(replace(state, left="Mine", inspected_pane="left"), library)
    side = run.sides[0]
    assert side.maps is not None and len(side.maps.maps) == 3
    assert len(side.histogram.model.points) == 40
    assert side.maps.settings.outlier_kind == library.subject(state.shape).outlier_kind
    for k in range(side.trajectory.iterations):
        inspection = inspect(run, state, k, 0)
        assert inspection is not None
        step = side.trajectory.x[k + 1] - side.trajectory.x[k]
        np.testing.assert_allclose(inspection.shares.update, step, atol=1e-6)
        np.testing.assert_allclose(inspection.shares.of_points.sum(axis=1), step, atol=1e-6)


def test_one_training_serves_all_tabs(open_own: OpenOwn, monkeypatch: pytest.MonkeyPatch):
    trainings: list[object] = []
    monkeypatch.setattr(plugins, "train", lambda *args, **more: (trainings.append(args), train(*args, **more))[1])
    _, open_one = open_own({"Mine": Narrow})
    tabs = [open_one(replace(PAUSED, left="Mine")) for _ in range(3)]
    for tab in tabs:
        ready(tab)
    assert len(trainings) == 1
    assert len({id(tab.shown.run.sides[0].maps) for tab in tabs}) == 1


def test_a_training_tells_how_far_it_is_and_goes_on_when_one_of_two_gives_up(open_own: OpenOwn):
    go = threading.Event()

    class Slow(Narrow):
        def describe(self, moved: FloatArray) -> FloatArray:
            if len(moved) != len(self.model.points):  # the reference is not waited for
                assert go.wait(PATIENCE)
            return super().describe(moved)

    _, open_one = open_own({"Mine": Slow})
    one, other = (open_one(replace(PAUSED, left="Mine")) for _ in range(2))
    for tab in (one, other):
        tab.wait("the training", lambda tab=tab: tab.shown.run.sides[0].waiting == "training, map 1 of 3")
    one.wait("the offer", lambda: one.may_cancel)
    one.actions.cancel()
    one.wait("the end of it", lambda: one.shown.run.sides[0].waiting == "cancelled")
    go.set()
    ready(other)


# Broken and hanging ones


class BrokenMaking(Drift):
    def __init__(self, cloud: Cloud) -> None:
        raise RuntimeError("no <b>luck</b>")


class BrokenUpdate(Drift):
    def update(self, points: FloatArray, x: FloatArray, /) -> FloatArray:
        return super().update(points, x) / np.zeros(5)


class NotFinite(Drift):
    def update(self, points: FloatArray, x: FloatArray, /) -> FloatArray:
        return np.log(-np.ones(6))


class Leaves(Drift):
    def update(self, points: FloatArray, x: FloatArray, /) -> FloatArray:
        sys.exit(3)


class BrokenDescribe(Narrow):
    def describe(self, moved: FloatArray) -> FloatArray:
        if len(moved) != len(self.model.points):
            raise KeyError("bins")
        return super().describe(moved)


class UntrainableNan(Narrow):
    def describe(self, moved: FloatArray) -> FloatArray:
        return super().describe(moved) * (np.nan if len(moved) != len(self.model.points) else 1.0)


class Shapeless(Narrow):
    def describe(self, moved: FloatArray) -> FloatArray:
        return np.ones(3)


def forgets_to_return(_: Cloud) -> None:
    pass


@pytest.mark.parametrize(
    ("broken", "told", "traced"),
    [
        (forgets_to_return, "OwnError: forgets_to_return returns nothing; it must return a method", "_made"),
        (BrokenMaking, "RuntimeError: no <b>luck</b>", "in __init__"),
        (BrokenUpdate, "ValueError: operands", "in update"),
        (NotFinite, "OwnError: Mine: update 1 is not finite", "nan"),
        (Leaves, "SystemExit: 3", "sys.exit(3)"),
        (BrokenDescribe, "KeyError: 'bins'", "in describe"),
        (UntrainableNan, "OwnError: UntrainableNan cannot be trained", "not finite, or too large"),
        (Shapeless, "OwnError: Shapeless: describe gives the shape (3,)", "80"),
    ],
)
@pytest.mark.filterwarnings("ignore::RuntimeWarning", "ignore:the training error did not fall:UserWarning")
def test_a_broken_one_shows_where_and_the_rest_works(open_own: OpenOwn, broken: OwnClass, told: str, traced: str):
    _, open_one = open_own({"Mine": broken})
    tab = open_one(replace(PAUSED, left="Mine"))
    for rotation in (10.0, 20.0):  # and again for another scene
        tab.set(rotation=rotation)
        tab.wait("the other scene", lambda rotation=rotation: tab.shown.state.perturbation.rotation == rotation)
        tab.wait("the failure", lambda: "failed" in tab.shown.run.sides[0].waiting)
        left, right = tab.shown.run.sides
        assert left.waiting.startswith(f"failed: {told}"[:47])
        assert left.trace.startswith("Traceback (most recent call last):")
        assert traced in left.trace
        assert left.trace.count("in _awaited") == 0 and left.trace.count("raise job.error") <= 1
        assert right.waiting == "" and right.trajectory.iterations > 0
    tab.set(left="DO")
    tab.wait("another method", lambda: tab.shown.run.sides[0].method == "DO")
    assert tab.shown.run.sides[0].trajectory.iterations > 0
    assert tab.notes == []


def test_a_hanging_one_can_be_left_and_keeps_one_thread_busy(open_own: OpenOwn):
    go, calls = threading.Event(), []

    class Hangs(Drift):
        def update(self, points: FloatArray, x: FloatArray, /) -> FloatArray:
            calls.append(x)
            assert go.wait(PATIENCE)
            return super().update(points, x)

    _, open_one = open_own({"Hangs": Hangs})
    tab = open_one(replace(PAUSED, left="Hangs"))
    for rotation in (11.0, 22.0, 33.0):
        tab.set(rotation=rotation)
        tab.wait("a frame", lambda rotation=rotation: tab.shown.state.perturbation.rotation == rotation)
        assert tab.shown.run.sides[1].trajectory.iterations > 0
    tab.wait("the offer to cancel", lambda: tab.may_cancel)
    tab.actions.cancel()
    tab.wait("the end", lambda: tab.shown.run.sides[0].waiting == "cancelled")
    other = open_one(PAUSED)
    other.set(rotation=44.0)
    other.wait("its frame", lambda: other.shown.state.perturbation.rotation == 44.0)
    assert len(calls) == 1
    go.set()
    tab.set(rotation=55.0)
    tab.wait("the next scene", lambda: tab.shown.state.perturbation.rotation == 55.0)
    ready(tab)


class Text(HTMLParser):
    def __init__(self, source: str) -> None:
        super().__init__()
        self.tags: set[str] = set()
        self.text = ""
        self.feed(source)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.add(tag)

    def handle_data(self, data: str) -> None:
        self.text += data


def test_a_traceback_is_shown_as_text():
    run = compute(PAUSED, shipped_library())
    evil = "</pre><script>alert(1)</script><img src=x onerror=alert(1)>"
    failed = replace(run.sides[1], pending=Verdict.FAILED, waiting=f"failed: {evil}", trace=evil, method=evil)
    shown = Text(readout_html(frame_of(Run(run.subject, run.scene, (run.sides[0], failed)), PAUSED)))
    assert shown.tags <= {"table", "tr", "td", "th", "div", "span", "b", "pre"}
    assert shown.text.count(evil) == 4  # the head of the column, the verdict, and the box with its title
    assert "pre" not in Text(readout_html(frame_of(run, PAUSED))).tags


def test_an_error_is_told_in_one_line_whatever_it_is():
    class UnspeakableError(Exception):
        def __str__(self) -> str:
            raise ValueError

    assert headline(ValueError("one\n  two")) == "ValueError: one two"
    assert headline(ValueError()) == "ValueError"
    assert headline(UnspeakableError()) == "UnspeakableError: (its message cannot be shown)"
    assert len(headline(ValueError("x" * 500))) < 60
    long = traceback_of(ValueError("a" * 100_000 + "end"))
    assert len(long) < 20_000 and long.rstrip().endswith("end")


def test_a_reference_of_zeros_leaves_the_distance_undivided():
    class Residual(Narrow):
        def describe(self, moved: FloatArray) -> FloatArray:
            away = float(len(moved) != len(self.model.points))
            return np.full(self.n_bins, away)

    run = compute(PAUSED, shipped_library())
    histogram = Residual(run.sides[0].histogram.model)
    assert distances(histogram, run.scene, run.sides[0].trajectory)[-1] == pytest.approx(np.sqrt(histogram.n_bins))


# Work that is shared


def test_shared_work_is_given_up_when_all_have_and_begun_anew():
    begun, go = [], threading.Event()

    def work(report: Callable[[int | str], None]) -> str:
        begun.append(len(begun))
        while not go.wait(0.01):
            report("under way")
        return f"work {begun[-1]}"

    shared = Shared(work)
    jobs = [Job(shared.get, lambda: None) for _ in range(2)]
    while any(job.progress != "under way" for job in jobs):
        pass
    jobs[0].cancel()
    assert jobs[0].wait(PATIENCE) and jobs[0].result is None
    assert not jobs[1].wait(0.3)
    jobs[1].cancel()
    assert jobs[1].wait(PATIENCE)
    threading.Event().wait(0.1)
    late = Job(shared.get, lambda: None)
    go.set()
    assert late.wait(PATIENCE) and late.result == "work 1"
    assert shared.get(lambda _: None) == "work 1"


def test_an_error_of_shared_work_is_kept_and_its_traceback_does_not_grow():
    def work(report: Callable[[int | str], None]) -> str:
        raise ValueError("once")

    shared, traces = Shared(work), []
    for _ in range(3):
        with pytest.raises(ValueError, match="once") as raised:
            shared.get(lambda _: None)
        traces.append(traceback_of(raised.value))
    assert traces[0].count("\n") == traces[2].count("\n")


def test_a_watch_that_raises_ends_the_waiting():
    def stop(_: int | str) -> None:
        raise CancelledError

    def slow(_: Callable[[int | str], None]) -> Drift:
        threading.Event().wait(0.5)
        return Drift(shipped_cloud("bunny"))

    own = Own(slow)
    histogram = shipped_library().subject("bunny").first_histogram
    with pytest.raises(CancelledError):
        own.method("Drift", histogram, 1e-3, 10, stop)
    assert own.method("Drift", histogram, 1e-3, 10, lambda _: None).name == "Drift"


# From the command line


def made(library: Library, state: State) -> Method:
    """The method of the left pane."""
    return library.select(state).entries[0].make(state.epsilon, state.max_iterations, lambda _: None)


MODULE = """
import numpy as np, ido

class Still:
    name = "Stands <still>"
    def __init__(self, cloud): ...
    def update(self, points, x): return np.zeros(6)

class DO(Still):
    name = "DO"

class Shells(ido.Histogram):
    name = "shells"
    blocks = (ido.Block("near", "far"),)
    def describe(self, moved):
        away = np.linalg.norm(moved[None] - self.model.points[:, None], axis=2)
        return np.concatenate([(away < 0.2).mean(axis=1), ((away >= 0.2) & (away < 0.4)).mean(axis=1)])
"""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """Where a person works, with two modules."""
    (tmp_path / "own_module.py").write_text(MODULE, encoding="utf-8")
    (tmp_path / "broken_module.py").write_text("def broken(:\n", encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", list(sys.path))
    yield tmp_path
    sys.modules.pop("own_module", None)


def started(*args: str) -> tuple[Library, State]:
    return start(tyro.cli(Options, args=args))


def test_the_first_own_method_is_shown_on_the_left(folder: Path):
    library, state = started("--method", "own_module:Still", "own_module:DO", "--histogram", "own_module:Shells")
    assert (state.left, state.right) == ("Stands <still>", "Improved DO")
    own = ("Stands <still>", "own_module:DO", "shells (30 scenes)")  # the name DO is taken
    assert set(own) < set(library.methods("bunny")) & set(library.methods("urban"))
    assert started("--shape", "urban", "--histogram", "own_module:Shells")[1].left == "shells (30 scenes)"
    for other in (("--lesson", "histogram"), ("--state", encode(PAUSED))):  # these say what is shown
        assert started("--method", "own_module:Still", *other)[1].left == "DO"


def test_what_cannot_be_imported_is_listed_by_its_text_and_shows_where(folder: Path, open_own: OpenOwn):
    texts = ["broken_module:Mine", "nowhere_module:Mine", "own_module:Other", "own_module:Shells"]
    library, state = started("--method", *texts, "--histogram", "own_module:Still")
    assert state.left == texts[0]
    assert {*texts, "own_module:Still"} < set(library.methods("urban"))
    expected = {
        "broken_module:Mine": "SyntaxError",
        "nowhere_module:Mine": "there is no module nowhere_module",
        "own_module:Other": "has no Other",
        "own_module:Shells": "give it with --histogram",
        "own_module:Still": "no subclass of ido.Histogram",
    }
    for text, message in expected.items():
        for _ in range(2):
            with pytest.raises((OwnError, SyntaxError)) as raised:
                made(library, replace(state, left=text))
            assert message in traceback_of(raised.value)


@pytest.mark.parametrize("flag", ["--method", "--histogram"])
def test_an_argument_without_a_colon_is_an_error_of_usage(
    folder: Path, flag: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    monkeypatch.setattr(sys, "argv", ["ido-viz", "--no-open", flag, "own_module"])
    assert main() == 2
    said = capsys.readouterr()
    assert said.err.count("\n") == 1 and "module:Class" in said.err
    assert "Traceback" not in said.err


def test_maps_of_an_own_feature_are_taken_from_a_file(folder: Path, bunny: Cloud):
    np.savez(folder / "cloud.npz", points=bunny.points[::20])
    cloud = Cloud.of(bunny.points[::20].astype(np.float64))
    sys.path.insert(0, str(folder))
    from own_module import Shells  # type: ignore[import-not-found]

    maps = train(cloud, Shells(Model.of(cloud, 50)), TrainingSettings(samples=20, maps=2))
    maps.save(folder / "mine.npz")
    options = ("--cloud", "cloud.npz", "--histogram", "own_module:Shells")
    library, state = started(*options, "--maps", "mine.npz")
    assert (state.shape, state.left) == ("cloud", "mine")
    assert "shells (30 scenes)" not in library.methods("cloud")
    assert "shells (30 scenes)" in library.methods("bunny")
    side = compute(state, library).sides[0]
    assert isinstance(side.maps, Maps)
    np.testing.assert_array_equal(side.maps.maps, maps.maps)
    library, state = started(*options)  # without maps it is trained when it is shown
    assert (state.shape, state.left) == ("cloud", "shells (30 scenes)")
    assert compute(state, library).sides[0].maps is not None
    broken = ("--cloud", "cloud.npz", "--maps", "mine.npz", "--histogram", "broken_module:Shells")
    library, state = started(*broken)  # it may be what the file means, so it shows where
    with pytest.raises(SyntaxError):
        made(library, replace(state, left="mine"))
    library, state = started("--cloud", "cloud.npz")  # to be trained on in the page
    assert state == State() and "cloud" not in library.subjects
    with pytest.raises(StateError, match="give --maps with the --cloud"):
        started("--maps", "mine.npz", "--histogram", "own_module:Shells")


def test_nothing_of_the_users_own_runs_before_it_is_shown():
    class Never(Drift):
        def __init__(self, cloud: Cloud) -> None:
            raise AssertionError

    library = shipped_library().with_methods({"Never": Never})
    warm_up(replace(PAUSED, left="Never"), library)
    assert library.checked(replace(PAUSED, left="Never")).left == "Never"
    with pytest.raises(StateError, match="already"):
        library.with_methods({"Never": Never})
    with pytest.raises(StateError, match="already"):
        library.with_methods({"DO": Drift})
