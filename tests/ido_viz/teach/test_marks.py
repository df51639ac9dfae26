"""What a step points at lies where the arrow ends, and is called what it is."""

from __future__ import annotations

import numpy as np
import pytest
from checks.helpers import page_of, run_of

from ido.blocks import azimuth, elevation
from ido.poses import transform
from ido_viz.core.frame import Frame, frame_of
from ido_viz.core.geometry import upright
from ido_viz.core.state import NO_POINT, State, with_values
from ido_viz.teach.marks import Pointer, pointers

PAIR = page_of("histogram/in-front")
BALL = page_of("failure/do-in-place", playing=False, iteration=4)


def frame(state: State) -> Frame:
    return frame_of(run_of(state), state)


def missed(pointer: Pointer, point: np.ndarray) -> float:
    """How far the straight line along an arrow passes by a point."""
    along = pointer.path[-1] - pointer.path[0]
    along /= np.linalg.norm(along)
    offset = point - pointer.path[-1]
    return float(np.linalg.norm(offset - (offset @ along) * along))


def test_the_picked_pair_is_named_with_its_answer_and_weight():
    shown = frame(PAIR)
    model, scene, answer = pointers(shown, ("model point", "scene point", "answer"))
    assert (model.pane, scene.pane, answer.pane) == (0, 0, 0)
    assert (model.label, scene.label) == ("model point", "scene point")
    assert answer.label == "scene point\nfront, weight 0.59"
    assert model.color != scene.color
    assert np.array_equal(answer.path, scene.path)
    assert missed(model, shown.run.sides[0].histogram.model.points[PAIR.inspected]) < 1e-6
    assert scene.tip == pytest.approx(shown.run.scene.points[PAIR.scene_point], abs=1e-6)
    assert missed(scene, shown.run.scene.points[PAIR.scene_point]) < 1e-6
    words = np.linalg.norm(model.path[0] - scene.path[0])
    assert words > 0.5, "the two words stand apart"


def test_arrows_follow_the_scene_in_both_panes():
    shown = frame(BALL)
    found = pointers(shown, ("outliers",))
    assert [each.pane for each in found] == [0, 1]
    scene = shown.run.scene
    for each, side in zip(found, shown.sides, strict=True):
        moved = transform(side.T_model_scene, scene.points[scene.is_outlier].astype(np.float64))
        assert missed(each, moved.mean(axis=0)) < 1e-6
        assert each.label == "outliers"
    (one, _) = pointers(frame(page_of("outliers/unseen-by-do")), ("outliers",))
    assert one.label == "outlier"


def test_the_axis_and_the_way_round_are_those_of_the_questions():
    axis, bent = pointers(frame(page_of("binaries/less-than-half-clockwise")), ("up", "round"))
    assert elevation(axis.path[1:])[0] == pytest.approx(np.pi / 2)
    assert np.all(np.diff(azimuth(bent.path)) > 0)


def test_a_word_at_the_top_stands_below_what_it_names():
    (ears,) = pointers(frame(page_of("histogram/nothing-from-the-ears")), ("scene point",))
    (tail,) = pointers(frame(PAIR), ("scene point",))
    turn = upright(frame(PAIR).run.subject.up)
    assert turn.apply(ears.path[0])[2] < turn.apply(ears.tip)[2]
    assert turn.apply(tail.path[0])[2] > turn.apply(tail.tip)[2]


@pytest.mark.parametrize("step", ["in-front", "behind", "nothing-from-the-ears"])
def test_a_word_stays_in_its_pane(step: str):
    shown = frame(page_of(f"histogram/{step}"))
    turn = upright(shown.run.subject.up)
    for each in pointers(shown, ("model point", "scene point")):
        assert abs(turn.apply(each.path[0])[0]) < 0.8


def test_what_is_not_there_is_not_pointed_at():
    nothing = with_values(PAIR, {"inspected": NO_POINT, "scene_point": NO_POINT})
    assert pointers(frame(nothing), ("model point", "scene point", "outliers")) == ()
