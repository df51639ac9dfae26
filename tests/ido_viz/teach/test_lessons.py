"""The lessons: every claim of their texts holds for the page beside it, and the folder opens those pages."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import pytest
import viser
from checks import CHECKS, NAMES
from checks.helpers import Check, both_in_place, both_wrong, mean, means, paper_says, run_of

from ido import Perturbation
from ido_viz.core.library import shipped_library
from ido_viz.core.run import Run
from ido_viz.core.state import LAST, State, StateError, decode, encode
from ido_viz.teach.lesson_folder import NONE, LessonFolder
from ido_viz.teach.lessons import Step, lesson, lessons, step_of

DEFAULT = State()
MOST_WORDS = 90
"""Longest text of a step."""

STEPS = {f"{each.name}-{i + 1}": step for each in lessons() for i, step in enumerate(each.steps)}
CLAIMS = {f"{each.name}/{claim.id}": step for each in lessons() for step in each.steps for claim in step.claims}


def test_every_claim_has_one_check_and_every_check_its_claim() -> None:
    checks = Counter(name for name in NAMES if not name.startswith("presets/"))
    assert sorted(CLAIMS.keys() - checks.keys()) == [], "claims without a check"
    assert sorted(checks.keys() - CLAIMS.keys()) == [], "checks without a claim"
    assert sorted(name for name, count in checks.items() if count > 1) == [], "claims with more than one check"


@pytest.mark.parametrize(("name", "step"), CLAIMS.items(), ids=CLAIMS)
def test_every_claim_holds(name: str, step: Step) -> None:
    assert name in CHECKS, f"add a check of {name} in tests/helpers/checks"
    assert CHECKS[name](run_of(step.state)) is True


@pytest.mark.parametrize("step", STEPS.values(), ids=STEPS)
def test_a_step_is_short_and_its_page_can_be_opened_and_shared(step: Step) -> None:
    assert 20 <= len(step.text.split()) <= MOST_WORDS
    assert all(claim.text in step.text for claim in step.claims)
    assert shipped_library().checked(step.state) == step.state
    assert decode(encode(step.state)) == step.state
    assert step.state.iteration <= max(side.trajectory.iterations for side in run_of(step.state).sides)
    assert not (step.state.iteration == LAST and step.state.playing)


def test_lessons_have_their_own_names_titles_and_pages() -> None:
    states = [step.state for step in STEPS.values()]
    for values in ([each.name for each in lessons()], [each.title for each in lessons()], states):
        assert len(set(values)) == len(values)
    assert all(2 <= len(each.steps) <= 5 for each in lessons())
    assert all(step.claims for step in STEPS.values())
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
    assert step_of(dark.steps[1].state) == (dark, 1)
    assert step_of(State()) is None


class Student:
    """Uses the folder as a browser would, and notes the pages that it opens."""

    def __init__(self, gui: viser.GuiApi, state: State) -> None:
        self.opened: list[State] = []
        self.folder = LessonFolder(gui, self.opened.append, state)

    def _send(self, handle: Any, value: str) -> None:
        handle._impl.value = value
        for callback in handle._impl.update_cb:
            callback(SimpleNamespace(target=handle, client=object()))

    def choose(self, title: str) -> None:
        self._send(self.folder._menu, title)

    def press(self, button: str) -> None:
        assert button in self.folder._buttons.options
        self._send(self.folder._buttons, button)

    @property
    def shown(self) -> tuple[str, str]:
        return self.folder._text.content, self.folder._count.content


@pytest.fixture(scope="module")
def server() -> Iterator[viser.ViserServer]:
    server = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
    yield server
    server.stop()


@pytest.fixture
def student(server: viser.ViserServer) -> Iterator[Callable[..., Student]]:
    server.gui.reset()
    yield lambda state=DEFAULT: Student(server.gui, state)
    server.gui.reset()


def test_nothing_is_opened_before_a_lesson_is_chosen(student: Callable[..., Student]) -> None:
    at_desk = student()
    assert at_desk.folder._menu.value == NONE
    assert not at_desk.folder._buttons.visible
    at_desk.press("Next")
    assert at_desk.opened == []


def test_a_student_walks_through_every_lesson(student: Callable[..., Student]) -> None:
    at_desk = student()
    for each in lessons():
        at_desk.opened.clear()
        at_desk.choose(each.title)
        for number, step in enumerate(each.steps):
            assert at_desk.shown == (step.text, f"*Step {number + 1} of {len(each.steps)}*")
            at_desk.press("Next")  # at the last one it does nothing
        assert at_desk.opened == [step.state for step in each.steps]


def test_back_and_again(student: Callable[..., Student]) -> None:
    at_desk, dark = student(), lesson("dark")
    at_desk.choose(dark.title)
    for button in ("Back", "Again", "Next", "Again", "Back"):
        at_desk.press(button)
    assert at_desk.opened == [dark.steps[i].state for i in (0, 0, 1, 1, 0)]
    at_desk.choose(NONE)
    assert not at_desk.folder._buttons.visible
    assert len(at_desk.opened) == 5


def test_a_page_of_a_step_begins_with_its_lesson(student: Callable[..., Student]) -> None:
    dark = lesson("dark")
    at_desk = student(dark.steps[1].state)
    assert at_desk.folder._menu.value == dark.title
    assert at_desk.shown == (dark.steps[1].text, "*Step 2 of 4*")
    assert at_desk.opened == []
    at_desk.press("Next")
    assert at_desk.opened == [dark.steps[2].state]
    assert student(State()).folder._menu.value == NONE
