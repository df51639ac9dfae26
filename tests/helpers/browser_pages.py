"""Pages of a browser, made cheap: they can rest, and one that a test has left serves the next."""

from __future__ import annotations

from typing import Any

from playwright.sync_api import Browser, Page, ViewportSize

BETWEEN_PICTURES = 120  # milliseconds at least

WITH_RESTS = """const nextFrame = requestAnimationFrame;
const resting = [];
let drawn = 0;
const drawAt = (draw, time) => { drawn = performance.now(); draw(time); };
window.requestAnimationFrame = draw => window.atRest
    ? (resting.push(draw), 0)
    : setTimeout(() => nextFrame(time => drawAt(draw, time)), Math.max(0, drawn + BETWEEN - performance.now()));
window.cancelAnimationFrame = clearTimeout;
window.rest = atRest => {
    window.atRest = atRest;
    if (!atRest) resting.splice(0).forEach(draw => nextFrame(draw));
};""".replace("BETWEEN", str(BETWEEN_PICTURES))
"""A page that can rest: it is drawn no more, and costs nothing, until it is used again.

It is also drawn seldom, though at once after a pause: in software, pictures take most of a page's time.
"""

WITH_PLAIN_EDGES = """const take = HTMLCanvasElement.prototype.getContext;
HTMLCanvasElement.prototype.getContext = function (kind, options) {
    return take.call(this, kind, kind.startsWith("webgl") ? {...options, antialias: false} : options);
};"""
"""A page whose 3D scene has no smooth edges: in software, they take half of the time of a picture."""

WITHOUT_DRAWING = """for (const of of [WebGLRenderingContext, WebGL2RenderingContext])
    for (const name of ["clear", "drawArrays", "drawElements", "drawArraysInstanced", "drawElementsInstanced"])
        if (of.prototype[name]) of.prototype[name] = () => {};"""
"""A page's 3D scene without its pixels: drawn in software, it takes most of the time of a browser test."""


class BrowserPages:
    """Pages that tests use one after another.

    Where a browser has read the program before, it opens with half the work.
    """

    def __init__(self, browser: Browser) -> None:
        self._browser = browser
        self._left: dict[bool, list[Page]] = {True: [], False: []}

    def take(self, size: tuple[int, int], *, draws: bool) -> Page:
        """A blank page, of a size, that draws the 3D scene or not."""
        viewport = ViewportSize(width=size[0], height=size[1])
        if not self._left[draws]:
            return new_page(self._browser, draws=draws, viewport=viewport)
        page = self._left[draws].pop()
        page.set_viewport_size(viewport)
        return page

    def give_back(self, page: Page, *, draws: bool) -> None:
        """For the next test, a page that is blank again."""
        self._left[draws].append(page)


def new_page(browser: Browser, *, draws: bool = False, **options: Any) -> Page:
    """A new page that can rest; where its 3D scene is not drawn, it has few pixels, with all in the same place."""
    page = browser.new_page(device_scale_factor=1.0 if draws else 0.5, **options)
    page.add_init_script(WITH_RESTS)
    page.add_init_script(WITH_PLAIN_EDGES)
    if not draws:
        page.add_init_script(WITHOUT_DRAWING)
    return page
