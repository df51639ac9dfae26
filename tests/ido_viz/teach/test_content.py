"""Files of lessons, presets and derivations: what they say is loaded, and a mistake is told with its place."""

from __future__ import annotations

import re
import sys
from pathlib import Path

import numpy as np
import pytest

from ido_viz import app, command
from ido_viz.core.state import State, StateError, with_values
from ido_viz.teach import lessons
from ido_viz.teach.content import ContentError
from ido_viz.teach.derivations import Derivation, Equation, load_derivations
from ido_viz.teach.lessons import Claim, Guess, Lesson, Step, load_lessons
from ido_viz.teach.presets import Preset, load_presets
from ido_viz.teach.step_control import StepControl

LESSON = """
title = "Seen"
preset = "turned"

[[steps]]
text = '''
Look. [Both end
*in place*.](#both-in-place) Press **P**.
'''
tab = "Maps"
end = true
sweep = "noise"
marks = ["scene"]
camera = [1, -1, 0.5]
control = { seed = [1, 2] }
[steps.page]
rotation = 20
hidden = ["view"]

[[steps]]
text = "Nothing."
change = { seed = 9, playing = false }
[steps.guess]
answers = ["DO", "Both"]
right = "Both"
text = "[So it is.](#so-it-is)"

[[steps]]
text = "Still there."

[[steps]]
text = "Else."
control = "noise"
[steps.page]
iteration = 3
"""
PRESETS = """
[[presets]]
id = "far"
label = "Far away"
hint = "Both fail."
good = false
[presets.page]
translation = 0.9

[[presets]]
id = "near"
label = "Near"
hint = "Both succeed."
good = true
[presets.page]
"""
DERIVATION = """
title = "A sum"
plain = "One and one."
look = "At two."

[[steps]]
text = "It is"

[[steps]]
equation = "one-and-one"
tex = '''
1 + 1
= 2
'''
alt = "one and one is two"
"""


def saved(text: str, file: Path) -> Path:
    file.write_text(text, encoding="utf-8")
    return file


def test_a_lesson_is_what_its_file_says(tmp_path: Path):
    saved(LESSON, tmp_path / "10-seen.toml")
    saved(LESSON.replace("Seen", "Before"), tmp_path / "9-seen-before.toml")
    saved("what a lecturer reads", tmp_path / "README.md")
    before, seen = load_lessons(tmp_path)
    away = 1 / np.linalg.norm([1.0, -1.0, 0.5])
    plain = with_values(State(), {"handles": False})
    page = with_values(plain, {"rotation": 20, "hidden": ("view",)})
    camera = (*np.round(np.array([1.0, -1.0, 0.5]) * away, 3).tolist(), 0.0, 0.0, 0.0)
    claim = Claim("both-in-place", "Both end *in place*.")
    second = with_values(page, {"seed": 9, "playing": False})
    steps = (
        Step(
            "Look. Both end *in place*. Press **P**.",
            (claim,),
            with_values(page, {"camera": camera}),
            control=StepControl("seed", (1, 2)),
            tab="Maps",
            end=True,
            sweep="noise",
            marks=("scene",),
        ),
        Step(
            "Nothing.",
            (Claim("so-it-is", "So it is."),),
            second,
            guess=Guess(("DO", "Both"), "Both", "So it is.", second),
        ),
        Step("Still there.", (), second),
        Step("Else.", (), with_values(plain, {"iteration": 3}), control=StepControl("noise")),
    )
    assert seen == Lesson("seen", "Seen", steps, preset="turned")
    assert before == Lesson("seen-before", "Before", steps, preset="turned")


def test_a_step_that_asks_waits_at_the_start(tmp_path: Path):
    saved(LESSON.replace("playing = false", "iteration = 3"), tmp_path / "01-seen.toml")
    (seen,) = load_lessons(tmp_path)
    asking = seen.steps[1]
    assert asking.guess is not None
    assert (asking.state.playing, asking.state.iteration) == (False, 0)
    assert (asking.guess.state.playing, asking.guess.state.iteration) == (True, 3)
    assert seen.steps[2].state == asking.shown == asking.guess.state


def test_presets_are_what_their_file_says(tmp_path: Path):
    far = Preset("far", "Far away", "Both fail.", with_values(State(), {"translation": 0.9}), good=False)
    near = Preset("near", "Near", "Both succeed.", State(), good=True)
    assert load_presets(saved(PRESETS, tmp_path / "presets.toml")) == (far, near)


def test_a_derivation_is_what_its_file_says(tmp_path: Path):
    saved(DERIVATION, tmp_path / "1-sum.toml")
    steps = ("It is", Equation("one-and-one", "1 + 1 = 2", "one and one is two"))
    assert load_derivations(tmp_path) == (Derivation("A sum", "One and one.", steps, "At two."),)


def test_a_file_of_windows_is_read(tmp_path: Path):
    (tmp_path / "01-seen.toml").write_bytes(b"\xef\xbb\xbf" + LESSON.replace("\n", "\r\n").encode())
    (lesson,) = load_lessons(tmp_path)
    assert lesson.steps[0].text == "Look. Both end *in place*. Press **P**."


@pytest.mark.parametrize(
    ("right", "wrong", "message"),
    [
        ("rotation =", "rotatoin =", "01-seen.toml, step 1: unknown key 'rotatoin'; known: .*rotation"),
        ("rotation = 20", "rotation = 900", "01-seen.toml, step 1: rotation must lie between 0 and 180, not 900"),
        ("rotation = 20", 'rotation = "20"', "01-seen.toml, step 1: rotation must be a number, not '20'"),
        ("rotation = 20", 'left = "CPD, tunde"', "01-seen.toml, step 1: 'CPD, tunde' cannot register 'bunny'"),
        (
            "rotation = 20",
            'shape = "teapot"',
            "01-seen.toml, step 1: there is no shape 'teapot' on this server",
        ),
        ('["view"]', '["views"]', "01-seen.toml, step 1: hidden must name parts of the page"),
        ("rotation = 20", "rotation 20", r"01-seen.toml: not TOML: .*\(at line 17, column 10\)"),
        ('title = "Seen"', "", "01-seen.toml: 'title' is missing; give text in quotes"),
        ('title = "Seen"', "title = 1", "01-seen.toml: 'title' must be text in quotes, not 1"),
        ('text = "Nothing."', "", "01-seen.toml, step 2: 'text' is missing"),
        (
            'text = "Nothing."',
            'text = "No."\ntxt = ""',
            "01-seen.toml, step 2: unknown key 'txt'; known: camera, change, control, .*text",
        ),
        (
            "(#both-in-place)",
            "(#Both in place)",
            "01-seen.toml, step 1: the id 'Both in place' must be of small",
        ),
        ("(#both-in-place)", "(#)", "01-seen.toml, step 1: the id '' must be"),
        ("*in place*.](#", "[in place].](#", "01-seen.toml, step 1: write a claim as"),
        ('"Nothing."', '"[None.](#both-in-place)"', "01-seen.toml: the id 'both-in-place' is there twice; change one"),
        (
            "hidden = [",
            "[steps.change]\nhidden = [",
            "01-seen.toml, step 1: give \\[steps.page\\] or 'change', not both",
        ),
        (
            "[steps.page]\nrotation = 20\n",
            "[steps.change]\n",
            "01-seen.toml, step 1: 'page' is missing; the first step",
        ),
        ('"turned"', '"upside-down"', "01-seen.toml: unknown preset 'upside-down'; known: defaults, .*turned"),
        ('"Maps"', '"Map"', "01-seen.toml, step 1: unknown tab 'Map'; known: Histograms, .*Maps"),
        ('"noise"\nmarks', '"nose"\nmarks', "01-seen.toml, step 1: unknown sweep 'nose'; known: noise, .*translation"),
        ("end = true", "end = 1", "01-seen.toml, step 1: 'end' must be true or false, not 1"),
        ('["scene"]', '["scenes"]', "01-seen.toml, step 1: unknown mark 'scenes'; known: model point, .*scene"),
        ("[1, -1, 0.5]", "[1, -1]", "01-seen.toml, step 1: 'camera' must be a direction of three numbers"),
        ("[1, -1, 0.5]", "[0, 0, 0]", "01-seen.toml, step 1: 'camera' must be a direction"),
        ("[1, -1, 0.5]", '[1, -1, "up"]', "01-seen.toml, step 1: 'camera' must be a direction"),
        ("seed = [1, 2]", "sed = [1, 2]", "01-seen.toml, step 1: a control is a name"),
        ('["DO", "Both"]', '["Both"]', "01-seen.toml, step 2, guess: 'answers' must be two or more"),
        ('["DO", "Both"]', '["DO", "Both", "DO"]', "01-seen.toml, step 2, guess: the answer 'DO' is there twice"),
        ('right = "Both"', 'right = "DO!"', "01-seen.toml, step 2, guess: unknown right 'DO!'; known: DO, Both"),
        ('right = "Both"', "", "01-seen.toml, step 2, guess: 'right' is missing; give text in quotes"),
        ("#so-it-is", "#both-in-place", "01-seen.toml: the id 'both-in-place' is there twice; change one"),
        (LESSON, 'title = "Seen"\nsteps = []', r"01-seen.toml: there is no step; begin one with \[\[steps\]\]"),
        (LESSON, 'title = "Seen"\nsteps = [1]', "01-seen.toml, step 1: must be a table, not 1"),
    ],
)
def test_a_mistake_in_a_lesson_is_told(tmp_path: Path, right: str, wrong: str, message: str):
    assert right in LESSON
    saved(LESSON.replace(right, wrong), tmp_path / "01-seen.toml")
    with pytest.raises(ContentError, match=f"^{message}"):
        load_lessons(tmp_path)


@pytest.mark.parametrize(
    ("names", "message"),
    [
        (["seen.toml"], "seen.toml: name the file after its place and its content, such as 07-half.toml"),
        (["01-Seen.toml"], "01-Seen.toml: name the file"),
        (["01-seen.toml", "02-seen.toml"], "lessons: the name 'seen' is there twice; change one"),
        (["01-seen.toml", "02-copy.toml"], "lessons: the title 'Seen' is there twice; change one"),
    ],
)
def test_a_wrong_name_of_a_lesson_is_told(tmp_path: Path, names: list[str], message: str):
    folder = tmp_path / "lessons"
    folder.mkdir()
    for name in names:
        saved(LESSON, folder / name)
    with pytest.raises(ContentError, match=f"^{message}"):
        load_lessons(folder)


def test_a_file_that_is_not_in_utf_8_is_told(tmp_path: Path):
    (tmp_path / "01-seen.toml").write_bytes(LESSON.replace("Look", "Schön").encode("latin-1"))
    with pytest.raises(ContentError, match=r"^01-seen.toml: save the file in UTF-8"):
        load_lessons(tmp_path)


@pytest.mark.parametrize(
    ("right", "wrong", "message"),
    [
        ('id = "near"', 'id = "far"', "presets.toml: the id 'far' is there twice"),
        ('id = "near"', 'id = "Near"', "presets.toml, preset 2: the id 'Near' must be of small letters"),
        ('label = "Near"', 'label = "Far away"', "presets.toml: the label 'Far away' is there twice"),
        ("good = false", 'good = "no"', "presets.toml, preset 1: 'good' must be true or false, not 'no'"),
        ("translation = 0.9", "translation = 9", "presets.toml, preset 1: translation must lie between 0 and 1"),
        ("[presets.page]\ntranslation = 0.9", "", "presets.toml, preset 1: 'page' is missing; give a table"),
        (PRESETS, "", "presets.toml: 'presets' is missing; give an array"),
    ],
)
def test_a_mistake_in_presets_is_told(tmp_path: Path, right: str, wrong: str, message: str):
    assert right in PRESETS
    file = saved(PRESETS.replace(right, wrong), tmp_path / "presets.toml")
    with pytest.raises(ContentError, match=f"^{message}"):
        load_presets(file)


@pytest.mark.parametrize(
    ("right", "wrong", "message"),
    [
        ('alt = "one and one is two"', "", "1-sum.toml, step 2: 'alt' is missing"),
        ('text = "It is"', 'txt = "It is"', "1-sum.toml, step 1: unknown key 'txt'; known: text"),
        ('"one-and-one"', '"../one"', "1-sum.toml, step 2: the equation '../one' must be of small letters"),
        ('plain = "One and one."', "", "1-sum.toml: 'plain' is missing"),
    ],
)
def test_a_mistake_in_a_derivation_is_told(tmp_path: Path, right: str, wrong: str, message: str):
    assert right in DERIVATION
    saved(DERIVATION.replace(right, wrong), tmp_path / "1-sum.toml")
    with pytest.raises(ContentError, match=f"^{message}"):
        load_derivations(tmp_path)


def test_an_equation_is_in_one_derivation(tmp_path: Path):
    saved(DERIVATION, tmp_path / "1-sum.toml")
    saved(DERIVATION.replace("A sum", "Again"), tmp_path / "2-again.toml")
    with pytest.raises(ContentError, match="the equation 'one-and-one' is there twice"):
        load_derivations(tmp_path)


def test_the_command_tells_a_mistake_before_anything_is_opened(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    saved(LESSON.replace("rotation = 20", "rotation = 900"), tmp_path / "01-seen.toml")
    monkeypatch.setattr(app, "lessons", lambda: load_lessons(tmp_path))
    monkeypatch.setattr(sys, "argv", ["ido-viz", "--no-open", "--port", "0", "--data", str(tmp_path / "data")])
    assert command.run() == 2
    assert re.fullmatch(r"ido-viz: 01-seen\.toml, step 1: rotation must lie .*\n", capsys.readouterr().err)


def test_shipped_content_is_read_once():
    assert lessons.lessons() is lessons.lessons()


def test_values_are_set_by_name():
    state = with_values(State(), {"rotation": 90.0, "seed": 7, "left": "ICP, tuned"})
    assert (state.perturbation.rotation, state.perturbation.seed, state.left) == (90.0, 7, "ICP, tuned")
    assert with_values(state, {}) == state
    for wrong in ({"rotatoin": 90}, {"rotation": 900}, {"rotation": "90"}, {"perturbation": None}, {"speed": 0.5}):
        with pytest.raises(StateError):
            with_values(state, wrong)
