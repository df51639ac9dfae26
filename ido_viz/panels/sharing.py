"""The page as a short code, and what a lecturer takes off it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, get_args

import viser

from ido_viz.core.actions import Actions, plain
from ido_viz.core.state import Part, State, encode
from ido_viz.panels.markup import caption

_HIDING = caption(
    "What is ticked disappears for whoever opens the code above. <i>Show all parts</i>, in the menu of commands at the "
    "top, brings it back."
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


class ShareFolder:
    """The code of the page, and a box for each part that can be hidden.

    Args:
        gui: where they are placed.
        state: what the page begins with.
        actions: what a pasted code does.
        changed: called when a person ticks a box.
    """

    def __init__(
        self,
        gui: viser.GuiApi,
        state: State,
        actions: Actions,
        changed: Callable[[viser.GuiEvent[Any]], None],
    ) -> None:
        self._hidden: dict[Part, viser.GuiCheckboxHandle] = {}
        self._code = gui.add_text("State", "", hint="Copy this code, or paste one to get exactly its page.")
        self._code.on_update(lambda event: actions.apply_code(event.target.value) if event.client else None)
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

    def show_code(self, state: State) -> None:
        """Write a state's code."""
        code = encode(state)
        if self._code.value != code:
            self._code.value = code
