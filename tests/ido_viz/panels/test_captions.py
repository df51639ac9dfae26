"""What is written over the canvas: names, verdicts with their reasons, and the meaning of the colours."""

from __future__ import annotations

import html
import re
from dataclasses import replace

import numpy as np
import pytest

from ido import StopReason
from ido_viz.core import palette
from ido_viz.core.frame import Frame, frame_of
from ido_viz.core.legend import legend_html
from ido_viz.core.library import shipped_library
from ido_viz.core.run import Run, compute
from ido_viz.core.state import LAST, State
from ido_viz.core.verdict import Verdict
from ido_viz.panels.captions import captions_html

AT_THE_END = State(playing=False, iteration=LAST, max_iterations=12)


@pytest.fixture(scope="module")
def run() -> Run:
    return compute(AT_THE_END, shipped_library())


def ending_with(run: Run, accuracy: float) -> Run:
    """A run whose both sides end with a PointAcc."""
    left, right = (
        replace(side, scores=replace(side.scores, accuracy=np.append(side.scores.accuracy[:-1], accuracy)))
        for side in run.sides
    )
    return replace(run, sides=(left, right))


def texts(frame: Frame, kind: str) -> list[str]:
    """What is written in each pane, as text: its names or its verdicts; or over both, as the legend."""
    whole = kind in ("legend", "opening")
    for part in captions_html(frame).split('<div class="over-canvas ')[1:]:
        name, _, content = part.partition('">')
        if name == kind:
            panes = content.split("</div>")
            return [html.unescape(re.sub(r"<[^>]*>", " ", pane)).strip() for pane in panes if "<b" in pane or whole]
    return []


@pytest.mark.parametrize("name", ["<img src=x onerror=alert(1)>", '"><script>alert(1)</script>', "<b>bold</b> & co"])
def test_a_name_is_shown_as_it_is(run: Run, name: str):
    sides = (replace(run.sides[0], method=name), run.sides[1])
    state = replace(AT_THE_END, overlay="other method")
    frame = frame_of(replace(run, sides=sides), state)
    assert name not in captions_html(frame)
    left, right = texts(frame, "names")
    assert left.startswith(name)
    assert right.endswith(f"12 of 12, with {name}")


def test_a_long_name_stays_short(run: Run):
    sides = (replace(run.sides[0], method="W" * 300), run.sides[1])
    assert captions_html(frame_of(replace(run, sides=sides), AT_THE_END)).count("W") < 60


def test_each_pane_tells_its_method_and_iteration(run: Run):
    left, right = texts(frame_of(run, replace(AT_THE_END, iteration=5)), "names")
    assert " ".join(left.split()) == "DO iteration 5 of 12"
    assert " ".join(right.split()) == "Improved DO iteration 5 of 12"


@pytest.mark.parametrize(
    ("accuracy", "words"),
    [
        (1.0, "✓ in place"),
        (0.95, "✓ in place"),
        (0.9499, "≈ nearly in place"),
        (0.5, "≈ nearly in place"),
        (0.4999, "✗ wrong pose"),
        (0.0, "✗ wrong pose"),
    ],
)
def test_the_verdict_is_told_with_its_reason(run: Run, accuracy: float, words: str):
    ended = ending_with(run, accuracy)
    for text, side in zip(texts(frame_of(ended, AT_THE_END), "verdicts"), ended.sides, strict=True):
        assert text.startswith(words)
        assert f"{round(100 * accuracy)}% arrived" in text
        assert text.endswith("iteration limit")
        away = f"{side.scores.rotation[-1]:.0f}° off"
        assert (away in text) == (accuracy < 0.95)


@pytest.mark.parametrize(("iteration", "words"), [(0, "→ at its start"), (3, "→ moving")])
def test_on_the_way_nothing_is_said_of_the_place(run: Run, iteration: int, words: str):
    frame = frame_of(ending_with(run, 0.0), replace(AT_THE_END, iteration=iteration))
    for text, side in zip(texts(frame, "verdicts"), run.sides, strict=True):
        assert text.startswith(words)
        assert text.endswith(f"{round(100 * side.scores.accuracy[iteration])}% arrived")


def test_a_held_scene_shows_how_it_will_end(run: Run):
    state = replace(AT_THE_END, iteration=0, playing=True)
    for text in texts(frame_of(ending_with(run, 1.0), state, held=True), "verdicts"):
        assert text.startswith("✓ will end in place")
        assert "100% arrived" in text
    for text in texts(frame_of(ending_with(run, 0.2), state, held=True), "verdicts"):
        assert text.startswith("✗ will end in a wrong pose")
        assert "20% arrived" in text and "° off" in text


@pytest.mark.parametrize("held", [False, True])
@pytest.mark.parametrize(
    ("pending", "waiting", "sign"),
    [
        (Verdict.COMPUTING, "computing, iteration 7", "…"),
        (Verdict.CANCELLED, "cancelled", "–"),
        (Verdict.FAILED, "failed: ValueError: <b>", "✗"),
    ],
)
def test_what_is_not_there_yet_says_why(run: Run, pending: Verdict, waiting: str, sign: str, held: bool):
    sides = (replace(run.sides[0], pending=pending, waiting=waiting), run.sides[1])
    frame = frame_of(replace(run, sides=sides), AT_THE_END, held=held)
    text = texts(frame, "verdicts")[0]
    assert text.startswith(f"{sign} {pending}")
    assert text.endswith(waiting)
    assert "arrived" not in text and "will end" not in text


@pytest.mark.parametrize("iteration", [0, 4, LAST])
@pytest.mark.parametrize("held", [False, True])
def test_nothing_is_told_of_scores_that_are_hidden(run: Run, iteration: int, held: bool):
    frame = frame_of(run, replace(AT_THE_END, iteration=iteration, hidden=("scores",)), held=held)
    assert texts(frame, "verdicts") == []
    written = re.sub(r"<[^>]*>", " ", captions_html(frame))
    for word in ("arrived", "place ", "pose", "moving", "start", "%", StopReason.MAX_ITERATIONS):
        assert word not in written
    assert len(texts(frame, "names")) == 2


def test_the_legend_names_what_is_seen(run: Run):
    full = re.sub(r"<[^>]*>", "", legend_html(frame_of(run, AT_THE_END)))
    for word in ("model", "scene", "arrived", "outliers", "its way", "where it belongs"):
        assert word in full
    bare = replace(AT_THE_END, ghost=False, hidden=("scores",))
    less = re.sub(r"<[^>]*>", "", legend_html(frame_of(run, bare)))
    assert "arrived" not in less and "where it belongs" not in less


def test_the_legend_names_the_colours_of_what_is_looked_into(run: Run):
    state = replace(AT_THE_END, iteration=3, inspected=5, inspected_pane="right")
    for question in run.sides[1].histogram.questions:
        written = legend_html(frame_of(run, replace(state, question=question.name)))
        for side, color in zip(
            question.sides,
            (palette.block_color(question, run.sides[1].histogram.blocks.index(question)), palette.ink(False)),
            strict=True,
        ):
            assert f'<span style="color:{palette.css(color)}">●</span> {side}' in written
        assert "for model point 5" in written
    nothing = legend_html(frame_of(run, AT_THE_END))
    for coloring, less, more in (("towards the truth", "astray", "right way"), ("φx", "takes away", "adds")):
        written = legend_html(frame_of(run, replace(AT_THE_END, coloring=coloring)))
        assert less in written and more in written and less not in nothing


def test_what_is_about_to_happen_is_said_before_it_begins_and_not_after(run: Run):
    start = frame_of(run, replace(AT_THE_END, iteration=0))
    assert "moves the coloured scene, step by step, onto the grey model" in texts(start, "opening")[0]
    assert texts(frame_of(run, replace(AT_THE_END, iteration=1)), "opening") == []
    assert texts(frame_of(run, AT_THE_END), "opening") == []
    assert texts(replace(start, held=True), "opening") == []
    assert texts(frame_of(run, replace(AT_THE_END, iteration=0, inside=0.5)), "opening") == []


def test_the_legend_names_error_vectors_where_they_are_drawn(run: Run):
    for shown in (True, False):
        state = replace(AT_THE_END, error_vectors=shown)
        assert ("to its place" in legend_html(frame_of(run, state))) == shown
