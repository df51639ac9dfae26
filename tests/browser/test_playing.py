"""Playing, stepping and scrubbing through a registration."""

from __future__ import annotations

import pytest
from any_explorer import SETTLING
from explorer import Explorer, OpenExplorer

from ido_viz.core.state import State

SLOWLY = 0.02  # of the slider: two iterations a second

pytestmark = pytest.mark.filterwarnings("error::pytest.PytestUnhandledThreadExceptionWarning")


def test_a_new_page_plays_by_itself_to_the_end(open_explorer: OpenExplorer):
    explorer = open_explorer(State(speed=60))
    explorer.wait_until("the end", lambda: explorer.iteration() == explorer.last_iteration())
    explorer.wait_until("the end of playing", lambda: not explorer.is_playing())
    explorer.expect_to_agree()
    assert explorer.slider_value("Iteration") == explorer.last_iteration()


def test_play_at_the_end_starts_again(explorer: Explorer):
    assert explorer.iteration() == explorer.last_iteration()
    explorer.drag("Speed", SLOWLY)
    explorer.press("Play (P)")
    explorer.wait_until("the beginning", lambda: explorer.iteration() < 5)
    assert explorer.is_playing()


def test_scrubbing_shows_the_iteration_under_the_mouse(at_the_start: Explorer):
    explorer = at_the_start
    value = explorer.drag("Iteration", 0.9, 0.5)
    assert 0 < value < explorer.last_iteration()
    explorer.wait_until(f"iteration {value}", lambda: explorer.iteration() == value)
    assert explorer.expect_to_agree().iteration == value
    assert explorer.slider_value("Iteration") == value
    explorer.drag("Iteration", 1.2)
    explorer.wait_until("the end", lambda: explorer.iteration() == explorer.last_iteration())


def test_what_plays_pauses_where_an_iteration_is_typed(at_the_start: Explorer):
    explorer = at_the_start
    explorer.type_into("Speed", "5")
    explorer.press("Play (P)")
    explorer.wait_until("some iterations", lambda: explorer.iteration() > 3)
    field = explorer.field("Iteration")
    field.dblclick()
    explorer.wait_until("a pause", lambda: not explorer.is_playing())
    explorer.pause(SETTLING)
    assert not explorer.is_playing()
    field.press_sequentially("17", delay=150)
    explorer.wait_until("what was typed", lambda: explorer.iteration() == 17)
    explorer.pause(SETTLING)
    assert field.input_value() == "17"
    assert explorer.expect_to_agree().iteration == 17


def test_keys_step_and_restart_but_not_while_writing(at_the_start: Explorer):
    explorer = at_the_start
    for key, expected in (("n", 1), ("n", 2), ("n", 3), ("b", 2), ("r", 0), ("N", 1)):
        explorer.type_key(key)
        explorer.wait_until(
            f"iteration {expected} after {key}", lambda expected=expected: explorer.iteration() == expected
        )
        explorer.pause()
    for _ in range(6):
        explorer.type_key("n")
    explorer.wait_until("all six quick presses", lambda: explorer.iteration() == 7)
    field = explorer.field("Seed")
    field.click()
    field.press_sequentially("nnnp")
    assert explorer.expect_to_agree().iteration == 7
    assert not explorer.is_playing()
