"""The lessons: they are short, and every claim of their texts holds for the page beside it."""

from __future__ import annotations

import re
from collections import Counter
from dataclasses import replace

import pytest
from checks import CHECKS, NAMES
from checks.helpers import (
    BOTH,
    LEFT,
    RIGHT,
    Check,
    both_in_place,
    both_wrong,
    ends,
    mean,
    means,
    paper_says,
    rotation_error,
    run_of,
)

from ido import Perturbation
from ido_viz.core.frame import frame_of
from ido_viz.core.library import shipped_library
from ido_viz.core.run import Run
from ido_viz.core.state import LAST, State, StateError, decode, encode
from ido_viz.core.verdict import Verdict
from ido_viz.teach.lesson_folder import NONE
from ido_viz.teach.lessons import Step, lesson, lessons, step_named, step_of
from ido_viz.teach.marks import pointers

MOST_WORDS = 30
"""Longest text that is shown at once."""

STEPS = {f"{each.name}-{i + 1}": step for each in lessons() for i, step in enumerate(each.steps)}
ASKING = {name: step for name, step in STEPS.items() if step.guess is not None}
CLAIMS = {f"{each.name}/{claim.id}": step for each in lessons() for step in each.steps for claim in step.claims}


def test_every_claim_has_one_check_and_every_check_its_claim() -> None:
    checks = Counter(name for name in NAMES if not name.startswith("presets/"))
    assert sorted(CLAIMS.keys() - checks.keys()) == [], "claims without a check"
    assert sorted(checks.keys() - CLAIMS.keys()) == [], "checks without a claim"
    assert sorted(name for name, count in checks.items() if count > 1) == [], "claims with more than one check"


@pytest.mark.parametrize(("name", "step"), CLAIMS.items(), ids=CLAIMS)
def test_every_claim_holds(name: str, step: Step) -> None:
    assert name in CHECKS, f"add a check of {name} in tests/helpers/checks"
    assert CHECKS[name](run_of(step.shown)) is True


def words(text: str) -> list[str]:
    """The words of a text as they are shown: numbers and symbols such as ε are words, signs such as = are none."""
    return [word for word in text.replace("*", "").split() if re.search(r"\w", word)]


def test_words_are_counted_as_they_are_shown() -> None:
    assert words("**Yes.** Front / *back*: ε = 0.005, φz at -0.22.") == [
        *("Yes.", "Front", "back:", "ε", "0.005,", "φz", "at", "-0.22.")
    ]


@pytest.mark.parametrize("step", STEPS.values(), ids=STEPS)
def test_a_step_is_short_and_its_page_can_be_opened_and_shared(step: Step) -> None:
    texts = [step.text] if step.guess is None else [step.text, step.guess.text]
    for text in texts:
        assert len(words(text)) <= MOST_WORDS
    assert all(any(claim.text in text for text in texts) for claim in step.claims)
    for state in (step.state, step.shown):
        assert shipped_library().checked(state) == state
        assert decode(encode(state)) == state
        assert state.iteration <= max(side.trajectory.iterations for side in run_of(state).sides)
        assert not (state.iteration == LAST and state.playing)


@pytest.mark.parametrize("step", STEPS.values(), ids=STEPS)
def test_what_a_step_points_at_is_on_its_page(step: Step) -> None:
    shown = frame_of(run_of(step.state), step.state)
    for mark in step.marks:
        assert pointers(shown, (mark,)), f"nothing to point at: {mark}"
    if step.tab is not None and step.tab in step.text:
        assert f"**{step.tab}**" in step.text, "what the page shows is bold"
    for named in re.findall(r"\*\*(\w+)\*\*", step.text):
        assert named == step.tab, f"{named} is named, but not opened"


@pytest.mark.parametrize(("name", "step"), ASKING.items(), ids=ASKING)
def test_nothing_plays_before_a_guess(name: str, step: Step) -> None:
    assert step.guess is not None
    assert not step.state.playing
    assert step.state.iteration == 0
    assert step.guess.right in step.guess.answers
    assert step.tab == "Maps", "the curves of Errors and Compare would tell the end"


VERDICTS: dict[tuple[str, ...], tuple[str, str]] = {
    ("DO", "Improved DO", "Both", "Neither"): ("DO", "Improved DO"),
    ("DO", "GMMReg, tuned", "Both", "Neither"): ("DO", "GMMReg, tuned"),
    ("The left one", "The right one", "Both", "Neither"): ("The left one", "The right one"),
}
"""What is asked of a scene, with the names of its left and right pane."""


@pytest.mark.parametrize(("name", "step"), ASKING.items(), ids=ASKING)
def test_the_right_answer_is_right(name: str, step: Step) -> None:
    assert step.guess is not None
    run = run_of(step.guess.state)
    if step.guess.answers not in VERDICTS:  # asked once
        assert name == "two-more-1"
        errors = [rotation_error(run, side, step.guess.state.iteration) for side in BOTH]
        assert errors[RIGHT] < errors[LEFT]
        assert step.guess.right == "Improved DO"
        return
    names = VERDICTS[step.guess.answers]
    in_place = [name for side, name in zip(BOTH, names, strict=True) if ends(Verdict.IN_PLACE, side)(run)]
    assert step.guess.right == {0: "Neither", 1: "".join(in_place), 2: "Both"}[len(in_place)]


def test_lessons_have_their_own_names_titles_and_pages() -> None:
    for values in ([each.name for each in lessons()], [each.title for each in lessons()]):
        assert len(set(values)) == len(values)
    of_lessons = [{step.state for step in each.steps} for each in lessons()]
    assert sum(map(len, of_lessons)) == len(set[State]().union(*of_lessons)), "a page stands in two lessons"
    assert all(any(step.claims for step in each.steps) for each in lessons())
    assert NONE not in [each.title for each in lessons()]


def test_claims_fail_where_they_do_not_hold() -> None:
    kind = run_of(State(perturbation=Perturbation(seed=0)))
    hopeless = run_of(State(perturbation=Perturbation(seed=1, rotation=180.0)))
    assert both_in_place(kind)
    assert not both_in_place(hopeless)
    assert both_wrong(hopeless)
    assert not both_wrong(kind)
    assert not means(("DO", "0.82"))(kind)
    assert not means(("DO", "0.69"), ("Improved DO", "0.69"), sweep="rotation", level=90)(kind)
    assert not paper_says("translation", ("DO", "0.755"))(kind)
    with pytest.raises(ValueError, match="no results of DO in rotation at 91"):
        mean("DO", "rotation", 91)


def test_what_is_claimed_of_a_page_fails_on_others() -> None:
    """Each claim on a page that differs: those about the scene's end or its outliers must not hold there."""
    failing = 0
    for name, step in CLAIMS.items():
        p = step.state.perturbation
        hopeless = Perturbation(seed=1, outlier_kind=p.outlier_kind, rotation=180.0, translation=1.0, outliers=0)
        easy = replace(hopeless, rotation=10.0, translation=0.1, incomplete=0.0)
        others = [run_of(replace(step.state, perturbation=other, max_iterations=60)) for other in (hopeless, easy)]
        failing += not all(_holds(CHECKS[name], run) for run in others)
    assert failing > 0.5 * len(CLAIMS)


def _holds(check: Check, run: Run) -> bool:
    try:
        return check(run)
    except IndexError:  # the run is too short for what is claimed
        return False


def test_a_lesson_is_found_by_name() -> None:
    assert lesson("dark").title == "When the Gaussian goes dark"
    with pytest.raises(StateError, match=r"unknown lesson 'drak'; known: histogram, .*dark"):
        lesson("drak")


def test_a_step_is_found_by_its_page() -> None:
    dark = lesson("dark")
    assert step_of(dark.steps[3].state) == (dark, 3)
    assert step_of(State()) is None


def test_a_step_is_found_by_its_name() -> None:
    dark = lesson("dark")
    last = len(dark.steps)
    assert step_named("dark") == step_named("dark/1") == (dark, 0)
    assert step_named(f"dark/{last}") == (dark, last - 1)
    for name in (f"dark/{last + 1}", "dark/0", "dark/-1", "dark/one", "dark/1/1"):
        with pytest.raises(StateError, match=f"has steps 1 to {last}"):
            step_named(name)
    with pytest.raises(StateError, match="unknown lesson"):
        step_named("/1")
