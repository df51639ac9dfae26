"""Changing the scene, the methods and when they stop."""

from __future__ import annotations

from dataclasses import replace

import pytest
from any_explorer import SLIDERS, numbers_of
from unseen_explorer import UnseenExplorer

from ido import Perturbation
from ido_viz.core.library import shipped_library
from ido_viz.core.state import encode

pytestmark = pytest.mark.filterwarnings("error::pytest.PytestUnhandledThreadExceptionWarning")


def test_each_slider_is_followed_and_its_last_value_shown(explorer: UnseenExplorer):
    for label, share in SLIDERS.items():
        before = explorer.numbers()
        value = explorer.drag(label, share, steps=4)
        explorer.wait_until(
            f"{label} {value:g}", lambda label=label, value=value: explorer.slider_in_state(label) == value
        )
        explorer.expect_to_agree()
        assert explorer.slider_value(label) == value
        assert explorer.numbers() != before
    default, end = Perturbation(), explorer.state().perturbation
    assert all(getattr(end, label.lower()) != getattr(default, label.lower()) for label in SLIDERS)


def test_seeds_by_button_and_typed_make_other_scenes(explorer: UnseenExplorer):
    before = explorer.state()
    explorer.press("New seed")
    explorer.wait_until("another seed", lambda: explorer.state().perturbation.seed != before.perturbation.seed)
    after = explorer.expect_to_agree()
    assert replace(after, perturbation=before.perturbation) == before
    assert explorer.value("Seed") == after.perturbation.seed
    assert numbers_of(after) != numbers_of(before)
    explorer.set("Seed", 123_456)
    explorer.wait_until("the seed", lambda: explorer.state().perturbation.seed == 123_456)
    assert numbers_of(explorer.expect_to_agree()) != numbers_of(after)


def test_paper_defaults_undo_every_slider(explorer: UnseenExplorer):
    other = Perturbation(
        noise=0.1, points=900, outliers=120, incomplete=0.1, rotation=75.0, translation=1.0, outlier_kind="structured"
    )
    explorer.paste(encode(replace(explorer.state(), perturbation=other)))
    explorer.wait_until("another scene", lambda: explorer.state().perturbation == other)
    for label in SLIDERS:
        explorer.wait_until(
            f"the slider {label}",
            lambda label=label: explorer.slider_value(label) == pytest.approx(getattr(other, label.lower())),
        )
    explorer.press("Paper defaults")
    explorer.wait_until("the defaults", lambda: explorer.state().perturbation == Perturbation())
    explorer.expect_to_agree()
    for label in SLIDERS:
        assert explorer.slider_value(label) == pytest.approx(getattr(Perturbation(), label.lower()))


def test_another_shape_and_back(explorer: UnseenExplorer):
    library = shipped_library()
    before = explorer.state()
    explorer.choose("Shape", "urban")
    explorer.wait_until("the urban scan", lambda: explorer.state().shape == "urban")
    assert explorer.expect_to_agree() == library.at_shape(before, "urban")
    assert explorer.options("Left pane") == list(library.methods("urban"))
    explorer.choose("Shape", "bunny")
    explorer.wait_until("the bunny", lambda: explorer.state().shape == "bunny")
    assert explorer.expect_to_agree() == before
    assert explorer.options("Left pane") == list(library.methods("bunny"))


def test_any_method_in_any_pane(explorer: UnseenExplorer):
    for pane, method in (("Left pane", "Improved DO (as printed)"), ("Right pane", "DO")):
        explorer.choose(pane, method)
        explorer.wait_until(f"{method} shown", lambda method=method: method in explorer.methods())
        explorer.expect_to_agree()
    assert explorer.methods() == ("Improved DO (as printed)", "DO")
