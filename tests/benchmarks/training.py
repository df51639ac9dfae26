"""Pages while a cloud of one's own is trained on: how often they move, before, meanwhile and after.

    python tests/benchmarks/training.py [--plan quick]

One page plays, one is dragged at ten messages a second, and a third one trains. Only figures of one machine in one run
can be compared.
"""

from __future__ import annotations

import asyncio
import sys
import tempfile
import threading
import time
from pathlib import Path
from types import SimpleNamespace
from typing import Literal, cast

import numpy as np
import tyro

sys.path.insert(0, str(Path(__file__).parents[1] / "helpers"))
sys.path.append(str(Path(__file__).parents[1]))
sys.path.append(str(Path(__file__).parents[2]))  # or the folders of tests would be taken for the packages

from headless import HeadlessTab, Message
from load import started
from unseen_explorer import UnseenExplorer

from ido.shipped import shipped_cloud
from ido_viz.app import App

WINDOW = 2.0
"""Seconds of which the frames are counted together."""

ALONE = 10.0
"""Seconds before and after the training."""


class PlayingTab(HeadlessTab):
    """One that counts how often its left cloud moves."""

    moves = 0

    def _note(self, message: Message) -> None:
        super()._note(message)
        self.moves += message.type == "SetPositionMessage" and message.name.startswith("/left/scene")


async def watch(address: str, phase: list[str]) -> dict[str, list[tuple[float, float]]]:
    """Moves and frames a second of a page that plays and one that is dragged, by the phase, until there is none."""
    playing, dragged = PlayingTab(address), HeadlessTab(address)
    await asyncio.gather(playing.open(), dragged.open())
    await playing.set("Speed", 1)
    found: dict[str, list[tuple[float, float]]] = {}
    while phase:
        now = phase[0]
        await playing.push("First (R)")  # one run at the slowest speed takes longer than a window
        await playing.trigger("Play or pause")
        moves, frames, began = playing.moves, dragged.counts.frames, time.perf_counter()
        for step in range(round(10 * WINDOW)):
            await dragged.set("Rotation", round(60 + 30 * float(np.sin(step / 3))))
            await asyncio.sleep(max(0.0, began + (step + 1) / 10 - time.perf_counter()))
        took = time.perf_counter() - began
        if phase and phase[0] == now:
            counts = (playing.moves - moves) / took, (dragged.counts.frames - frames) / took
            found.setdefault(now, []).append(counts)
    await asyncio.gather(playing.close(), dragged.close())
    return found


def train(address: str, plan: str, phase: list[str]) -> float:
    """Train on the bunny, thinned, on a page of its own; the seconds that took."""
    page = UnseenExplorer(cast(App, SimpleNamespace(url=address)))
    page.open_tab("Own cloud")
    points = shipped_cloud("bunny").points[::40]
    page.upload("Upload a cloud", "bunny.xyz", "\n".join(" ".join(map(str, each)) for each in points.tolist()).encode())
    page.wait_until("its preview", lambda: "Train" in page.buttons())
    page.choose("Time", plan)
    page.wait_until("its estimate, whose measuring takes a processor", lambda: page.says("maps of each method on"))
    phase[0] = "before"
    time.sleep(ALONE)
    phase[0], began = "training", time.perf_counter()
    page.press("Train")
    while not (page.says("trained and kept") or page.says("training failed")):
        time.sleep(0.2)
    took = time.perf_counter() - began
    assert page.says("trained and kept"), "the training failed"
    phase[0] = "after"
    time.sleep(ALONE)
    phase.clear()
    page.close()
    return took


def main(plan: Literal["quick", "standard", "paper"] = "quick") -> None:
    """Measure pages beside a training.

    Args:
        plan: how long is trained.
    """
    phase = ["preparing"]
    with tempfile.TemporaryDirectory() as folder, started("--data", folder) as server:
        found: dict[str, list[tuple[float, float]]] = {}
        watching = threading.Thread(target=lambda: found.update(asyncio.run(watch(server.address, phase))))
        watching.start()
        took = train(server.address, plan, phase)
        watching.join()
    print(f"{plan}: trained in {took:.0f} s; moves a second of the page that plays, frames of the one that is dragged")
    for now in ("before", "training", "after"):
        moves, frames = np.array(found[now]).T
        least = f"least in {WINDOW:.0f} s {moves.min():.1f}, {frames.min():.1f}"
        print(f"{now:10} median {np.median(moves):.1f}, {np.median(frames):.1f}; {least}")


if __name__ == "__main__":
    tyro.cli(main)
