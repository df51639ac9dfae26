"""Several servers in processes of their own, behind one address, for Python computes on one processor at a time."""

from __future__ import annotations

import asyncio
import contextlib
import os
import signal
import socket
import threading
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess

from rich.markup import escape

from ido.console import note
from ido.processes import process_context
from ido_viz.serving.front import Front

MOST_BY_DEFAULT = 4
"""Servers for a class, unless told otherwise: each takes some 350 MB."""

_AGAIN = 2.0
"""Seconds after which a server that has ended is started again."""

_PATIENCE = 10.0
"""Seconds in which a server must end when it is asked to."""


class ServersError(RuntimeError):
    """The servers cannot be started; the message says why."""


@dataclass(frozen=True, slots=True)
class Ready:
    """What a server tells when it can be asked.

    Args:
        port: at which it listens, on this machine alone.
        notes: what whoever started it should know.
    """

    port: int
    notes: tuple[str, ...] = ()


Serve = Callable[[Connection], None]
"""What a process does: tell `Ready`, or in a sentence why it cannot serve, and serve until the connection ends."""


def usual_servers(*, is_open: bool) -> int:
    """How many servers there should be: one for whoever sits at this machine, and one a processor for a class."""
    return min(os.cpu_count() or 1, MOST_BY_DEFAULT) if is_open else 1


async def serve_with(
    serves: Sequence[Serve], shares: Sequence[int], listener: socket.socket, stands: Callable[[Ready], None]
) -> None:
    """Serve by several processes until it is cancelled; one that ends is started again.

    Args:
        serves: what each does; they must be picklable.
        shares: how many pages each serves at once.
        listener: where pages come to.
        stands: called on another thread when the first of them can be asked.

    Raises:
        ServersError: one could not be started at all.
    """
    front = Front(shares)
    loop = asyncio.get_running_loop()
    first: asyncio.Future[Ready] = loop.create_future()

    def told(number: int, what: Ready | str) -> None:
        """Take note, on the loop's thread, of what became of a server."""
        if isinstance(what, Ready):
            front.stands(number, what.port)
            if not first.done():
                first.set_result(what)
            return
        front.stands(number, None)
        if not first.done():
            first.set_exception(ServersError(what))
        elif first.exception() is None:  # else all end, and it has been said why
            note(f"[yellow]a server ended ({escape(what)}); it is started again[/]")

    def tell(number: int, what: Ready | str) -> None:
        loop.call_soon_threadsafe(told, number, what)

    processes = [_Server(serve, partial(tell, number)) for number, serve in enumerate(serves)]
    visits = asyncio.create_task(front.serve(listener))
    try:
        await asyncio.to_thread(stands, await first)  # it may open a browser, which may wait for the page
        await visits
    finally:
        visits.cancel()
        await asyncio.to_thread(_end, processes)


def shares_of(pages: int, servers: int) -> tuple[int, ...]:
    """How many of so many pages each server serves at once; no more servers than pages."""
    servers = min(servers, pages)
    return tuple(pages // servers + (number < pages % servers) for number in range(servers))


class _Server:
    """A process that serves, and is started again when it ends.

    Args:
        serve: what it does.
        tell: called, on another thread, when it serves, and with a reason when it does no more.
    """

    def __init__(self, serve: Serve, tell: Callable[[Ready | str], None]) -> None:
        self._serve = serve
        self._tell = tell
        self._closing = threading.Event()
        self._lock = threading.Lock()
        self._process: BaseProcess | None = None
        self._here: Connection | None = None
        self._thread = threading.Thread(target=self._keep_up, daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Ask it to end."""
        with self._lock:
            self._closing.set()
            if self._here is not None:
                with contextlib.suppress(OSError):
                    self._here.send(None)

    def wait(self) -> None:
        """Wait for its end, and force it where that does not come."""
        self._thread.join(_PATIENCE)
        if self._thread.is_alive() and self._process is not None:
            self._process.kill()

    def _keep_up(self) -> None:
        if hasattr(signal, "pthread_sigmask"):  # or a process that begins would be ended by Ctrl-C, with a traceback
            signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
        while not self._closing.is_set():
            try:
                if not self._begun():
                    return
            except OSError as error:  # too many processes or files, or no memory
                self._tell(f"a process cannot be started: {error}")
                self._closing.wait(_AGAIN)
                continue
            assert self._process is not None and self._here is not None
            why = ""
            with contextlib.suppress(EOFError, OSError):
                told = self._here.recv()
                if isinstance(told, str):
                    why = told
                else:
                    self._tell(told)
                self._here.recv()  # nothing comes but its end
            self._process.join()
            if self._closing.is_set():
                return
            self._tell(why or f"exit code {self._process.exitcode}")
            self._closing.wait(_AGAIN)

    def _begun(self) -> bool:
        """Whether a process was begun: as long as it is not to close."""
        with self._lock:
            if self._closing.is_set():
                return False
            context = process_context("ido_viz.app")
            self._here, there = context.Pipe()
            self._process = context.Process(target=_work, args=(self._serve, there), name="server")
            self._process.start()
            there.close()
            return True


def _end(servers: list[_Server]) -> None:
    for server in servers:
        server.close()
    for server in servers:
        server.wait()


def _work(serve: Serve, there: Connection) -> None:
    """In the process: Ctrl-C is for the one that started it."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    serve(there)
