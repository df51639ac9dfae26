"""What a browser may write into widgets: what they offer, and nothing else.

viser takes any value over before anybody is asked. So its own way of taking values is put behind a look at them.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import viser
from viser._messages import GuiUpdateMessage

LONGEST_TEXT = 20_000
"""Letters of a text that is typed or pasted; our longest code has a hundredth of that."""

LARGEST_NUMBER = 2.0**53
"""Up to which numbers are exact in a browser; much larger ones cannot be sent back to it."""

_SHOWN = 40  # letters of a value in a message


def refuse_nonsense(client: viser.ClientHandle, tell: Callable[[str], object]) -> None:
    """Have values refused that a page's widgets do not offer.

    Args:
        client: the page.
        tell: called with a sentence on what was refused and why.
    """
    gui: Any = client.gui
    connection, take_over = gui._websock_interface, gui._handle_gui_updates

    async def take(client_id: Any, message: GuiUpdateMessage) -> None:
        widget = gui._gui_input_handle_from_uuid.get(message.uuid)
        reason = None if widget is None else refusal(widget, message.updates.get("value"))
        if widget is None or reason is None:
            await take_over(client_id, message)
            return
        if not widget._impl.is_button:  # the browser shows again what it was
            connection.queue_message(GuiUpdateMessage(message.uuid, {"value": widget.value}))
        tell(f"{widget.label}: {reason}")

    connection.unregister_handler(GuiUpdateMessage, take_over)
    connection.register_handler(GuiUpdateMessage, take)


def refusal(widget: Any, value: object) -> str | None:
    """Why a widget cannot have a value, in a sentence; None if it can.

    Args:
        widget: as viser's handles are: one with options, with limits, or of text or a tick.
        value: from a browser.
    """
    if widget.disabled:
        return "it cannot be used just now."
    options = getattr(widget, "options", None)
    if options is not None:
        return None if value in options else f"{_shown(value)} is not on offer; choose from the list."
    now = widget.value
    if isinstance(now, viser.UploadedFile):
        return "a file is chosen with its button."
    if isinstance(now, str):
        usable = isinstance(value, str) and len(value) <= LONGEST_TEXT
        return None if usable else f"it takes text, of {LONGEST_TEXT} letters at most."
    if isinstance(now, bool):
        return None if isinstance(value, bool) else f"{_shown(value)} is neither on nor off."
    if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) <= LARGEST_NUMBER:
        return f"{_shown(value)} is not a number."
    if isinstance(widget, viser.GuiSliderHandle) and not widget.min <= value <= widget.max:
        return f"{_shown(value)} does not lie between {widget.min:g} and {widget.max:g}."
    return None


def _shown(value: object) -> str:
    text = repr(value)
    return text if len(text) <= _SHOWN else f"{text[: _SHOWN - 1]}…"
