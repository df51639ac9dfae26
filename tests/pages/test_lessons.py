"""Lessons: their steps, trying things, guessing, and coming back."""

from __future__ import annotations

from dataclasses import replace

from unseen_explorer import UnseenExplorer

from ido_viz.core.state import State
from ido_viz.teach.lessons import lesson


def test_a_lesson_is_walked_left_and_taken_up_again(explorer: UnseenExplorer):
    before = explorer.expect_to_agree()
    chosen = lesson("stopping")
    explorer.choose("Lesson", chosen.title)
    for number, step in enumerate(chosen.steps, start=1):
        explorer.expect_step(number, len(chosen.steps))
        explorer.wait_until(f"the page of step {number}", lambda step=step: at_rest(explorer) == at_its_end(step.state))
        if step.guess is not None:
            explorer.press(step.guess.right)
            explorer.wait_until("the answer to it", lambda: explorer.says("Yes."))
            explorer.wait_until("the answer", lambda step=step: at_rest(explorer) == at_its_end(step.shown))
        if number < len(chosen.steps):
            explorer.press("Next")
    explorer.press("Back")
    explorer.expect_step(len(chosen.steps) - 1, len(chosen.steps))
    explorer.pause(300)
    explorer.drag("Noise", 0.9)
    explorer.press("Again")
    wanted = chosen.steps[-2].state
    explorer.wait_until("the step's page again", lambda: explorer.state().perturbation == wanted.perturbation)
    explorer.press("Leave")
    explorer.wait_until("what was there before", lambda: explorer.state() == before)
    assert explorer.step() is None


def test_nothing_plays_before_a_guess(explorer: UnseenExplorer):
    chosen = lesson("half")
    explorer.choose("Lesson", chosen.title)
    explorer.expect_step(1, len(chosen.steps))
    explorer.expect_numbers(chosen.steps[0].state)
    explorer.pause(500)
    assert explorer.iteration() == 0
    guess = chosen.steps[0].guess
    assert guess is not None
    explorer.press("DO")
    explorer.drag("Speed", 1.0)
    explorer.wait_until("the answer to it", lambda: explorer.says("No."))
    explorer.wait_until("the end", lambda: explorer.iteration() == explorer.last_iteration())


def test_the_page_says_what_the_lesson_says_of_one_pair_of_points(explorer: UnseenExplorer):
    explorer.choose("Lesson", lesson("histogram").title)
    for number in (1, 2):
        explorer.expect_step(number, 12)
        explorer.press("Next")
    for answer, weight in (("front", "0.5873"), ("back", "0.0434")):
        explorer.wait_until(
            f"{answer} and {weight}",
            lambda wanted=[answer, weight]: rows(explorer, "front / back")[-1][1:3] == wanted,
        )
        explorer.press("Next")


def test_the_bin_that_misleads_most_is_listed_first(explorer: UnseenExplorer):
    steps = lesson("misled").steps
    explorer.choose("Lesson", lesson("misled").title)
    explorer.press("Next")
    explorer.open_tab("Inspect")
    explorer.wait_until("the list", lambda: first_bin(explorer).startswith("430 front"))
    assert explorer.options("Strongest bins")[1].startswith("430 front -")
    explorer.press("Next")
    assert steps[2].state.inspected == 430
    explorer.wait_until("its model point", lambda: explorer.value("Model point") == 430)


def test_a_scene_of_the_training_comes_unrounded(explorer: UnseenExplorer):
    learned = lesson("overfitting").steps[0].state
    explorer.choose("Lesson", lesson("overfitting").title)
    explorer.expect_numbers(learned)
    assert explorer.expect_to_agree() == learned


def rows(explorer: UnseenExplorer, name: str) -> list[list[str]]:
    """The rows of the tables of Inspect that begin with a name, cell by cell."""
    explorer.open_tab("Inspect")
    found = [[cell.get_text() for cell in row.find_all("td")] for row in explorer.elements("tr", "<table")]
    return [row for row in found if row and row[0] == name] or [[]]


def first_bin(explorer: UnseenExplorer) -> str:
    """What the list of bins begins with."""
    found = explorer.elements("tr[data-bin]", "data-bin")
    return found[0].get_text(" ") if found else ""


def at_rest(explorer: UnseenExplorer) -> object:
    """What the page shows, whatever the iteration."""
    return at_its_end(explorer.state()) if not explorer.is_playing() else None


def at_its_end(state: State) -> State:
    return replace(state, iteration=0, playing=False)
