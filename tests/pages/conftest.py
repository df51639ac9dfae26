"""Pages that nobody sees, each of a test of its own."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import pytest
from any_explorer import AT_THE_END, AT_THE_START
from apps import app_for as app_for
from apps import no_waiting as no_waiting
from unseen_explorer import OpenUnseen, UnseenExplorer

from ido_viz.app import App
from ido_viz.core.state import State


@pytest.fixture
def open_unseen(app_for: Callable[[State], App]) -> Iterator[OpenUnseen]:
    """Opens pages that begin with a state, by default at the end of a registration and not playing."""
    opened: list[UnseenExplorer] = []

    def open_page(state: State = AT_THE_END, app: App | None = None) -> UnseenExplorer:
        opened.append(UnseenExplorer(app or app_for(state)))
        return opened[-1]

    yield open_page
    for explorer in opened:
        if explorer.is_open:
            explorer.close()


@pytest.fixture
def explorer(open_unseen: OpenUnseen) -> UnseenExplorer:
    """A page at the end of a registration, not playing."""
    return open_unseen()


@pytest.fixture
def at_the_start(open_unseen: OpenUnseen) -> UnseenExplorer:
    """A page before the first iteration, not playing."""
    return open_unseen(AT_THE_START)
