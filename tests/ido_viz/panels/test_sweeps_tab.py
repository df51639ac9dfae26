"""The tab of the sweeps: what is chosen is what is drawn."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
import viser

from ido.experiments import LEVELS
from ido_viz.core.state import State
from ido_viz.panels import sweeps_tab
from ido_viz.panels.sweeps_tab import SweepsTab


@pytest.fixture(scope="module")
def gui() -> Iterator[viser.GuiApi]:
    server = viser.ViserServer(port=0, verbose=False)
    yield server.gui
    server.stop()


@pytest.fixture
def tab(gui: viser.GuiApi) -> SweepsTab:
    return SweepsTab(gui, lambda _: None, lambda: None)


def levels_of(sweep: str) -> tuple[str, ...]:
    return tuple(f"{level:g}" for level in LEVELS[sweep])


@pytest.mark.parametrize("sweep", LEVELS)
def test_the_levels_on_offer_are_those_of_the_sweep(tab: SweepsTab, sweep: str):
    tab._sweep.value = sweep
    tab.draw(State())
    assert tab._level.options == levels_of(sweep)
    assert len(tab._trial.options) > 1


def test_a_choice_that_comes_while_another_is_drawn_is_drawn_next(tab: SweepsTab, monkeypatch: pytest.MonkeyPatch):
    rows_of = sweeps_tab.rows_of

    def while_a_person_chooses(shape: str, sweep: str) -> object:
        tab._sweep.value = "rotation"
        return rows_of(shape, sweep)

    monkeypatch.setattr(sweeps_tab, "rows_of", while_a_person_chooses)
    tab.draw(State())
    monkeypatch.setattr(sweeps_tab, "rows_of", rows_of)
    tab.draw(State())
    assert tab._level.options == levels_of("rotation")
