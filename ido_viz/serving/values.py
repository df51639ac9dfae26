"""What a browser may write into widgets: what they offer, and nothing else.

viser takes any value over before anybody is asked. So its own way of taking values is put behind a look at them.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from typing import Any

import viser
from viser._messages import GuiUpdateMessage

LONGEST_TEXT = 20_000
"""Letters of a text that is typed or pasted; our longest code has a hundredth of that."""

LARGEST_NUMBER = 2.0**53
"""Up to which numbers are exact in a browser; much larger ones cannot be sent back to it."""

AT_REST = 2.0
"""Seconds without another value after which a widget is answered, or answered once more."""

_SHOWN = 40  # letters of a value in a message


def refuse_nonsense(client: viser.ClientHandle, tell: Callable[[str], object]) -> None:
    """Have values refused that a page's widgets do not offer.

    The browser is answered with the value that the widget has. A number out of range may be the first digits of another
    one, so that is told when the widget is at rest. It then has the nearest number that it can have: until then it has
    that of the digits before. What a browser sent before a value of the server's came is taken, but not shown there any
    more. So a number, and what was refused, is told once more at rest, too.

    Args:
        client: the page.
        tell: called with a sentence on what was refused and why.
    """
    gui: Any = client.gui
    connection, take_over = gui._websock_interface, gui._handle_gui_updates
    ends: set[asyncio.Task[None]] = set()  # or nothing would keep them
    # Of each widget that is to be answered: since when, what is wrong, and the number that was refused.
    moved: dict[str, tuple[float, str | None, object]] = {}

    def answer(uuid: str, reason: str | None) -> None:
        widget = gui._gui_input_handle_from_uuid.get(uuid)
        if widget is not None:
            connection.queue_message(GuiUpdateMessage(uuid, {"value": widget.value}))
            if reason is not None:
                tell(f"{widget.label}: {reason}")

    def look(client_id: Any, uuid: str, loop: asyncio.AbstractEventLoop) -> None:
        at, reason, refused = moved[uuid]
        if loop.time() < at + AT_REST:  # a hand drags it on
            loop.call_at(at + AT_REST, look, client_id, uuid, loop)
        else:
            del moved[uuid]
            ending = loop.create_task(end(client_id, uuid, reason, refused))
            ends.add(ending)
            ending.add_done_callback(ends.discard)

    async def end(client_id: Any, uuid: str, reason: str | None, refused: object) -> None:
        widget = gui._gui_input_handle_from_uuid.get(uuid)
        nearest = None if refused is None or widget is None or widget.disabled else _nearest(widget, refused)
        if nearest is not None:  # of the range that it has now
            await take_over(client_id, GuiUpdateMessage(uuid, {"value": nearest}))
            reason = f"{reason} It is {nearest:g} now."
        answer(uuid, reason)

    def answer_at_rest(client_id: Any, uuid: str, reason: str | None = None, refused: object = None) -> None:
        loop = asyncio.get_running_loop()
        if uuid not in moved:
            loop.call_later(AT_REST, look, client_id, uuid, loop)
        moved[uuid] = (loop.time(), reason, refused)

    async def take(client_id: Any, message: GuiUpdateMessage) -> None:
        widget, value = gui._gui_input_handle_from_uuid.get(message.uuid), message.updates.get("value")
        reason = None if widget is None else refusal(widget, value)
        if widget is None or reason is None:
            if widget is not None:
                widget._impl.sync_cb = None  # viser would tell the other pages, and there are none: it wakes the sender
            await take_over(client_id, message)
            if message.uuid in moved or _is_number(value):
                answer_at_rest(client_id, message.uuid)
        elif _is_number(value) and _is_number(widget.value) and not widget.disabled:
            answer_at_rest(client_id, message.uuid, reason, value)
        else:
            if not widget._impl.is_button:
                answer(message.uuid, None)
                answer_at_rest(client_id, message.uuid)
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
    low, high = getattr(widget, "min", None), getattr(widget, "max", None)
    if low is not None and value < low:
        return f"{_shown(value)} is too small; the least is {low:g}."
    if high is not None and value > high:
        return f"{_shown(value)} is too large; the most is {high:g}."
    return None


def _nearest(widget: Any, value: Any) -> float | None:
    """The number in a widget's range that is nearest to one out of range; None where that is none that we can tell."""
    low, high = getattr(widget, "min", None), getattr(widget, "max", None)
    return low if low is not None and value < low else high if high is not None and value > high else None


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _shown(value: object) -> str:
    text = repr(value)
    return text if len(text) <= _SHOWN else f"{text[: _SHOWN - 1]}…"
