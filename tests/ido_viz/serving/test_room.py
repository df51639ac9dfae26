"""How many pages are served at once."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

from ido_viz.serving import room
from ido_viz.serving.room import A_PAGE, A_PROCESSOR, OPEN_FILES, Room, usual_room


@pytest.mark.skipif(not hasattr(os, "sysconf"), reason="Windows does not tell its memory so")
@pytest.mark.parametrize(
    ("processors", "memory", "pages"),
    [(2, 2**34, 2 * A_PROCESSOR), (16, 2**30, 2**30 // A_PAGE), (1, 10**6, 1)],
)
def test_a_machine_serves_what_its_processors_and_its_memory_bear(
    monkeypatch: pytest.MonkeyPatch, processors: int, memory: int, pages: int
):
    monkeypatch.setattr(room.os, "cpu_count", lambda: processors)
    monkeypatch.setattr(room.os, "sysconf", lambda name: 1 if name == "SC_PAGE_SIZE" else memory)
    assert usual_room() == pages


def test_a_room_is_full_when_all_its_places_are_taken():
    assert not Room(3, taken=2).is_full
    assert Room(3, taken=3).is_full


@pytest.mark.skipif(os.name == "nt", reason="Windows has no such limit")
@pytest.mark.parametrize(("soft", "hard", "then"), [(100, 300, 300), (100, 10_000, OPEN_FILES), (9000, 9000, 9000)])
def test_as_many_connections_can_be_open_as_the_system_lets(soft: int, hard: int, then: int):
    script = f"""
import resource
resource.setrlimit(resource.RLIMIT_NOFILE, ({soft}, {hard}))
from ido_viz.serving.room import open_enough_files
open_enough_files()
print(*resource.getrlimit(resource.RLIMIT_NOFILE))
"""
    ended = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert ended.stdout.split() == [str(then), str(hard)]
