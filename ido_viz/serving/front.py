"""One address for several servers: each page has one of them, and the same one when it comes back.

Nothing of what passes is changed or kept. Only the first lines of a connection are read: a page says its name there
(see `address.js`), and keeps the server to which it was brought first, which knows what can be undone there.
"""

from __future__ import annotations

import asyncio
import contextlib
import re
import socket
from collections import OrderedDict
from collections.abc import Callable, Sequence
from urllib.parse import parse_qs, urlsplit

_LONGEST_WAIT = 10.0
"""Seconds within which a connection must say what it wants."""

_LONGEST_START = 60.0
"""Seconds within which there must be a server for it."""

_LONGEST_STILL = 30.0
"""Seconds within which who is sent something must take it, and in which one side may go on when the other has ended."""

_LONGEST_LEAVE = 3.0
"""Seconds that a page waits for room at the server that knows it."""

_AGAIN = 0.1
"""Seconds after which servers are asked again of which none answered."""

_CHUNK = 1 << 16
_MOST_NAMES = 10_000
_LONGEST_NAME = 64
_ACCEPTED = b"HTTP/1.1 101 "
_IS_SOCKET = re.compile(rb"^upgrade:\s*websocket\s*$", re.IGNORECASE | re.MULTILINE)


class Front:
    """Hands connections on; to be used on the thread of its loop alone.

    Args:
        shares: how many pages each server serves at once; `stands` tells where it is.
    """

    def __init__(self, shares: Sequence[int]) -> None:
        self._ports: list[int | None] = [None for _ in shares]
        self._pages = [0 for _ in shares]
        self._shares = tuple(shares)
        self._homes: OrderedDict[str, int] = OrderedDict()
        self._changed = asyncio.Event()

    def stands(self, number: int, port: int | None) -> None:
        """Take note of the port of a server on this machine, or that it has none any more."""
        self._ports[number] = port
        self._changed.set()

    async def serve(self, listener: socket.socket) -> None:
        """Hand on what comes to a socket that listens, until it is cancelled."""
        server = await asyncio.start_server(self._visit, sock=listener)
        try:
            await asyncio.get_running_loop().create_future()  # to wait for the server is to wait for its pages, too
        finally:
            server.close()

    async def _visit(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        gone = (OSError, TimeoutError, asyncio.IncompleteReadError, asyncio.LimitOverrunError, asyncio.CancelledError)
        with contextlib.suppress(*gone):
            async with asyncio.timeout(_LONGEST_WAIT):
                head = await reader.readuntil(b"\r\n\r\n")
            await self._hand_over(head, reader, writer)
        writer.close()

    async def _hand_over(self, head: bytes, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        """Bring a connection to a server, and stay between them until it ends."""
        name, is_page = _page_name(head), _IS_SOCKET.search(head) is not None
        refused: set[int] = set()
        deadline = asyncio.get_running_loop().time() + _LONGEST_START
        while True:
            async with asyncio.timeout_at(deadline):
                number = await self._home(name, refused)
            self._pages[number] += is_page  # at once, for a whole class may come in the same moment
            try:
                there = await asyncio.open_connection("127.0.0.1", self._ports[number])
                there[1].write(head)

                def answered(chunk: bytes, number: int = number) -> None:
                    if is_page and chunk.startswith(_ACCEPTED):
                        self._remember(name, number)

                await _join((reader, writer), there, answered)
                return
            except ConnectionRefusedError:  # it has just ended, or has too much to do
                refused.add(number)
            finally:
                self._pages[number] -= is_page

    async def _home(self, name: str, refused: set[int]) -> int:
        """The server of a page, none of those that refused it; waits until there is one."""
        while True:
            standing = [number for number, port in enumerate(self._ports) if port is not None]
            if able := [number for number in standing if number not in refused]:
                break
            self._changed.clear()
            with contextlib.suppress(TimeoutError):
                await asyncio.wait_for(self._changed.wait(), _AGAIN if standing else None)
            refused.clear()
        home = self._homes.get(name)
        if home in able:
            with contextlib.suppress(TimeoutError):
                async with asyncio.timeout(_LONGEST_LEAVE):
                    while self._pages[home] >= self._shares[home]:  # perhaps by the page itself, as it is reloaded
                        await asyncio.sleep(_AGAIN)
                    return home
        return min(able, key=lambda number: (self._pages[number] >= self._shares[number], self._pages[number]))

    def _remember(self, name: str, number: int) -> None:
        """Note which server knows a page."""
        if 0 < len(name) <= _LONGEST_NAME:
            self._homes[name] = number
            self._homes.move_to_end(name)
            if len(self._homes) > _MOST_NAMES:
                self._homes.popitem(last=False)


def _page_name(head: bytes) -> str:
    """What a page calls itself in the first line of its request; empty if it does not."""
    _, _, rest = head.partition(b" ")
    path = rest.partition(b" ")[0].decode("latin-1")
    try:
        return parse_qs(urlsplit(path).query).get("page", [""])[0]
    except ValueError:  # no address at all; the server will say so
        return ""


async def _join(
    one: tuple[asyncio.StreamReader, asyncio.StreamWriter],
    other: tuple[asyncio.StreamReader, asyncio.StreamWriter],
    answered: Callable[[bytes], None],
) -> None:
    """Hand on what either says to the other until both have ended, one not much later than the other.

    Args:
        one: who asks.
        other: who answers.
        answered: called with the first that the other says.
    """
    ways = [
        asyncio.create_task(_hand_on(one[0], other[1], lambda _: None)),
        asyncio.create_task(_hand_on(other[0], one[1], answered)),
    ]
    try:
        done, on = await asyncio.wait(ways, return_when=asyncio.FIRST_COMPLETED)
        if on and all(way.exception() is None for way in done):
            await asyncio.wait(on, timeout=_LONGEST_STILL)
    finally:
        for way in ways:
            way.cancel()
        await asyncio.gather(*ways, return_exceptions=True)
        other[1].close()


async def _hand_on(reader: asyncio.StreamReader, writer: asyncio.StreamWriter, first: Callable[[bytes], None]) -> None:
    said = False
    while chunk := await reader.read(_CHUNK):
        if not said:
            first(chunk)
            said = True
        writer.write(chunk)
        try:
            async with asyncio.timeout(_LONGEST_STILL):
                await writer.drain()
        except TimeoutError:  # a page that is no more, of which nobody told
            writer.transport.abort()
            raise
    writer.write_eof()
