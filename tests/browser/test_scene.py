"""Changing the scene, the methods and when they stop."""

from __future__ import annotations

from dataclasses import replace

import pytest
from explorer import Explorer, box_of, numbers_of

from ido import Perturbation
from ido.perturbation import LARGEST_SEED
from ido_viz.core.library import shipped_library
from ido_viz.core.state import LONGEST_RUN, encode

pytestmark = pytest.mark.filterwarnings("error::pytest.PytestUnhandledThreadExceptionWarning")

SLIDERS = {
    "Noise": 0.2,
    "Points": 0.25,
    "Outliers": 0.9,
    "Incomplete": 0.15,
    "Rotation": 0.6,
    "Translation": 0.75,
}
"""The sliders, and to which share of its track each is dragged."""


def test_each_slider_is_followed_and_its_last_value_shown(explorer: Explorer):
    for label, share in SLIDERS.items():
        before = explorer.numbers()
        value = explorer.drag(label, share, steps=4)
        explorer.wait_until(
            f"{label} {value:g}", lambda label=label, value=value: value_in_state(explorer, label) == value
        )
        explorer.expect_to_agree()
        assert explorer.slider_value(label) == value
        assert float(explorer.field(label).input_value()) == value
        assert explorer.numbers() != before
    default, end = Perturbation(), explorer.state().perturbation
    assert all(getattr(end, label.lower()) != getattr(default, label.lower()) for label in SLIDERS)


def value_in_state(explorer: Explorer, label: str) -> float:
    return getattr(explorer.state().perturbation, label.lower())


def test_a_held_slider_shows_other_numbers_and_a_wild_drag_ends_at_its_last_value(explorer: Explorer):
    thumb = explorer.row("Rotation").get_by_role("slider")
    thumb.scroll_into_view_if_needed()
    box = box_of(thumb)
    explorer.page.mouse.move(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    explorer.page.mouse.down()
    seen = [explorer.numbers()]
    for step in range(1, 4):
        explorer.page.mouse.move(box["x"] + 10 * step, box["y"] + box["height"] / 2, steps=3)
        explorer.wait_until("other numbers", lambda: explorer.numbers() not in seen)
        seen.append(explorer.numbers())
    explorer.page.mouse.up()
    explorer.pause()
    value = explorer.drag("Rotation", 0.9, 0.0, 1.0, 0.3, steps=10)
    assert value == pytest.approx(0.3 * 180, abs=4)
    explorer.wait_until(f"rotation {value:g}", lambda: explorer.state().perturbation.rotation == value)
    assert explorer.expect_to_agree().perturbation.rotation == value
    assert explorer.slider_value("Rotation") == value


def test_seeds_by_button_and_typed_make_other_scenes(explorer: Explorer):
    before = explorer.state()
    explorer.press("New seed")
    explorer.wait_until("another seed", lambda: explorer.state().perturbation.seed != before.perturbation.seed)
    after = explorer.expect_to_agree()
    assert replace(after, perturbation=before.perturbation) == before
    assert explorer.field("Seed").input_value() == str(after.perturbation.seed)
    assert numbers_of(after) != numbers_of(before)
    explorer.type_into("Seed", "123456")
    explorer.wait_until("the seed", lambda: explorer.state().perturbation.seed == 123_456)
    assert numbers_of(explorer.expect_to_agree()) != numbers_of(after)


def test_paper_defaults_undo_every_slider(explorer: Explorer):
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


def test_another_shape_and_back(explorer: Explorer):
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


def test_any_method_in_any_pane(explorer: Explorer):
    for pane, method in (("Left pane", "Improved DO (as printed)"), ("Right pane", "DO")):
        explorer.choose(pane, method)
        explorer.wait_until(f"{method} shown", lambda method=method: method in explorer.methods())
        explorer.expect_to_agree()
    assert explorer.methods() == ("Improved DO (as printed)", "DO")


def test_absurd_input_does_no_harm(explorer: Explorer):
    explorer.tick("Maps follow the iteration")
    for label, low, high in (
        ("Stop below ε", 1e-5, 0.1),
        ("Most iterations", 1, LONGEST_RUN),
        ("Seed", 0, LARGEST_SEED),
        ("Speed", 1, 60),
        ("Map", 1, 30),
        ("Points", 100, 4000),
    ):
        for text in ("-5", "1e9", "abc", "", "99999999999999999999", "0.0000001"):
            explorer.type_into(label, text)
            left = explorer.field(label).input_value()
            assert left == "" or low <= float(left) <= high, f"{label} {left} after {text!r}"
        if label == "Most iterations":
            explorer.type_into(label, "100")  # or every change that follows takes seconds
        explorer.expect_alive()
    explorer.expect_to_agree()
