"""The tab that shows the derivations, each with its equations as pictures."""

from __future__ import annotations

import base64
import html
import re
import threading
from functools import cache

import viser

from ido.shipped import asset
from ido_viz.teach.derivations import Derivation, Equation, derivations

_SIZE = 1.25
"""Of the equations, relative to the text."""

_STYLE = """<style>
.derivation{margin:0.2rem 0.75rem 0.75rem 0.75rem;font-size:0.8125rem;line-height:1.45}
.derivation p{margin:0.45rem 0}
.derivation i{font-family:"STIX Two Text","Times New Roman",Times,serif;font-size:1.08em;line-height:0}
.derivation sub,.derivation sup{font-size:0.8em;line-height:0}
.derivation code{font-size:0.95em;overflow-wrap:anywhere}
.derivation .plain{padding:0.4rem 0.6rem;border-left:0.2rem solid rgb(0,114,178);background:rgba(128,128,128,0.12)}
.derivation .look{padding-top:0.45rem;border-top:thin solid rgba(128,128,128,0.4)}
.derivation img{display:block;max-width:100%;margin:0.5rem auto}
</style>"""


class DerivationsTab:
    """The menu of derivations and the chosen one.

    Args:
        gui: where its widgets are placed.
    """

    def __init__(self, gui: viser.GuiApi) -> None:
        self._by_title = {derivation.title: derivation for derivation in derivations()}
        self._lock = threading.Lock()  # the choice and the theme change on two threads
        self._dark = False
        self._menu = gui.add_dropdown(
            "Derivation",
            tuple(self._by_title),
            initial_value=next(iter(self._by_title)),
            hint="First in plain words, then step by step, then where to see it.",
        )
        self._page = gui.add_html("")
        self._menu.on_update(lambda _: self._show())
        self._show()

    def draw(self, dark: bool) -> None:
        """Draw for a light or a dark page."""
        if dark != self._dark:
            self._dark = dark
            self._show()

    def _show(self) -> None:
        with self._lock:
            self._page.content = derivation_html(self._by_title[self._menu.value], self._dark)


def derivation_html(derivation: Derivation, dark: bool) -> str:
    """A derivation as HTML."""
    steps = "".join(
        equation_html(step, dark) if isinstance(step, Equation) else f"<p>{step}</p>" for step in derivation.steps
    )
    return (
        f'{_STYLE}<div class="derivation"><p class="plain">{derivation.plain}</p>{steps}'
        f'<p class="look"><b>Where to look.</b> {derivation.look}</p></div>'
    )


def equation_html(equation: Equation, dark: bool) -> str:
    """An equation as a picture that grows with the text, in the ink of the page."""
    drawing = drawing_of(equation)
    data = base64.b64encode(drawing.encode()).decode()
    ink = ";filter:invert(0.85)" if dark else ""
    return (
        f'<img alt="{html.escape(equation.alt)}" style="width:{_SIZE * width_of(drawing):.3f}em{ink}" '
        f'src="data:image/svg+xml;base64,{data}">'
    )


@cache
def drawing_of(equation: Equation) -> str:
    """The shipped SVG of an equation."""
    return (asset("equations") / f"{equation.name}.svg").read_text("utf-8")


def width_of(drawing: str) -> float:
    """Width of a drawing, em."""
    found = re.search(r'width="([\d.]+)em"', drawing)
    if found is None:
        raise ValueError("an equation's drawing does not tell its width")
    return float(found[1])
