"""A run as one HTML file that needs nothing else: viser's own page with a recording of both panes in it."""

from __future__ import annotations

import contextlib
import html
import threading
from collections.abc import Iterator
from dataclasses import replace

import viser

from ido.console import hush
from ido_viz.canvas.pane import PaneView
from ido_viz.core import palette
from ido_viz.core.frame import Frame, frame_at
from ido_viz.core.legend import legend_html
from ido_viz.core.pacing import Pacing
from ido_viz.core.run import Run
from ido_viz.core.state import NO_POINT, State
from ido_viz.core.wording import scene_line

MOST_FRAMES = 500
"""A longer animation has this many frames, further apart."""

_FIRST, _LAST = 1.0, 2.0  # seconds that the start and the end are shown
_APART = 1 / 20  # seconds between two frames
_CAMERA = (0.0, -3.0, 1.05)  # both panes fit in windows at least 1.25 times as wide as high
_LOOK_AT = (0.0, 0.0, 0.1)
_recording = threading.Lock()  # one at a time: the server's greeting is kept off the terminal, which is everybody's


def animation_html(frame: Frame) -> bytes:
    """A page that plays both registrations, titles, iteration numbers and scores, from the start to the end.

    It has a button to play and pause and a slider, and opens without a network. It plays at the pace of the page (see
    `pacing`), with poses between the iterations.
    """
    run, state = frame.run, unpicked(frame.state)
    with _recording, _throw_away_server() as server:
        server.scene.world_axes.visible = False
        server.initial_camera.position = _CAMERA
        server.initial_camera.look_at = _LOOK_AT
        panes = [PaneView(server.scene, pane, titled=True) for pane in range(2)]
        positions, apart = Pacing(run).moments(state.speed, _APART, MOST_FRAMES)
        _draw(panes, run, state, 0.0)
        recording = server.get_scene_serializer()
        recording.insert_sleep(_FIRST)
        for position in positions[1:]:
            _draw(panes, run, state, float(position))
            recording.insert_sleep(apart)
        recording.insert_sleep(_LAST)
        page = recording.as_html(dark_mode=state.dark)
    title = html.escape(f"{run.sides[0].method} and {run.sides[1].method} on {state.shape}")
    page = page.replace("<title>Viser</title>", f"<title>{title}</title>", 1)
    return page.replace("</body>", f"{_caption(frame)}</body>").encode()


def _draw(panes: list[PaneView], run: Run, state: State, position: float) -> None:
    frame = frame_at(run, state, position)
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


def _caption(frame: Frame) -> str:
    """What scene it is and what the colours mean, over the lower left corner."""
    return (
        f'<div style="position:fixed;left:14px;bottom:54px;font:12px/1.5 sans-serif;pointer-events:none;'
        f'color:{palette.css(palette.ink(frame.state.dark))}">{html.escape(scene_line(frame.state))}<br>{legend_html(frame)}</div>'
    )
