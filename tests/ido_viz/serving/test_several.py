"""The command with several servers, as a class meets it: pages, what they can undo, kept clouds, and the end."""

from __future__ import annotations

import asyncio
import contextlib
import os
import shutil
import signal
import sys
import time
import urllib.error
import urllib.request
from collections.abc import AsyncIterator, Callable, Iterator
from pathlib import Path
from urllib.parse import quote

import load
import pytest
from command_line import BESIDE_ITS_OWN
from headless import HeadlessTab, run
from websockets.exceptions import InvalidStatus

from ido import Perturbation
from ido_viz.core.library import shipped_library
from ido_viz.core.state import State, encode
from ido_viz.own.kept import KeptCloud
from ido_viz.own.shelf import Shelf

PATIENCE = 60.0  # seconds; only a failing test waits that long


@pytest.fixture(scope="module")
def data(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("data")


@pytest.fixture(scope="module")
def server(data: Path) -> Iterator[load.Server]:
    """Two servers with room for a page each."""
    with load.started("--servers", "2", "--sessions", "2", "--data", str(data)) as server:
        yield server


@contextlib.asynccontextmanager
async def pages(server: load.Server, *names: str, fragment: str = "") -> AsyncIterator[list[HeadlessTab]]:
    """Open pages of these names and this address; they wait for room, as until the other server stands."""
    tabs: list[HeadlessTab] = []
    try:
        for name in names:
            deadline = time.monotonic() + PATIENCE
            while True:
                tabs.append(HeadlessTab(f"{server.address}/?page={name * 32}&fragment={quote(fragment)}"))
                try:
                    await tabs[-1].open()
                    break
                except InvalidStatus:
                    assert time.monotonic() < deadline
                    del tabs[-1]
                    await asyncio.sleep(0.1)
        yield tabs
    finally:
        for tab in tabs:
            await tab.close()


def answers(server: load.Server) -> int:
    try:
        with urllib.request.urlopen(server.address, timeout=PATIENCE) as answer:
            return answer.status
    except urllib.error.HTTPError as error:
        return error.code


def wait(what: str, until: Callable[[], object]) -> None:
    deadline = time.monotonic() + PATIENCE
    while not until():
        assert time.monotonic() < deadline, f"waited in vain for {what}"
        time.sleep(0.02)


def test_each_server_has_its_pages_and_one_too_many_is_told_so(server: load.Server):
    async def visit() -> None:
        async with pages(server, "a", "b") as (first, second):
            assert answers(server) == 503
            with pytest.raises(InvalidStatus, match="503"):
                await HeadlessTab(server.address).open()
            await first.close()
            await second.until("room", lambda: answers(server) == 200)

    run(visit())


@pytest.mark.parametrize(("names", "comes_back"), [("cd", "c"), ("gh", "h")])
def test_a_page_comes_back_to_the_server_that_knows_what_it_can_undo(server: load.Server, names: str, comes_back: str):
    begun, left = State(), State(perturbation=Perturbation(rotation=20), playing=False)

    async def visit() -> None:
        async with pages(server, *names) as tabs:
            for tab in tabs:
                await tab.push("Last")
                seen = tab.counts.frames
                await tab.set("Rotation", left.perturbation.rotation)
                await tab.until("its scene", lambda tab=tab, seen=seen: tab.counts.frames > seen)
        async with pages(server, comes_back, fragment=f"state={encode(left)}") as (tab,):
            slider = tab.named("Rotation")
            await tab.push("Undo")
            await tab.until("what was before", lambda: tab.widgets[slider].value == begun.perturbation.rotation)

    run(visit())


def test_a_cloud_that_one_server_keeps_is_offered_by_both(server: load.Server, data: Path, kept: KeptCloud):
    async def shapes() -> list[tuple[str, ...]]:
        async with pages(server, "e", "f") as tabs:
            return [tab.widgets[tab.named("Shape")].options for tab in tabs]

    shelf = Shelf(shipped_library().subjects, data)
    shelf.keep(kept)
    assert all("tiny" in options for options in run(shapes()))
    shelf.withdraw("tiny")
    assert not any("tiny" in options for options in run(shapes()))


@pytest.mark.usefixtures("default_interrupts")
@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no such signal")
@pytest.mark.parametrize("how", [signal.SIGINT, signal.SIGKILL])
def test_the_servers_end_with_the_command(tmp_path: Path, how: int):
    with load.started("--servers", "2", "--data", str(tmp_path)) as server:
        command = server.process
        assert command is not None
        wait("both", lambda: len(command.children(recursive=True)) == 2 + BESIDE_ITS_OWN)
        its = command.children(recursive=True)
        os.kill(command.pid, how)
        wait("their end", lambda: not any(each.is_running() and each.status() != "zombie" for each in its))
    shutil.rmtree(tmp_path)  # nobody writes there any more
