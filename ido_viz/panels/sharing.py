"""The page as a link and as a short code, and what a lecturer takes off it."""

from __future__ import annotations

import html
import threading
import uuid
from collections.abc import Callable
from typing import Any, get_args

import segno
import viser

from ido_viz.core.actions import Actions, plain
from ido_viz.core.address import Fragment, opens_elsewhere, shared
from ido_viz.core.state import Part, State, encode
from ido_viz.panels.markup import caption

_HIDING = caption(
    "What is ticked disappears for whoever opens the link or the code. <i>Show all parts</i>, in the menu of commands "
    "at the top, brings it back."
)
_PARTS: dict[Part, str] = {
    "lessons": "The menu of lessons.",
    "presets": "The prepared pages.",
    "scores": "All that tells how well a method does: the numbers, the panes' scores, and the tabs Errors, Compare and "
    "Sweeps.",
    "scene": "The sliders that perturb the scene.",
    "methods": "The choice of methods and when they stop.",
    "view": "Orders, overlays and the look of the page.",
    "share": "This folder, so that nobody can bring back the others by accident.",
    "download": "The files to take along.",
    "upper charts": "Histograms, training and explanations.",
    "lower charts": "Maps, errors, comparisons, sweeps and Inspect.",
}


_ONLY_HERE = (
    "Only this machine can open this page. To let a class in, start the explorer with "
    "`ido-viz --host 0.0.0.0`; then the code to scan appears here."
)


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


class ShareFolder:
    """The link and the code of the page, and a box for each part that can be hidden.

    Args:
        gui: where they are placed.
        state: what the page begins with.
        actions: what a pasted code does.
        changed: called when a person ticks a box.
        order: place among the page's folders.
    """

    def __init__(
        self,
        gui: viser.GuiApi,
        state: State,
        actions: Actions,
        changed: Callable[[viser.GuiEvent[Any]], None],
        order: float,
    ) -> None:
        self._gui = gui
        self._actions = actions
        self._hidden: dict[Part, viser.GuiCheckboxHandle] = {}
        self._written: str | None = None
        self._address = AddressBar(gui)  # outside the folder, which may be hidden
        self.folder = gui.add_folder("Share", order=order)
        with self.folder:
            ways = {"Copy link": self._copy_link, "QR code": self._show_qr}
            gui.add_button_group(
                "Page", tuple(ways), hint="The link opens exactly this page, as does the address of the browser."
            ).on_click(lambda event: ways[event.target.value](event))
            self._code = gui.add_text("State", "", hint="Copy this code, or paste one to get exactly its page.")
            self._code.on_update(self._pasted)
            with gui.add_folder("For a class"):
                gui.add_html(_HIDING)
                for part in get_args(Part):
                    box = gui.add_checkbox(f"Hide {part}", part in state.hidden, hint=_PARTS[part])
                    box.on_update(changed)
                    self._hidden[part] = box
        gui.add_command("Show all parts").on_trigger(plain(actions.show_all))

    @property
    def hidden(self) -> tuple[Part, ...]:
        """The parts whose boxes are ticked."""
        return tuple(part for part, box in self._hidden.items() if box.value)

    def show(self, state: State) -> None:
        """Tick the boxes as a state has it."""
        for part, box in self._hidden.items():
            if box.value != (part in state.hidden):
                box.value = part in state.hidden

    def share(self, state: State, step: str) -> None:
        """Write a state's code, and make it, with the step of a lesson that is read, the page's address."""
        code = encode(shared(state))
        self._address.show(str(Fragment(code, step)))
        if code != self._written:
            self._written = self._code.value = code

    def _pasted(self, event: viser.GuiEvent[Any]) -> None:
        if event.client is not None and event.target.value.strip():  # else it was cleared, to paste another
            self._written = None  # whatever becomes of it, the page's own code comes back
            self._actions.apply_code(event.target.value)

    def _copy_link(self, event: viser.GuiEvent[Any]) -> None:
        link = self._actions.link()
        self._address.copy(link)
        if event.client is not None:
            event.client.add_notification("Link copied", link, auto_close_seconds=8.0)

    def _show_qr(self, _: viser.GuiEvent[Any]) -> None:
        link = self._actions.link()
        with self._gui.add_modal("QR code of this page" if opens_elsewhere(link) else "No QR code yet") as window:
            if opens_elsewhere(link):
                self._gui.add_html(qr_html(link))
            else:
                self._gui.add_markdown(_ONLY_HERE)
            self._gui.add_button("Close", hint="Back to the page.").on_click(plain(window.close))


def qr_html(link: str) -> str:
    """A link to be scanned from across a room, and to be read."""
    drawn = segno.make_qr(link, error="l").svg_inline(border=4, dark="#000", light="#fff", omitsize=True)
    return f'{drawn}<div style="overflow-wrap:anywhere;font-size:0.75rem;margin:4px 8px">{html.escape(link)}</div>'
