"""A state goes into the widgets' values and comes back as it was."""

from __future__ import annotations

from dataclasses import replace

import pytest

from ido import Perturbation
from ido_viz.core.library import shipped_library
from ido_viz.core.run import start_size
from ido_viz.core.state import State
from ido_viz.panels.control_values import values_of, with_values
from ido_viz.teach.lessons import lessons
from ido_viz.teach.presets import presets

LIBRARY = shipped_library()
PREPARED = {f"{each.name}/{n}": step.state for each in lessons() for n, step in enumerate(each.steps, 1)}
PREPARED |= {each.id: each.state for each in presets()}
OTHER = {
    "perturbation": Perturbation(noise=0.01, points=900, outliers=7, incomplete=0.1, rotation=3.0, seed=9),
    "shape": "urban",
    "left": "ICP, tuned",
    "right": "ICP, tuned",
    "epsilon": 0.002,
    "max_iterations": 7,
    "speed": 40,
    "replay": False,
    "order": "model index",
    "difference": True,
    "pinned_map": 3,
    "ghost": False,
    "handles": False,
    "error_vectors": True,
    "overlay": "other method",
    "overlaid_iteration": 5,
    "dark": True,
    "large_text": True,
}


@pytest.mark.parametrize("name", PREPARED)
def test_every_prepared_page_comes_back_from_its_widgets(name: str):
    state = PREPARED[name]
    by_hand = ("perturbation",) if state.start else ()  # a pose belongs to its scene
    other = replace(state, **{field: value for field, value in OTHER.items() if field not in by_hand})
    assert with_values(other, values_of(state), LIBRARY, 30) == state


def test_a_scene_that_was_moved_by_hand_stays_where_it_is_until_a_slider_moves_it():
    start = (0.1, 0.2, 0.0, 0.0, 0.5, 0.0)
    state = State(start=start)
    angle, _ = start_size(state)
    values = values_of(state)
    assert values["rotation"] == pytest.approx(angle, abs=0.5)
    assert with_values(state, values, LIBRARY, 30).start == start
    moved = with_values(state, values | {"rotation": 90.0}, LIBRARY, 30)
    assert moved.start == () and moved.perturbation.rotation == 90.0
