"""The page as a link and as a short code, and what a lecturer takes off it."""

from __future__ import annotations

import html
from typing import get_args

import viser

from ido_viz.core.actions import Actions, at_once, plain
from ido_viz.core.address import opens_elsewhere, shared
from ido_viz.core.state import Part, State, encode
from ido_viz.panels.markup import caption

_HIDING = caption(
    "What is ticked disappears here and for whoever opens the link or the code. <i>Show all parts</i>, in the menu of "
    "commands at the top, brings it back."
)
_PARTS: dict[Part, str] = {
    "lessons": "The menu of lessons.",
    "presets": "The prepared pages.",
    "scores": "All that tells how well a method does: the numbers, the panes' scores, and the tabs Errors, Compare, "
    "Basin and Sweeps.",
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


class ShareFolder:
    """The link and the code of the page, and a box for each part that can be hidden.

    Args:
        gui: where they are placed.
        state: what the page begins with.
        actions: what a pasted code and a ticked box do.
    """

    def __init__(self, gui: viser.GuiApi, state: State, actions: Actions) -> None:
        self._gui = gui
        self._actions = actions
        self._hidden: dict[Part, viser.GuiCheckboxHandle] = {}
        self._written: str | None = None
        ways = {"Copy link": actions.copy_link, "QR code": self._show_qr}
        gui.add_button_group(
            "Page", tuple(ways), hint="The link opens exactly this page, as does the address of the browser."
        ).on_click(lambda event: ways[event.target.value]())
        self._code = gui.add_text("State", "", hint="Copy this code, or paste one to get exactly its page.")
        self._code.on_update(at_once(self._pasted))  # the page writes there, too
        with gui.add_folder("For a class"):
            gui.add_html(_HIDING)
            for part in get_args(Part):
                box = gui.add_checkbox(f"Hide {part}", part in state.hidden, hint=_PARTS[part])
                box.on_update(at_once(lambda _: actions.changed()))
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

    def show_code(self, state: State) -> None:
        """Write a state's code."""
        code = encode(shared(state))
        if code != self._written:
            self._written = self._code.value = code

    def _pasted(self, code: str) -> None:
        if code.strip():  # else it was cleared, to paste another
            self._written = None  # whatever becomes of it, the page's own code comes back
            self._actions.apply_code(code)

    def _show_qr(self) -> None:
        link = self._actions.link()
        with self._gui.add_modal("QR code of this page" if opens_elsewhere(link) else "No QR code yet") as window:
            if opens_elsewhere(link):
                self._gui.add_html(qr_html(link))
            else:
                self._gui.add_markdown(_ONLY_HERE)
            self._gui.add_button("Close", hint="Back to the page.").on_click(plain(window.close))


def qr_html(link: str) -> str:
    """A link to be scanned from across a room, and to be read."""
    import segno  # takes a while to import

    drawn = segno.make_qr(link, error="l").svg_inline(border=4, dark="#000", light="#fff", omitsize=True)
    return f'{drawn}<div style="overflow-wrap:anywhere;font-size:0.75rem;margin:4px 8px">{html.escape(link)}</div>'
