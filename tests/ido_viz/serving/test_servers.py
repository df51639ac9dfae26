"""Several servers in processes of their own: they are started again when they end, and end with the one they serve."""

from __future__ import annotations

import asyncio
import contextlib
import os
import signal
import socket
import threading
import time
from collections.abc import Callable
from multiprocessing.connection import Connection

import psutil
import pytest
from headless import run

from ido_viz.serving import servers as servers_module
from ido_viz.serving.listening import listen
from ido_viz.serving.servers import Ready, ServersError, serve_with, shares_of, usual_servers

PATIENCE = 30.0  # seconds; only a failing test waits that long


def tell_its_process(there: Connection) -> None:
    """A server that answers each request with the number of its process."""
    with socket.create_server(("127.0.0.1", 0)) as listener:
        there.send(Ready(listener.getsockname()[1], ("a note",)))

        def answer() -> None:
            pages = []
            while True:
                page, _ = listener.accept()
                page.recv(1 << 16)
                page.sendall(f"{os.getpid()}\n".encode())
                pages.append(page)

        threading.Thread(target=answer, daemon=True).start()
        there.recv()


def never_ends(there: Connection) -> None:
    there.send(Ready(1, (str(os.getpid()),)))
    while True:
        time.sleep(1)


def cannot_serve(there: Connection) -> None:
    there.send("there is no such cloud")


async def server_of(address: tuple[str, int], pages: list[asyncio.StreamWriter]) -> int:
    """The process of the server that a new page gets; it stays open as long as the list of pages is kept."""
    reader, writer = await asyncio.open_connection(*address)
    pages.append(writer)
    writer.write(b"GET / HTTP/1.1\r\nUpgrade: websocket\r\n\r\n")
    return int(await asyncio.wait_for(reader.readline(), PATIENCE))


async def until(there: Callable[[], object]) -> None:
    ends = time.monotonic() + PATIENCE
    while not there():
        assert time.monotonic() < ends
        await asyncio.sleep(0.02)


def test_one_that_is_killed_is_started_again_and_all_end_at_the_end(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    monkeypatch.setattr(servers_module, "_AGAIN", 0.1)

    async def steps() -> None:
        listener, ready = listen("127.0.0.1", 0), asyncio.Queue[Ready]()
        address, pages = listener.getsockname(), list[asyncio.StreamWriter]()
        serving = asyncio.create_task(serve_with([tell_its_process] * 2, [1000] * 2, listener, ready.put_nowait))
        assert (await asyncio.wait_for(ready.get(), PATIENCE)).notes == ("a note",)
        killed = await server_of(address, pages)
        os.kill(killed, signal.SIGKILL)
        await until(lambda: not psutil.pid_exists(killed))
        pids = {killed}
        ends = time.monotonic() + PATIENCE
        while len(pids) < 3:  # the other one, and the new one as soon as it stands
            assert time.monotonic() < ends
            pids.add(await server_of(address, pages))
            await asyncio.sleep(0.1)
        serving.cancel()
        with contextlib.suppress(asyncio.CancelledError):
            await serving
        assert not any(map(psutil.pid_exists, pids))
        with pytest.raises(ConnectionRefusedError):
            await server_of(address, pages)

    run(steps())
    assert "a server ended (exit code -9); it is started again" in capsys.readouterr().err


def test_why_none_can_serve_is_said():
    with listen("127.0.0.1", 0) as listener, pytest.raises(ServersError, match="no such cloud"):
        run(serve_with([cannot_serve] * 2, [10] * 2, listener, lambda _: None))


def test_one_that_does_not_end_is_forced(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(servers_module, "_PATIENCE", 0.3)

    async def steps() -> None:
        listener, ready = listen("127.0.0.1", 0), asyncio.Queue[Ready]()
        serving = asyncio.create_task(serve_with([never_ends], [10], listener, ready.put_nowait))
        pid = int((await asyncio.wait_for(ready.get(), PATIENCE)).notes[0])
        serving.cancel()
        await asyncio.wait([serving])
        await until(lambda: not psutil.pid_exists(pid))

    run(steps())


@pytest.mark.parametrize(
    ("processors", "open_to_others", "servers"), [(8, False, 1), (2, True, 2), (1, True, 1), (64, True, 4)]
)
def test_a_class_has_a_server_a_processor_and_whoever_is_alone_one(
    monkeypatch: pytest.MonkeyPatch, processors: int, open_to_others: bool, servers: int
):
    monkeypatch.setattr(servers_module.os, "cpu_count", lambda: processors)
    assert usual_servers(is_open=open_to_others) == servers


@pytest.mark.parametrize(
    ("pages", "servers", "shares"), [(60, 2, (30, 30)), (5, 4, (2, 1, 1, 1)), (1, 4, (1,)), (10, 3, (4, 3, 3))]
)
def test_servers_share_the_pages_and_serve_no_more_together(pages: int, servers: int, shares: tuple[int, ...]):
    assert shares_of(pages, servers) == shares


def test_a_process_that_cannot_be_started_is_told(monkeypatch: pytest.MonkeyPatch):
    def begin(_: object) -> bool:
        raise OSError("no more processes")

    monkeypatch.setattr(servers_module._Server, "_begun", begin)
    with listen("127.0.0.1", 0) as listener, pytest.raises(ServersError, match="no more processes"):
        run(serve_with([cannot_serve], [1], listener, lambda _: None))
