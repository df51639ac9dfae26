"""The command line in tests: run as a user runs it, on files in the user's own units."""

from __future__ import annotations

import sys

import numpy as np
import pytest

from ido import cli
from ido.clouds import Frame
from ido.processes import process_context

FRAME = Frame(np.array([1000.0, -200.0, 50.0]), 37.0)
"""The user's units: the bunny is 74 units long and lies far from the origin."""

BESIDE_ITS_OWN = 2 if process_context("ido").get_start_method() == "forkserver" else 1
"""Processes that Python begins beside those of a command: one tracks what they share, from another they are forked."""

IDO = (sys.executable, "-c", "import sys; from ido.cli import main; sys.exit(main(sys.argv[1:]))")
"""The command in a process of its own."""

TRAINING = ("--histogram", "front-back", "--samples", "500", "--maps", "6")


def fails(capfd: pytest.CaptureFixture[str], *args: str) -> str:
    """The one line on standard error of a command that must fail with exit code 2."""
    assert cli.main(args) == 2
    said = capfd.readouterr()
    assert said.out == ""
    assert said.err.startswith("error: ")
    assert said.err.count("\n") == 1
    assert "Traceback" not in said.err
    return said.err
