"""Playing, stepping, and taking back."""

from __future__ import annotations

from dataclasses import replace

import pytest
from any_explorer import AT_THE_END
from unseen_explorer import OpenUnseen, UnseenExplorer

from ido_viz.core.state import LAST

SLOWLY = 0.1  # of the slider

pytestmark = pytest.mark.filterwarnings("error::pytest.PytestUnhandledThreadExceptionWarning")


def test_play_moves_the_iteration_pauses_and_ends_by_button_and_key(at_the_start: UnseenExplorer):
    explorer = at_the_start
    explorer.drag("Speed", SLOWLY)
    explorer.press("Play (P)")
    explorer.wait_until("two iterations", lambda: explorer.iteration() >= 2)
    assert explorer.is_playing()
    explorer.type_key("p")
    explorer.wait_until("the pause", lambda: not explorer.is_playing())
    at = explorer.expect_to_agree().iteration
    explorer.type_key("p")
    explorer.wait_until("two more", lambda: explorer.iteration() >= at + 2)
    explorer.press("Pause (P)")
    explorer.wait_until("the pause", lambda: not explorer.is_playing())
    paused = explorer.expect_to_agree()
    assert 2 <= paused.iteration < explorer.last_iteration()
    explorer.drag("Speed", 1.0)
    explorer.press("Play (P)")
    explorer.wait_until("the end", lambda: explorer.iteration() == explorer.last_iteration())
    explorer.wait_until("the end of playing", lambda: not explorer.is_playing())
    explorer.expect_to_agree()


def test_step_buttons_step_and_stay_within_the_run(at_the_start: UnseenExplorer):
    explorer = at_the_start
    last = explorer.last_iteration()
    for button, expected in (
        ("Back (B)", 0),
        ("Next (N)", 1),
        ("Next (N)", 2),
        ("Back (B)", 1),
        ("Last", last),
        ("Next (N)", last),
        ("Back (B)", last - 1),
        ("First (R)", 0),
        ("Back (B)", 0),
    ):
        explorer.press(button)
        explorer.wait_until(
            f"iteration {expected} after {button}", lambda expected=expected: explorer.iteration() == expected
        )
        assert explorer.expect_to_agree().iteration == (LAST if expected == last else expected)


def test_undo_and_redo_by_their_buttons(explorer: UnseenExplorer):
    before = explorer.state()
    value = explorer.drag("Rotation", 0.8, steps=1)  # one change, however slow the machine is
    explorer.wait_until("the rotation", lambda: explorer.state().perturbation.rotation == value)
    changed = explorer.expect_to_agree()
    explorer.press("Undo")
    explorer.wait_until("the rotation before", lambda: explorer.state() == before)
    assert explorer.slider_value("Rotation") == before.perturbation.rotation
    explorer.press("Redo")
    explorer.wait_until("the rotation again", lambda: explorer.state() == changed)
    assert explorer.slider_value("Rotation") == value


def test_another_scene_is_played_from_its_start(open_unseen: OpenUnseen):
    explorer = open_unseen(replace(AT_THE_END, replay=True, speed=60))
    explorer.drag("Rotation", 0.2)
    explorer.wait_until("how it will end", lambda: all("will end" in text for text in explorer.verdicts()))
    assert explorer.iteration() == 0
    explorer.wait_until("the end", lambda: explorer.iteration() == explorer.last_iteration())
    explorer.expect_to_agree()
    assert not any("will end" in text for text in explorer.verdicts())
