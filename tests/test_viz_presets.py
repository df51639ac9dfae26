"""Presets: what each is said to be known for holds, and its button opens it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import pytest
import viser

from ido_viz.lesson import BOTH, ends
from ido_viz.lessons import step_of
from ido_viz.library import shipped_library
from ido_viz.presets import PRESETS, Preset, PresetPanel
from ido_viz.run import compute
from ido_viz.state import State, decode, encode

by_label = pytest.mark.parametrize("preset", PRESETS, ids=lambda preset: preset.label)


@by_label
def test_what_is_known_holds(preset: Preset) -> None:
    run = compute(preset.state, shipped_library())
    assert preset.check(run)
    assert ends("in place", *BOTH)(run) is preset.good


@by_label
def test_what_is_known_fails_elsewhere(preset: Preset) -> None:
    p = preset.state.perturbation
    other = replace(p, rotation=180.0, seed=1) if preset.good else replace(p, rotation=5.0, translation=0.0, outliers=0)
    assert not preset.check(compute(replace(preset.state, perturbation=other), shipped_library()))


@by_label
def test_it_can_be_shared_and_is_no_page_of_a_lesson(preset: Preset) -> None:
    assert decode(encode(preset.state)) == preset.state
    assert step_of(preset.state) is None
    assert preset.state.perturbation.seed < 10_000


def test_there_are_both_kinds_and_no_two_are_alike() -> None:
    assert [preset.good for preset in PRESETS] == [True] * 3 + [False] * 6
    for values in ([p.label for p in PRESETS], [p.hint for p in PRESETS], [p.state for p in PRESETS]):
        assert len(set(values)) == len(values)


@pytest.fixture
def server() -> Iterator[viser.ViserServer]:
    server = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
    yield server
    server.stop()


def test_each_button_opens_its_page(server: viser.ViserServer) -> None:
    opened: list[State] = []
    buttons: dict[str, Any] = dict(PresetPanel(server.gui, opened.append).buttons)
    for preset in PRESETS:
        for callback in buttons[preset.label]._impl.update_cb:
            callback(None)
    assert opened == [preset.state for preset in PRESETS]


def test_good_and_bad_differ_by_more_than_colour(server: viser.ViserServer) -> None:
    buttons: dict[str, Any] = dict(PresetPanel(server.gui, lambda _: None).buttons)
    icons = {good: {buttons[p.label].icon for p in PRESETS if p.good is good} for good in (True, False)}
    assert len(icons[True]) == len(icons[False]) == 1
    assert icons[True] != icons[False]
    assert all(buttons[p.label]._impl.props.hint == p.hint for p in PRESETS)
