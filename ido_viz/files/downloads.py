"""What a page shows, as files to take away: the run, its curves, animations and charts."""

from __future__ import annotations

import csv
import io
import logging
import re
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import viser

from ido.recording import RecordedMethod, RecordedRun
from ido_viz.core.frame import Frame
from ido_viz.core.run import Run
from ido_viz.core.state import State, encode
from ido_viz.files.animation_gif import animation_gif
from ido_viz.files.animation_html import animation_html
from ido_viz.files.chart_archive import charts_zip

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
        make: the file's content.
    """

    label: str
    hint: str
    ending: str
    make: Callable[[Frame], bytes]


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


EXPORTS = (
    Export("Run (.npz)", "Points, poses, histograms, updates and settings; ido.load_run reads them.", ".npz", run_npz),
    Export(
        "Curves (.csv)",
        "Scores and update norms of both methods at every iteration.",
        ".csv",
        lambda frame: curves_csv(frame.run).encode(),
    ),
    Export("Animation (.html)", "Both methods in one file that opens in any browser.", ".html", animation_html),
    Export("Animation (.gif)", "Both methods as a moving picture for slides.", ".gif", animation_gif),
    Export("Charts (.zip)", "Histograms, maps and curves for a paper, as SVG and PNG.", ".zip", charts_zip),
)
"""What the page offers."""


class DownloadFolder:
    """A folder of buttons in a page's controls; each sends the browser one file of what is shown.

    Args:
        client: the page.
        shown: gives the frame that the page shows; asked at each click, on a thread of the server.
    """

    def __init__(self, client: viser.ClientHandle, shown: Callable[[], Frame | None]) -> None:
        self._client = client
        self._shown = shown
        self.folder = client.gui.add_folder("Download")
        with self.folder:
            for export in EXPORTS:
                button = client.gui.add_button(export.label, icon=viser.Icon.DOWNLOAD, color="gray", hint=export.hint)
                button.on_click(lambda event, export=export: self._send(event.target, export))

    def _send(self, button: viser.GuiButtonHandle, export: Export) -> None:
        frame = self._shown()
        if frame is None:
            self._tell("Nothing to download yet", "Wait until the page shows a run.")
            return
        waiting = [f"{side.method}: {side.waiting}" for side in frame.run.sides if side.waiting]
        if waiting:
            self._tell("Nothing to download yet", "; ".join(waiting))
            return
        button.disabled = True
        try:
            content = export.make(frame)
            self._client.send_file_download(file_name(frame.state, export.ending), content, save_immediately=True)
        except Exception as error:  # the page must outlive it, and the person hear of it
            _log.exception("export failed")
            self._tell("The file could not be made", f"{type(error).__name__}: {error}")
        finally:
            button.disabled = False

    def _tell(self, title: str, body: str) -> None:
        self._client.add_notification(title, body, color="red", auto_close_seconds=8.0)


def file_name(state: State, ending: str) -> str:
    """A name for a file of a state: its shape and seed, in letters that every system takes."""
    return f"ido-{re.sub(r'[^A-Za-z0-9]+', '-', state.shape).strip('-')}-{state.perturbation.seed}{ending}"
