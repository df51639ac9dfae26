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
from urllib.parse import parse_qs, urlsplit

_LONGEST_WAIT = 10.0
"""Seconds within which a connection must say what it wants."""

_CHUNK = 1 << 16
_MOST_NAMES = 10_000
_IS_SOCKET = re.compile(rb"^upgrade:\s*websocket\s*$", re.IGNORECASE | re.MULTILINE)


class Front:
    """Hands connections on; to be used on the thread of its loop alone.

    Args:
        servers: how many there are; `stands` tells where.
        share: how many pages each of them serves at once.
    """

    def __init__(self, servers: int, share: int) -> None:
        self._ports: list[int | None] = [None] * servers
        self._pages = [0] * servers
        self._share = share
        self._homes: OrderedDict[str, int] = OrderedDict()
        self._changed = asyncio.Event()

    def stands(self, number: int, port: int | None) -> None:
        """Take note of the port of a server on this machine, or that it has none any more."""
        self._ports[number] = port
        self._changed.set()

    async def serve(self, listener: socket.socket) -> None:
        """Hand on what comes to a socket that listens, until it is cancelled."""
        async with await asyncio.start_server(self._visit, sock=listener) as server:
            await server.serve_forever()

    async def _visit(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        with contextlib.suppress(OSError, TimeoutError, asyncio.IncompleteReadError, asyncio.LimitOverrunError):
            async with asyncio.timeout(_LONGEST_WAIT):
                head = await reader.readuntil(b"\r\n\r\n")
            is_page = _IS_SOCKET.search(head) is not None
            while True:
                number = await self._home(_page_name(head))
                self._pages[number] += is_page  # at once, for a whole class may come in the same moment
                try:
                    there = await asyncio.open_connection("127.0.0.1", self._ports[number])
                    there[1].write(head)
                    await _join((reader, writer), there)
                    break
                except ConnectionRefusedError:  # it has just ended
                    self._ports[number] = None
                finally:
                    self._pages[number] -= is_page
        writer.close()

    async def _home(self, name: str) -> int:
        """The server of a page; waits until there is one."""
        while not (standing := [number for number, port in enumerate(self._ports) if port is not None]):
            self._changed.clear()
            await self._changed.wait()
        home = self._homes.get(name)
        if home not in standing or self._pages[home] >= self._share:
            home = min(standing, key=self._pages.__getitem__)
        if name:
            self._homes[name] = home
            self._homes.move_to_end(name)
            if len(self._homes) > _MOST_NAMES:
                self._homes.popitem(last=False)
        return home


def _page_name(head: bytes) -> str:
    """What a page calls itself in the first line of its request; empty if it does not."""
    _, _, rest = head.partition(b" ")
    path = rest.partition(b" ")[0].decode("latin-1")
    try:
        return parse_qs(urlsplit(path).query).get("page", [""])[0]
    except ValueError:  # no address at all; the server will say so
        return ""


async def _join(
    one: tuple[asyncio.StreamReader, asyncio.StreamWriter], other: tuple[asyncio.StreamReader, asyncio.StreamWriter]
) -> None:
    """Hand on what either says to the other, until one of them ends."""
    ways = [asyncio.create_task(_hand_on(one[0], other[1])), asyncio.create_task(_hand_on(other[0], one[1]))]
    try:
        await asyncio.wait(ways, return_when=asyncio.FIRST_COMPLETED)
    finally:
        for way in ways:
            way.cancel()
        await asyncio.gather(*ways, return_exceptions=True)
        other[1].close()


async def _hand_on(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
    while chunk := await reader.read(_CHUNK):
        writer.write(chunk)
        await writer.drain()
