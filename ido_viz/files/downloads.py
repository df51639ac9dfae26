"""What a page shows, as files to take away: the run, its curves, animations and charts."""

from __future__ import annotations

import contextlib
import csv
import ctypes
import io
import logging
import re
import sys
import threading
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import viser

from ido.recording import RecordedMethod, RecordedRun
from ido_viz.core.actions import plain
from ido_viz.core.background import CancelledError, Job, Report, in_turn
from ido_viz.core.frame import Frame
from ido_viz.core.run import Run
from ido_viz.core.state import State, encode
from ido_viz.core.turns import Turns
from ido_viz.files.animation_gif import animation_gif
from ido_viz.files.animation_html import animation_html

_FILES = Turns(1)
_log = logging.getLogger(__name__)

COLUMNS = (
    "pane",
    "method",
    "iteration",
    "PointAcc",
    "PointRMSE",
    "rotation error (degrees)",
    "translation error",
    "update norm",
    "histogram distance",
)
"""Of the curves; errors are in model units but for the angle, the last two as `MethodRun` has them."""


@dataclass(frozen=True, slots=True)
class Export:
    """A kind of file.

    Args:
        label: of its button.
        hint: of its button.
        ending: of the file's name.
        make: the file's content; the report is told how far it is, and what it raises ends it.
    """

    label: str
    hint: str
    ending: str
    make: Callable[[Frame, Report], bytes]


def recorded(run: Run, state: State) -> RecordedRun:
    """The run of a state as a value that can be saved.

    Raises:
        RunError: a registration holds numbers that are not finite.
    """
    return RecordedRun(
        shape=state.shape,
        perturbation=state.perturbation,
        scene=run.scene,
        methods=tuple(
            RecordedMethod.of(side.method, side.settings, side.trajectory, run.scene, side.histogram)
            for side in run.sides
        ),
        moved=state.start,
        code=encode(state),
    )


def run_npz(frame: Frame) -> bytes:
    """The run of a page as the content of a file that `ido.load_run` reads."""
    content = io.BytesIO()
    recorded(frame.run, frame.state).save(content)
    return content.getvalue()


def curves_csv(run: Run) -> str:
    """The scores of every pose and the size of the update made there, one row each, with the heads `COLUMNS`.

    Numbers are written in full; the update norm is empty where none was computed.
    """
    text = io.StringIO()
    rows = csv.writer(text, lineterminator="\n")
    rows.writerow(COLUMNS)
    for pane, side in zip(("left", "right"), run.sides, strict=True):
        s = side.scores
        columns = (s.accuracy, s.rmse, s.rotation, s.translation, side.norms, side.distances)
        for iteration, row in enumerate(np.stack(columns, axis=1).tolist()):
            rows.writerow([pane, side.method, iteration, *("" if np.isnan(value) else value for value in row)])
    return text.getvalue()


def _charts(frame: Frame) -> bytes:
    from ido_viz.files.chart_archive import charts_zip  # with Matplotlib, which takes a while to import

    return charts_zip(frame)


EXPORTS = (
    Export(
        "Run (.npz)",
        "Points, poses, histograms, updates and settings; ido.load_run reads them.",
        ".npz",
        lambda frame, _: run_npz(frame),
    ),
    Export(
        "Curves (.csv)",
        "Scores and update norms of both methods at every iteration.",
        ".csv",
        lambda frame, _: curves_csv(frame.run).encode(),
    ),
    Export(
        "Animation (.html)",
        "Both methods in one file that opens in any browser.",
        ".html",
        lambda frame, _: animation_html(frame),
    ),
    Export("Animation (.gif)", "Both methods as a moving picture for slides.", ".gif", animation_gif),
    Export(
        "Charts (.zip)",
        "Histograms, maps and curves for a paper, as SVG and PNG.",
        ".zip",
        lambda frame, _: _charts(frame),
    ),
)
"""What the page offers."""


class DownloadFolder:
    """A folder of buttons in a page's controls; each sends the browser one file of what is shown.

    Files take long to make, so those of all pages are made one after the other, and a page has one at a time.

    Args:
        client: the page.
        shown: gives the frame that the page shows; asked at each click, on a thread of the server.
    """

    def __init__(self, client: viser.ClientHandle, shown: Callable[[], Frame | None]) -> None:
        self._client = client
        self._shown = shown
        self._lock = threading.Lock()
        self._job: Job[None] | None = None
        self.folder = client.gui.add_folder("Download")
        with self.folder:
            for export in EXPORTS:
                button = client.gui.add_button(export.label, icon=viser.Icon.DOWNLOAD, color="gray", hint=export.hint)
                button.on_click(lambda _, export=export: self._begin(export))
            self._progress = client.gui.add_html("")
            self._cancel = client.gui.add_button(
                "Cancel the file", color="gray", visible=False, hint="Give up the file that is made or waited for."
            )
            self._cancel.on_click(plain(self.cancel))

    def cancel(self) -> None:
        """Give up the file that is made or waited for."""
        with self._lock:
            if self._job is not None:
                self._job.cancel()

    def _begin(self, export: Export) -> None:
        frame = self._shown()
        if frame is None:
            self._tell("Nothing to download yet", "Wait until the page shows a run.")
            return
        waiting = [f"{side.method}: {side.waiting}" for side in frame.run.sides if side.waiting]
        if waiting:
            self._tell("Nothing to download yet", "; ".join(waiting))
            return
        with self._lock:
            if self._job is not None and not self._job.ended:
                self._tell("One file at a time", "Wait for the one that is made, or cancel it.")
                return
            self._job = Job(lambda report: self._send(export, frame, report), self._draw)
        self._draw()

    def _send(self, export: Export, frame: Frame, report: Report) -> None:
        try:
            with in_turn(_FILES, report):
                report("being made")
                try:
                    content = export.make(frame, report)
                finally:
                    _give_memory_back()
            report("being sent")
            self._client.send_file_download(file_name(frame.state, export.ending), content, save_immediately=True)
        except CancelledError:
            raise
        except Exception as error:  # the page must outlive it, and the person hear of it
            _log.exception("export failed")
            self._tell("The file could not be made", f"{type(error).__name__}: {error}")

    def _draw(self) -> None:
        """Show how far the file is; called on its thread, too."""
        with self._lock:  # or what was true before would be written after the end
            job = self._job
            text = ""
            if job is not None and not job.ended:
                text = f'<div style="margin:0 8px;font-size:0.75rem">The file is {job.progress}.</div>'
            if self._progress.content != text:
                self._progress.content = text
            if self._cancel.visible != bool(text):
                self._cancel.visible = bool(text)

    def _tell(self, title: str, body: str) -> None:
        self._client.add_notification(title, body, color="red", auto_close_seconds=8.0)


def _give_memory_back() -> None:
    """Return to the system what pictures took; GNU's C library would keep it, for each thread anew."""
    if sys.platform == "linux":
        with contextlib.suppress(OSError, AttributeError):  # of another C library
            ctypes.CDLL(None).malloc_trim(0)


def file_name(state: State, ending: str) -> str:
    """A name for a file of a state: its shape and seed, in letters that every system takes."""
    return f"ido-{re.sub(r'[^A-Za-z0-9]+', '-', state.shape).strip('-')}-{state.perturbation.seed}{ending}"
