"""Lessons on the page: choosing one, its steps, trying things and coming back."""

from __future__ import annotations

from dataclasses import replace

from explorer import Explorer

from ido_viz.core.state import State
from ido_viz.teach.lessons import lesson


def test_a_lesson_is_walked_left_and_taken_up_again(explorer: Explorer):
    chosen = lesson("stopping")
    explorer.choose("Lesson", chosen.title)
    for number, step in enumerate(chosen.steps, start=1):
        explorer.page.get_by_text(f"Step {number} of {len(chosen.steps)}").wait_for()
        explorer.wait_until(f"the page of step {number}", lambda step=step: at_rest(explorer) == at_its_end(step.state))
        explorer.open_tab("Learn")
        if number < len(chosen.steps):
            explorer.press("Next")
    explorer.press("Back")
    explorer.page.get_by_text(f"Step {len(chosen.steps) - 1} of {len(chosen.steps)}").wait_for()
    explorer.pause(300)
    explorer.drag("Noise", 0.9)
    explorer.press("Again")
    wanted = chosen.steps[-2].state
    explorer.wait_until("the step's page again", lambda: explorer.state().perturbation == wanted.perturbation)


def test_the_page_says_what_the_lesson_says_of_one_pair_of_points(explorer: Explorer):
    explorer.choose("Lesson", lesson("histogram").title)
    explorer.open_tab("Inspect")
    for answer, weight in (("front", "0.5873"), ("back", "0.0434")):
        of_pair = explorer.page.get_by_role("row").filter(has_text="front / back").last
        explorer.wait_until(
            f"{answer} and {weight}",
            lambda row=of_pair, answer=answer, weight=weight: [answer, weight] == row.inner_text().split("\t")[1:3],
        )
        explorer.press("Next")


def test_the_bin_that_misleads_most_is_listed_first(explorer: Explorer):
    explorer.choose("Lesson", lesson("misled").title)
    explorer.open_tab("Inspect")
    explorer.wait_until("the list", lambda: explorer.options("Strongest bins")[1].startswith("430 front -"))
    explorer.press("Next")
    explorer.wait_until("its model point", lambda: explorer.field("Model point").input_value() == "430")


def test_a_scene_of_the_training_comes_unrounded(explorer: Explorer):
    learned = lesson("overfitting").steps[0].state
    explorer.choose("Lesson", lesson("overfitting").title)
    explorer.expect_numbers(learned)
    assert explorer.expect_to_agree() == learned


def at_rest(explorer: Explorer) -> object:
    """What the page shows, whatever the iteration."""
    return at_its_end(explorer.state()) if not explorer.is_playing() else None


def at_its_end(state: State) -> State:
    return replace(state, iteration=0, playing=False)
