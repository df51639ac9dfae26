"""The slow motion of one iteration: what its beats show is what the iteration does."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from ido import Perturbation
from ido_viz.core import palette
from ido_viz.core.address import shared
from ido_viz.core.frame import Frame, frame_of
from ido_viz.core.inside import STEP, inside_of, strongest_point
from ido_viz.core.library import shipped_library
from ido_viz.core.run import Run, compute
from ido_viz.core.state import BEATS, State, StateError, decode, encode
from ido_viz.panels.inside_panel import inside_html

STATE = State(
    perturbation=Perturbation(points=200, outliers=50), max_iterations=12, playing=False, iteration=2, inspected=7
)


@pytest.fixture(scope="module")
def run() -> Run:
    return compute(STATE, shipped_library())


def at(run: Run, position: float, **changes: object) -> Frame:
    frame = frame_of(run, replace(STATE, inside=position, **changes))
    assert frame.inside is not None
    return frame


def test_there_is_none_unless_it_is_asked_for(run: Run):
    assert frame_of(run, STATE).inside is None


def test_a_baseline_has_none():
    state = replace(STATE, right="Did nothing", inspected_pane="right", inside=1.0)
    assert frame_of(compute(state, shipped_library()), state).inside is None


@pytest.mark.parametrize("pane", ["left", "right"])
def test_its_end_is_the_next_iteration(run: Run, pane: str):
    frame = at(run, float(BEATS), inspected_pane=pane)
    number = ("left", "right").index(pane)
    side, other = frame.sides[number], frame.sides[1 - number]
    np.testing.assert_allclose(side.T_model_scene, side.run.T_model_scene[3], atol=1e-12)
    np.testing.assert_array_equal(other.T_model_scene, other.run.T_model_scene[2])


def test_the_points_that_were_asked_fill_the_two_bins(run: Run):
    """In front / back, a bin is what its points count together, divided by what all of them count in all bins."""
    inside = at(run, 2.0, question="front / back").inside
    assert inside is not None
    first, counts = inside.asked
    filled = np.array([counts[first].sum(), counts[~first].sum()])
    seen = inside.inspection.seen[list(inside.bins)]
    np.testing.assert_allclose(filled / filled.sum(), seen / seen.sum(), rtol=1e-5)


def test_points_are_asked_one_after_another_the_nearest_first(run: Run):
    asked = []
    for position in (0.1, 0.3, 0.6, 1.0):
        inside = at(run, position).inside
        assert inside is not None
        away = np.linalg.norm(
            inside.inspection.moved - inside.inspection.side.histogram.model.points[inside.point], axis=1
        )
        counted = inside.asked[1] > 0
        asked.append(counted)
        if counted.any() and not counted.all():
            everybody = at(run, 2.0).inside
            assert everybody is not None
            would_count = everybody.asked[1] > 0
            assert away[counted].max() <= away[would_count & ~counted].min(initial=np.inf)
    for earlier, later in pairwise(asked):
        assert (earlier <= later).all()


def test_the_arrow_and_the_arc_are_the_step(run: Run):
    inside = at(run, 4.5).inside
    assert inside is not None
    arrow, arc = inside.motion
    middle = inside.inspection.moved[~run.scene.is_outlier].mean(axis=0)
    step = inside.T_next @ np.linalg.inv(inside.T_now)
    np.testing.assert_allclose(arrow[0], [middle, step[:3, :3] @ middle + step[:3, 3]], atol=1e-9)
    spokes = arc[-3:-1, 0] - middle, arc[-3:-1, 1] - middle
    start, end = spokes[1][0], spokes[0][1]
    np.testing.assert_allclose(step[:3, :3] @ start, end, atol=1e-9)


def test_without_a_picked_point_the_strongest_one_is_shown(run: Run):
    frame = at(run, 0.5, inspected=-1)
    inspection = frame.inspected.inspection
    assert frame.inside is not None and inspection is not None
    shares = np.abs(inspection.of_points)
    assert shares[frame.inside.point] == shares.max()
    assert strongest_point(inspection) == frame.inside.point


def test_before_the_start_there_is_nothing(run: Run):
    side = frame_of(run, STATE).inspected
    assert inside_of(side.run, side.k, side.inspection, 0.0) is None


@pytest.mark.parametrize("position", [0.5, 1.5, 2.5, 3.5, 4.5, 5.0])
@pytest.mark.parametrize("dark", [False, True])
def test_every_beat_has_a_sentence_and_a_picture_of_finite_numbers(run: Run, position: float, dark: bool):
    inside = at(run, position).inside
    assert inside is not None
    content = inside_html(inside, dark)
    assert f"beat {inside.beat} of {BEATS}" in content
    assert f"<b>{inside.inspection.side.method}:</b>" in content
    assert "nan" not in content and "inf" not in content
    assert len(content) < 30_000


@pytest.mark.parametrize(
    ("right", "question", "said"),
    [
        ("Improved DO", "front / back", "The nearer a point is, the more it counts"),
        ("Improved DO", "up / down", "Every point counts the same, near or far."),
        ("Improved DO", "clockwise / anticlockwise", "Every point counts the same, near or far."),
        ("Improved DO (near / far)", "near / far", "The nearer a point is, the more it counts"),
    ],
)
def test_the_first_beat_says_how_the_points_of_each_question_count(right: str, question: str, said: str):
    state = replace(STATE, right=right, inspected_pane="right", question=question)
    inside = at(compute(state, shipped_library()), 0.5, right=right, question=question, inspected_pane="right").inside
    assert inside is not None and f"{inside.question.first} / {inside.question.second}" == question
    assert said in inside_html(inside, False)


def test_of_points_that_count_by_no_rule_of_distance_none_is_told(run: Run, monkeypatch: pytest.MonkeyPatch):
    inside = at(run, 0.5, question="up / down").inside
    assert inside is not None

    def by_number(_: object, points: np.ndarray, moved: np.ndarray) -> np.ndarray:
        return np.tile(np.arange(len(moved)) % 3 / 2, (len(points), 1))

    monkeypatch.setattr(type(inside.question), "weights", by_number)
    content = inside_html(inside, False)
    assert "The more a point counts, the stronger its colour." in content
    assert "near" not in content


def test_all_bins_have_the_colours_of_their_blocks(run: Run):
    inside = at(run, 2.99).inside
    assert inside is not None
    content = inside_html(inside, False)
    blocks = inside.inspection.side.histogram.blocks
    assert len(blocks) == 3
    for number, block in enumerate(blocks):
        assert f'stroke="{palette.css(palette.block_color(block, number))}" stroke-width="3"' in content


def test_the_six_bars_add_up_to_the_update(run: Run):
    inside = at(run, 4.0).inside
    assert inside is not None
    side, shares = inside.inspection.side, inside.inspection.shares
    np.testing.assert_allclose(shares.of_blocks.sum(axis=1), shares.update, atol=1e-12)
    np.testing.assert_allclose(side.trajectory.x[3] - side.trajectory.x[2], shares.update, atol=1e-5)


def test_a_beat_can_be_linked_to():
    state = replace(STATE, inside=3.25)
    assert decode(encode(state)) == state
    assert shared(replace(state, playing=True)).inside == STEP
    for wrong in (-0.1, 5.1, float("nan")):
        with pytest.raises(StateError):
            replace(state, inside=wrong)
