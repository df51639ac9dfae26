"""From a file to a kept shape and back, on one server, by the ways that the page takes, without a page."""

from __future__ import annotations

import io
import multiprocessing
import pickle
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from ido import MapsError, TrainingSettings, perturb, register, score, train
from ido.experiments import LEVELS
from ido.perturbation import Perturbation
from ido_viz.core.library import Library, shipped_library
from ido_viz.own import card as card_module
from ido_viz.own import learning
from ido_viz.own.card import Card
from ido_viz.own.draft import Draft
from ido_viz.own.kept import TRAINED, KeptCloud
from ido_viz.own.learning import measure_maps
from ido_viz.own.shelf import ShelfError
from ido_viz.own.training_queue import Told
from ido_viz.own.workshop import Workshop

PATIENCE = 60.0  # seconds; only a failing test waits that long
SETTINGS = TrainingSettings(samples=80, maps=3, rotation=30.0, translation=0.1)


@pytest.fixture
def workshop(tmp_path: Path) -> Iterator[Workshop]:
    workshop = Workshop(shipped_library(), tmp_path / "data")
    yield workshop
    workshop.close()


def wait(what: str, until: Callable[[], object]) -> None:
    deadline = time.monotonic() + PATIENCE
    while not until():
        assert time.monotonic() < deadline, f"waited in vain for {what}"
        time.sleep(0.01)


def kept_tiny(workshop: Workshop) -> KeptCloud:
    """What lies in the folder."""
    return KeptCloud.load(workshop.shelf.place("tiny").maps)


def measures(workshop: Workshop, name: str) -> bool:
    """Whether a card is being made."""
    return any(job.title == name and job.running and not job.maps for job in workshop.queue._jobs)


def test_a_cloud_is_trained_watched_kept_and_judged(workshop: Workshop, tiny_draft: Draft):
    seen: list[int] = []

    def look() -> None:
        subject = workshop.library.subjects.get("tiny")
        if subject is not None:
            seen.append(len(subject.maps["DO"]().maps))

    workshop.shelf.watch(look)
    job = workshop.train(tiny_draft, SETTINGS, 1.0, None, owner=1)
    wait("its end", lambda: job.over)
    assert job.failure == ""
    assert seen == sorted(seen) and seen[0] < 3 and seen[-1] == 3  # the first map could be seen before the last
    assert [told.maps for told in job.history] == [0, 1, 2, 3]
    kept = kept_tiny(workshop)
    for method, kind in TRAINED.items():
        expected = train(tiny_draft.cloud, kind(tiny_draft.model), SETTINGS)
        np.testing.assert_array_equal(kept.maps[method].maps, expected.maps)
    wait("its card to be begun", lambda: measures(workshop, "tiny"))
    assert [path.suffix for path in workshop.shelf.folder.iterdir()] == [".npz"]
    assert workshop.unit_of("tiny") == "mm" and workshop.unit_of("bunny") == "units"


def test_a_training_that_would_take_too_long_ends_with_the_maps_it_has(workshop: Workshop, tiny_draft: Draft):
    began = time.monotonic()
    job = workshop.train(tiny_draft, replace(SETTINGS, maps=1000), 1.0, 0.5, owner=1)
    wait("its end", lambda: job.over)
    assert not job.failure and time.monotonic() - began < PATIENCE / 2
    for maps in kept_tiny(workshop).maps.values():
        assert len(maps.maps) == job.history[-1].maps < 1000 and maps.complete


def test_a_page_that_fails_to_show_a_training_does_not_end_it(workshop: Workshop, tiny_draft: Draft):
    def broken() -> None:
        raise RuntimeError("this page is gone")

    told: list[int] = []
    for watcher in (broken, lambda: told.append(1)):
        workshop.watch(watcher)
    job = workshop.train(tiny_draft, SETTINGS, 1.0, None, owner=1)
    wait("its end", lambda: job.over)
    assert not job.failure and workshop.shelf.kept == ("tiny",) and told


def test_of_a_cancelled_training_nothing_is_left(workshop: Workshop, tiny_draft: Draft):
    job = workshop.train(tiny_draft, replace(SETTINGS, maps=1000), 1.0, None, owner=1)
    wait("its first map", lambda: "tiny" in workshop.library.subjects)
    workshop.queue.cancel(job)
    wait("its end", lambda: job.over)
    assert "tiny" not in workshop.library.subjects
    assert list(workshop.shelf.folder.iterdir()) == []


def test_two_drafts_of_a_name_get_two_names(workshop: Workshop, tiny_draft: Draft):
    jobs = [workshop.train(tiny_draft, SETTINGS, 1.0, None, owner=owner) for owner in (1, 2)]
    assert [job.title for job in jobs] == ["tiny", "tiny (2)"]
    for job in jobs:
        workshop.queue.cancel(job)


def test_what_is_downloaded_can_be_taken_in_elsewhere(workshop: Workshop, kept: KeptCloud, tmp_path: Path):
    workshop.shelf.keep(kept)
    content = workshop.given_away("tiny")
    assert workshop.take_in("whatever.npz", content) == "tiny (2)"
    scene = perturb(kept.cloud, Perturbation(rotation=10.0, points=200, outliers=0, seed=3))
    here, there = (workshop.library.subject(name).maps["Improved DO"]() for name in ("tiny", "tiny (2)"))
    np.testing.assert_array_equal(register(here, scene.points).x, register(there, scene.points).x)


@pytest.mark.parametrize("content", [b"", b"nothing", b"PK\x03\x04"])
def test_a_file_that_is_none_of_ours_is_refused_by_its_name(workshop: Workshop, content: bytes):
    with pytest.raises(MapsError, match=r"^<b>\.npz"):
        workshop.take_in("<b>.npz", content)
    foreign = io.BytesIO()
    np.savez(foreign, x=np.zeros(3))
    with pytest.raises(MapsError, match=r"^foreign\.npz"):
        workshop.take_in("foreign.npz", foreign.getvalue())
    assert list(workshop.shelf.folder.iterdir()) == [] and workshop.shelf.kept == ()


def test_deleting_tells_who_else_is_there_and_that_it_is_gone(workshop: Workshop, kept: KeptCloud):
    workshop.shelf.keep(kept)
    changes: list[bool] = []

    def changed() -> None:
        changes.append("tiny" in workshop.library.subjects)

    for visitor, shape in ((1, "tiny"), (2, "tiny"), (3, "bunny")):
        workshop.enter(visitor, lambda shape=shape: shape, changed)
    assert (workshop.others_at("tiny", 1), workshop.others_at("tiny", 3)) == (1, 2)
    workshop.delete("tiny")
    assert changes == [False] * 3
    with pytest.raises(ShelfError, match="any more"):
        workshop.delete("tiny")
    for visitor in (1, 2, 3):
        workshop.leave(visitor, changed)


def test_a_card_that_was_never_made_is_made_by_the_next_server(workshop: Workshop, kept: KeptCloud):
    workshop.shelf.keep(kept)
    assert workshop.shelf.card("tiny") is None
    again = Workshop(shipped_library(), workshop.shelf.folder)
    wait("the card to be begun", lambda: measures(again, "tiny"))
    again.close()
    Card({"DO": {name: (0.5,) * len(levels) for name, levels in LEVELS.items()}}).save(
        workshop.shelf.place("tiny").card
    )
    with_card = Workshop(shipped_library(), workshop.shelf.folder)
    assert not measures(with_card, "tiny") and with_card.shelf.card("tiny") is not None
    with_card.close()


def test_a_file_that_is_lost_while_it_is_learned_is_told(workshop: Workshop, tiny_draft: Draft):
    job = workshop.train(tiny_draft, SETTINGS, 1.0, None, owner=1)
    (told,) = (job.told,)
    workshop.queue.cancel(job)
    with pytest.raises(MapsError, match="no such file"):
        told(Told(1, (0.5, 0.5), written=True))


def test_a_draft_s_maps_register_its_scenes(workshop: Workshop, tiny_draft: Draft):
    """Enough is learned to be of use, in the units that were set."""
    job = workshop.train(tiny_draft, replace(SETTINGS, samples=400, maps=5), 1.0, None, owner=1)
    wait("its end", lambda: job.over)
    maps = kept_tiny(workshop).best
    assert maps.frame.scale == 78.0
    scene = perturb(tiny_draft.cloud, Perturbation(noise=0.0, rotation=20.0, translation=0.05, outliers=0, seed=1))
    moved = register(maps, scene.points)
    assert score(scene, moved.T_model_scene[-1]).accuracy > 0.9


def test_maps_that_the_server_began_with_get_a_card_when_they_are_shown_and_once(kept: KeptCloud, tmp_path: Path):
    given = Library({**shipped_library().subjects, "mine": kept.subject()})
    workshop = Workshop(given, tmp_path)
    assert [name for name in workshop.shelf if workshop.is_given(name)] == ["mine"]
    assert workshop.queue._jobs == []  # not before it is shown
    told: list[Card | None] = []
    workshop.watch(lambda: told.append(workshop.card("mine")))  # as pages do when they are told
    for name in ("mine", "bunny", "mine"):
        workshop.judge(name)
    assert told and set(told) == {None}
    wait("the card to be begun", lambda: measures(workshop, "mine"))
    assert len(workshop.queue._jobs) == 1
    workshop.close()
    made = Card({name: {sweep: (0.5,) * len(levels) for sweep, levels in LEVELS.items()} for name in kept.maps})
    made.save(tmp_path / Card.name_of(kept.maps))
    again = Workshop(given, tmp_path)
    again.judge("mine")
    assert again.card("mine") == made and again.queue._jobs == []
    again.close()


def test_the_card_of_given_maps_is_that_of_these_maps(kept: KeptCloud, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(card_module, "SCENES", 2)
    monkeypatch.setattr(card_module, "LEVELS", {"rotation": LEVELS["rotation"]})
    monkeypatch.setattr(learning, "_give_way", lambda: None)  # that is for a process of its own
    maps = pickle.loads(pickle.dumps(kept.maps))  # as they go to a process
    here, there = multiprocessing.Pipe()
    measure_maps(kept.cloud, maps, tmp_path / Card.name_of(maps), there)
    here.close()
    assert Card.load(tmp_path / Card.name_of(kept.maps)) == Card.of(kept.cloud, kept.maps)
    other = {"DO": replace(kept.maps["DO"], maps=2 * kept.maps["DO"].maps)}
    names = {Card.name_of(its) for its in (kept.maps, {"DO": kept.maps["DO"]}, other)}
    assert len(names) == 3
