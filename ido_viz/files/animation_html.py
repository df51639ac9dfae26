"""A run as one HTML file that needs nothing else: viser's own page with a recording of both panes in it."""

from __future__ import annotations

import contextlib
import html
import threading
from collections.abc import Iterator
from dataclasses import replace

import viser

from ido.console import hush
from ido.recording import chosen_iterations
from ido_viz.canvas.pane import PaneView
from ido_viz.core import palette
from ido_viz.core.frame import Frame, frame_of
from ido_viz.core.run import Run
from ido_viz.core.state import NO_POINT, State
from ido_viz.core.wording import scene_line

MOST_FRAMES = 500
"""Of a longer run, this many iterations are shown."""

_FIRST, _LAST = 1.0, 2.0  # seconds that the start and the end are shown
_CAMERA = (0.0, -3.0, 1.05)  # both panes fit in windows at least 1.25 times as wide as high
_LOOK_AT = (0.0, 0.0, 0.1)
_recording = threading.Lock()  # one at a time: the server's greeting is kept off the terminal, which is everybody's


def animation_html(frame: Frame) -> bytes:
    """A page that plays both registrations, titles, iteration numbers and scores, from the start to the end.

    It has a button to play and pause and a slider, and opens without a network. Iterations pass at the state's speed;
    of more than `MOST_FRAMES` the first half of those are shown one by one and the rest evenly spaced.
    """
    run, state = frame.run, unpicked(frame.state)
    with _recording, _throw_away_server() as server:
        server.scene.world_axes.visible = False
        server.initial_camera.position = _CAMERA
        server.initial_camera.look_at = _LOOK_AT
        panes = [PaneView(server.scene, pane) for pane in range(2)]
        _draw(panes, run, state, 0)
        recording = server.get_scene_serializer()
        recording.insert_sleep(_FIRST)
        for iteration in chosen_iterations(run.iterations, MOST_FRAMES)[1:]:
            _draw(panes, run, state, int(iteration))
            recording.insert_sleep(1 / state.speed)
        recording.insert_sleep(_LAST)
        page = recording.as_html(dark_mode=state.dark)
    title = html.escape(f"{run.sides[0].method} and {run.sides[1].method} on {state.shape}")
    page = page.replace("<title>Viser</title>", f"<title>{title}</title>", 1)
    return page.replace("</body>", f"{_caption(state)}</body>").encode()


def _draw(panes: list[PaneView], run: Run, state: State, iteration: int) -> None:
    frame = frame_of(run, replace(state, iteration=iteration))
    for pane in panes:
        pane.draw(frame)


def unpicked(state: State) -> State:
    """A state in which nothing is looked into: whoever opens a recording cannot pick anything else."""
    return replace(state, inspected=NO_POINT, scene_point=NO_POINT, coloring="height")


@contextlib.contextmanager
def _throw_away_server() -> Iterator[viser.ViserServer]:
    with hush():
        server = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
    try:
        yield server
    finally:
        with hush():
            server.stop()


def _caption(state: State) -> str:
    """What scene it is and what the colours mean, over the lower left corner."""
    legend = " &nbsp;".join(
        "".join(f'<span style="color:{palette.css(color)}">●</span>' for color in dots) + f" {name}"
        for name, dots in palette.LEGEND.items()
    )
    return (
        f'<div style="position:fixed;left:14px;bottom:54px;font:12px/1.5 sans-serif;pointer-events:none;'
        f'color:{palette.css(palette.ink(state.dark))}">{html.escape(scene_line(state))}<br>{legend}</div>'
    )
