"""A short run of the measurement of a class, see tests/load.py."""

from __future__ import annotations

import asyncio
import os
import subprocess
import sys
from pathlib import Path

import load
import pytest
from headless import run

HERE = Path(__file__).parent


async def idle(server: load.Server) -> float:
    """Seconds of the processor that five tabs took in one second, in which nobody did anything."""
    tabs = await load.class_of(server, 5)
    for tab in tabs:
        await tab.push("Last")
    await asyncio.sleep(1.0)
    before = server.processor()
    await asyncio.sleep(1.0)
    took = server.processor() - before
    for tab in tabs:
        await tab.close()
    return took


def test_idle_tabs_cost_nothing():
    with load.started() as server:
        assert run(idle(server)) < 0.1


@pytest.mark.parametrize("script", ["load.py", "monkey.py"])
def test_the_scripts_find_the_program_when_they_are_run_by_hand(script: str, tmp_path: Path):
    code = f"import runpy, sys; sys.path[0] = {str(HERE)!r}; runpy.run_path({str(HERE / script)!r}); import ido_viz.app"
    subprocess.run([sys.executable, "-c", code], check=True, cwd=tmp_path, env=os.environ | {"PYTHONPATH": ""})


def test_every_tab_of_a_small_class_gets_its_frames_few_bytes_each_and_is_freed():
    with load.started() as server:
        (figures,) = run(load.measure(server, (3,), 2.0, files=False))
    assert figures.slowest >= 2
    assert figures.bytes / figures.frames < 100_000  # whole charts alone would be twice that
