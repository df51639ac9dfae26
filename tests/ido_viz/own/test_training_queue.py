"""Work in processes of its own: in turn, one for each person, and whatever becomes of a process, the queue goes on."""

from __future__ import annotations

import os
import signal
import sys
import time
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path

import pytest
from jobs import failing, until_there

from ido_viz.own import training_queue
from ido_viz.own.training_queue import QueuedJob, QueueError, TrainingQueue

PATIENCE = 40.0  # seconds; only a failing test waits that long


def wait(what: str, until: Callable[[], object]) -> None:
    deadline = time.monotonic() + PATIENCE
    while not until():
        assert time.monotonic() < deadline, f"waited in vain for {what}"
        time.sleep(0.01)


@pytest.fixture
def queue() -> Iterator[TrainingQueue]:
    queue = TrainingQueue(lambda: None)
    yield queue
    queue.close()


def test_trainings_run_in_turn_one_for_each_person_and_before_all_else(queue: TrainingQueue, tmp_path: Path):
    order: list[str] = []

    def job(name: str, owner: int | None, maps: int = 1) -> QueuedJob:
        return QueuedJob(
            name, partial(until_there, tmp_path / name), maps, ended=lambda j: order.append(j.title), owner=owner
        )

    first, second, third, card = job("first", 1), job("second", 2), job("third", 3), job("card", None, maps=0)
    queue.submit(first)
    wait("its process", lambda: first.history)
    for other in (card, second, third):
        queue.submit(other)
    assert queue.trainings == (first, second, third)
    with pytest.raises(QueueError, match="you have a training already"):
        queue.submit(job("again", 2))
    for name in ("third", "card", "second", "first"):
        (tmp_path / name).touch()
    wait("all", lambda: len(order) == 4)
    assert order == ["first", "second", "third", "card"]
    assert not any(each.failure for each in (first, second, third, card)) and queue.trainings == ()


def test_what_is_no_training_gives_way_to_one_and_is_begun_anew(queue: TrainingQueue, tmp_path: Path):
    card = QueuedJob("card", partial(until_there, tmp_path / "card"))
    training = QueuedJob("training", partial(until_there, tmp_path / "training"), 1, owner=1)
    queue.submit(card)
    wait("its process", lambda: card.history)
    queue.submit(training)
    wait("the training", lambda: training.history)
    assert not card.over and not is_alive(card.history[0].maps)
    for name in ("training", "card"):
        (tmp_path / name).touch()
    wait("both", lambda: training.over and card.over)
    assert not training.failure and not card.failure and len(card.history) == 2


@pytest.mark.skipif(sys.platform == "win32", reason="signals")
def test_the_death_of_a_process_is_told_and_the_next_job_runs(queue: TrainingQueue, tmp_path: Path):
    killed, after = (
        QueuedJob(name, partial(until_there, tmp_path / name), 1, owner=name) for name in ("killed", "after")
    )
    queue.submit(killed)
    wait("its process", lambda: killed.history)
    queue.submit(after)
    os.kill(killed.history[0].maps, signal.SIGKILL)
    (tmp_path / "after").touch()
    wait("the next one", lambda: after.over)
    assert "ended from outside (signal 9)" in killed.failure
    assert not after.failure and not killed.cancelled


def test_an_error_in_a_process_is_told_in_its_own_words(queue: TrainingQueue):
    job = QueuedJob("failing", failing, 1, owner=1)
    queue.submit(job)
    wait("its end", lambda: job.over)
    assert job.failure == "ValueError: these scenes cannot be drawn"


def test_a_cancelled_job_ends_and_one_that_waits_never_begins(queue: TrainingQueue, tmp_path: Path):
    ended: list[QueuedJob] = []
    running, waiting = (
        QueuedJob(name, partial(until_there, tmp_path / name), 1, ended=ended.append, owner=name) for name in ("a", "b")
    )
    queue.submit(running)
    wait("its process", lambda: running.history)
    queue.submit(waiting)
    queue.cancel(waiting)
    queue.cancel(running)
    wait("its end", lambda: running.over)
    assert ended == [waiting, running] and waiting.history == []
    assert not running.failure and not waiting.failure
    wait("its process's end", lambda: not is_alive(running.history[0].maps))


def is_alive(process: int) -> bool:
    try:
        os.kill(process, 0)
    except OSError:
        return False
    return True


def test_a_training_outlives_its_page_and_counts_for_the_limit(
    queue: TrainingQueue, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(training_queue, "MOST_WAITING", 1)
    job = QueuedJob("left", partial(until_there, tmp_path / "left"), 1, owner=1)
    queue.submit(job)
    wait("its process", lambda: job.history)
    queue.leave(1)
    assert queue.of(1) is None and queue.trainings == (job,) and job.owner is None
    with pytest.raises(QueueError, match="trainings wait already"):
        queue.submit(QueuedJob("one more", failing, 1, owner=1))
    (tmp_path / "left").touch()
    wait("its end", lambda: job.over)
    assert not job.failure


def test_closing_ends_the_process(tmp_path: Path):
    queue = TrainingQueue(lambda: None)
    job = QueuedJob("closed", partial(until_there, tmp_path / "never"), 1, owner=1)
    queue.submit(job)
    wait("its process", lambda: job.history)
    queue.close()
    wait("its end", lambda: not is_alive(job.history[0].maps))
