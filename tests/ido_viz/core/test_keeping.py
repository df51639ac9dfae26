"""What is kept for a while."""

from __future__ import annotations

import time

from ido_viz.core.keeping import Keeping

PATIENCE = 10.0  # seconds; only a failing test waits that long


def test_what_is_kept_is_given_back_once():
    kept = Keeping[str](PATIENCE, lambda _: None)
    kept.keep("a", "first")
    kept.keep("b", "second")
    assert (kept.take("a"), kept.take("a"), kept.take("c")) == ("first", None, None)
    kept.clear()


def test_what_is_given_back_is_not_dropped_and_what_nobody_comes_for_is():
    dropped: list[str] = []
    kept = Keeping[str](0.2, dropped.append)
    kept.keep("a", "first")
    given_back = kept.take("a")  # a machine that is very busy may be too late
    kept.keep("b", "second")
    deadline = time.monotonic() + PATIENCE
    while dropped != (["second"] if given_back else ["first", "second"]):
        assert time.monotonic() < deadline
        time.sleep(0.01)
    assert kept.take("b") is None


def test_another_by_the_same_key_and_all_at_the_end_are_dropped():
    dropped: list[str] = []
    kept = Keeping[str](60.0, dropped.append)
    kept.keep("a", "first")
    kept.keep("a", "second")
    assert dropped == ["first"]
    kept.clear()
    assert dropped == ["first", "second"]
    assert kept.take("a") is None
