"""Walking through a lesson: on, back, and a guess before its answer."""

from __future__ import annotations

from dataclasses import replace

import pytest

from ido_viz.core.state import State
from ido_viz.teach.lessons import Lesson, lesson, lessons
from ido_viz.teach.walk import UNASKED, Place, is_still

PLAIN, ASKING = lesson("maps"), lesson("settings")


def way(place: Place) -> list[Place]:
    """All places on the way on, to where it ends."""
    found = [place]
    while (further := found[-1].on()) != found[-1]:
        found.append(further)
    return found


@pytest.mark.parametrize("each", lessons(), ids=lambda each: each.name)
def test_going_on_says_all_that_a_lesson_has_to_say_once(each: Lesson):
    said = [place.text for place in way(Place(each, 0))]
    texts = [text for step in each.steps for text in ([step.text] + ([step.guess.text] if step.guess else []))]
    assert said[:-1] == texts
    assert each.title in said[-1]


@pytest.mark.parametrize("each", lessons(), ids=lambda each: each.name)
def test_going_back_from_the_end_leads_to_the_start(each: Lesson):
    place = way(Place(each, 0))[-1]
    for number in reversed(range(len(each.steps))):
        place = place.back()
        assert (place.number, place.guessed) == (number, None)
    assert place.back() == place


def test_a_guess_is_answered_with_what_is_true():
    place = Place(ASKING, 0)
    guess = ASKING.steps[0].guess
    assert guess is not None
    assert place.state == ASKING.steps[0].state
    assert place.asking == guess.answers
    for answer in guess.answers:
        after = place.answered(answer)
        assert after.text == ("**Yes.** " if answer == guess.right else "**No.** ") + guess.text
        assert after.state == guess.state
        assert after.asking == ()
        assert after.on().number == 1
        assert after.answered(guess.right) == after, "the first answer counts"
    assert place.on().text == guess.text
    assert place.on().guessed == UNASKED
    assert place.answered("Nobody") == place
    assert Place(PLAIN, 0).answered("DO") == Place(PLAIN, 0)


def test_a_page_is_still_itself_while_it_plays_and_in_another_look():
    page = State(playing=True)
    assert is_still(replace(page, iteration=7, playing=False), page)
    assert is_still(replace(page, dark=True, large_text=True, hidden=("view",)), page)
    assert not is_still(replace(page, perturbation=replace(page.perturbation, rotation=1.0)), page)
    assert not is_still(replace(page, inspected=3), page)
    at_rest = State(playing=False, iteration=3)
    assert is_still(at_rest, at_rest)
    assert not is_still(replace(at_rest, iteration=4), at_rest)
    assert not is_still(replace(at_rest, playing=True), at_rest)
