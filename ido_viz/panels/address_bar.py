"""The browser's address bar and its clipboard, as far as a page can reach them."""

from __future__ import annotations

import html
import threading
import uuid

import viser


class AddressBar:
    """What the script in the page reads, `ido_viz/serving/address.js`: the address's fragment, and what to copy."""

    def __init__(self, gui: viser.GuiApi) -> None:
        self._element = gui.add_html("")
        self._data = {"fragment": "", "link": "", "copy": ""}
        self._lock = threading.Lock()  # clicks come on other threads than frames

    def show(self, fragment: str) -> None:
        """Make it the fragment of the browser's address."""
        if fragment != self._data["fragment"]:
            self._write(fragment=fragment)

    def copy(self, link: str) -> None:
        """Put a link into the browser's clipboard."""
        self._write(link=link, copy=uuid.uuid4().hex)  # the same link can be copied again

    def _write(self, **data: str) -> None:
        with self._lock:
            self._data |= data
            attributes = " ".join(f'data-{name}="{html.escape(value)}"' for name, value in self._data.items())
            self._element.content = f"<span hidden {attributes}></span>"
