"""A monkey at the page: thousands of random actions, many of them senseless, of which the server must not complain.

python tests/monkey.py [--actions 10000] [--seed 0]
"""

from __future__ import annotations

import asyncio
import random
import sys
from pathlib import Path
from typing import Any

import tyro

sys.path.insert(0, str(Path(__file__).parent / "helpers"))
sys.path.append(str(Path(__file__).parents[1]))  # or the folders of tests would be taken for the packages

from headless import CAMERA, HeadlessTab, Widget
from load import Server, started

from ido_viz.core.state import State, encode

AWAY = 200
"""Of so many actions, one leaves the page and opens it again, perhaps in the middle of a frame."""

_NONSENSE: tuple[Any, ...] = (
    None,
    "",
    "no such thing",
    "<img src=x onerror=alert(1)>",
    -1,
    10**9,
    1e308,
    float("nan"),
    float("inf"),
    True,
    [],
    [1, 2],
    {"a": 1},
)
_CODES = (
    "ido1-damaged",
    encode(State(left="ICP, tuned")),
    encode(State(shape="urban", left="DO", right="Improved DO")),
)
_NOT_PRESSED = ("Animation (.gif)", "Animation (.html)", "Charts (.zip)")  # they take seconds each


async def act(tab: HeadlessTab, rng: random.Random) -> None:
    """Do something to a page."""
    kind = rng.random()
    if kind < 0.85:
        uuid = rng.choice([uuid for uuid, widget in tab.widgets.items() if widget.label not in _NOT_PRESSED])
        widget = tab.widgets[uuid]
        if widget.kind == "RegisterCommandMessage":
            await tab.send(type="CommandTriggerMessage", uuid=uuid)
        else:
            await tab.send(type="GuiUpdateMessage", uuid=uuid, updates={"value": value_for(widget, rng)})
    elif kind < 0.9:
        place = [rng.uniform(-5, 5) for _ in range(3)]
        await tab.send(**CAMERA | {"position": place, "image_width": rng.choice((300, 1200))})
    elif kind < 0.95:
        ray = {"ray_origin": (0.0, -5.0, 0.0), "ray_direction": (rng.uniform(-0.4, 0.4), 1.0, rng.uniform(-0.2, 0.2))}
        await tab.send(type="ScenePointerMessage", event_type="click", screen_pos=((0.5, 0.5),), modifier=None, **ray)
    else:
        name = rng.choice(("/left/handles", "/right/handles", "/nowhere"))
        await tab.send(type="TransformControlsDragStartMessage", name=name)
        position = [rng.choice((0.1, 1.0, 1e6)) for _ in range(3)]
        await tab.send(type="TransformControlsUpdateMessage", name=name, wxyz=(1.0, 0.0, 0.0, 0.0), position=position)
        await tab.send(type="TransformControlsDragEndMessage", name=name)


def value_for(widget: Widget, rng: random.Random) -> Any:
    """A value for a widget: mostly one that it offers."""
    if rng.random() < 0.25:
        return rng.choice(_NONSENSE)
    if widget.options:
        return rng.choice(widget.options)
    if widget.kind == "GuiCheckboxMessage":
        return rng.random() < 0.5
    if widget.kind == "GuiTextMessage":
        return rng.choice((*_CODES, "bin 0 3 1", "shown 1 0.3 2", "Errors,Inspect,Compare,Sweeps", "Histograms,Maps"))
    if widget.min is not None and widget.max is not None:
        return rng.choice((widget.min, widget.max, round(rng.uniform(widget.min, widget.max))))
    return rng.choice((True, rng.randint(-1, 600)))


async def ape(server: Server, actions: int, seed: int) -> HeadlessTab:
    """So many actions; the tab that is left, which must still get frames."""
    rng = random.Random(seed)
    tab = HeadlessTab(server.address)
    await tab.open()
    for number in range(actions):
        await act(tab, rng)
        if rng.random() < 0.02:
            await asyncio.sleep(0.2)  # so that something is drawn in between
        if rng.random() < 1 / AWAY:
            await tab.close()
            tab = HeadlessTab(server.address)
            await tab.open()
        if number % 1000 == 999:
            print(f"{number + 1} actions", flush=True)
    await tab.close()
    last = HeadlessTab(server.address)
    await last.open()
    await last.close()
    return last


def main(actions: int = 10_000, seed: int = 0) -> int:
    """Let it loose.

    Args:
        actions: So many.
        seed: Draws them.

    Returns:
        1 if the server wrote anything into its log.
    """
    with started() as server:
        asyncio.run(ape(server, actions, seed))
        assert server.log is not None
        said = server.log.read_text()
    print(f"{said.count('Traceback')} tracebacks, {len(said.splitlines())} lines in the log")
    return 1 if said else 0


if __name__ == "__main__":
    sys.exit(tyro.cli(main))
