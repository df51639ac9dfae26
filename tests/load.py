"""A class at work: many tabs that drag two sliders, play, take files along and leave, and what that costs.

    python tests/load.py [--tabs 1 10 30 60] [--seconds 10] [--address http://…]

Without an address it starts a server of its own, and tells what that takes of the processor and of memory. Only figures
of one machine in one run can be compared: give PYTHONPATH another clone to measure two versions of the code in turn.
"""

from __future__ import annotations

import asyncio
import contextlib
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import numpy as np
import psutil
import tyro

sys.path.insert(0, str(Path(__file__).parent / "helpers"))
sys.path.append(str(Path(__file__).parents[1]))  # or the folders of tests would be taken for the packages

from headless import HeadlessTab

MESSAGES = 10
"""A second and tab, in turn for either slider."""

FILE = "Animation (.gif)"
"""What each tab takes along: the longest work that one click asks for."""

_LONGEST = 900.0  # seconds that a file is waited for


@dataclass(frozen=True, slots=True)
class Figures:
    """What came of so many tabs that drag two sliders.

    Args:
        tabs: how many.
        seconds: how long they were measured.
        frames: of all tabs.
        slowest: frames of the tab that got least.
        waited: seconds from each message to the next frame of its tab, shape (n,).
        bytes: of all that was sent.
        processor: seconds that the server computed; NaN where it is not ours.
    """

    tabs: int
    seconds: float
    frames: int
    slowest: int
    waited: np.ndarray
    bytes: int
    processor: float

    def __str__(self) -> str:
        together = self.frames / self.seconds
        half, most, nearly_all, worst = np.quantile(self.waited, (0.5, 0.9, 0.99, 1.0))
        each = max(self.frames, 1)
        return (
            f"{self.tabs:4d} {together / self.tabs:8.2f} {self.slowest / self.seconds:8.2f} {together:8.1f} "
            f"{half:8.3f} {most:7.3f} {nearly_all:7.3f} {worst:7.3f} "
            f"{self.bytes / each / 1e3:9.1f} {self.bytes / self.seconds / 1e6:7.2f} {1e3 * self.processor / each:9.1f}"
        )


HEAD = (
    f"{'':>4} {'frames/s':>8} {'slowest':>8} {'all':>8} {'message to frame, seconds':^32} {'kB':>9} {'':>7} "
    f"{'ms of the':>9}\n"
    f"{'tabs':>4} {'a tab':>8} {'tab':>8} {'tabs':>8} {'median':>8} {'90%':>7} {'99%':>7} {'worst':>7} "
    f"{'a frame':>9} {'MB/s':>7} {'processor':>9}"
)


@dataclass(frozen=True, slots=True)
class Server:
    """A server to be measured; `process` and its log are None where it is not ours."""

    address: str
    process: psutil.Process | None = None
    log: Path | None = None

    def processor(self) -> float:
        """Seconds that it has computed, with the processes that it started."""
        its = [] if self.process is None else [self.process, *self.process.children(recursive=True)]
        return sum(sum(each.cpu_times()[:2]) for each in its) if its else float("nan")

    def memory(self) -> float:
        """Megabytes in memory, with the processes that it started; what they share counts once, where that is known."""
        its = [] if self.process is None else [self.process, *self.process.children(recursive=True)]
        used = [each.memory_full_info() for each in its]
        return sum(getattr(each, "pss", each.rss) for each in used) / 1e6 if its else float("nan")


@contextlib.contextmanager
def started(*options: str) -> Iterator[Server]:
    """A server of its own process, as the command starts it; it must stop when asked to."""
    command = [sys.executable, "-P", "-m", "ido_viz", "--port", "0", "--no-open", *options]
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, sys.path))}  # what would be imported here
    with (
        tempfile.NamedTemporaryFile("w+") as log,
        subprocess.Popen(command, stdout=subprocess.PIPE, stderr=log, text=True, env=environment) as process,
    ):
        try:
            assert process.stdout is not None
            line = process.stdout.readline()
            if " is at " not in line:
                process.wait()
                log.seek(0)
                raise RuntimeError(f"no server: {line}{log.read()}")
            yield Server(line.split(" is at ")[1].split()[0], psutil.Process(process.pid), Path(log.name))
        finally:
            process.terminate()
            process.wait()
            log.seek(0)
            sys.stderr.write(log.read())


async def class_of(server: Server, count: int) -> list[HeadlessTab]:
    """So many tabs that show their first frame."""
    tabs = [HeadlessTab(server.address) for _ in range(count)]
    await asyncio.gather(*(tab.open() for tab in tabs))
    return tabs


async def drag(tabs: list[HeadlessTab], seconds: float, server: Server) -> Figures:
    """Drag two sliders in every tab."""

    async def one(tab: HeadlessTab, number: int) -> None:
        await asyncio.sleep(number / len(tabs) / MESSAGES)  # people do not move in step
        begin = time.perf_counter()
        for step in range(round(seconds * MESSAGES)):
            place = (5 * step + number) % 61 / 60  # never twice the same, for that is no change
            if step % 2:
                await tab.set("Rotation", round(30 + 60 * place))
            else:
                await tab.set("Translation", round(0.15 + 0.3 * place, 2))
            await asyncio.sleep(max(0.0, begin + (step + 1) / MESSAGES - time.perf_counter()))

    for tab in tabs:
        tab.counts.waited.clear()
    before = [(tab.counts.frames, tab.counts.bytes) for tab in tabs]
    processor, began = server.processor(), time.perf_counter()
    await asyncio.gather(*(one(tab, number) for number, tab in enumerate(tabs)))
    took = time.perf_counter() - began
    frames = [tab.counts.frames - frames for tab, (frames, _) in zip(tabs, before, strict=True)]
    return Figures(
        tabs=len(tabs),
        seconds=took,
        frames=sum(frames),
        slowest=min(frames),
        waited=np.array([second for tab in tabs for second in tab.counts.waited] or [np.nan]),
        bytes=sum(tab.counts.bytes - sent for tab, (_, sent) in zip(tabs, before, strict=True)),
        processor=server.processor() - processor,
    )


async def play(tabs: list[HeadlessTab], seconds: float) -> float:
    """Play in every tab, and stop; megabytes a second that were sent."""
    await asyncio.gather(*(tab.push("First (R)") for tab in tabs))
    await asyncio.gather(*(tab.trigger("Play or pause") for tab in tabs))
    sent, began = sum(tab.counts.bytes for tab in tabs), time.perf_counter()
    await asyncio.sleep(seconds)
    rate = (sum(tab.counts.bytes for tab in tabs) - sent) / (time.perf_counter() - began) / 1e6
    await asyncio.gather(*(tab.push("Last") for tab in tabs))
    return rate


async def take_along(tabs: list[HeadlessTab]) -> float:
    """Take a file along from every tab; seconds until all have theirs."""
    began = time.perf_counter()
    await asyncio.gather(*(tab.press(FILE) for tab in tabs))
    await asyncio.gather(*(tab.until("the file", lambda tab=tab: tab.files, _LONGEST) for tab in tabs))
    return time.perf_counter() - began


async def measure(server: Server, counts: tuple[int, ...], seconds: float, *, files: bool) -> list[Figures]:
    """Print what each number of tabs costs."""
    print(HEAD)
    all_figures = []
    for count in counts:
        before = server.memory()
        tabs = await class_of(server, count)
        opened = server.memory()
        figures = await drag(tabs, seconds, server)
        print(figures, flush=True)
        all_figures.append(figures)
        told = [f"playing {await play(tabs, seconds / 4):.2f} MB/s"]
        if files:
            told.append(f"all {count} files after {await take_along(tabs):.1f} s")
        in_use = server.memory()
        await asyncio.gather(*(tab.close() for tab in tabs))
        await asyncio.sleep(1.0)  # until the server has room again
        told.append(f"memory {before:.0f} MB, {opened:.0f} with all open, {in_use:.0f} at the end")
        print(f"     {'; '.join(told)}", flush=True)
    return all_figures


def main(
    tabs: tuple[int, ...] = (1, 10, 30, 60),
    seconds: float = 10.0,
    address: str = "",
    files: bool = False,
    options: Annotated[tuple[str, ...], tyro.conf.arg(metavar="OPTION ...")] = (),
) -> None:
    """Measure a server.

    Args:
        tabs: So many at once, one number after the other.
        seconds: How long each drags; a quarter of that it plays.
        address: Of a server that runs; without it, one is started.
        files: Have every tab take an animation along, too.
        options: For the server that is started.
    """
    with contextlib.nullcontext(Server(address)) if address else started(*options) as server:
        asyncio.run(measure(server, tabs, seconds, files=files))


if __name__ == "__main__":
    tyro.cli(main)
