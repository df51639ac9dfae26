"""Where the panels are docked, how wide they are, and how large their text is."""

from __future__ import annotations

import viser

from ido_viz.core.state import State

CONTROLS_WIDTH = 314
CHARTS_WIDTH = 390
LARGE_TEXT = 1.25
"""How much larger text is for a projector."""

# viser gives all labels the width of its widest; ours are short, and sliders must be long enough to aim with.
# Its greys and its blue are too pale to be read from the back of a room, and its scrollbars lie over what stands there.
_STYLE = """
div[style*="width: 7.25em"] { width: 5.6em !important; }
div[style*="width: 7.25em"]:has(label:empty) { display: none; }
[role=tab] { padding-inline: 0.6rem !important; }
.mantine-Button-root[data-size="compact-xs"] { --button-padding-x: 0.25rem !important; }
:root[data-mantine-color-scheme="light"] { --mantine-color-dimmed: #565d64 !important;
  --mantine-color-gray-filled: #565d64 !important; --for-text: var(--mantine-primary-color-8); }
:root[data-mantine-color-scheme="dark"] { --mantine-color-dimmed: #a9afb5 !important;
  --for-text: var(--mantine-primary-color-4); }
.mantine-Slider-markLabel, .mantine-Notification-description { color: var(--mantine-color-dimmed) !important; }
.mantine-Button-root[data-variant="outline"] { --button-color: var(--for-text) !important; }
.mantine-Notifications-root { top: 8rem !important; } /* below the names, the opening and a lesson's verdicts */
@media (max-width: 600px) { .mantine-Notifications-root { top: 4.2rem !important; } }
.mantine-ScrollArea-scrollbar[data-orientation="vertical"] { width: 7px !important; padding: 0 !important; }
[role=tab][aria-selected=true] { color: var(--for-text) !important; }
"""
_CLOSER_TABS = "[role=tab] { padding-inline: 0.35rem !important; }"  # all in one row, also with large text
_WIDER = 1.14  # panels are then, less than the text, for the canvas needs its room


class Placing:
    """The main panel on the left, and two panels of charts on the right.

    Args:
        gui: whose panels they are.
        upper: the upper one on the right.
        lower: the lower one.
    """

    def __init__(self, gui: viser.GuiApi, upper: viser.PanelHandle, lower: viser.PanelHandle) -> None:
        self._main = gui.main_panel
        self._right = (upper, lower)
        self._style = gui.add_html("")
        self._look: tuple[bool, ...] | None = None

    def draw(self, state: State) -> None:
        """Set the size that all text is relative to, and show the panels that are not hidden, as wide as it needs."""
        shown = ("upper charts" not in state.hidden, "lower charts" not in state.hidden)
        if (*shown, state.large_text) == self._look:
            return
        self._look = (*shown, state.large_text)
        scale = LARGE_TEXT if state.large_text else 1.0
        self._style.content = (
            f"<style>html{{font-size:{100 * scale:g}%}}{_STYLE}{_CLOSER_TABS if state.large_text else ''}</style>"
        )
        wider = _WIDER if state.large_text else 1.0
        self._main.set_width(round(CONTROLS_WIDTH * wider))
        above = None
        for panel, visible in zip(self._right, shown, strict=True):
            panel.visible = visible
            if not visible:
                continue
            if above is None:  # a panel that was hidden has lost its place
                panel.dock_right()
            else:
                panel.dock_below(above)
            above = panel
        if above is not None:
            above.set_width(round(CHARTS_WIDTH * wider))
