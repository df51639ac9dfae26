"""The command `ido-viz`."""

from __future__ import annotations

import sys
import threading
import webbrowser
from dataclasses import dataclass
from typing import Annotated, Literal

import tyro

from ido_viz.app import App
from ido_viz.run import compute
from ido_viz.state import State, StateError, decode


@dataclass(frozen=True, slots=True)
class Options:
    """Explore how DO and Improved DO register a perturbed point cloud, step by step, in the browser."""

    shape: Literal["bunny", "urban"] | None = None
    """Shape to begin with."""
    state: str | None = None
    """Code of the state to begin with, copied from the page's Share box."""
    host: str = "127.0.0.1"
    """Address to listen on; 0.0.0.0 lets other machines in."""
    port: Annotated[int, tyro.conf.arg(metavar="PORT")] = 8080
    """Port to listen on; if it is busy, the next free one is taken and printed."""
    open: bool = True
    """Open the page in a browser."""


def main() -> int:
    """Run the explorer until Ctrl-C."""
    options = tyro.cli(Options, prog="ido-viz")
    try:
        state = start_state(options)
        app = App(state, host=options.host, port=options.port)
    except (StateError, OSError, OverflowError) as error:
        print(f"ido-viz: {error}", file=sys.stderr)
        return 2
    print(f"IDO Explorer is at {app.url} (stop it with Ctrl-C)", flush=True)
    # compiles on the very first start, and loads clouds and maps, while the browser loads the page
    threading.Thread(target=compute, args=(state,), daemon=True).start()
    if options.open:
        webbrowser.open(app.url)
    try:
        app.server.sleep_forever()
    except KeyboardInterrupt:
        app.stop()
    return 0


def start_state(options: Options) -> State:
    """The state that new tabs begin with.

    Raises:
        StateError: the code cannot be used.
    """
    state = decode(options.state) if options.state else State()
    if options.shape and options.shape != state.shape:
        state = state.with_shape(options.shape)
    return state


if __name__ == "__main__":
    sys.exit(main())
