"""A short run of the measurement of a class, see tests/load.py."""

from __future__ import annotations

import asyncio

import load


def test_every_tab_of_a_small_class_gets_its_frames_few_bytes_each_and_is_freed():
    with load.started() as server:
        (figures,) = asyncio.run(load.measure(server, (3,), 2.0, files=False))
    assert figures.slowest >= 2
    assert figures.bytes / figures.frames < 100_000  # whole charts alone would be twice that
