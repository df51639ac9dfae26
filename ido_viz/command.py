"""What the command `ido-viz` does."""

from __future__ import annotations

import asyncio
import contextlib
import gc
import sys
import threading
import webbrowser
from dataclasses import dataclass, replace
from functools import partial
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Annotated

import tyro
from platformdirs import user_data_path
from rich.markup import escape

from ido import CloudError, MapsError, OwnError
from ido.console import note
from ido_viz.app import App
from ido_viz.core.library import Library, shipped_library
from ido_viz.core.plugins import QUICK, QUICK_POINTS, classes_of
from ido_viz.core.run import warm_up
from ido_viz.core.state import State, StateError, decode
from ido_viz.own.draft import Draft, read_draft
from ido_viz.serving.entrance import Entrance
from ido_viz.serving.guests import OriginError, read_origins
from ido_viz.serving.listening import ListenError, listen, opens_to_others
from ido_viz.serving.room import open_enough_files, usual_room
from ido_viz.serving.servers import Ready, ServersError, serve_with, shares_of, usual_servers
from ido_viz.teach.content import ContentError
from ido_viz.teach.lessons import lesson

HISTOGRAM_HELP = (
    "Histograms of your own. If none of --maps is of it, maps are trained when it is first shown: "
    f"{QUICK.maps} maps on {QUICK.samples} scenes and {QUICK_POINTS} model points, much less than `ido train` takes."
)


@dataclass(frozen=True, slots=True)
class Options:
    """Explore how DO and Improved DO register a perturbed point cloud, step by step, in the browser."""

    shape: str | None = None
    """Shape to begin with: bunny or urban."""
    cloud: Path | None = None
    """A cloud or mesh of your own: to train on in the page, or with --maps to explore what was trained."""
    maps: tuple[Path, ...] = ()
    """Maps that `ido train` made of that cloud; the first two are shown."""
    method: Annotated[tuple[str, ...], tyro.conf.arg(metavar="MODULE:CLASS ...")] = ()
    """Methods of your own, as module:Class or path/to/file.py:Class; the first is shown. See the README."""
    histogram: Annotated[tuple[str, ...], tyro.conf.arg(metavar="MODULE:CLASS ...", help=HISTOGRAM_HELP)] = ()
    state: str | None = None
    """Code of the state to begin with, copied from the page's Share box."""
    lesson: str | None = None
    """Lesson to begin with; a wrong name lists them all."""
    host: str = "127.0.0.1"
    """Address to listen on; 0.0.0.0 lets other machines in."""
    port: Annotated[int | None, tyro.conf.arg(metavar="PORT")] = None
    """Port to listen on, 0 for any; the first free one from 8080 on unless given."""
    token: bool = True
    """Answer other machines only with the token of the printed address."""
    allow_origin: Annotated[tuple[str, ...], tyro.conf.arg(metavar="ORIGIN ...")] = ()
    """Where else the page may come from, as https://example.org of a proxy."""
    sessions: Annotated[int | None, tyro.conf.arg(metavar="N")] = None
    """Pages that are served at once; as many as suit the machine unless given."""
    servers: Annotated[int | None, tyro.conf.arg(metavar="N")] = None
    """Processes that serve them; one, and where other machines are let in one a processor (4 at most), unless given."""
    data: Path | None = None
    """Folder where clouds that were trained on in the page are kept; the system's own place for that unless given."""
    open: bool = True
    """Open the page in a browser."""

    @property
    def explores_cloud(self) -> bool:
        """Whether the cloud can be registered from the start; else it is trained on in the page."""
        return self.cloud is not None and bool(self.maps or self.method or self.histogram)


OPEN_WITH_TOKEN = (
    "Other machines can open this address. Whoever has it can use this machine to compute; nothing is encrypted."
)
OPEN_TO_ALL = (
    "Everybody who can reach this machine can open this address and use the machine to compute; nothing is encrypted."
)


REFUSALS = (StateError, ContentError, CloudError, MapsError, OwnError, ListenError, OriginError, ServersError, OSError)


def run() -> int:
    """Run the explorer until Ctrl-C; what the command ends with."""
    options = tyro.cli(Options, prog="ido-viz")
    try:
        if any(number is not None and number < 1 for number in (options.sessions, options.servers)):
            raise StateError("--sessions and --servers must be at least 1")
        open_enough_files()
        servers = options.servers or usual_servers(is_open=opens_to_others(options.host))
        if servers == 1:
            serve(options)
        else:
            serve_by_several(options, servers)
    except KeyboardInterrupt:
        return 0
    except REFUSALS as error:
        print(f"ido-viz: {error}", file=sys.stderr)
        return 2
    return 0


def serve(options: Options) -> None:
    """Serve in this process, until Ctrl-C.

    Raises:
        Exception: one of `REFUSALS`.
    """
    library, state = start(options)
    app = App(
        state,
        library=library,
        host=options.host,
        port=options.port,
        token=options.token,
        origins=options.allow_origin,
        sessions=options.sessions,
        data=data_folder(options),
        draft=draft(options),
    )
    try:
        announce(options, app.entrance, app.unreadable)
        # while the browser loads the page
        threading.Thread(target=get_ready, args=(state, library), daemon=True).start()
        app.server.sleep_forever()
    finally:
        app.stop()


def serve_by_several(options: Options, servers: int) -> None:
    """Serve by several processes, until Ctrl-C.

    Raises:
        Exception: one of `REFUSALS`.
    """
    origins, data = read_origins(options.allow_origin), data_folder(options)
    shares = shares_of(options.sessions or usual_room(), servers)
    with listen(options.host, options.port) as listener:
        entrance = Entrance.of(listener, options.host, token=options.token, origins=origins)
        serves = [partial(serve_behind, options, data, entrance, share) for share in shares]

        def stands(ready: Ready) -> None:
            announce(options, entrance, ready.notes)

        asyncio.run(serve_with(serves, shares, listener, stands))


def serve_behind(options: Options, data: Path | None, entrance: Entrance, share: int, there: Connection) -> None:
    """What each of several processes does: serve until the one that started it says so, or has ended itself."""
    try:
        library, state = start(options)
        app = App(state, library=library, sessions=share, data=data, draft=draft(options), entrance=entrance)
    except REFUSALS as error:
        with contextlib.suppress(OSError):
            there.send(str(error))
        return
    try:
        with contextlib.suppress(EOFError, OSError):  # the other end is gone
            there.send(Ready(app.server.get_port(), app.unreadable))
            threading.Thread(target=get_ready, args=(state, library), daemon=True).start()
            there.recv()
    finally:
        app.stop()


def announce(options: Options, entrance: Entrance, notes: tuple[str, ...]) -> None:
    """Say where the page is, and open it."""
    print(f"IDO Explorer is at {entrance.url} (stop it with Ctrl-C)", flush=True)
    if entrance.is_open:
        note(f"[yellow]{OPEN_WITH_TOKEN if options.token else OPEN_TO_ALL}[/]")
    for text in notes:
        note(f"[yellow]this kept cloud cannot be read: {escape(text)}[/]")
    if options.open:
        webbrowser.open(entrance.url)


def draft(options: Options) -> Draft | None:
    """The cloud that pages begin with, to be trained on there; None where there is none.

    Raises:
        CloudError: it cannot be used.
    """
    return read_draft(options.cloud) if options.cloud and not options.explores_cloud else None


def get_ready(state: State, library: Library) -> None:
    """Compile, on the very first start, and load clouds and maps.

    What there is then stays, and the collector of garbage, which stops all pages while it looks, need not look at it.
    """
    warm_up(state, library)
    gc.freeze()


def data_folder(options: Options) -> Path | None:
    """Where people's own clouds are kept; None, and a note, where the system's folder for them cannot be made.

    Raises:
        OSError: the folder that was asked for cannot be made.
    """
    folder = options.data or user_data_path("ido-explorer", appauthor=False)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        if options.data is not None:
            raise
        note(f"[yellow]own clouds cannot be kept ({escape(str(error))}); name a folder with --data[/]")
        return None
    return folder


def start(options: Options) -> tuple[Library, State]:
    """What is on offer, and the state that new tabs begin with.

    Raises:
        StateError: the code, the shape or the combination of options cannot be used.
        CloudError: the cloud cannot be used.
        MapsError: a maps file cannot be used.
        OwnError: a method or histogram of one's own is not named as it must be.
    """
    library = shipped_library()
    if options.lesson and (options.state or options.shape or options.cloud or options.maps):
        raise StateError("give --lesson without --state, --shape, --cloud and --maps")
    state = lesson(options.lesson).steps[0].state if options.lesson else State()
    state = decode(options.state) if options.state else state
    if options.maps and options.cloud is None:
        raise StateError("give --maps with the --cloud that they were trained on")
    taken = {name for shape in library.subjects for name in library.methods(shape)}
    classes = classes_of(options.method, options.histogram, taken | {path.stem for path in options.maps})
    shape = options.shape
    if options.cloud is not None and options.explores_cloud:
        library, own_shape = library.with_own(options.cloud, options.maps, classes)
        shape = shape or own_shape
    library = library.with_methods(classes)
    if shape is not None and shape != state.shape:
        state = library.at_shape(state, shape)
    own = library.subject(state.shape).own
    if own and not (options.state or options.lesson):
        state = replace(state, left=next(iter(own)))
    return library, library.checked(state)
