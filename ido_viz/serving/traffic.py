"""A connection that takes from its browser what a page sends, and no more."""

from __future__ import annotations

import asyncio
import time
from typing import Any, TypeGuard

import msgspec
from websockets.asyncio.server import ServerConnection
from websockets.typing import Data

from ido_viz.serving.uploads import UploadGate

LARGEST = 2**20
"""Bytes of a message; a part of an upload has half of that."""

_LARGEST_ELSE = 2**18  # a page that was dragged about sent 223 at most, and what is pasted is longer

RATE = 250
"""Messages a second that are taken in the long run; a page whose camera was dragged about sent 49 at most."""

BURST = 500
"""Messages that are taken at once."""

_USED = frozenset(
    {
        "ViewerCameraMessage",
        "GuiUpdateMessage",
        "CommandTriggerMessage",
        "ScenePointerMessage",
        "TransformControlsUpdateMessage",
        "TransformControlsDragStartMessage",
        "TransformControlsDragEndMessage",
    }
)
"""Kinds that our pages may send; viser acts on more: forms that it repeats to all, requests for a tunnel."""

_UPLOAD = frozenset({"FileTransferStartUpload", "FileTransferPart"})
"""Kinds that go through the gate for uploads."""


class _Head(msgspec.Struct):
    """What is looked at of a message."""

    type: str
    updates: dict[str, Any] = {}  # of a widget


class BoundedConnection(ServerConnection):
    """Drops what a page of ours would not send, and reads no faster than `RATE`: the browser has to wait."""

    def __init__(self, *arguments: Any, **settings: Any) -> None:
        super().__init__(*arguments, **settings)
        self._allowance = float(BURST)
        self._counted = time.monotonic()
        self._uploads = UploadGate()

    async def recv(self, decode: bool | None = None) -> Data:  # type: ignore[override]
        """The next message that is let through."""
        while True:
            message = await super().recv(decode)
            await self._wait_for_turn()
            if is_used(message) or (is_upload(message) and self._uploads.lets_through(message)):
                return message

    async def _wait_for_turn(self) -> None:
        now = time.monotonic()
        self._allowance = min(BURST, self._allowance + (now - self._counted) * RATE) - 1
        self._counted = now
        if self._allowance < 0:
            await asyncio.sleep(-self._allowance / RATE)


def is_used(message: Data) -> bool:
    """Whether a message is of a kind that our pages send, and of a widget changes the value alone."""
    head = _head(message) if len(message) <= _LARGEST_ELSE else None
    return head is not None and head.type in _USED and head.updates.keys() <= {"value"}


def is_upload(message: Data) -> TypeGuard[bytes]:
    """Whether a message is about an upload."""
    head = _head(message)
    return head is not None and head.type in _UPLOAD


def _head(message: Data) -> _Head | None:
    if not isinstance(message, bytes):
        return None
    try:
        return msgspec.msgpack.decode(message, type=_Head)
    except msgspec.MsgspecError:
        return None
