"""What the commands say besides their results: notes and progress, on standard error."""

from __future__ import annotations

import contextlib
import io
import signal
import sys
import threading
from collections.abc import Iterator

import rich
from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn


def note(markup: str) -> None:
    """Print a line of rich markup."""
    Console(stderr=True).print(markup, soft_wrap=True, highlight=False)


def progress_bar(*columns: str) -> Progress:
    """A bar with the time that has passed and that is left, between a text before it and texts after it."""
    before, *after = columns
    return Progress(
        TextColumn(before),
        BarColumn(),
        *map(TextColumn, after),
        TimeElapsedColumn(),
        TimeRemainingColumn(),
        TextColumn("left"),
        console=Console(stderr=True),
        speed_estimate_period=3600,
    )


@contextlib.contextmanager
def ended_as_by_ctrl_c() -> Iterator[None]:
    """Have a request to end (SIGTERM, as of a cluster whose time is up) do what Ctrl-C does."""
    if threading.current_thread() is not threading.main_thread():  # which alone can be told
        yield
        return
    before = signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)


def replace_what_cannot_be_shown() -> None:
    """Show a ? where the terminal's encoding has no such letter as λ or ±, rather than lose what was computed."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")


@contextlib.contextmanager
def hush() -> Iterator[None]:
    """Keep what a library prints, to a terminal or into a notebook's cell, to itself."""
    console = rich.get_console()
    was, console.quiet = console.quiet, True
    try:
        with contextlib.redirect_stdout(io.StringIO()):
            yield
    finally:
        console.quiet = was
