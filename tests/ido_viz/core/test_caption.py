"""What is written of both sides: one value, which the page and the pictures draw."""

from __future__ import annotations

import html
from dataclasses import replace

import pytest

from ido import Perturbation
from ido.scores import score
from ido_viz.core.frame import frame_of
from ido_viz.core.library import shipped_library
from ido_viz.core.run import Run, compute
from ido_viz.core.state import LAST, State
from ido_viz.panels.captions import captions_html
from ido_viz.panels.readout import readout_html

STATE = State(perturbation=Perturbation(points=200, outliers=50), playing=False, iteration=2)


@pytest.fixture(scope="module")
def run() -> Run:
    return compute(STATE, shipped_library())


def test_it_says_how_far_each_method_is_and_how_near(run: Run):
    for side in frame_of(run, STATE).sides:
        its = score(run.scene, side.T_model_scene)
        assert side.caption.method == side.run.method
        assert side.caption.progress == f"iteration 2 of {side.run.trajectory.iterations}"
        assert side.caption.scores == (f"PointRMSE {float(its.rmse):.3f}", f"PointAcc {float(its.accuracy):.2f}")
        assert side.caption.overlay == ""


def test_why_it_stopped_is_told_at_its_end_alone(run: Run):
    assert {side.caption.stop for side in frame_of(run, STATE).sides} == {"not yet"}
    for side in frame_of(run, replace(STATE, iteration=LAST)).sides:
        assert side.caption.stop == str(side.run.trajectory.stop)


def test_scores_that_are_hidden_are_not_in_it(run: Run):
    assert {side.caption.scores for side in frame_of(run, replace(STATE, hidden=("scores",))).sides} == {()}


def test_page_and_readout_write_what_it_says(run: Run):
    frame = frame_of(run, replace(STATE, overlay="other method"))
    page, readout = captions_html(frame), readout_html(frame)
    for side in frame.sides:
        assert side.overlay is not None and side.caption.overlay == f"with {side.overlay.title}"
        written = f"{side.caption.progress.removeprefix('iteration ')}, {side.caption.overlay}"
        assert html.escape(side.caption.method) in page and html.escape(written) in page
        assert f">{side.caption.stop}<" in readout
