"""The explorer in a browser: what can be seen, and what can be done with mouse and keyboard."""

from __future__ import annotations

import contextlib
import io
import re
import time
from collections.abc import Callable
from typing import get_args

import numpy as np
from any_explorer import BETWEEN_CONTROLS, PATIENCE, AnyExplorer
from PIL import Image
from playwright.sync_api import Error, FloatRect, Locator, Page, TimeoutError

from ido_viz.app import App
from ido_viz.core.address import read_fragment
from ido_viz.core.state import Part, State, decode, encode

SMALL = (1200, 700)  # software rendering takes its time for each pixel
TABS = {
    "Scene": ("Outlier kind", "Seed", "Play a change", "New seed", "Paper defaults"),
    "Learn": ("Lesson", "Only Improved DO fails"),
    "Methods": ("Left pane", "Right pane", "Stop below ε", "Most iterations"),
    "View": (
        "Reset view (V)",
        "Order bins by",
        "Histogram minus reference",
        "Maps follow the iteration",
        "Map",
        "Where it belongs",
        "Handles",
        "Error vectors",
        "Overlay",
        "At iteration",
        "Dark",
        "Large text",
    ),
    "Share": ("State", "Copy link", "QR code", *(f"Hide {part}" for part in get_args(Part))),
}
"""The tabs of the control panel and what is in each. Of the rest nothing is on the page while another is open."""

TAB_OF = {label: tab for tab, labels in TABS.items() for label in labels}

MENU_OPENS = 5000  # milliseconds within which a menu that was clicked is open

AT_THE_MOUSE = 3.0  # seconds within which a slider that was let go stands where the mouse did

NEAR = 12  # of 255: colours this close count as the same

COUNT_DRAWN_PIXELS = """canvas => {
    const data = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data;
    return data.filter((value, i) => i % 4 == 3 && value).length;
}"""

READ_TABLE = """() => [...document.querySelectorAll("table.readout tr")].map(
    row => [...row.children].map(cell => cell.textContent.trim())
)"""  # at once: the table is replaced many times a second

READ_FRAGMENT = """() => document.querySelector("[data-fragment]").dataset.fragment"""

AFTER_WHAT_IS_DUE = """() => new Promise(
    done => requestAnimationFrame(() => requestAnimationFrame(() => setTimeout(done)))
)"""  # all that was asked for the next frame has been done, and taken over

OpenExplorer = Callable[..., "Explorer"]
"""Opens a page; see `conftest.open_explorer`."""


class Explorer(AnyExplorer):
    """One open page of a browser."""

    def __init__(self, app: App, page: Page) -> None:
        self.app = app
        self.page = page
        self.errors: list[str] = []
        page.on("pageerror", self._note)
        page.set_default_timeout(PATIENCE * 1000)

    def _note(self, error: Error) -> None:
        self.errors.append(str(error))

    def leave(self) -> Page:
        """Go away, with nothing left behind in the browser; the page can be used again."""
        self.page.remove_listener("pageerror", self._note)
        self.page.evaluate("() => { sessionStorage.clear(); localStorage.clear(); }")
        self.page.goto("about:blank")
        self.page.context.clear_cookies()
        self.page.context.clear_permissions()
        return self.page

    def open(self) -> Explorer:
        """Go to the page and wait until it shows a run."""
        self.page.goto(self.app.url)
        return self.wait_ready()

    def put_back(self, state: State) -> None:
        """Make an open page like one that begins with a state: not its history, nor what was chosen inside of tabs."""
        self.page.mouse.up()
        if self.step() is not None:
            self.press("Leave")
        self.type_key("Escape")
        self.close_notifications()
        for tab in ("Histograms", "Maps", "Share"):
            self.open_tab(tab)
        self.paste(encode(state))
        self.expect_numbers(state)
        self.wait_until("its state", lambda: self.state() == state)
        self.open_tab("Scene")

    def rest(self, at_rest: bool) -> None:
        """Let a page cost nothing until it is used again, or use it again."""
        self.page.evaluate("atRest => rest(atRest)", at_rest)

    def wait_ready(self) -> Explorer:
        """Wait until the page shows a run, with nothing over it."""
        self.page.get_by_role("row", name="PointRMSE").wait_for()
        self.page.wait_for_function("!document.querySelector('#ido-splash:not(.gone)')")
        return self

    def pause(self, milliseconds: int = BETWEEN_CONTROLS) -> None:
        """Wait as people do between two controls."""
        self.page.wait_for_timeout(milliseconds)

    # What can be seen

    def readout(self) -> list[list[str]]:
        """The table of numbers, row by row."""
        return self.page.evaluate(READ_TABLE)

    def verdicts(self) -> list[str]:
        """What is said of each pane over the canvas."""
        return self.page.locator(".verdict").all_inner_texts()

    def code(self) -> str:
        """What the Share box holds."""
        return self.field("State").input_value()

    def state(self) -> State:
        """The state of the page's address: unlike the Share box, it is there whichever tab is open."""
        return decode(read_fragment(self.page.evaluate(READ_FRAGMENT)).code)

    def expect_to_agree(self) -> State:
        """Wait until the readout fits the state, see that it stays so and that the Share box has it; the state."""
        state = super().expect_to_agree()
        assert decode(self.code()) == state, "the Share box has another state than the address"
        return state

    def notifications(self) -> list[str]:
        """The messages on the page, without the browser's own about software rendering."""
        texts = self.page.get_by_role("alert").all_inner_texts()
        return [text for text in texts if "Software WebGL" not in text]

    def close_notifications(self) -> None:
        """Close all messages."""
        while self.page.get_by_role("alert").count():
            with contextlib.suppress(TimeoutError):  # it has closed itself
                self.page.get_by_role("alert").first.get_by_role("button").click(timeout=1000)
            self.pause(300)  # they fade away

    def is_playing(self) -> bool:
        """Whether the play button offers to pause."""
        return self.page.get_by_role("button", name="Pause (P)").count() == 1

    def presenter(self) -> Locator:
        """The panel of a lesson."""
        return self.page.locator("[data-dock-group]").filter(has=self.page.locator(".lesson"))

    def step(self) -> str | None:
        """Where the lesson is, in words; None when there is none."""
        shown = self.page.locator(".lesson")
        return shown.inner_text().split(" · ")[0] if shown.count() else None

    # What can be done

    def press(self, button: str) -> None:
        """Press a button, in its tab."""
        self.open_tab_of(button)
        self.page.get_by_role("button", name=button, exact=True).click()

    def type_key(self, key: str) -> None:
        """Press a key, with no text field in use."""
        self.page.evaluate("document.activeElement.blur()")
        self.page.keyboard.press(key)

    def inspect(self) -> None:
        """Open the tab Inspect and wait until it is filled: its menus have their options then."""
        self.open_tab("Inspect")
        self.page.locator("tr[data-bin]").first.wait_for()
        self.pause()

    def row(self, label: str) -> Locator:
        """The row of the control panel that has this label, in its tab."""
        self.open_tab_of(label)
        return self.page.locator("label").filter(has_text=re.compile(f"^{re.escape(label)}$")).locator("xpath=../../..")

    def field(self, label: str) -> Locator:
        """The text or number field of a row."""
        return self.row(label).locator("input:not([type=hidden]):not([type=checkbox])").last

    def slider_value(self, label: str) -> float:
        """Where a slider's thumb is."""
        return float(self.row(label).get_by_role("slider").get_attribute("aria-valuenow") or "nan")

    def drag_on_canvas(self, start: tuple[float, float], by: tuple[float, float], *, steps: int = 6) -> None:
        """Drag with the mouse, as fast as the canvas is drawn: of more than one place in a picture it takes one."""
        mouse = self.page.mouse
        mouse.move(*start)
        self.page.evaluate(AFTER_WHAT_IS_DUE)
        mouse.down()
        for step in range(1, steps + 1):
            mouse.move(start[0] + by[0] * step / steps, start[1] + by[1] * step / steps)
            self.page.evaluate(AFTER_WHAT_IS_DUE)
        mouse.up()

    def drag(self, label: str, *shares: float, steps: int = 12) -> float:
        """Drag a slider's thumb with the mouse to shares of its track, one after another; where it ends."""
        thumb = self.row(label).get_by_role("slider")
        thumb.scroll_into_view_if_needed()
        start, track = box_of(thumb), box_of(self.row(label).locator(".mantine-Slider-track"))
        y = start["y"] + start["height"] / 2
        self.page.mouse.move(start["x"] + start["width"] / 2, y)
        self.page.mouse.down()
        for share in shares:
            self.page.mouse.move(track["x"] + share * track["width"], y, steps=steps)
        self.page.mouse.up()
        self.page.evaluate(AFTER_WHAT_IS_DUE)  # the thumb goes to the mouse when the page is painted next
        x = track["x"] + min(max(shares[-1], 0.0), 1.0) * track["width"]
        seen: list[float] = []
        deadline = time.monotonic() + AT_THE_MOUSE
        while len(seen) < 2 or seen[-1] != seen[-2]:
            self.pause()
            seen.append(self.slider_value(label))
            here = box_of(thumb)
            if abs(here["x"] + here["width"] / 2 - x) > here["width"] / 2 and time.monotonic() < deadline:
                seen.clear()  # a busy browser was answered in the middle of the drag, and is answered again
        return seen[-1]

    def type_into(self, label: str, text: str) -> None:
        """Write into a field as from the keyboard, all at once, and leave it."""
        field = self.field(label)
        field.fill("")
        self.page.keyboard.insert_text(text)
        field.press("Tab")
        self.pause()

    def choose(self, label: str, option: str) -> None:
        """Choose from a menu."""
        wanted = self.page.get_by_role("option", name=option, exact=True)
        self._open_menu(label)
        try:
            wanted.click(timeout=MENU_OPENS)
        except TimeoutError:
            self._open_menu(label)
            wanted.click()
        self.pause()

    def _open_menu(self, label: str) -> None:
        """Open a menu that is not open; once more where a frame that came just then has closed it."""
        offered = self.page.get_by_role("option").first
        if offered.is_visible():
            return
        self.field(label).click()
        try:
            offered.wait_for(timeout=MENU_OPENS)
        except TimeoutError:
            self.field(label).click()
            offered.wait_for()

    def options(self, label: str) -> list[str]:
        """What a menu offers."""
        self._open_menu(label)
        offered = self.page.get_by_role("option").all_inner_texts()
        self.field(label).press("Escape")
        self.page.get_by_role("option").first.wait_for(state="hidden")
        return offered

    def tick(self, label: str) -> None:
        """Tick or untick a box."""
        self.row(label).get_by_role("checkbox").click()
        self.pause()

    def paste(self, code: str) -> None:
        """Paste a code into the Share box."""
        self.field("State").fill(code)
        self.pause()

    def open_tab(self, name: str) -> None:
        """Open a tab of a panel."""
        self.page.get_by_role("tab", name=name, exact=True).click()

    def open_tab_of(self, label: str) -> None:
        """Open the tab of the control panel that something is in, unless it is open or there is none."""
        tab = self.page.get_by_role("tab", name=TAB_OF.get(label, ""), exact=True)
        if label in TAB_OF and tab.get_attribute("aria-selected") != "true":
            tab.click()

    # Pictures

    def canvas(self) -> Locator:
        """The 3D canvas."""
        return self.page.locator("canvas[data-engine]")

    def canvas_halves(self) -> tuple[np.ndarray, np.ndarray]:
        """The pixels of the canvas's left and right half, each of shape (height, width, 3), without what is written."""
        shot = self.page.screenshot(clip=box_of(self.canvas()), style=".over-canvas { visibility: hidden; }")
        pixels = np.asarray(Image.open(io.BytesIO(shot)).convert("RGB")).astype(int)
        middle = pixels.shape[1] // 2
        return pixels[:, :middle], pixels[:, middle:]

    def charts(self) -> Locator:
        """The charts that can be seen."""
        return self.page.locator(".uplot canvas:visible")

    def chart_picture(self, number: int) -> str:
        """What a chart shows."""
        return self.charts().nth(number).evaluate("canvas => canvas.toDataURL()")

    def chart_ink(self, number: int) -> int:
        """How many pixels of a chart are drawn on."""
        return self.charts().nth(number).evaluate(COUNT_DRAWN_PIXELS)

    def heatmaps(self) -> Locator:
        """The heatmaps that can be seen."""
        return self.page.locator("img[alt='heatmap of the map']:visible")

    def heatmap_pictures(self) -> list[str]:
        """The pictures of all heatmaps that can be seen."""
        return self.heatmaps().evaluate_all("images => images.map(image => image.src)")


def box_of(locator: Locator) -> FloatRect:
    """Where something is on the page."""
    box = locator.bounding_box()
    assert box is not None, f"{locator} cannot be seen"
    return box


def like(pixels: np.ndarray, color: tuple[int, int, int]) -> np.ndarray:
    """Which pixels are nearly of a colour, shape (height, width)."""
    return np.abs(pixels - np.array(color)).max(axis=2) <= NEAR
