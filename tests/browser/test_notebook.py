"""The example notebook runs, and the page in its cells is the explorer."""

from __future__ import annotations

import re
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from pathlib import Path

import nbformat
import pytest
from browser_pages import new_page
from nbclient import NotebookClient
from playwright.sync_api import Browser

NOTEBOOK = Path(__file__).parents[2] / "assets" / "examples" / "07_notebook.ipynb"


@pytest.mark.filterwarnings("ignore::DeprecationWarning")
def test_the_example_notebook_shows_the_explorer_in_its_cells(browser: Browser):
    notebook = nbformat.read(NOTEBOOK, as_version=4)
    client = NotebookClient(notebook, timeout=120)
    shown = 0
    with ThreadPoolExecutor(1) as thread, ExitStack() as kernel:  # the browser's event loop lives in this thread
        thread.submit(kernel.enter_context, client.setup_kernel()).result()
        for number, cell in enumerate(notebook.cells):
            if cell.cell_type != "code":
                continue
            thread.submit(client.execute_cell, cell, number).result()
            for output in cell.outputs:
                if "text/html" in output.get("data", {}):
                    expect_an_explorer(browser, output["data"]["text/html"], first=shown == 0)
                    shown += 1
        thread.submit(kernel.close).result()
    assert shown == 2
    printed = "".join(output.get("text", "") for cell in notebook.cells for output in cell.get("outputs", []))
    assert re.search(r"^DO: .* PointAcc \d\.\d\d\nImproved DO: .* PointAcc", printed)


def expect_an_explorer(browser: Browser, cell: str, *, first: bool) -> None:
    page = new_page(browser, viewport={"width": 1300, "height": 900})
    page.set_content(f"<body>{cell}</body>")
    frame = page.frame_locator("iframe")
    frame.get_by_role("row", name="PointRMSE").wait_for(timeout=60_000)
    head = frame.locator("table.readout tr").first.inner_text().split("\t")
    assert [name.strip() for name in head if name.strip()] == (
        ["DO", "Improved DO"] if first else ["300 scenes", "3,000 scenes"]
    )
    page.close()
