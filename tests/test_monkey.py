"""A short run of the monkey, see tests/monkey.py: the long one is run by hand."""

from __future__ import annotations

from headless import run
from load import started
from monkey import ape


def test_a_monkey_leaves_nothing_in_the_log():
    with started() as server:
        run(ape(server, 800, seed=1))
        assert server.log is not None
        assert server.log.read_text() == ""
