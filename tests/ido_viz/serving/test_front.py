"""One address for several servers: who is brought to which, and that what passes is not changed."""

from __future__ import annotations

import asyncio
import contextlib
import hashlib
import random
from collections.abc import Awaitable, Callable

import pytest
from headless import run

from ido_viz.serving import front as front_module
from ido_viz.serving.front import Front
from ido_viz.serving.listening import listen

PATIENCE = 20.0  # seconds; only a failing test waits that long
SHARE = 3


class Place:
    """A front with servers that say which of them they are, and then send back what they are sent."""

    def __init__(self) -> None:
        self.listener = listen("127.0.0.1", 0)
        self.port = self.listener.getsockname()[1]
        self.front = Front([SHARE, SHARE])
        self.servers: dict[int, asyncio.Server] = {}
        self.heads: list[bytes] = []

    async def start(self, number: int) -> None:
        async def answer(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
            self.heads.append(await reader.readuntil(b"\r\n\r\n"))
            writer.write(f"HTTP/1.1 101 {number}\r\n".encode())
            while chunk := await reader.read(1 << 16):
                writer.write(chunk)
                await writer.drain()
            writer.close()

        server = self.servers[number] = await asyncio.start_server(answer, "127.0.0.1", 0)
        self.front.stands(number, server.sockets[0].getsockname()[1])


class Visitor:
    """A connection to a front, on which it was said what is wanted."""

    def __init__(self, place: Place, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        self.place = place
        self.reader = reader
        self.writer = writer

    @classmethod
    async def asking(cls, place: Place, target: str = "/", *, page: bool = True) -> Visitor:
        """Connect and say what is wanted."""
        reader, writer = await asyncio.open_connection("127.0.0.1", place.port)
        upgrade = "Connection: Upgrade\r\nUpgrade: websocket\r\n" if page else ""
        writer.write(f"GET {target} HTTP/1.1\r\nHost: here\r\n{upgrade}\r\n".encode())
        return cls(place, reader, writer)

    async def server(self) -> int:
        """Which server answered."""
        return int((await asyncio.wait_for(self.reader.readline(), PATIENCE)).split()[-1])

    async def leave(self) -> None:
        self.writer.close()
        while sum(self.place.front._pages) and await self.reader.read(1 << 16):
            pass
        await asyncio.sleep(0.05)  # the front has seen it, too


def visit(steps: Callable[[Place], Awaitable[None]], *standing: int) -> None:
    """Take steps at a front with some of its servers."""

    async def all_steps() -> None:
        place = Place()
        serving = asyncio.create_task(place.front.serve(place.listener))
        for number in standing:
            await place.start(number)
        try:
            await steps(place)
        finally:
            serving.cancel()
            for server in place.servers.values():
                server.close()

    run(all_steps())


def test_pages_are_shared_out_and_one_that_comes_back_finds_its_server():
    async def steps(place: Place) -> None:
        pages = [await Visitor.asking(place, f"/?token=x&page=page-{number}&fragment=y") for number in range(4)]
        its = [await page.server() for page in pages]
        assert sorted(its) == [0, 0, 1, 1]
        for page in pages:
            await page.leave()
        for number in (3, 1, 0, 2):  # whatever the order, and although all have room
            page = await Visitor.asking(place, f"/?page=page-{number}")
            assert await page.server() == its[number]
            await page.leave()

    visit(steps, 0, 1)


def test_a_class_that_comes_at_once_is_shared_out():
    async def steps(place: Place) -> None:
        pages = await asyncio.gather(*(Visitor.asking(place, f"/?page={number}") for number in range(2 * SHARE)))
        its = await asyncio.gather(*(page.server() for page in pages))
        assert sorted(its) == [0] * SHARE + [1] * SHARE

    visit(steps, 0, 1)


def test_what_passes_is_not_changed_either_way():
    async def steps(place: Place) -> None:
        visitor = await Visitor.asking(place, "/some/path?page=%C3%A4&x=%0d%0a")
        await visitor.server()
        assert place.heads == [
            b"GET /some/path?page=%C3%A4&x=%0d%0a HTTP/1.1\r\n"
            b"Host: here\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n\r\n"
        ]
        sent = random.Random(1).randbytes(3_000_000)
        visitor.writer.write(sent)
        back = await asyncio.wait_for(visitor.reader.readexactly(len(sent)), PATIENCE)
        assert hashlib.sha256(back).digest() == hashlib.sha256(sent).digest()
        await visitor.leave()

    visit(steps, 0, 1)


def test_who_only_reads_a_file_takes_no_place_of_a_page():
    async def steps(place: Place) -> None:
        readers = [await Visitor.asking(place, page=False) for _ in range(4)]
        for reader in readers:
            await reader.server()
        assert place.front._pages == [0, 0]
        pages = [await Visitor.asking(place) for _ in range(2)]
        assert sorted([await page.server() for page in pages]) == [0, 1]

    visit(steps, 0, 1)


def test_a_page_whose_server_is_full_or_gone_finds_another(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(front_module, "_LONGEST_LEAVE", 0.2)

    async def steps(place: Place) -> None:
        first = await Visitor.asking(place, "/?page=first")
        home = await first.server()
        await first.leave()
        others: list[Visitor] = []
        while place.front._pages[home] < SHARE:
            others.append(await Visitor.asking(place))
            await others[-1].server()
        again = await Visitor.asking(place, "/?page=first")
        assert await again.server() == 1 - home
        for other in (again, *others):
            await other.leave()
        place.servers[1 - home].close()  # the front has not been told
        again = await Visitor.asking(place, "/?page=first")
        assert await again.server() == home

    visit(steps, 0, 1)


def test_a_page_that_is_reloaded_at_once_finds_its_server_although_it_fills_it_itself():
    async def steps(place: Place) -> None:
        first = await Visitor.asking(place, "/?page=first")
        home = await first.server()
        others: list[Visitor] = []
        while place.front._pages[home] < SHARE:
            others.append(await Visitor.asking(place))
            await others[-1].server()
        again = await Visitor.asking(place, "/?page=first")
        await asyncio.sleep(0.3)
        await first.leave()
        assert await again.server() == home

    visit(steps, 0, 1)


def test_who_comes_before_any_server_stands_waits_for_one():
    async def steps(place: Place) -> None:
        early = await Visitor.asking(place)
        answer = asyncio.create_task(early.server())
        await asyncio.sleep(0.1)
        assert not answer.done()
        await place.start(1)
        assert await answer == 1

    visit(steps)


@pytest.mark.parametrize(
    "sent", [b"", b"GET / HTTP/1.1\r\n", b"x" * 200_000, b"\r\n\r\n", b"GET http://[ HTTP/1.1\r\n\r\n"]
)
def test_nonsense_and_silence_end_alone(monkeypatch: pytest.MonkeyPatch, sent: bytes):
    monkeypatch.setattr(front_module, "_LONGEST_WAIT", 0.3)

    async def steps(place: Place) -> None:
        reader, writer = await asyncio.open_connection("127.0.0.1", place.port)
        writer.write(sent)
        if b"\r\n\r\n" in sent:  # a server's affair
            assert await asyncio.wait_for(reader.readline(), PATIENCE) in (b"HTTP/1.1 101 0\r\n", b"HTTP/1.1 101 1\r\n")
        else:
            with pytest.raises((asyncio.IncompleteReadError, ConnectionError)):
                await asyncio.wait_for(reader.readexactly(1), PATIENCE)
        good = await Visitor.asking(place)
        assert await good.server() in (0, 1)

    visit(steps, 0, 1)


@pytest.mark.parametrize(
    ("target", "page", "is_kept"),
    [("/?page=a", True, True), ("/?page=a", False, False), ("/?page=" + "a" * 65, True, False), ("/", True, False)],
)
def test_pages_that_were_let_in_are_known_again_and_nobody_else(target: str, page: bool, is_kept: bool):
    async def steps(place: Place) -> None:
        visitor = await Visitor.asking(place, target, page=page)
        await visitor.server()
        assert (list(place.front._homes) == ["a"]) == is_kept and len(place.front._homes) == is_kept

    visit(steps, 0, 1)


def test_who_ends_what_it_says_gets_the_whole_answer():
    async def steps(place: Place) -> None:
        visitor = await Visitor.asking(place)
        visitor.writer.write(b"so far")
        visitor.writer.write_eof()
        assert await asyncio.wait_for(visitor.reader.read(), PATIENCE) in (
            b"HTTP/1.1 101 0\r\nso far",
            b"HTTP/1.1 101 1\r\nso far",
        )

    visit(steps, 0, 1)


def test_who_takes_nothing_any_more_is_let_go(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(front_module, "_LONGEST_STILL", 0.3)

    async def steps(place: Place) -> None:
        visitor = await Visitor.asking(place)
        await visitor.server()
        assert sum(place.front._pages) == 1
        visitor.writer.transport.pause_reading()  # type: ignore[attr-defined]  # as a machine that sleeps
        with contextlib.suppress(ConnectionError):
            for _ in range(400):
                visitor.writer.write(bytes(1 << 16))
                await asyncio.wait_for(visitor.writer.drain(), PATIENCE)
        async with asyncio.timeout(PATIENCE):
            while sum(place.front._pages):
                await asyncio.sleep(0.02)

    visit(steps, 0, 1)


def test_an_open_page_does_not_keep_the_front_from_its_end():
    async def all_steps() -> None:
        place = Place()
        serving = asyncio.create_task(place.front.serve(place.listener))
        await place.start(0)
        visitor = await Visitor.asking(place)
        await visitor.server()
        serving.cancel()
        await asyncio.wait_for(asyncio.gather(serving, return_exceptions=True), PATIENCE)
        place.servers[0].close()

    run(all_steps())


def test_names_are_forgotten_before_they_fill_the_memory(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(front_module, "_MOST_NAMES", 5)

    async def steps(place: Place) -> None:
        for number in range(20):
            page = await Visitor.asking(place, f"/?page={number}")
            await page.server()
        assert list(place.front._homes) == [str(number) for number in range(15, 20)]

    visit(steps, 0, 1)
