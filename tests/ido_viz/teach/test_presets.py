"""Presets: what each is said to be known for holds, and its button opens it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import pytest
import viser
from checks import CHECKS, NAMES
from checks.helpers import both_in_place, run_of

from ido_viz.core.state import State, decode, encode
from ido_viz.teach.lessons import step_of
from ido_viz.teach.preset_folder import PresetFolder
from ido_viz.teach.presets import Preset, presets

PRESETS = presets()

by_id = pytest.mark.parametrize("preset", PRESETS, ids=lambda preset: preset.id)


def test_every_preset_has_one_check_and_every_check_its_preset() -> None:
    ids = {f"presets/{preset.id}" for preset in PRESETS}
    checks = Counter(name for name in NAMES if name.startswith("presets/"))
    assert sorted(ids - checks.keys()) == [], "presets without a check"
    assert sorted(checks.keys() - ids) == [], "checks without a preset"
    assert sorted(name for name, count in checks.items() if count > 1) == [], "presets with more than one check"


@by_id
def test_what_is_known_holds(preset: Preset) -> None:
    run = run_of(preset.state)
    assert CHECKS[f"presets/{preset.id}"](run)
    assert both_in_place(run) is preset.good


@by_id
def test_what_is_known_fails_elsewhere(preset: Preset) -> None:
    p = preset.state.perturbation
    other = replace(p, rotation=180.0, seed=1) if preset.good else replace(p, rotation=5.0, translation=0.0, outliers=0)
    assert not CHECKS[f"presets/{preset.id}"](run_of(replace(preset.state, perturbation=other)))


@by_id
def test_it_can_be_shared_and_is_no_page_of_a_lesson(preset: Preset) -> None:
    assert decode(encode(preset.state)) == preset.state
    assert step_of(preset.state) is None
    assert preset.state.perturbation.seed < 10_000


def test_there_are_both_kinds_and_no_two_are_alike() -> None:
    assert [preset.good for preset in PRESETS] == [True] * 3 + [False] * 6
    for values in (
        [p.id for p in PRESETS],
        [p.label for p in PRESETS],
        [p.hint for p in PRESETS],
        [p.state for p in PRESETS],
    ):
        assert len(set(values)) == len(values)


@pytest.fixture
def server() -> Iterator[viser.ViserServer]:
    server = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
    yield server
    server.stop()


def test_each_button_opens_its_page(server: viser.ViserServer) -> None:
    opened: list[State] = []
    buttons: dict[str, Any] = dict(PresetFolder(server.gui, opened.append).buttons)
    for preset in PRESETS:
        for callback in buttons[preset.label]._impl.update_cb:
            callback(None)
    assert opened == [preset.state for preset in PRESETS]


def test_good_and_bad_differ_by_more_than_colour(server: viser.ViserServer) -> None:
    buttons: dict[str, Any] = dict(PresetFolder(server.gui, lambda _: None).buttons)
    icons = {good: {buttons[p.label].icon for p in PRESETS if p.good is good} for good in (True, False)}
    assert len(icons[True]) == len(icons[False]) == 1
    assert icons[True] != icons[False]
    assert all(buttons[p.label]._impl.props.hint == p.hint for p in PRESETS)
