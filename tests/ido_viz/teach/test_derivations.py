"""The derivations: their drawings ship and are up to date, and the page shows them."""

from __future__ import annotations

import base64
import importlib
import re
import xml.etree.ElementTree as ET
from html.parser import HTMLParser
from types import SimpleNamespace
from typing import Any, cast

import pytest
import viser

from ido.shipped import asset
from ido_viz.teach.derivations import Derivation, Equation, derivations, equations_of
from ido_viz.teach.derivations_tab import DerivationsTab, derivation_html, drawing_of, width_of

DERIVATIONS = derivations()
EQUATIONS = equations_of(DERIVATIONS)

WIDEST = 22.5
"""Widest drawing that fits into the panel without being made smaller, em."""

FOLDER = asset("equations")
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
    shown = DerivationsTab(cast(viser.GuiApi, tab))
    tab.menu.value = DERIVATIONS[3].title
    tab.changed(None)
    for dark in (False, True, True, False):
        shown.draw(dark)
    expected = [(DERIVATIONS[0], False), (DERIVATIONS[3], False), (DERIVATIONS[3], True), (DERIVATIONS[3], False)]
    assert tab.written == [derivation_html(*each) for each in expected]
