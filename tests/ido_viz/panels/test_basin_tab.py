"""The maps of the tab Basin: where their dots are, and what they tell."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import cast

import numpy as np
import pytest

from ido_viz.core import palette
from ido_viz.core.basin import ANGLES, AXES, STARTS, Basin, start_of
from ido_viz.core.frame import Frame, frame_of
from ido_viz.core.library import shipped_library
from ido_viz.core.run import compute
from ido_viz.core.state import State
from ido_viz.core.verdict import Verdict
from ido_viz.panels.basin_tab import basin_html, places, verdicts

STATE = State(playing=False, max_iterations=3)
UP = shipped_library().subject("bunny").up


class Known:
    """A basin of which this is known."""

    running, begun = False, True

    def __init__(self, accuracies: np.ndarray, *, fits: bool = True, failure: str = "") -> None:
        self._accuracies, self._fits, self._failure = accuracies, fits, failure

    def fits(self, state: State) -> bool:
        return self._fits

    def accuracies(self, method: str) -> np.ndarray:
        return self._accuracies

    def failure(self, method: str) -> str:
        return self._failure


def drawn(known: Known, state: State = STATE) -> str:
    return basin_html(frame(state), cast(Basin, known))


def frame(state: State) -> Frame:
    return frame_of(compute(state, shipped_library()), state)


def test_equal_areas_of_the_sphere_have_equal_areas_in_a_map():
    directions = np.random.default_rng(0).standard_normal((20_000, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    x, y = places(directions, 0)
    x, y = x - 30, y - 30
    away = np.hypot(x, y) / np.hypot(x, y).max()
    assert np.allclose(np.quantile(away**2, [0.25, 0.5, 0.75]), [0.25, 0.5, 0.75], atol=0.02)
    upright = places(np.array([[0.0, 0.0, 1.0], [0.0, -1.0, 0.0], [1.0, 0.0, 0.0]]), 2)
    assert upright[0][0] == 150 and upright[1][0] == 30
    assert upright[1][1] > 30 and upright[0][2] > 150  # towards the viewer is down, right is right


def test_every_start_can_be_clicked_in_both_maps_and_has_the_colour_of_its_end():
    accuracies = np.full(STARTS, np.nan)
    accuracies[:3] = 1.0, 0.7, 0.1
    content = drawn(Known(accuracies))
    assert sorted(map(int, re.findall(r'data-start="(\d+)"', content))) == sorted(2 * list(range(STARTS)))
    for number, verdict in enumerate((Verdict.IN_PLACE, Verdict.NEARLY_IN_PLACE, Verdict.WRONG_POSE)):
        group = next(each for each in content.split("<g ") if f'data-start="{number}"' in each)
        assert palette.css(palette.verdict_color(verdict)) in group
    assert verdicts(accuracies[2:4]) == [Verdict.WRONG_POSE, None]


def test_shares_are_of_what_is_known():
    accuracies = np.full(STARTS, np.nan)
    accuracies[:AXES], accuracies[AXES : AXES + 4] = 1.0, (1.0, 0.0, 0.0, 0.0)
    content = drawn(Known(accuracies))
    assert content.count("30° 100%") == content.count("60° 25%") == 2
    assert f"{AXES + 1} of {AXES + 4} starts in place, {STARTS - AXES - 4} not tried" in content
    assert "90°<" in content


@pytest.mark.parametrize("number", [0, 45, 150])
def test_a_ring_is_around_the_dot_where_the_scene_begins(number: int):
    content = drawn(Known(np.full(STARTS, np.nan)), replace(STATE, start=start_of(STATE, UP, number)))
    ring = re.findall(r'<circle cx="([\d.]+)" cy="([\d.]+)" r="5.2"', content)
    dot = re.findall(rf'<circle cx="([\d.]+)" cy="([\d.]+)" r="1.2" data-start="{number}"', content)
    assert len(ring) == 2 and ring == dot
    assert int(float(ring[0][0]) // 60) == number // AXES < len(ANGLES)


def test_an_old_map_and_a_failure_say_so():
    assert "has changed" in drawn(Known(np.zeros(STARTS), fits=False))
    assert "has changed" not in drawn(Known(np.zeros(STARTS)))
    content = drawn(Known(np.full(STARTS, np.nan), failure="ValueError: <img src=x>"))
    assert "ValueError: &lt;img" in content and "<img" not in content
