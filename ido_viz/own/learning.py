"""What the process beside the server does: it learns maps, or measures them, and tells how far it is."""

from __future__ import annotations

import os
import warnings
from contextlib import suppress
from dataclasses import dataclass
from multiprocessing.connection import Connection
from pathlib import Path
from time import monotonic

from ido import Cloud, Model, TrainingSettings
from ido.experiments.workers import become_worker
from ido.training import Learner, training_scenes
from ido_viz.own.card import Card
from ido_viz.own.kept import TRAINED, Kept

POLITENESS = 10
"""By how much the process gives way to others, where the system knows of that."""

_BETWEEN = 1.0  # seconds between two writings of what was learned, at least


@dataclass(frozen=True, slots=True)
class Order:
    """A training: what `Kept` needs besides its maps, and how they are learned."""

    name: str
    unit: str
    up: str
    cloud: Cloud
    model: Model
    settings: TrainingSettings


@dataclass(frozen=True, slots=True)
class Told:
    """How far a process is.

    Args:
        maps: learned so far, of each method.
        errors: mean training error of each method after them, in the order of `TRAINED`.
        written: whether the file holds them.
    """

    maps: int
    errors: tuple[float, ...]
    written: bool


def learn(order: Order, file: Path, told: Connection) -> None:
    """Learn all methods, map by map side by side, and write what is there to a file again and again.

    Args:
        order: what to learn.
        file: where the maps go; it is always whole.
        told: gets a `Told` before the first map and after each.
    """
    _give_way()
    warnings.filterwarnings("ignore", ".*Theorem 1")  # the curve shows it
    scenes = training_scenes(order.cloud, order.settings)
    learners = {
        method: Learner(order.cloud, kind(order.model), order.settings, scenes=scenes)
        for method, kind in TRAINED.items()
    }
    told.send(Told(0, tuple(learner.error for learner in learners.values()), written=False))
    last = -_BETWEEN
    for count in range(1, order.settings.maps + 1):
        for learner in learners.values():
            learner.learn()
        written = monotonic() - last >= _BETWEEN or count == order.settings.maps
        if written:
            maps = {method: learner.maps() for method, learner in learners.items()}
            Kept(order.name, order.unit, order.up, order.cloud, maps).save(file)
            last = monotonic()
        told.send(Told(count, tuple(learner.error for learner in learners.values()), written))


def measure(file: Path, card: Path, told: Connection) -> None:
    """Write the quality card of a kept cloud."""
    _give_way()
    kept = Kept.load(file)
    Card.of(kept.cloud, kept.maps).save(card)


def _give_way() -> None:
    """Leave the processor to the panes, and end with the server."""
    become_worker()
    with suppress(AttributeError, OSError):  # not on Windows, and not where the system forbids it
        os.nice(POLITENESS)
