"""Lessons on the page: choosing one, its steps, trying things and coming back."""

from __future__ import annotations

from dataclasses import replace

from explorer import Explorer

from ido_viz.lessons import lesson


def test_a_lesson_is_walked_left_and_taken_up_again(explorer: Explorer):
    chosen = lesson("stopping")
    explorer.choose("Lesson", chosen.title)
    for number, step in enumerate(chosen.steps, start=1):
        explorer.page.get_by_text(f"Step {number} of {len(chosen.steps)}").wait_for()
        explorer.wait_until(f"the page of step {number}", lambda step=step: at_rest(explorer) == at_its_end(step.state))
        if number < len(chosen.steps):
            explorer.press("Next")
    explorer.press("Back")
    explorer.page.get_by_text(f"Step {len(chosen.steps) - 1} of {len(chosen.steps)}").wait_for()
    explorer.pause(300)
    explorer.drag("Noise", 0.9)
    explorer.press("Again")
    wanted = chosen.steps[-2].state
    explorer.wait_until("the step's page again", lambda: explorer.state().perturbation == wanted.perturbation)


def at_rest(explorer: Explorer) -> object:
    """What the page shows, whatever the iteration."""
    return at_its_end(explorer.state()) if not explorer.is_playing() else None


def at_its_end(state):  # type: ignore[no-untyped-def]
    return replace(state, iteration=0, playing=False)
