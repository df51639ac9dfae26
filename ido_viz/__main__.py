"""The command `ido-viz`."""

from __future__ import annotations

import sys
import threading
import webbrowser
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from ido import CloudError, MapsError
from ido_viz.app import App
from ido_viz.lessons import lesson
from ido_viz.library import Library, shipped_library
from ido_viz.run import compute
from ido_viz.state import State, StateError, decode


@dataclass(frozen=True, slots=True)
class Options:
    """Explore how DO and Improved DO register a perturbed point cloud, step by step, in the browser."""

    shape: str | None = None
    """Shape to begin with: bunny or urban."""
    cloud: Path | None = None
    """A cloud of your own to register; needs --maps."""
    maps: tuple[Path, ...] = ()
    """Maps that `ido train` made of that cloud; the first two are shown."""
    state: str | None = None
    """Code of the state to begin with, copied from the page's Share box."""
    lesson: str | None = None
    """Lesson to begin with; a wrong name lists them all."""
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
        library, state = start(options)
        app = App(state, library=library, host=options.host, port=options.port)
    except (StateError, CloudError, MapsError, OSError, OverflowError) as error:
        print(f"ido-viz: {error}", file=sys.stderr)
        return 2
    print(f"IDO Explorer is at {app.url} (stop it with Ctrl-C)", flush=True)
    # compiles on the very first start, and loads clouds and maps, while the browser loads the page
    threading.Thread(target=compute, args=(state, library), daemon=True).start()
    if options.open:
        webbrowser.open(app.url)
    try:
        app.server.sleep_forever()
    except KeyboardInterrupt:
        app.stop()
    return 0


def start(options: Options) -> tuple[Library, State]:
    """What is on offer, and the state that new tabs begin with.

    Raises:
        StateError: the code, the shape or the combination of options cannot be used.
        CloudError: the cloud cannot be used.
        MapsError: a maps file cannot be used.
    """
    library = shipped_library()
    if options.lesson and (options.state or options.shape or options.cloud or options.maps):
        raise StateError("give --lesson without --state, --shape, --cloud and --maps")
    state = lesson(options.lesson).steps[0].state if options.lesson else State()
    state = decode(options.state) if options.state else state
    if (options.cloud is None) != (not options.maps):
        raise StateError("give --cloud and --maps together; make maps with `ido train CLOUD -o FILE`")
    shape = options.shape
    if options.cloud is not None:
        library, own = library.with_own(options.cloud, options.maps)
        shape = shape or own
    if shape is not None and shape != state.shape:
        state = library.at_shape(state, shape)
    return library, library.checked(state)


if __name__ == "__main__":
    sys.exit(main())
