"""How many pages are served at once."""

from __future__ import annotations

import os

import pytest

from ido_viz.serving import room
from ido_viz.serving.room import A_PAGE, A_PROCESSOR, Room, usual_room


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
