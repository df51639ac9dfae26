"""Turns: how many at once, and in which order."""

from __future__ import annotations

import threading
import time

import pytest

from ido_viz.core.turns import Turns

PATIENCE = 10.0  # seconds; only a failing test waits that long


@pytest.mark.parametrize("allowed", [1, 2])
def test_no_more_than_so_many_have_their_turn_and_all_get_it_in_the_order_in_which_they_came(allowed: int):
    turns, lock, at_once, most, order = Turns(allowed), threading.Lock(), [0], [0], []

    def work(number: int) -> None:
        with turns.turn():
            with lock:
                order.append(number)
                at_once[0] += 1
                most[0] = max(most[0], at_once[0])
            time.sleep(0.03)
            with lock:
                at_once[0] -= 1

    threads = [threading.Thread(target=work, args=(number,)) for number in range(8)]
    for thread in threads:
        thread.start()
        time.sleep(0.005)  # so that it is known in which order they come
    for thread in threads:
        thread.join(PATIENCE)
    assert all(abs(place - number) < allowed for place, number in enumerate(order))  # two at once may swap
    assert sorted(order) == list(range(8))
    assert most == [allowed]


def test_who_fails_gives_the_turn_back():
    turns = Turns(1)
    for _ in range(3):
        try:
            with turns.turn():
                raise ValueError
        except ValueError:
            pass
    done = threading.Event()

    def work() -> None:
        with turns.turn():
            done.set()

    threading.Thread(target=work, daemon=True).start()
    assert done.wait(PATIENCE)
