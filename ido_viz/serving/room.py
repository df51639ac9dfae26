"""How many pages are served at once, and what one is told for which there is no room."""

from __future__ import annotations

import contextlib
import os
from dataclasses import dataclass

A_PROCESSOR = 30
"""Pages by default: a class of so many can drag its sliders at once, see assets/docs/class.md."""

A_PAGE = 20_000_000
"""Bytes of memory that are reckoned for a page by default; one took a quarter of that."""


OPEN_FILES = 8192
"""Of a process, where the system lets it."""


@dataclass
class Room:
    """How many connections there may be, and are; to be used on the server's thread alone."""

    most: int
    taken: int = 0

    @property
    def is_full(self) -> bool:
        """Whether there is no room for another page."""
        return self.taken >= self.most


def usual_room() -> int:
    """How many pages this machine should serve at once."""
    processors = A_PROCESSOR * (os.cpu_count() or 1)
    if not hasattr(os, "sysconf"):  # on Windows
        return processors
    memory = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    return max(1, min(processors, memory // A_PAGE))


def open_enough_files() -> None:
    """Let this process and those that it starts have as many connections open as there are pages in a full room.

    A page takes two where several servers stand behind one address; some systems give 256 unless asked for more.
    """
    try:
        import resource
    except ImportError:  # on Windows there is no such limit
        return
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    wanted = OPEN_FILES if hard == resource.RLIM_INFINITY else min(OPEN_FILES, hard)
    if soft != resource.RLIM_INFINITY and soft < wanted:
        with contextlib.suppress(ValueError, OSError):  # a system may promise more than it gives
            resource.setrlimit(resource.RLIMIT_NOFILE, (wanted, hard))


FULL = """<!doctype html>
<html lang="en">
<meta charset="utf-8">
<meta http-equiv="refresh" content="10">
<title>IDO Explorer is full</title>
<body style="font:1.1rem/1.5 sans-serif;max-width:32rem;margin:20vh auto;padding:0 1rem">
<h1>The explorer is full</h1>
<p>As many pages are open as it shows at once. This page tries again every ten seconds; it goes on as soon as
somebody closes theirs.</p>
<p>Whoever runs it can let more in with <code>ido-viz --sessions N</code>.</p>
</body>
</html>
"""
"""What somebody sees for whom there is no room; it tries again by itself."""
