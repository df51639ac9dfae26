"""The folder and the presenter as a student uses them: what is said, what is opened, and what comes back."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import pytest
import viser
from checks.helpers import run_of

from ido_viz.core.actions import Actions
from ido_viz.core.frame import frame_of
from ido_viz.core.state import LAST, NO_CAMERA, State
from ido_viz.teach.lesson_folder import NONE, LessonFolder
from ido_viz.teach.lessons import Lesson, lesson, lessons
from ido_viz.teach.presenter import WATCH
from ido_viz.teach.presets import presets

DEFAULT = State()
MINE = replace(DEFAULT, playing=False, iteration=4, perturbation=replace(DEFAULT.perturbation, seed=77))


class Student:
    """Uses the folder as a browser would, on a page that shows at once what is opened."""

    def __init__(self, server: viser.ViserServer, state: State) -> None:
        self.opened: list[State] = []
        self.scene = server.scene
        self.page = state
        client = SimpleNamespace(gui=server.gui, scene=server.scene)
        actions = SimpleNamespace(
            open_page=self._open, shown=lambda: SimpleNamespace(state=self.page), redraw=lambda: None, **_UNUSED
        )
        self.sweeps: list[str] = []
        self.brought_back = 0
        self.folder = LessonFolder(
            cast(viser.ClientHandle, client), cast(Actions, actions), self.sweeps.append, self._bring_tabs_back, state
        )
        self.presenter: Any = self.folder._presenter
        self.draw()

    def _open(self, state: State) -> None:
        self.opened.append(state)
        self.page = state

    def _bring_tabs_back(self) -> None:
        self.brought_back += 1

    def draw(self) -> None:
        self.folder.draw(frame_of(run_of(self.page), self.page))

    def play_to_the_end(self) -> None:
        ended = replace(self.page, playing=False, iteration=LAST)
        self.folder.draw(frame_of(run_of(ended), ended))

    def _send(self, handle: Any, value: str | None) -> None:
        handle._impl.value = value
        for callback in handle._impl.update_cb:
            callback(SimpleNamespace(target=handle, client=object()))
        self.draw()

    def choose(self, title: str) -> None:
        self._send(self.folder._menu, title)

    def press(self, button: str) -> None:
        assert button in self.presenter._moves.options
        self._send(self.presenter._moves, button)

    @property
    def offered(self) -> list[Any]:
        return [each for each in self.presenter._slot._children.values() if not isinstance(each, viser.GuiHtmlHandle)]

    def guess(self, answer: str) -> None:
        (group,) = self.offered
        assert answer in group.options
        self._send(group, answer)

    def take(self, button: str) -> None:
        (found,) = (each for each in self.offered if each.label == button)
        self._send(found, None)

    @property
    def text(self) -> str:
        return self.presenter._text.content

    @property
    def at(self) -> str:
        return self.presenter._head.content

    @property
    def reading(self) -> bool:
        return self.presenter.panel.visible


_UNUSED = dict.fromkeys(("play", "step", "jump", "new_seed", "map_basin", "set_values"), lambda *_: None)


@pytest.fixture(scope="module")
def server() -> Iterator[viser.ViserServer]:
    server = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
    yield server
    server.stop()


@pytest.fixture
def student(server: viser.ViserServer) -> Iterator[Callable[..., Student]]:
    server.gui.reset()
    yield lambda state=DEFAULT: Student(server, state)
    server.gui.reset()


def test_an_answer_is_told_early_to_whoever_goes_on(student: Callable[..., Student]):
    each = next(each for each in lessons() if each.steps[0].guess is not None and each.steps[0].guess.state.playing)
    guess = each.steps[0].guess
    assert guess is not None
    at_desk = student()
    at_desk.choose(each.title)
    at_desk.press("Next")
    assert at_desk.text == WATCH
    at_desk.press("Next")
    assert at_desk.text == guess.text
    at_desk.press("Next")
    assert at_desk.text == each.steps[1].text


def test_nothing_is_opened_or_said_before_a_lesson_is_chosen(student: Callable[..., Student]):
    at_desk = student()
    assert at_desk.folder._menu.value == NONE
    assert not at_desk.reading
    for button in ("Next", "Back", "Again", "Leave"):
        at_desk.press(button)
    assert at_desk.opened == []
    assert not at_desk.reading


@pytest.mark.parametrize("each", lessons(), ids=lambda each: each.name)
def test_a_student_walks_through_every_lesson(student: Callable[..., Student], each: Lesson):
    at_desk = student()
    at_desk.choose(each.title)
    for number, step in enumerate(each.steps, start=1):
        assert at_desk.reading
        assert at_desk.text == step.text
        assert f"Step {number} of {len(each.steps)}" in at_desk.at
        assert at_desk.page == step.state
        assert len(at_desk.offered) == (step.control is not None or step.guess is not None)
        if step.guess is not None:
            at_desk.guess(step.guess.right)
            assert at_desk.page == step.guess.state
            if step.guess.state.playing:
                assert at_desk.text == WATCH
                at_desk.play_to_the_end()
            assert at_desk.text == "**Yes.** " + step.guess.text
        at_desk.press("Next")
    assert each.title in at_desk.text
    assert at_desk.sweeps == [step.sweep for step in each.steps if step.sweep is not None]
    at_desk.press("Next")
    assert at_desk.page == each.steps[-1].shown


def test_what_was_tried_is_put_back_and_what_plays_plays_on(student: Callable[..., Student]):
    at_desk, outliers = student(), lesson("outliers")
    at_desk.choose(outliers.title)
    while "Step 6 of" not in at_desk.at:
        at_desk.press("Next")
    playing = outliers.steps[5].state
    assert at_desk.page == playing == outliers.steps[6].state
    at_desk.page = replace(playing, iteration=9)
    opened = len(at_desk.opened)
    at_desk.press("Next")
    assert len(at_desk.opened) == opened
    at_desk.page = replace(playing, perturbation=replace(playing.perturbation, points=400))
    at_desk.press("Next")
    assert at_desk.page == playing
    at_desk.page = replace(playing, iteration=9)
    at_desk.press("Again")
    assert at_desk.page == playing


def test_leaving_brings_back_what_was_there(student: Callable[..., Student]):
    at_desk = student()
    at_desk.page = MINE
    at_desk.choose(lesson("maps").title)
    at_desk.press("Next")
    at_desk.choose(lesson("dark").title)  # another one in the middle of the first
    at_desk.press("Next")
    assert at_desk.brought_back == 0
    at_desk.press("Leave")
    assert at_desk.page == MINE
    assert not at_desk.reading
    assert at_desk.folder._menu.value == NONE
    assert at_desk.brought_back == 1
    at_desk.choose(lesson("dark").title)
    at_desk.choose(NONE)
    assert at_desk.page == MINE
    assert not at_desk.reading


def test_the_end_leads_to_the_next_lesson_the_preset_and_to_trying(student: Callable[..., Student]):
    at_desk, half = student(), lesson("half")
    at_desk.page = MINE

    def to_the_end() -> list[str]:
        at_desk.choose(half.title)
        while "The end" not in at_desk.at:
            at_desk.press("Next")
        return [each.label for each in at_desk.offered]

    following, preset, own = to_the_end()
    assert following == f"Next lesson: {lesson('dark').title}"
    at_desk.take(following)
    assert (at_desk.text, at_desk.page) == (lesson("dark").steps[0].text, lesson("dark").steps[0].state)
    to_the_end()
    (wanted,) = (each for each in presets() if each.id == half.preset)
    assert preset == f"Preset: {wanted.label}"
    at_desk.take(preset)
    assert at_desk.page == wanted.state
    assert not at_desk.reading
    to_the_end()
    at_desk.take(own)
    assert at_desk.page == half.steps[-1].shown
    assert not at_desk.reading


def test_the_last_lesson_has_no_next_one(student: Callable[..., Student]):
    at_desk, last = student(), lessons()[-1]
    at_desk.choose(last.title)
    while "The end" not in at_desk.at:
        at_desk.press("Next")
    assert [each.label for each in at_desk.offered] == ["Try it yourself: keep this page"]


def test_a_page_of_a_step_begins_with_its_lesson(student: Callable[..., Student]):
    dark = lesson("dark")
    at_desk = student(dark.steps[3].state)
    assert at_desk.folder._menu.value == dark.title
    assert at_desk.text == dark.steps[3].text
    assert at_desk.opened == []
    at_desk.press("Back")
    assert at_desk.opened == [dark.steps[2].state]
    at_desk.press("Leave")
    assert at_desk.page == DEFAULT


def test_a_lecturer_who_hides_the_lessons_hides_the_presenter(student: Callable[..., Student]):
    at_desk = student()
    at_desk.choose(lesson("maps").title)
    at_desk.page = replace(at_desk.page, hidden=("lessons",))
    at_desk.draw()
    assert not at_desk.reading
    at_desk.page = replace(at_desk.page, hidden=())
    at_desk.draw()
    assert at_desk.reading


def test_the_view_is_turned_for_a_step_and_turned_back(student: Callable[..., Student]):
    at_desk, steps = student(), lesson("binaries").steps
    at_desk.choose(lesson("binaries").title)
    turned = 0
    for step in steps:
        assert at_desk.page.camera == step.state.camera
        turned += step.state.camera != NO_CAMERA
        at_desk.press("Next")
    assert turned > 1
    at_desk.press("Leave")
    assert at_desk.page.camera == NO_CAMERA


def test_what_a_step_marks_is_named_in_the_3d_view_until_the_next(student: Callable[..., Student]):
    at_desk, steps = student(), lesson("histogram").steps

    def words() -> list[str]:
        nodes: Any = at_desk.scene._handle_from_node_name
        return sorted(node.text for name, node in nodes.items() if name.endswith("/word"))

    at_desk.choose(lesson("histogram").title)
    assert words() == ["model point", "scene point"]
    for step in steps[1:]:
        at_desk.press("Next")
        assert len(words()) == len(step.marks)
    at_desk.press("Back")
    at_desk.choose(lesson("failure").title)
    assert words() == ["outliers", "outliers"]
    at_desk.press("Leave")
    assert words() == []
