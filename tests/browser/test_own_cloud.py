"""One's own cloud in a real page: from the file to the panes, a scan of it, and its end."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from any_explorer import AT_THE_START
from browser_pages import BrowserPages
from explorer import SMALL, Explorer
from playwright.sync_api import expect

from ido import Cloud
from ido_viz.app import App
from ido_viz.own.plans import PLANS, Plan

NAME = "<b>half bunny</b>"


@pytest.fixture
def explorer(browser_pages: BrowserPages, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Explorer]:
    """A page whose quick training is very quick."""
    monkeypatch.setitem(PLANS, "quick", Plan(20.0, 3, 100))
    app = App(replace(AT_THE_START, dark=True), port=0, data=tmp_path / "data")
    explorer = Explorer(app, browser_pages.take(SMALL, draws=False))
    yield explorer.open()
    browser_pages.give_back(explorer.leave(), draws=False)
    app.stop()
    assert explorer.errors == []


def upload(explorer: Explorer, button: str, file: Path) -> None:
    with explorer.page.expect_file_chooser() as chooser:
        explorer.page.get_by_role("button", name=button, exact=True).click()
    chooser.value.set_files(file)


def test_a_cloud_is_uploaded_trained_shown_registered_to_and_deleted(explorer: Explorer, bunny: Cloud, tmp_path: Path):
    page = explorer.page
    points = bunny.points[bunny.points[:, 0] > -0.2][::200] * 100.0
    np.savetxt(tmp_path / "cloud.xyz", points)
    np.savetxt(tmp_path / "scan.xyz", points[points[:, 1] > -40.0] + 3.0)
    explorer.open_tab("Own cloud")

    upload(explorer, "Upload a cloud", tmp_path / "cloud.xyz")
    page.get_by_text(f"{len(points)} points read").wait_for()
    assert page.locator(".over-canvas:not(.of-preview)").first.evaluate(VISIBILITY) == "hidden"
    explorer.type_into("Name", NAME)
    page.get_by_text("maps of each method on 100 scenes").wait_for()

    explorer.press("Train")
    explorer.wait_until("the shape", lambda: explorer.field("Shape").input_value() == NAME)
    page.get_by_text("trained and kept").wait_for()
    assert explorer.methods() == ("DO", "Improved DO")
    assert page.locator("b", has_text="half bunny").filter(has_not_text="<b>").count() == 0

    explorer.wait_until("its code", lambda: explorer.state().shape == NAME)

    upload(explorer, "Upload a scan", tmp_path / "scan.xyz")
    page.get_by_text("histogram distance").wait_for()
    explorer.wait_until("it on the model", lambda: explorer.row("On the model").get_by_role("checkbox").is_checked())
    page.reload()
    title, verdict = page.locator(".of-preview"), page.locator(".verdict").first
    explorer.wait_ready().open_tab("Histograms")  # the scan is seen with its title, whichever tab is open
    expect(title).to_contain_text("scan.xyz")
    expect(verdict).to_be_hidden()
    explorer.open_tab("Own cloud")
    page.get_by_text("histogram distance").wait_for()
    assert explorer.row("On the model").get_by_role("checkbox").is_checked()
    upload(explorer, "Upload a scan", Path(__file__))
    page.get_by_text("This file cannot be used").wait_for()
    expect(page.get_by_text("scan.xyz", exact=True).last).to_be_visible()  # the scan before keeps its name
    explorer.drag("Noise", 0.2)  # whoever changes the scene looks at the panes
    expect(title).to_have_count(0)
    expect(verdict).to_be_visible()
    assert not explorer.row("On the model").get_by_role("checkbox").is_checked()
    with page.expect_download() as download:
        explorer.press("Moved scan (.ply)")
    assert download.value.suggested_filename == "ido-scan-moved.ply"

    explorer.press("Delete")
    explorer.press("Delete it")
    explorer.wait_until("another shape", lambda: explorer.field("Shape").input_value() == "bunny")
    expect(page.get_by_role("alert").filter(has_text="This cloud is gone")).to_be_visible()
    assert list((tmp_path / "data").glob("*.npz")) == []


VISIBILITY = "box => getComputedStyle(box).visibility"

DROP = """(zone, [name, text]) => {
    const carried = new DataTransfer();
    carried.items.add(new File([text], name));
    for (const type of ["dragenter", "dragover", "drop"]) {
        const event = new DragEvent(type, { bubbles: true, cancelable: true, dataTransfer: carried });
        const taken = !zone.dispatchEvent(event);
        if (type === "dragover" && !taken) return false;
    }
    return true;
}"""
"""Drop a file on an element, as a browser does: only where dragging over it was taken."""


def test_a_file_is_dropped_on_the_button_or_anywhere_on_the_canvas(explorer: Explorer, bunny: Cloud):
    page = explorer.page
    rows = ["{:.4f} {:.4f} {:.4f}".format(*point) for point in bunny.points[::300]]
    assert not page.locator("canvas[data-engine]").evaluate(DROP, ["early.xyz", "\n".join(rows)]), "no tab to take it"
    explorer.open_tab("Own cloud")
    button = page.get_by_role("button", name="Upload a cloud", exact=True)
    assert button.evaluate(DROP, ["button.xyz", "\n".join(rows)])
    page.get_by_text(f"{len(rows)} points read").wait_for()
    assert explorer.field("Name").input_value() == "button"
    assert page.locator("canvas[data-engine]").evaluate(DROP, ["canvas.xyz", "\n".join(rows[:-5])])
    page.get_by_text(f"{len(rows) - 5} points read").wait_for()
    assert explorer.field("Name").input_value() == "canvas"
