"""The tab Own cloud: from a file to a shape of the page, trained, kept, judged and registered to."""

from __future__ import annotations

import threading
from collections.abc import Callable

import viser

from ido_viz.core.run import inputs
from ido_viz.core.state import State
from ido_viz.own.draft import Draft
from ido_viz.own.draft_folder import DraftFolder
from ido_viz.own.kept_folder import KeptFolder, card_html
from ido_viz.own.own_scan import LastScan
from ido_viz.own.own_scan_folder import OwnScanFolder
from ido_viz.own.preview import Preview
from ido_viz.own.train_folder import TrainFolder
from ido_viz.own.workshop import Workshop

NAME = "Own cloud"


class OwnCloudTab:
    """The parts of the tab, one below the other.

    Args:
        client: the page.
        workshop: of the server.
        preview: of the page.
        last_scan: of the page, also before it was reloaded.
        state: what the page begins with.
        show_shape: called with the name of a shape that the panes are to show.
    """

    def __init__(
        self,
        client: viser.ClientHandle,
        workshop: Workshop,
        preview: Preview,
        last_scan: LastScan,
        state: State,
        show_shape: Callable[[str], None],
    ) -> None:
        self._workshop, self._state, self._show_shape = workshop, state, show_shape
        self._turn = threading.Lock()  # the queue tells on its thread, the page draws on another
        gui = client.gui
        self._preview = preview
        self._draft = DraftFolder(gui, workshop, self._preview, self._estimate)
        self._train = TrainFolder(client, workshop, state, self._draft, self._show)
        self._scan = OwnScanFolder(client, workshop, self._preview, last_scan, lambda: self._state.shape)
        self._kept = KeptFolder(client, workshop, self._show)
        self._card = gui.add_html("")  # of maps that the server began with

    def begin(self) -> None:
        """Show what is there already, once the page is built."""
        self._workshop.judge(self._state.shape)
        self.refresh()
        with self._turn:
            self._kept.choose(self._state.shape)
        self._scan.begin()
        draft = self._workshop.draft
        if draft is not None:
            self._draft.begin(draft, None)
            threading.Thread(target=self._measure, args=(draft,), daemon=True).start()

    def _measure(self, draft: Draft) -> None:
        cost = self._workshop.draft_cost
        if self._draft.draft is not None and self._draft.draft.cloud is draft.cloud:  # else another was uploaded
            self._draft.set_cost(cost)

    def refresh(self) -> None:
        """Show how far the trainings are, and what is kept."""
        with self._turn:
            self._train.refresh()
            self._kept.refresh(self._state.shape)
            self._show_card()

    def draw(self, state: State) -> None:
        """Draw in the colours of a page."""
        before, self._state = self._state, state
        if inputs(state) != inputs(before) or state.playing > before.playing:  # what a person looks for is in the panes
            self._end_previews()
        if state.shape != before.shape:
            self._workshop.judge(state.shape)
            with self._turn:
                self._kept.choose(state.shape)  # what is done there is done to what is seen
                self._show_card()
        if state.dark != before.dark or state.large_text != before.large_text:
            self._preview.dark = state.dark
            with self._turn:
                self._train.draw(state)
            self._draft.redraw()

    def _show_card(self) -> None:
        """The card of the shape that the panes show, if the server began with its maps."""
        name = self._state.shape
        given = self._workshop.is_given(name)
        self._card.content = card_html(name, self._workshop.card(name)) if given else ""

    def _estimate(self) -> None:
        self._train.show_estimate()

    def _show(self, name: str) -> None:
        """Have the panes show a cloud."""
        self._end_previews()
        self._show_shape(name)

    def _end_previews(self) -> None:
        self._draft.end_preview()
        self._scan.end_preview()
