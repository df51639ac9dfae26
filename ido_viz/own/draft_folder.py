"""The part of the tab where a cloud is uploaded, looked at and set right before it is trained on."""

from __future__ import annotations

import html
import logging
import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any, get_args

import viser

from ido import CloudError
from ido_viz.own.draft import LONGEST_NAME, UNITS, UPS, Draft, Facing, shown_name
from ido_viz.own.plans import Cost
from ido_viz.own.preview import Preview
from ido_viz.own.workshop import Workshop
from ido_viz.panels.markup import caption
from ido_viz.serving.uploads import MOST_UPLOAD

_log = logging.getLogger(__name__)
_NOTHING = (
    "Upload a cloud or a mesh, at most {limit} MB: PLY, PCD, LAS, text, NumPy, OBJ, STL or OFF, also as .gz. Then "
    "train on it, and explore it like the bunny."
)


class DraftFolder:
    """The draft of one page, and the widgets that show and change it.

    Args:
        gui: where they are placed.
        workshop: of the server.
        preview: of the page.
        changed: called when the draft, or what training on it costs, is another.
    """

    def __init__(self, gui: viser.GuiApi, workshop: Workshop, preview: Preview, changed: Callable[[], None]) -> None:
        self._workshop, self._preview, self._changed = workshop, preview, changed
        self.draft: Draft | None = None
        self.cost: Cost | None = None
        self._upload = gui.add_upload_button(
            "Upload a cloud",
            icon=viser.Icon.UPLOAD,
            hint=f"At most {MOST_UPLOAD >> 20} MB; it may be dropped here or on the canvas.",
        )
        self._upload.on_upload(lambda event: self._read(event.target.value.name, event.target.value.content))
        self._text = gui.add_html(caption(_NOTHING.format(limit=MOST_UPLOAD >> 20)))
        self._folder = gui.add_folder(None, visible=False)
        with self._folder:
            self._preview_box = gui.add_checkbox(
                "Preview", True, hint="Show the cloud, the model points and their normals instead of the panes."
            )
            with gui.add_folder("Name, size, up and normals"):
                self._name = gui.add_text("Name", "", hint=f"As it is listed; at most {LONGEST_NAME} letters.")
                self._unit: Any = gui.add_dropdown("Unit", UNITS, hint="What lengths are in. Files do not say.")
                self._side = gui.add_text(
                    "Longest side", "", hint="In the unit. Another number scales the whole cloud, as scans must be."
                )
                self._up = gui.add_dropdown("Up", tuple(UPS), hint="Which of its axes is up in the pictures.")
                self._facing = gui.add_dropdown(
                    "Normals", get_args(Facing), hint="Where they point to. It changes the pictures, and no result."
                )
        for handle in (self._name, self._unit, self._side, self._up, self._facing):
            handle.on_update(lambda event: self._take() if event.client else None)
        self._preview_box.on_update(lambda event: self._show() if event.client else None)

    def begin(self, draft: Draft, cost: Cost | None) -> None:
        """Show another draft; its cost may follow with `set_cost`."""
        self._name.value, self._side.value = draft.name, side_text(draft)
        self._show_values(draft)
        self._preview_box.value = True
        self._become(draft, cost)
        self._show()

    def set_cost(self, cost: Cost | None) -> None:
        """Say what training costs, once it was measured."""
        self.cost = cost
        self._changed()

    def end_preview(self) -> None:
        """Show the panes again."""
        self._preview_box.value = False
        self._preview.hide()

    def redraw(self) -> None:
        """Draw the preview again, in the colours of another page."""
        if self._preview_box.value and self.draft is not None:
            self._preview.show_draft(self.draft)

    def _read(self, name: str, content: bytes) -> None:
        self._upload.disabled = True
        before = self.draft, self.cost
        self._become(None, None)  # or the draft before would be named and trained while the new one is read
        self._text.content = caption(f"Reading {html.escape(shown_name(name))}…")
        try:
            draft, cost = self._workshop.drafted(name, content)
        except CloudError as error:
            self._refuse(str(error), *before)
        except Exception as error:  # the page must outlive it, and the person hear of it
            _log.exception("upload failed")
            self._refuse(repr(error), *before)
        else:
            self.begin(draft, cost)
        finally:
            self._upload.disabled = False

    def _refuse(self, why: str, draft: Draft | None, cost: Cost | None) -> None:
        """Say what is wrong with a file, and go on with the draft before."""
        self._become(draft, cost)
        self._text.content = caption(f"<b>This file cannot be used.</b> {html.escape(why)}")

    def _become(self, draft: Draft | None, cost: Cost | None) -> None:
        """Have a draft to change and to train on, or none; the picture stays, so that nothing jumps."""
        self.draft, self.cost = draft, cost
        self._folder.visible = draft is not None
        self._changed()

    def _take(self) -> None:
        """Make the draft what the widgets say."""
        draft = self.draft
        if draft is None:
            return
        factor, longest = draft.factor, float(draft.size.max())
        if self._side.value != side_text(draft):  # another number was written
            factor *= read_length(self._side.value, longest) / longest
        self.draft = replace(
            draft,
            name=shown_name(self._name.value),
            unit=self._unit.value,
            factor=factor,
            up=self._up.value,
            facing=self._facing.value,
        )
        self._show_values(self.draft)
        self._show()
        self._changed()

    def _show_values(self, draft: Draft) -> None:
        values: list[tuple[Any, Any]] = [(self._unit, draft.unit), (self._up, draft.up), (self._facing, draft.facing)]
        if shown_name(self._name.value) != draft.name:  # else a name that is being written would be written over
            values.append((self._name, draft.name))
        if not means(self._side.value, float(draft.size.max())):
            values.append((self._side, side_text(draft)))
        for handle, value in values:
            if handle.value != value:
                handle.value = value
        self._text.content = draft_html(draft)

    def _show(self) -> None:
        if self._preview_box.value and self.draft is not None:
            self._preview.show_draft(self.draft)
        else:
            self._preview.hide()


def side_text(draft: Draft) -> str:
    """The longest side of its bounding box, as it is written."""
    return f"{draft.size.max():.6g}"


def read_length(text: str, otherwise: float) -> float:
    """A length that a person wrote; `otherwise` if it is none that could be meant."""
    try:
        length = float(text)
    except ValueError:
        return otherwise
    return length if 1e-9 <= length <= 1e12 else otherwise


def means(text: str, length: float) -> bool:
    """Whether what a person has written so far means this length, or nothing yet."""
    return not text.strip() or math.isclose(read_length(text, math.nan), length, rel_tol=1e-5)


def draft_html(draft: Draft) -> str:
    """What there is to say of a draft."""
    x, y, z = draft.size
    lines = [
        f"<b>{html.escape(draft.name)}</b>: {draft.read:,} points read, {len(draft.in_file.points):,} used",
        f"{x:.4g} × {y:.4g} × {z:.4g} {draft.unit}, {draft.up} up, {len(draft.bare.points)} model points, "
        f"normals {draft.facing}",
        *(html.escape(note) for note in draft.notes),
    ]
    return caption("<br>".join(lines))
