"""The derivations: their drawings ship and are up to date, the page shows them, and the code does what they say."""

from __future__ import annotations

import base64
import importlib
import re
import xml.etree.ElementTree as ET
from html.parser import HTMLParser
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
import viser
from scipy.linalg import expm

import ido
from ido import poses, shipped_cloud, shipped_maps
from ido.attribution import Attribution
from ido.histograms import SIGMA2, AsPrinted, SceneBatch, azimuth, elevation
from ido.kernels import SMALLEST_WEIGHT
from ido.training import solve, training_scenes
from ido.types import DoubleArray, FloatArray
from ido_viz.derivations import (
    DERIVATIONS,
    EQUATIONS,
    WIDEST,
    Derivations,
    derivation_html,
    drawing_of,
    width_of,
)
from ido_viz.derivations_text import Derivation, Equation
from ido_viz.lessons import LESSONS

FOLDER = Path(__file__).parent.parent / "assets" / "equations"
SVG = "{http://www.w3.org/2000/svg}"
SHAPES = {"svg", "title", "defs", "g", "path", "rect", "use"}
ATTRIBUTES = {"width", "height", "viewBox", "d", "id", "href", "transform", "x", "y"}
MARKUP = {"style", "div", "p", "i", "b", "sub", "sup", "code", "img"}

of_every_equation = pytest.mark.parametrize("equation", EQUATIONS, ids=lambda equation: equation.name)
of_every_derivation = pytest.mark.parametrize("derivation", DERIVATIONS, ids=lambda derivation: derivation.title)


def test_every_equation_has_its_drawing_and_every_drawing_is_used():
    names = [equation.name for equation in EQUATIONS]
    assert len(set(names)) == len(names)
    assert {file.name for file in FOLDER.iterdir()} == {f"{name}.svg" for name in names}


@of_every_equation
def test_a_drawing_was_made_from_the_source_that_is_shown(equation: Equation):
    assert ET.fromstring(drawing_of(equation)).findtext(f"{SVG}title") == equation.tex


@of_every_equation
def test_a_drawing_is_shapes_alone(equation: Equation):
    root = ET.fromstring(drawing_of(equation))
    drawn = set()
    for element in root.iter():
        assert element.tag.removeprefix(SVG) in SHAPES
        assert set(element.attrib) <= ATTRIBUTES
        drawn.add(element.attrib.get("id"))
    used = {element.attrib["href"] for element in root.iter(f"{SVG}use")}
    assert used == {f"#{name}" for name in drawn if name}


@of_every_equation
def test_an_equation_fits_into_the_panel(equation: Equation):
    root = ET.fromstring(drawing_of(equation))
    _, _, width, height = (float(number) for number in root.attrib["viewBox"].split())
    assert root.attrib["width"] == f"{width / 1000:.3f}em"
    assert root.attrib["height"] == f"{height / 1000:.3f}em"
    assert width_of(drawing_of(equation)) <= WIDEST


@of_every_equation
def test_an_equation_can_be_read_aloud_and_has_the_letters_of_the_page(equation: Equation):
    assert re.fullmatch(r"[A-Za-z0-9 ,;]+", equation.alt)
    assert not re.search(r"\\(phi|epsilon)\b", equation.tex)  # the page has φ and ε


class Page(HTMLParser):
    """Tags and pictures of a piece of HTML."""

    def __init__(self, source: str) -> None:
        super().__init__()
        self.tags: set[str] = set()
        self.pictures: list[dict[str, str]] = []
        self.open: list[str] = []
        self.feed(source)
        self.close()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.add(tag)
        if tag == "img":
            self.pictures.append({name: value or "" for name, value in attrs})
        else:
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag


@pytest.mark.parametrize("dark", [False, True])
@of_every_derivation
def test_a_derivation_shows_its_equations_in_order(derivation: Derivation, dark: bool):
    page = Page(derivation_html(derivation, dark))
    assert page.open == []
    assert page.tags <= MARKUP
    equations = [step for step in derivation.steps if isinstance(step, Equation)]
    assert [picture["alt"] for picture in page.pictures] == [equation.alt for equation in equations]
    for picture, equation in zip(page.pictures, equations, strict=True):
        kind, data = picture["src"].split(",")
        assert kind == "data:image/svg+xml;base64"
        assert base64.b64decode(data).decode() == drawing_of(equation)
        assert ("invert" in picture["style"]) == dark
        assert re.match(r"width:[\d.]+em", picture["style"])


@of_every_derivation
def test_a_derivation_is_short_and_begins_in_plain_words(derivation: Derivation):
    assert len(re.sub(r"<[^>]*>", "", derivation.plain).split()) <= 70
    assert 2 <= len(re.findall(r"[.?](?= |$)", derivation.plain)) <= 4
    assert len(derivation.steps) <= 24


@of_every_derivation
def test_a_derivation_leads_to_code_that_exists(derivation: Derivation):
    named = re.findall(r"<code>([^<]+)</code>", derivation.look)
    assert named[-1].endswith(".py")
    module = importlib.import_module(named[-1].removesuffix(".py").replace("/", "."))
    assert all(hasattr(module, name) for name in named[:-1])


class Tab:
    """The widgets that a tab is made of."""

    def __init__(self) -> None:
        self.menu = SimpleNamespace(value="", on_update=lambda changed: setattr(self, "changed", changed))
        self.written: list[str] = []
        self.changed: Any = None

    def add_dropdown(self, label: str, options: tuple[str, ...], *, initial_value: str, hint: str) -> SimpleNamespace:
        assert label and hint and options == tuple(derivation.title for derivation in DERIVATIONS)
        self.menu.value = initial_value
        return self.menu

    def add_html(self, content: str) -> Tab:
        assert content == ""
        return self

    def __setattr__(self, name: str, value: object) -> None:
        if name == "content":
            self.written.append(str(value))
        else:
            super().__setattr__(name, value)


def test_the_tab_shows_what_is_chosen_and_draws_again_when_the_page_turns_dark():
    tab = Tab()
    derivations = Derivations(cast(viser.GuiApi, tab))
    tab.menu.value = DERIVATIONS[3].title
    tab.changed(None)
    for dark in (False, True, True, False):
        derivations.draw(dark)
    expected = [(DERIVATIONS[0], False), (DERIVATIONS[3], False), (DERIVATIONS[3], True), (DERIVATIONS[3], False)]
    assert tab.written == [derivation_html(*shown) for shown in expected]


# What they say


def hat(v: FloatArray) -> DoubleArray:
    return np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]], dtype=np.float64)


@pytest.mark.parametrize("angle", [0.1, 1.0, 3.0])
def test_poses_are_what_the_formulas_say(angle: float):
    rng = np.random.default_rng(0)
    u, rho, p = rng.normal(size=(3, 3))
    u /= np.linalg.norm(u)
    U, eye = hat(u), np.eye(3)
    np.testing.assert_allclose(hat(u) @ p, np.cross(u, p))
    np.testing.assert_allclose(U @ U @ U, -U, atol=1e-12)
    T = poses.exp(np.concatenate([rho, angle * u]))
    R, t = T[:3, :3], T[:3, 3]
    twist = np.zeros((4, 4))
    twist[:3, :3], twist[:3, 3] = angle * U, rho
    np.testing.assert_allclose(expm(twist), T, atol=1e-12)
    np.testing.assert_allclose(eye + np.sin(angle) * U + (1 - np.cos(angle)) * U @ U, R, atol=1e-12)
    V = eye + (1 - np.cos(angle)) / angle * U + (1 - np.sin(angle) / angle) * U @ U
    np.testing.assert_allclose(V @ rho, t, atol=1e-12)
    turns = [expm(tau * angle * U) for tau in (np.arange(400) + 0.5) / 400]
    np.testing.assert_allclose(np.mean(turns, axis=0), V, atol=1e-5)
    np.testing.assert_allclose((np.trace(R) - 1) / 2, np.cos(angle))
    np.testing.assert_allclose((R - R.T) / (2 * np.sin(angle)), U, atol=1e-10)
    np.testing.assert_allclose(poses.log(T), np.concatenate([np.linalg.inv(V) @ t, angle * u]), atol=1e-10)


def drawn_scenes(count: int) -> tuple[FloatArray, FloatArray]:
    """What is wrong with the first poses of training scenes, and their histograms."""
    cloud = shipped_cloud("bunny")
    scenes, x_true = training_scenes(cloud, ido.TrainingSettings(samples=count))
    histogram = ido.FrontBack(ido.Model.of(cloud, n_points=60))
    x = np.zeros_like(x_true)
    return x - x_true, histogram.batch(SceneBatch.of([scenes[i] for i in range(count)]), x).astype(np.float64)


def objective(D: FloatArray, e: FloatArray, h: FloatArray, ridge: float) -> float:
    return float(((e - h @ D.T) ** 2).sum(axis=1).mean() + ridge * (D**2).sum())


def as_printed(e: FloatArray, h: FloatArray, ridge: float) -> DoubleArray:
    return np.mean([np.outer(-e_i, h_i) / (ridge + h_i @ h_i) for e_i, h_i in zip(e, h, strict=True)], axis=0)


def test_the_learned_map_is_where_the_gradient_is_zero_and_the_error_falls():
    e, h = drawn_scenes(200)
    ridge = 0.01
    D = solve(h.astype(np.float32), e, ridge).astype(np.float64)
    gradient = -2 / len(e) * (e - h @ D.T).T @ h + 2 * ridge * D
    assert np.abs(gradient).max() < 1e-4
    assert objective(D, e, h, ridge) <= (e**2).sum(axis=1).mean()
    rng = np.random.default_rng(0)
    assert all(
        objective(D + 0.1 * rng.normal(size=D.shape), e, h, ridge) > objective(D, e, h, ridge) for _ in range(20)
    )


def test_the_printed_map_is_right_for_one_scene_but_for_the_sign_and_wrong_for_more():
    e, h = drawn_scenes(200)
    ridge = 0.01
    one = solve(h[:1].astype(np.float32), e[:1], ridge)
    np.testing.assert_allclose(-as_printed(e[:1], h[:1], ridge), one, atol=1e-5)
    best = objective(solve(h.astype(np.float32), e, ridge), e, h, ridge)
    printed = as_printed(e, h, ridge)
    assert objective(-printed, e, h, ridge) > 1.1 * best
    assert objective(printed, e, h, 0.0) > objective(np.zeros_like(printed), e, h, 0.0)  # it leads away


def test_the_weight_has_the_told_values():
    assert SIGMA2 == 0.03
    assert [round(float(np.exp(-(d**2) / SIGMA2)), 4) for d in (0.1732, 0.5)] == [0.3679, 0.0002]
    assert SMALLEST_WEIGHT == 1e-6


def test_the_bins_are_what_the_formulas_say():
    rng = np.random.default_rng(0)
    model = ido.Model.of(shipped_cloud("bunny"), n_points=40)
    scene, x = rng.normal(0, 0.5, (30, 3)).astype(np.float32), rng.normal(0, 0.3, 6)
    T = poses.exp(x)
    moved = np.array([T[:3, :3] @ s + T[:3, 3] for s in scene])
    bins = np.zeros((6, 40))
    for a, (m, n) in enumerate(zip(model.points.astype(float), model.normals.astype(float), strict=True)):
        for s in moved:
            weight = np.exp(-((s - m) @ (s - m)) / 0.03)
            bins[0 if n @ (s - m) > 0 else 1, a] += weight
            bins[2 if elevation(s[None])[0] > elevation(m[None])[0] else 3, a] += 1
            bins[4 if azimuth(s[None])[0] > azimuth(m[None])[0] else 5, a] += 1
    blocks = bins.reshape(3, -1)
    expected = (blocks / np.linalg.norm(blocks, axis=1, keepdims=True)).reshape(-1)
    np.testing.assert_allclose(ido.TripleBinary(model)(scene, x), expected, atol=1e-4)


def test_a_greater_azimuth_lies_anticlockwise_from_the_tip_of_z():
    x_axis, y_axis = np.array([[1.0, 0, 0]]), np.array([[0, 1.0, 0]])
    assert azimuth(y_axis)[0] > azimuth(x_axis)[0]
    assert np.cross(x_axis[0], y_axis[0])[2] > 0


def test_most_points_of_the_bunny_have_less_than_a_tenth_of_it_in_front():
    histogram = shipped_maps("bunny", "as-printed").histogram
    assert isinstance(histogram, AsPrinted)
    assert (histogram.weights[0] < 0.1).mean() > 0.5


def test_shares_add_up_as_told():
    maps = shipped_maps("bunny", "front-back")
    histogram, D = maps.histogram, maps.maps[3].astype(np.float64)
    h = histogram(ido.perturb(shipped_cloud("bunny"), ido.Perturbation()).points, np.zeros(6))
    shares = Attribution.of(D, histogram, h)
    np.testing.assert_allclose(shares.update, -D @ h)
    np.testing.assert_allclose(shares.along().sum(), np.linalg.norm(D @ h))
    against = Attribution.of(D, histogram, h, against_reference=True)
    np.testing.assert_allclose(against.update, shares.update + D @ histogram.reference, atol=1e-9)
    at_the_line = [round(float(np.linalg.norm(D @ histogram.reference)), 3) for D in maps.maps]
    assert (round(at_the_line[0], 2), at_the_line[-1]) == (0.12, 0.004)


def test_there_are_as_many_maps_as_told_and_a_lesson_by_that_name():
    assert len(shipped_maps("bunny", "front-back").maps) == 30
    assert any(lesson.title.startswith("Learned by heart") for lesson in LESSONS)
