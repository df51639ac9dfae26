"""The part of the tab with the clouds that are kept: show, download, import and delete them, and their cards."""

from __future__ import annotations

import html
import logging
from collections.abc import Callable
from typing import Any

import viser

from ido import CloudError, MapsError
from ido.experiments import LEVELS
from ido_viz.own.card import SCENES, Card
from ido_viz.own.draft import file_name
from ido_viz.own.shelf import ShelfError
from ido_viz.own.workshop import Workshop
from ido_viz.panels.markup import caption, table_html

_log = logging.getLogger(__name__)
_NONE = "– none yet –"


class KeptFolder:
    """The clouds in the server's folder.

    Args:
        client: the page.
        workshop: of the server.
        show: called with the name of a cloud that the panes are to show.
    """

    def __init__(self, client: viser.ClientHandle, workshop: Workshop, show: Callable[[str], None]) -> None:
        gui = client.gui
        self._client, self._workshop, self._show = client, workshop, show
        with gui.add_folder("Kept clouds"):
            self._choice: Any = gui.add_dropdown("Cloud", (_NONE,), hint="Those that were trained or imported here.")
            ways = {"Show": self._show_chosen, "Download": self._download, "Delete": self._ask}
            self._ways = gui.add_button_group(
                "Do", tuple(ways), hint="Show it in the panes, take it along as one file, or delete it for everybody."
            )
            self._ways.on_click(lambda event: self._act(ways[event.target.value]))
            self._upload = gui.add_upload_button(
                "Import maps (.npz)",
                icon=viser.Icon.UPLOAD,
                mime_type=".npz",
                hint="A file that was downloaded here, or that `ido train` wrote.",
            )
            self._card = gui.add_html("")
        self._choice.on_update(lambda event: self.refresh() if event.client else None)
        self._upload.on_upload(
            lambda event: self._act(lambda: self._import(event.target.value.name, event.target.value.content))
        )

    def refresh(self, shown: str = "") -> None:
        """Offer what is kept now, with the card of the chosen one: the shape that the panes show, once it is kept."""
        names, before = self._workshop.shelf.kept or (_NONE,), self._choice.options
        if before != names:
            self._choice.options = names
            if shown in names and shown not in before:
                self._choice.value = shown
        self._ways.visible = names != (_NONE,)
        name = self._choice.value
        self._card.content = "" if name == _NONE else card_html(name, self._workshop.shelf.card(name))

    def choose(self, name: str) -> None:
        """Choose a cloud, as the menu does; what is not kept is not chosen."""
        self.refresh()
        if name in self._choice.options:
            self._choice.value = name
            self.refresh()

    def _act(self, act: Callable[[], None]) -> None:
        try:
            act()
        except (ShelfError, MapsError, CloudError, OSError) as error:
            self._client.add_notification("This cannot be done", str(error), color="red", auto_close_seconds=8.0)
        except Exception as error:  # the page must outlive it, and the person hear of it
            _log.exception("kept cloud failed")
            self._client.add_notification("Something went wrong", repr(error), color="red", auto_close_seconds=8.0)

    def _show_chosen(self) -> None:
        if self._choice.value != _NONE:
            self._workshop.shelf.place(self._choice.value)  # it may have been deleted
            self._show(self._choice.value)

    def _download(self) -> None:
        name = self._choice.value
        if name != _NONE:
            self._client.send_file_download(
                file_name(name, ".npz"), self._workshop.given_away(name), save_immediately=True
            )

    def _import(self, name: str, content: bytes) -> None:
        self.choose(self._workshop.take_in(name, content))

    def _ask(self) -> None:
        """Delete after a question, which says who else is there."""
        name = self._choice.value
        if name == _NONE:
            return
        others = self._workshop.others_at(name, self._client.client_id)
        modal = self._client.gui.add_modal(f"Delete {name}?")
        with modal:
            self._client.gui.add_html(caption(question(others)))
            delete = self._client.gui.add_button("Delete it", color="red", hint="It cannot be brought back.")
            keep = self._client.gui.add_button("Keep it", color="gray", hint="Leave everything as it is.")

        def deleted() -> None:
            modal.close()
            self._act(lambda: self._workshop.delete(name))

        delete.on_click(lambda _: deleted())
        keep.on_click(lambda _: modal.close())


def question(others: int) -> str:
    """What deleting does, as HTML."""
    pages = "No other page shows it." if others == 0 else f"<b>{others} other page{'s' * (others > 1)}</b> will go to "
    rest = "" if others == 0 else "another shape, and say why."
    return f"Its maps and its quality card are deleted for everybody on this server. {pages}{rest}"


def card_html(name: str, card: Card | None) -> str:
    """A quality card as tables, one for each method."""
    if card is None:
        return caption(f"<b>{html.escape(name)}</b>: its quality card is being made, when no training waits.")
    head = caption(
        f"<b>Quality card</b>: mean PointAcc on {SCENES} fresh scenes a level; one thing is varied, the rest is at the "
        "paper's default."
    )
    tables = [
        table_html(
            (method, "levels", "PointAcc"),
            [
                (sweep, " ".join(f"{level:g}" for level in LEVELS[sweep]), " ".join(f"{share:.2f}" for share in row))
                for sweep, row in rows.items()
            ],
        )
        for method, rows in card.rows.items()
    ]
    return head + "".join(tables)
