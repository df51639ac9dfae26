"""What the maps were trained on is said, and what of a scene lies beyond it."""

from __future__ import annotations

from dataclasses import replace

import pytest

from ido import Maps, Perturbation, TrainingSettings
from ido_viz.core.frame import Frame, frame_of
from ido_viz.core.library import shipped_library
from ido_viz.core.run import compute
from ido_viz.core.state import State
from ido_viz.panels.reach import beyond, reach_html


def frame_with(state: State) -> Frame:
    return frame_of(compute(state, shipped_library()), state)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({}, []),
        ({"rotation": 120.0}, ["rotation 120 > 90"]),
        ({"rotation": 0.0, "translation": 0.31, "noise": 0.06}, ["noise 0.06 > 0.05", "translation 0.31 > 0.3"]),
        ({"points": 100, "incomplete": 0.5}, ["points 100 < 400", "incomplete 0.5 > 0.3"]),
        ({"outliers": 400}, ["outliers 400 > 300"]),
    ],
)
def test_what_lies_beyond_the_training_is_named(small_maps: Maps, changes: dict[str, float], said: list[str]):
    state = State(perturbation=replace(Perturbation(), **changes))
    assert beyond(small_maps, state) == said


def test_a_wider_training_reaches_farther_and_a_carried_scene_counts_where_it_lies(small_maps: Maps):
    wide = replace(small_maps, settings=TrainingSettings(samples=600, maps=8, rotation=180.0, translation=1.0))
    far = State(perturbation=Perturbation(rotation=170.0, translation=0.9))
    assert beyond(small_maps, far) == ["rotation 170 > 90", "translation 0.9 > 0.3"] and beyond(wide, far) == []
    carried = State(perturbation=Perturbation(rotation=0.0, translation=0.0), start=(0.8, 0.0, 0.0, 0.0, 0.0, 0.0))
    assert beyond(small_maps, carried) == ["translation 0.8 > 0.3"]


def test_the_page_says_the_range_of_the_shown_maps_and_nothing_of_baselines():
    text = reach_html(frame_with(State()))
    assert "up to 90° and 0.3" in text and "Beyond" not in text
    far = reach_html(frame_with(State(perturbation=Perturbation(rotation=130.0, translation=0.5))))
    assert "rotation 130 > 90, translation 0.5 > 0.3" in far and "<br>" not in far
    baselines = State(left="ICP, default", right="ICP, tuned")
    assert reach_html(frame_with(baselines)) == ""
