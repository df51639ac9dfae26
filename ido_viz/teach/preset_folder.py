"""The folder of presets: a button for each."""

from __future__ import annotations

from collections.abc import Callable

import viser

from ido_viz.core.state import State
from ido_viz.panels.markup import caption
from ido_viz.teach.presets import presets

_GROUPS = (
    (True, "Known to be registered", viser.Icon.CIRCLE_CHECK, (70, 110, 95)),
    (False, "Known to fail", viser.Icon.ALERT_TRIANGLE, (135, 95, 65)),
)
"""Good or not, with the title, the icon and the colour (white text on it can be read)."""


class PresetFolder:
    """A button for each preset.

    Args:
        gui: where they are placed.
        open_state: opens a page; called on a thread of the server.
    """

    def __init__(self, gui: viser.GuiApi, open_state: Callable[[State], None]) -> None:
        self.buttons: dict[str, viser.GuiButtonHandle] = {}
        self.folder = gui.add_folder("Presets")
        with self.folder:
            self._fill(gui, open_state)

    def _fill(self, gui: viser.GuiApi, open_state: Callable[[State], None]) -> None:
        for good, title, icon, color in _GROUPS:
            gui.add_html(caption(title))
            for preset in presets():
                if preset.good == good:
                    button = gui.add_button(preset.label, icon=icon, color=color, hint=preset.hint)
                    button.on_click(lambda _, state=preset.state: open_state(state))
                    self.buttons[preset.label] = button
