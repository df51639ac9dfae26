"""What the process beside the server does: it learns maps, or measures them, and tells how far it is."""

from __future__ import annotations

import os
import warnings
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from multiprocessing.connection import Connection
from pathlib import Path
from time import monotonic

from ido import Cloud, Maps, Model, TrainingSettings
from ido.experiments.workers import become_worker
from ido.training import Learner, training_scenes
from ido_viz.own.card import Card
from ido_viz.own.kept import TRAINED, KeptCloud
from ido_viz.own.training_queue import Told

POLITENESS = 5
"""By how much the process gives way to others, where the system knows of that."""

_BETWEEN = 1.0  # seconds between two writings of what was learned, at least


@dataclass(frozen=True, slots=True)
class Order:
    """A training: what `KeptCloud` needs besides its maps, how they are learned, and the seconds until it is ended."""

    name: str
    unit: str
    up: str
    cloud: Cloud
    model: Model
    settings: TrainingSettings
    limit: float | None = None


def learn(order: Order, file: Path, told: Connection) -> None:
    """Learn all methods, map by map side by side, and write what is there to a file again and again.

    When another map would take it beyond the order's limit, it ends with the maps that it has.

    Args:
        order: what to learn.
        file: where the maps go; it is always whole.
        told: gets a `Told` before the first map and after each.
    """
    began = monotonic()
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
        before = monotonic()
        for learner in learners.values():
            learner.learn()
        ends = count == order.settings.maps or _is_late(began, before, order.limit)
        written = ends or monotonic() - last >= _BETWEEN
        if written:
            maps = {method: learner.maps() for method, learner in learners.items()}
            if ends:  # the maps that there are were all that was wanted
                settings = replace(order.settings, maps=count)
                maps = {method: replace(its, settings=settings) for method, its in maps.items()}
            KeptCloud(order.name, order.unit, order.up, order.cloud, maps).save(file)
            last = monotonic()
        told.send(Told(count, tuple(learner.error for learner in learners.values()), written))
        if ends:
            return


def _is_late(began: float, before: float, limit: float | None) -> bool:
    """Whether a map more, as long as that which began at `before`, would end beyond the limit."""
    now = monotonic()
    return limit is not None and (now - began) + (now - before) > limit


def measure(file: Path, card: Path, told: Connection) -> None:
    """Write the quality card of a kept cloud."""
    kept = KeptCloud.load(file)
    measure_maps(kept.cloud, kept.maps, card, told)


def measure_maps(cloud: Cloud, maps: Mapping[str, Maps], card: Path, told: Connection) -> None:
    """Write the quality card of maps of a cloud, by their methods' names."""
    _give_way()
    Card.of(cloud, maps).save(card)


def _give_way() -> None:
    """Leave the processor to the panes, and end with the server."""
    become_worker()
    with suppress(AttributeError, OSError):  # not on Windows, and not where the system forbids it
        os.nice(POLITENESS)
