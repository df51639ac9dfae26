"""A browser tab that shows nothing: it speaks to a server as viser's page does, and counts what comes back."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable, Coroutine
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from typing import Any, TypeVar
from urllib.parse import urlsplit, urlunsplit

import msgspec
import viser
import zstandard
from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import ConnectionClosed
from websockets.typing import Origin, Subprotocol

Value = TypeVar("Value")

PROTOCOL = Subprotocol(f"viser-v{viser.__version__}")
CAMERA = {
    "type": "ViewerCameraMessage",
    "wxyz": (1.0, 0.0, 0.0, 0.0),
    "position": (0.0, 0.0, 5.0),
    "fov": 1.0,
    "near": 0.01,
    "far": 1000.0,
    "image_height": 700,
    "image_width": 1200,
    "look_at": (0.0, 0.0, 0.0),
    "up_direction": (0.0, 0.0, 1.0),
}
"""A browser's first message: with it, its page begins."""

SCENE = "/left/scene/points"
"""The node whose points are sent with each new scene, and with nothing else."""

_PATIENCE = 60.0  # seconds
_HEAD = 16  # bytes before the packed messages: two lengths


class Widget(msgspec.Struct, frozen=True):
    """What the page was told of a widget; all empty but its kind where there is nothing to tell."""

    kind: str = ""
    label: str | None = None
    options: tuple[str, ...] = ()
    min: float | None = None
    max: float | None = None
    value: Any = None  # what it was set to since it came
    title: str | None = None
    body: str = ""


class Message(msgspec.Struct):
    """What a server sends; what is packed once more is left packed."""

    type: str
    uuid: str = ""
    container_uuid: str = ""
    name: str = ""
    value: msgspec.Raw = msgspec.Raw(b"")
    props: msgspec.Raw = msgspec.Raw(b"\x80")
    updates: dict[str, msgspec.Raw] = {}
    filename: str = ""


class _Window(msgspec.Struct):
    messages: list[msgspec.Raw]


@dataclass
class Counts:
    """What has come so far."""

    frames: int = 0
    bytes: int = 0
    waited: list[float] = field(default_factory=list)
    """Seconds from a message to the next frame."""


class HeadlessTab:
    """One tab.

    Args:
        address: of the page, as a person opens it.
    """

    def __init__(self, address: str) -> None:
        parts = urlsplit(address)
        self._place = urlunsplit(parts._replace(scheme="wss" if parts.scheme == "https" else "ws"))
        self._origin = Origin(f"{parts.scheme}://{parts.netloc}")
        self._connection: ClientConnection | None = None
        self._listening: asyncio.Task[None] | None = None
        self._asked: float | None = None
        self._unpack = zstandard.ZstdDecompressor()
        self.counts = Counts()
        self.widgets: dict[str, Widget] = {}
        """By their identities; the commands are among them."""
        self.charts: set[str] = set()
        """Identities of the charts that there are."""
        self.files: list[str] = []
        """Names of what has been downloaded."""
        self.notes: list[str] = []

    async def open(self, **settings: Any) -> None:
        """Connect, and wait for the first frame; `settings` go to the connection."""
        self._connection = await connect(
            self._place, subprotocols=[PROTOCOL], compression=None, max_size=None, origin=self._origin, **settings
        )
        self._listening = asyncio.create_task(self._listen(self._connection))
        await self.send(**CAMERA)
        await self.until("a first frame", lambda: self.counts.frames > 0)

    async def close(self) -> None:
        """Leave, as a tab that is closed, perhaps before it had come."""
        if self._connection is not None:
            await self._connection.close()
        if self._listening is not None:
            await self._listening

    async def until(self, what: str, there: Callable[[], object], patience: float = _PATIENCE) -> None:
        """Wait for something, so many seconds at most.

        Raises:
            TimeoutError: it does not come.
        """
        ends = time.perf_counter() + patience
        while not there():
            if time.perf_counter() > ends:
                raise TimeoutError(f"waited in vain for {what}")
            await asyncio.sleep(0.01)

    async def send(self, **message: Any) -> None:
        """Send a message as it is."""
        assert self._connection is not None
        await self._connection.send(msgspec.msgpack.encode(message))

    async def set(self, label: str, value: Any) -> None:
        """Move a widget."""
        if self._asked is None:
            self._asked = time.perf_counter()
        await self.send(type="GuiUpdateMessage", uuid=self.named(label), updates={"value": value})

    async def press(self, label: str) -> None:
        """Press a button."""
        await self.send(type="GuiUpdateMessage", uuid=self.named(label), updates={"value": True})

    async def push(self, option: str) -> None:
        """Press a button of a group."""
        (uuid,) = (uuid for uuid, each in self.widgets.items() if "Group" in each.kind and option in each.options)
        await self.send(type="GuiUpdateMessage", uuid=uuid, updates={"value": option})

    async def trigger(self, label: str) -> None:
        """Give a command, as a key does."""
        await self.send(type="CommandTriggerMessage", uuid=self.named(label))

    def named(self, label: str) -> str:
        """The identity of a widget by its label.

        Raises:
            KeyError: there is none.
        """
        for uuid, widget in self.widgets.items():
            if widget.label == label:
                return uuid
        raise KeyError(label)

    async def _listen(self, connection: ClientConnection) -> None:
        try:
            while True:
                self._take(await connection.recv(decode=False))
        except ConnectionClosed:
            pass

    def _take(self, data: bytes) -> None:
        self.counts.bytes += len(data)
        packed = int.from_bytes(data[8:_HEAD], "little")
        window = self._unpack.decompress(data[_HEAD : _HEAD + packed])
        is_frame = False
        for raw in msgspec.msgpack.decode(window, type=_Window).messages:
            message = msgspec.msgpack.decode(raw, type=Message)
            is_frame |= message.name == SCENE and "points" in message.updates
            self._note(message)
        if is_frame:
            self.counts.frames += 1
            if self._asked is not None:
                self.counts.waited.append(time.perf_counter() - self._asked)
                self._asked = None

    def _note(self, message: Message) -> None:
        if message.type == "GuiRemoveMessage":
            self.widgets.pop(message.uuid, None)
            self.charts.discard(message.uuid)
        elif message.type == "GuiUplotMessage":
            self.charts.add(message.uuid)
        elif message.type == "GuiUpdateMessage" and message.uuid in self.widgets:
            decode = msgspec.msgpack.decode
            news = {name: decode(raw) for name, raw in message.updates.items() if name in ("options", "value")}
            if "options" in news:
                news["options"] = tuple(news["options"])
            self.widgets[message.uuid] = msgspec.structs.replace(self.widgets[message.uuid], **news)
        elif message.type.startswith("Gui") or message.type == "RegisterCommandMessage":
            widget = msgspec.msgpack.decode(message.props, type=Widget)
            if message.uuid and widget.label is not None:
                self.widgets[message.uuid] = msgspec.structs.replace(widget, kind=message.type)
        elif message.type == "FileTransferStartDownload":
            self.files.append(message.filename)
        elif message.type == "NotificationShowMessage":
            note = msgspec.msgpack.decode(message.props, type=Widget)
            self.notes.append(f"{note.title}: {note.body}")


def run(visit: Coroutine[Any, Any, Value]) -> Value:
    """Run a visit to its end, on a thread of its own: a test's own may have a browser's event loop."""
    with ThreadPoolExecutor(1) as thread:
        return thread.submit(asyncio.run, visit).result()
