"""Film the README's animation from the running explorer: `python assets/scripts/make_picture.py` (needs Chromium)."""

from __future__ import annotations

import io
import shutil
from pathlib import Path

import tyro
from PIL import Image
from playwright.sync_api import sync_playwright

from ido_viz.app import App
from ido_viz.core.state import State

FLAGS = ("--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader")
ITERATIONS = (0, 1, 2, 3, 4, 5, 6, 7, 8, 10, 12, 15, 18, 22, 26, 30, 34)
WINDOW = {"width": 1280, "height": 720}
SHOWN = (1024, 576)


def main(output: Path = Path(__file__).parents[1] / "explorer.webp", chromium: str | None = None) -> None:
    """Step through the default scene and write the frames as an animated WebP.

    Args:
        output: where the animation goes.
        chromium: the browser; the one on the PATH unless given.
    """
    app = App(State(playing=False), port=8145)
    frames = []
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium or shutil.which("chromium"), args=FLAGS)
        page = browser.new_page(viewport=WINDOW)  # type: ignore[arg-type]
        page.goto(app.url)
        page.get_by_text("PointAcc").first.wait_for()
        for notice in page.locator(".mantine-Notification-closeButton").all():  # about WebGL without a graphics card
            notice.click()
        page.wait_for_timeout(3000)
        shown = 0
        for iteration in ITERATIONS:
            while shown < iteration:
                page.keyboard.press("n")
                shown += 1
                page.wait_for_timeout(80)
            page.wait_for_timeout(1200)
            frame = Image.open(io.BytesIO(page.screenshot())).convert("RGB")
            frames.append(frame.resize(SHOWN, Image.Resampling.LANCZOS))
        browser.close()
    app.stop()
    durations = [1200, *[350] * (len(frames) - 2), 3000]
    frames[0].save(output, save_all=True, append_images=frames[1:], duration=durations, loop=0, quality=70)


if __name__ == "__main__":
    tyro.cli(main)
