"""How sure a method from any start is, as it is written beside its verdict."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from ido.global_registration import Confidence
from ido_viz.core.frame import Frame, frame_of
from ido_viz.core.library import shipped_library
from ido_viz.core.run import Run, compute
from ido_viz.core.state import LAST, State
from ido_viz.panels.captions import captions_html
from ido_viz.panels.sureness import percent, sureness_html

AT_THE_END = State(playing=False, iteration=LAST, max_iterations=12)


@pytest.fixture(scope="module")
def run() -> Run:
    return compute(AT_THE_END, shipped_library())


def sure_of(probability: float, *reasons: str) -> Confidence:
    """A confidence of which nothing but this is asked."""
    return cast(Confidence, SimpleNamespace(probability=probability, reasons=reasons))


def shown(run: Run, confidence: Confidence | None, state: State = AT_THE_END, **rest: Any) -> Frame:
    left, right = run.sides
    return frame_of(replace(run, sides=(left, replace(right, confidence=confidence))), state, **rest)


def test_the_probability_is_told_with_its_reasons_and_of_its_pane_alone(run: Run):
    frame = shown(run, sure_of(0.34, "symmetric: 3 poses fit equally", "it fits only weakly"))
    text = sureness_html(frame.sides[1], frame)
    assert "34% sure" in text
    assert "symmetric: 3 poses fit equally; it fits only weakly" in text
    assert sureness_html(frame.sides[0], frame) == ""
    assert text in captions_html(frame)


@pytest.mark.parametrize(("probability", "said"), [(0.0001, "1%"), (0.966, "97%"), (0.9999, "99%")])
def test_nothing_is_quite_certain(probability: float, said: str):
    assert percent(probability) == said


def test_surer_and_less_sure_have_other_colours(run: Run):
    texts = {sureness_html((f := shown(run, sure_of(p))).sides[1], f).split(">")[0] for p in (0.2, 0.8, 0.98)}
    assert len(texts) == 3


def test_nothing_is_told_on_the_way_or_where_scores_are_hidden(run: Run):
    for state in (replace(AT_THE_END, iteration=3), replace(AT_THE_END, hidden=("scores",))):
        frame = shown(run, sure_of(0.5), state)
        assert "sure<" not in captions_html(frame)
    held = shown(run, sure_of(0.5), replace(AT_THE_END, iteration=0), held=True)
    assert "50% sure" in captions_html(held)


def test_reasons_are_shown_as_they_are(run: Run):
    assert "<img" not in captions_html(shown(run, sure_of(0.1, "<img src=x onerror=alert(1)>")))


@pytest.mark.parametrize(
    ("probability", "accuracy", "differs"), [(0.9, 1.0, False), (0.9, 0.2, True), (0.1, 1.0, True), (0.1, 0.2, False)]
)
def test_where_the_verdict_says_otherwise_it_is_said_why(run: Run, probability: float, accuracy: float, differs: bool):
    left, right = run.sides
    scores = replace(right.scores, accuracy=np.append(right.scores.accuracy[:-1], accuracy))
    frame = shown(replace(run, sides=(left, replace(right, scores=scores))), sure_of(probability, "a reason"))
    text = sureness_html(frame.sides[1], frame)
    assert "a reason" in text
    assert ("the verdict knows the true place" in text) == differs
