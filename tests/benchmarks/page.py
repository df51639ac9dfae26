"""What the page costs: until it is first painted, while it plays, and while a slider is dragged.

    python tests/benchmarks/page.py [--size 1440x900] [--seconds 6]

Needs Chromium (see tests/browser/conftest.py), which may draw in software. Only figures of one machine in one run can
be compared: copy this file into another clone to measure two versions of the code in turn.
"""

from __future__ import annotations

import os
import sys
import time
from pathlib import Path
from typing import Any

began = time.perf_counter()  # before what takes long to import, as for a person who gives the command

import numpy as np  # noqa: E402
import websockets.asyncio.connection  # noqa: E402
from playwright.sync_api import Page as BrowserPage  # noqa: E402
from playwright.sync_api import ViewportSize, sync_playwright  # noqa: E402

from ido_viz import page, requests  # noqa: E402
from ido_viz.app import App  # noqa: E402
from ido_viz.core.state import State  # noqa: E402

sys.path.insert(0, str(Path(__file__).parents[1] / "browser"))
sys.path.insert(0, str(Path(__file__).parents[1] / "helpers"))

COUNT_FRAMES = """window.painted = 0; (function count() { window.painted++; requestAnimationFrame(count); })()"""
SLIDER = "xpath=//label[.='Rotation']/../../..//*[@role='slider']"


class Watch:
    """What the server does, noted as it does it."""

    def __init__(self) -> None:
        self.bytes = 0
        self.frames = 0
        self.asked: float | None = None
        self.waited: list[float] = []
        send = websockets.asyncio.connection.Connection.send
        draw, changed = page.Page.draw, requests.Requests._changed

        async def counted(connection: Any, message: Any, *rest: Any, **options: Any) -> None:
            self.bytes += len(message)
            await send(connection, message, *rest, **options)

        def drawn(of: Any, *rest: Any, **options: Any) -> None:
            draw(of, *rest, **options)
            self.frames += 1
            if self.asked is not None:
                self.waited.append(time.perf_counter() - self.asked)
                self.asked = None

        def asked(of: Any) -> None:
            if self.asked is None:
                self.asked = time.perf_counter()
            changed(of)

        websockets.asyncio.connection.Connection.send = counted  # type: ignore[method-assign]
        page.Page.draw, requests.Requests._changed = drawn, asked  # type: ignore[method-assign]


def measure(size: tuple[int, int], seconds: float) -> None:
    """Print the figures."""
    from conftest import FLAGS, chromium  # pyright: ignore[reportMissingImports, reportAttributeAccessIssue]

    watch = Watch()
    app = App(State(), port=0)
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium(), args=FLAGS)
        tab = browser.new_page(viewport=ViewportSize(width=size[0], height=size[1]))
        tab.goto(app.url)
        tab.get_by_role("row", name="PointRMSE").wait_for(timeout=60_000)
        print(f"first painted numbers after {time.perf_counter() - began:.1f} s")
        play(tab, watch, seconds)
        drag(tab, watch, seconds)
        browser.close()
    app.stop()


def play(tab: BrowserPage, watch: Watch, seconds: float) -> None:
    """Frames and bytes a second while it plays, the first panels open."""
    tab.get_by_role("button", name="First (R)").click()
    tab.wait_for_timeout(500)
    tab.get_by_role("button", name="Play (P)").click()
    tab.evaluate(COUNT_FRAMES)
    bytes_before = watch.bytes
    tab.wait_for_timeout(1000 * seconds / 2)
    painted = tab.evaluate("window.painted")
    sent = watch.bytes - bytes_before
    print(f"playing: {2 * painted / seconds:.0f} frames/s painted, {2 * sent / seconds / 1e3:.0f} kB/s sent")


def drag(tab: BrowserPage, watch: Watch, seconds: float) -> None:
    """From a slider's message to the frame, and bytes of a frame."""
    tab.get_by_role("button", name="Last").click()
    tab.wait_for_timeout(1000)
    thumb = tab.locator(SLIDER)
    thumb.scroll_into_view_if_needed()
    box = thumb.bounding_box()
    assert box is not None
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    tab.mouse.move(x, y)
    tab.mouse.down()
    watch.waited.clear()
    bytes_before, frames_before, ends = watch.bytes, watch.frames, time.perf_counter() + seconds
    step = 0
    while time.perf_counter() < ends:
        step += 1
        tab.mouse.move(x + 30 * np.sin(step / 4), y)
        tab.wait_for_timeout(60)
    tab.mouse.up()
    waited = 1e3 * np.array(watch.waited)
    frames = max(watch.frames - frames_before, 1)
    half, most = np.quantile(waited, (0.5, 0.9))
    print(
        f"dragging: {len(waited)} messages to a frame in {half:.0f} ms (median), {most:.0f} (nine of ten), "
        f"{waited.max():.0f} (worst); {(watch.bytes - bytes_before) / frames / 1e3:.1f} kB a frame"
    )


if __name__ == "__main__":
    wanted = dict(zip(sys.argv[1::2], sys.argv[2::2], strict=True))
    width, height = (int(n) for n in wanted.get("--size", "1440x900").split("x"))
    os.environ.setdefault("CHROMIUM", "/usr/bin/chromium")
    measure((width, height), float(wanted.get("--seconds", "6")))
