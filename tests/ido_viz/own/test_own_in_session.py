"""A page whose shape is being learned, and then deleted: it follows, and says so."""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from tab import PAUSED, Computing, Tab

from ido_viz.core.history import AT_ONCE, OF_ONE_HAND
from ido_viz.core.library import Library, shipped_library
from ido_viz.own.kept import KeptCloud
from ido_viz.own.shelf import Shelf


@pytest.fixture
def shelf(tmp_path: Path) -> Shelf:
    return Shelf(shipped_library().subjects, tmp_path)


@pytest.fixture
def tab(shelf: Shelf, kept: KeptCloud, computing: Computing) -> Iterator[Tab]:
    """A page that shows the cloud with its first maps."""
    first = {name: replace(maps, maps=maps.maps[:1]) for name, maps in kept.maps.items()}
    shelf.show(replace(kept, maps=first))
    tab = Tab(replace(PAUSED, shape="tiny"), Library(shelf))
    shelf.watch(tab.session._wake)
    tab.settle()
    yield tab
    tab.session.close()
    tab.wait("the end of the session", lambda: not tab.is_served)


def test_the_panes_use_each_map_as_soon_as_it_is_learned(tab: Tab, shelf: Shelf, kept: KeptCloud):
    before = tab.shown.run
    assert [len(side.maps.maps) for side in before.sides if side.maps is not None] == [1, 1]
    shelf.show(kept)
    tab.wait("the second map", lambda: tab.shown.run is not before)
    after = tab.settle().run
    assert [len(side.maps.maps) for side in after.sides if side.maps is not None] == [2, 2]
    np.testing.assert_array_equal(after.scene.points, before.scene.points)


def test_a_page_whose_shape_is_deleted_goes_to_another_and_says_so(tab: Tab, shelf: Shelf):
    shelf.withdraw("tiny")
    tab.wait("another shape", lambda: tab.shown.state.shape == "bunny")
    assert tab.settle().state.perturbation == PAUSED.perturbation
    assert tab.widgets.shape == "bunny"
    assert tab.notes == ["This cloud is gone: tiny is not kept on this server any more; the page shows bunny."]
    tab.actions.step(1)
    assert tab.settle().iteration == 1


def test_undo_does_not_lead_back_to_a_deleted_shape(tab: Tab, shelf: Shelf):
    tab.actions.set_values({"rotation": 12.0})
    tab.settle()
    shelf.withdraw("tiny")
    tab.wait("another shape", lambda: tab.shown.state.shape == "bunny")
    tab.actions.undo()
    assert tab.settle().state.shape == "bunny"
    assert all(note.startswith("This cloud is gone") for note in tab.notes)


def test_what_was_done_before_a_deleted_shape_was_shown_is_undone_behind_it(tab: Tab, shelf: Shelf):
    tab.set(shape="bunny")
    for change in ({"noise": 0.08}, {"shape": "tiny"}):
        tab.settle()
        time.sleep(AT_ONCE)  # or it would be one with the change before
        tab.set(**change)
    tab.settle()
    time.sleep(OF_ONE_HAND)
    shelf.withdraw("tiny")
    tab.wait("another shape", lambda: tab.shown.state.shape == "bunny")
    noises = []
    for _ in range(2):
        tab.actions.undo()
        noises.append(tab.settle().state.perturbation.noise)
    assert noises == [0.08, PAUSED.perturbation.noise]


def test_a_shape_that_cannot_have_the_shown_methods_brings_its_own(tab: Tab):
    tab.set(shape="bunny")
    tab.settle()
    tab.set(left="Improved DO (near / far)")
    tab.settle()
    tab.actions.show_shape("tiny")
    shown = tab.settle().state
    assert (shown.shape, shown.left, shown.right) == ("tiny", "DO", "Improved DO")
