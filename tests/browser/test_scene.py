"""Changing the scene, the methods and when they stop."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from any_explorer import SLIDERS
from explorer import Explorer, box_of

from ido import Perturbation
from ido.perturbation import LARGEST_SEED
from ido_viz.core.state import LONGEST_RUN, State
from ido_viz.serving import values

pytestmark = pytest.mark.filterwarnings("error::pytest.PytestUnhandledThreadExceptionWarning")


def test_each_slider_is_dragged_and_its_last_value_shown(explorer: Explorer):
    for label, share in SLIDERS.items():
        before = explorer.numbers()
        value = explorer.drag(label, share, steps=4)
        explorer.wait_until(
            f"{label} {value:g}", lambda label=label, value=value: explorer.slider_in_state(label) == value
        )
        assert explorer.slider_value(label) == value
        assert float(explorer.field(label).input_value()) == value
        explorer.wait_until("other numbers", lambda before=before: explorer.numbers() != before)
    default, end = Perturbation(), explorer.expect_to_agree().perturbation
    assert all(getattr(end, label.lower()) != getattr(default, label.lower()) for label in SLIDERS)


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


def test_what_follows_a_decimal_point_or_comma_is_no_whole_number(explorer: Explorer, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(values, "AT_REST", 3.0)  # what is typed takes a busy browser longer than a person
    keyboard = explorer.page.keyboard
    for label, text, shown in (
        ("Seed", "12.7", "12"),
        ("Seed", "1,5", "1"),
        ("Seed", "0.05", "0"),
        ("Seed", "34", "34"),
        ("Noise", "0,07", "0.07"),
        ("Noise", "0.03", "0.03"),
    ):
        explorer.field(label).click()
        keyboard.press("Control+a")
        keyboard.type(text)
        keyboard.press("Tab")
        explorer.wait_until(
            f"{shown} for {text}", lambda label=label, shown=shown: explorer.field(label).input_value() == shown
        )
        explorer.wait_until(
            "its value", lambda label=label, shown=shown: explorer.slider_in_state(label) == float(shown)
        )
    explorer.field("Seed").click()
    keyboard.press("Control+a")
    keyboard.type("12.7")
    keyboard.press("Backspace")
    keyboard.type("45")
    explorer.wait_until("what was typed after a correction", lambda: explorer.field("Seed").input_value() == "145")


def test_absurd_input_does_no_harm(explorer: Explorer):
    explorer.tick("Maps follow the iteration")
    held: dict[str, Callable[[State], float]] = {
        "Noise": lambda state: state.perturbation.noise,
        "Stop below ε": lambda state: state.epsilon,
        "Most iterations": lambda state: state.max_iterations,
        "Seed": lambda state: state.perturbation.seed,
        "Speed": lambda state: state.speed,
        "Map": lambda state: state.pinned_map,
        "Points": lambda state: state.perturbation.points,
    }
    for label, low, high in (
        ("Noise", 0, 0.1),
        ("Stop below ε", 1e-5, 0.1),
        ("Most iterations", 1, LONGEST_RUN),
        ("Seed", 0, LARGEST_SEED),
        ("Speed", 1, 60),
        ("Map", 1, 30),
        ("Points", 100, 4000),
    ):
        field, sliders = explorer.field(label), explorer.row(label).get_by_role("slider")
        for text in ("-5", "1e9", "abc", "", "99999999999999999999", "0.0000001"):
            explorer.type_into(label, text)
            its = held[label]
            explorer.wait_until(
                f"the field {label} to show the value after {text!r}",
                lambda field=field, its=its: (
                    field.input_value() != "" and float(field.input_value()) == its(explorer.state())
                ),
            )
            assert low <= its(explorer.state()) <= high
            if sliders.count():
                explorer.wait_until(
                    "the slider", lambda label=label, its=its: explorer.slider_value(label) == its(explorer.state())
                )
        if label == "Most iterations":
            explorer.type_into(label, "100")  # or every change that follows takes seconds
            explorer.wait_until("more than one iteration", lambda: explorer.last_iteration() > 1)  # or Next is the last
        explorer.expect_alive()
    explorer.expect_to_agree()
