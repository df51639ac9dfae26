"""Codes: one page's state in another."""

from __future__ import annotations

from dataclasses import replace

import pytest
from any_explorer import AT_THE_END
from unseen_explorer import OpenUnseen, UnseenExplorer

from ido import Perturbation
from ido_viz.core.address import read_fragment
from ido_viz.core.state import State, decode, encode

pytestmark = pytest.mark.filterwarnings("error::pytest.PytestUnhandledThreadExceptionWarning")
ELSEWHERE = State(
    perturbation=Perturbation(noise=0.01, points=900, outliers=120, incomplete=0.1, rotation=75.0, seed=8),
    left="Improved DO",
    right="DO",
    iteration=6,
    playing=False,
    replay=False,
    order="elevation",
    pinned_map=15,
)


def test_a_pasted_code_gives_exactly_its_page_and_one_can_go_on_from_there(explorer: UnseenExplorer):
    explorer.paste(encode(ELSEWHERE))
    explorer.expect_numbers(ELSEWHERE)
    assert explorer.expect_to_agree() == ELSEWHERE
    assert explorer.methods() == ("Improved DO", "DO")
    assert explorer.slider_value("Rotation") == 75
    assert explorer.slider_value("Points") == 900
    assert explorer.value("Seed") == 8
    assert explorer.value("Order bins by") == "elevation"
    explorer.press("Next (N)")
    explorer.wait_until("the next iteration", lambda: explorer.iteration() == 7)
    value = explorer.drag("Noise", 0.7)
    expected = replace(ELSEWHERE, iteration=7, perturbation=replace(ELSEWHERE.perturbation, noise=value))
    explorer.expect_numbers(expected)
    assert explorer.expect_to_agree() == expected


def test_broken_codes_are_refused_with_a_message_and_the_page_goes_on(explorer: UnseenExplorer):
    before, its_code = explorer.state(), explorer.code()
    for code in (encode(ELSEWHERE)[:-6], encode(State(left="ICP")), "<img src=x onerror=alert(1)>"):
        explorer.paste(code)
        explorer.wait_until("a message", explorer.notifications)
        assert "This code cannot be used" in explorer.notifications()[0]
        explorer.wait_until("the page's own code again", lambda: explorer.code() == its_code)
        explorer.close_notifications()
    explorer.press("Back (B)")
    explorer.wait_until("the iteration before", lambda: explorer.iteration() == explorer.last_iteration() - 1)
    after = explorer.expect_to_agree()
    assert replace(after, iteration=before.iteration) == before


def test_a_box_that_is_cleared_to_paste_another_code_is_no_code(explorer: UnseenExplorer):
    before = state_of(explorer)
    for nothing in ("", "   "):
        explorer.paste(nothing)
        explorer.expect_alive()  # goes to another iteration
        assert explorer.notifications() == []
    assert replace(state_of(explorer), iteration=before.iteration) == before


def test_one_tab_s_code_gives_the_same_page_in_another(explorer: UnseenExplorer, open_unseen: OpenUnseen):
    one, other = explorer, open_unseen()
    one.drag("Rotation", 0.5)
    one.press("New seed")
    one.wait_until("another seed", lambda: one.state().perturbation.seed != 0)
    shared = one.expect_to_agree()
    other.paste(one.code())
    other.expect_numbers(shared)
    assert other.numbers() == one.numbers()


def test_a_page_with_a_map_that_its_methods_lack_appears_and_shows_their_last(open_unseen: OpenUnseen):
    explorer = open_unseen(replace(AT_THE_END, pinned_map=40))
    explorer.wait_until(
        "the pinned maps", lambda: sum(text.count("map 30 of 30 (pinned)") for text in explorer.texts()) == 2
    )
    explorer.paste(encode(replace(AT_THE_END, pinned_map=1000)))
    explorer.expect_alive()
    assert explorer.notifications() == []


def test_where_the_scores_are_hidden_their_tabs_say_so(explorer: UnseenExplorer):
    explorer.open_tab("Compare")
    explorer.wait_until("what the tab is for", lambda: explorer.says("Every method and setting on the scene"))
    assert not explorer.says("The scores are hidden")
    explorer.tick("Hide scores")
    for tab in ("Errors", "Compare", "Basin", "Sweeps"):
        explorer.open_tab(tab)
        explorer.wait_until(f"a word in {tab}", lambda: explorer.says("The scores are hidden"))
        assert not explorer.says("Every method and setting on the scene")


def test_the_address_is_kept_where_the_share_folder_is_hidden(open_unseen: OpenUnseen):
    hidden = replace(AT_THE_END, hidden=("share",))
    explorer = open_unseen(hidden)
    explorer.wait_until("its address", lambda: state_of(explorer) == hidden)
    explorer.press("First (R)")
    explorer.wait_until("the next address", lambda: state_of(explorer) == replace(hidden, iteration=0))


def state_of(explorer: UnseenExplorer) -> State:
    """The state that the server gives the browser's address."""
    return decode(read_fragment(explorer.fragment()).code)
