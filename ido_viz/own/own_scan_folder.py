"""The part of the tab where a scan is registered onto the model that the panes show."""

from __future__ import annotations

import html
import json
import logging
import math
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any, get_args

import viser

from ido import CloudError
from ido.files import save_cloud
from ido.scans import as_json
from ido.user_units import Start
from ido_viz.own.draft import file_name, shown_name
from ido_viz.own.kept import TRAINED
from ido_viz.own.own_scan import LastScan, OwnScan, registered_own
from ido_viz.own.preview import Preview
from ido_viz.own.workshop import Workshop
from ido_viz.panels.markup import caption, table_html

_log = logging.getLogger(__name__)
_WHAT = (
    "Upload a scan of what the panes show, whole or a part of it, in the same unit. It is registered by Improved DO; "
    "nobody knows the true pose, so look at the figures."
)


class OwnScanFolder:
    """Registers scans.

    Args:
        client: the page.
        workshop: of the server.
        preview: of the page.
        last: of the page, also before it was reloaded.
        shape: gives the name of the shape that the page shows.
    """

    def __init__(
        self,
        client: viser.ClientHandle,
        workshop: Workshop,
        preview: Preview,
        last: LastScan,
        shape: Callable[[], str],
    ) -> None:
        gui = client.gui
        self._client, self._workshop, self._preview, self._last, self._shape = client, workshop, preview, last, shape
        with gui.add_folder("A scan of one's own"):
            self._start = gui.add_dropdown(
                "Start", get_args(Start), hint="Where the scan lies, or with its middle moved onto the model's."
            )
            self._upload = gui.add_upload_button("Upload a scan", icon=viser.Icon.UPLOAD, hint="Of the shape shown.")
            self._text = gui.add_html(caption(_WHAT))
            self._box = gui.add_checkbox(
                "On the model", False, visible=False, hint="The scan where it was put, instead of the panes."
            )
            self._pose = gui.add_text("Pose", "", visible=False, hint="T_model_scene, 4 rows of 4 numbers, to copy.")
            ways = {"Pose (.json)": self._send_pose, "Moved scan (.ply)": self._send_moved}
            self._ways = gui.add_button_group("Download", tuple(ways), visible=False, hint="In the unit of the cloud.")
        self._upload.on_upload(lambda event: self._read(event.target.value.name, event.target.value.content))
        self._box.on_update(lambda event: self._show(event.target.value) if event.client else None)
        self._ways.on_click(lambda event: ways[event.target.value]())

    def begin(self) -> None:
        """Show what there is already, once the page is built."""
        if self._last.found is not None:
            self._tell(self._last.found)
            self._show(self._last.on_model)

    def end_preview(self) -> None:
        """Show the panes again."""
        self._box.value = self._last.on_model = False

    def _read(self, name: str, content: bytes) -> None:
        self._upload.disabled = True
        self._text.content = caption(f"Registering {html.escape(shown_name(name))}…")
        try:
            found = self._last.found = self._registered(name, content)
        except CloudError as error:
            self._refuse(f"<b>This file cannot be used.</b> {html.escape(str(error))}")
        except Exception as error:  # the page must outlive it, and the person hear of it
            _log.exception("scan failed")
            self._refuse(f"<b>This scan cannot be registered.</b> {html.escape(repr(error))}")
        else:
            self._tell(found)
            self._show(True)
        finally:
            self._upload.disabled = False

    def _refuse(self, why: str) -> None:
        """Say why, above the scan before, which stays."""
        before = self._last.found
        self._text.content = caption(why) + ("" if before is None else scan_html(before))

    def _tell(self, found: OwnScan) -> None:
        self._text.content = scan_html(found)
        self._pose.value = json.dumps(found.scan.T_model_scene.tolist())
        for handle in (self._box, self._pose, self._ways):
            handle.visible = True

    def _registered(self, name: str, content: bytes) -> OwnScan:
        shape = self._shape()
        subject = self._workshop.library.subject(shape)
        if not subject.maps:
            raise CloudError(f"{shape} has no maps of DO or Improved DO, by which scans are registered; train it first")
        method = next((name for name in reversed(TRAINED) if name in subject.maps), next(iter(subject.maps)))
        unit = self._workshop.unit_of(shape)
        file, used = self._workshop.open(name, content)
        start: Start = "centre" if self._start.value == "centre" else "here"
        self._last.subject = subject
        return registered_own(subject.maps[method](), method, unit, shown_name(name), file, used, start)

    def _show(self, on_model: bool) -> None:
        last = self._last
        self._box.value = last.on_model = on_model
        if on_model and last.found is not None and last.subject is not None:
            self._preview.show_scan(last.found.name, last.subject, last.found.placed)
        else:
            self._preview.hide()

    def _send_pose(self) -> None:
        found = self._last.found
        if found is not None:
            content = json.dumps(pose_of(found), indent=2, allow_nan=False).encode()
            self._client.send_file_download(_file_name(found, "-pose.json"), content, save_immediately=True)

    def _send_moved(self) -> None:
        found = self._last.found
        if found is not None:
            content = moved_ply(found, self._workshop.shelf.folder)
            self._client.send_file_download(_file_name(found, "-moved.ply"), content, save_immediately=True)


def _file_name(found: OwnScan, ending: str) -> str:
    return file_name(Path(found.name).stem, ending)


def pose_of(found: OwnScan) -> dict[str, Any]:
    """What `ido register` writes of a scan, with the unit and the histogram's distance; plain values."""
    return (
        {"file": found.name, "method": found.method, "unit": found.unit}
        | as_json(found.scan)
        | {"histogram_distance": found.distance}
    )


def moved_ply(found: OwnScan, folder: Path) -> bytes:
    """All points of a scan's file, moved, with its other columns, as PLY; `folder` is where it may be written."""
    with tempfile.TemporaryDirectory(dir=folder, prefix="upload-") as place:
        path = Path(place) / "moved.ply"
        save_cloud(path, found.scan.file.moved(found.scan.T_model_scene))
        return path.read_bytes()


def scan_html(found: OwnScan) -> str:
    """How a scan ended, its figures, and why they may be wrong."""
    scan, unit = found.scan, found.unit
    fit, extent = scan.quality.fit, scan.quality.extent
    rows = [
        ("near the model", f"{fit.near_share:.0%}"),
        ("their RMSE", "–" if math.isnan(fit.near_rmse) else f"{fit.near_rmse:.4g} {unit}"),
        ("of the model covered", f"{fit.covered_share:.0%}"),
        ("histogram distance", f"{found.distance:.3f}"),
        ("size, of the model's", f"{extent.size_ratio:.2f}"),
        ("points read, registered", f"{scan.used.read:,}, {scan.registered:,}"),
    ]
    verdict = "nothing is doubted" if scan.sure else "<b>look at it before you use it</b>"
    doubts = [f"⚠ {html.escape(doubt)}" for doubt in scan.doubts] + [html.escape(note) for note in scan.used.notes]
    return (
        caption(
            f"<b>{html.escape(found.name)}</b>, {html.escape(found.method)}: {scan.stop} after {scan.iterations} "
            f"iterations; {verdict}"
        )
        + table_html(("figure", "value"), rows)
        + "".join(map(caption, doubts))
    )
