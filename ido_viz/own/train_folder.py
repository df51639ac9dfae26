"""The part of the tab where maps are learned: how long, on which range, whose turn it is, and the curves so far."""

from __future__ import annotations

import html
from collections.abc import Callable
from typing import Any

import numpy as np
import viser

from ido import TrainingSettings
from ido_viz.core import palette
from ido_viz.core.state import State
from ido_viz.own.draft_folder import DraftFolder
from ido_viz.own.kept import TRAINED
from ido_viz.own.plans import PLANS, in_words, time_left
from ido_viz.own.shelf import ShelfError
from ido_viz.own.training_queue import QueuedJob, QueueError
from ido_viz.own.workshop import Workshop
from ido_viz.panels.markup import caption, method_span
from ido_viz.panels.plot import Plot, plain_axes

_POWERS = (-4, 0)  # of ten, of the errors that are drawn


class TrainFolder:
    """Trains on the page's draft.

    Args:
        client: the page.
        workshop: of the server.
        state: what the page begins with.
        draft: of the page.
        begun: called with the cloud's name when its first maps can be seen.
    """

    def __init__(
        self,
        client: viser.ClientHandle,
        workshop: Workshop,
        state: State,
        draft: DraftFolder,
        begun: Callable[[str], None],
    ) -> None:
        gui = client.gui
        self._client, self._workshop, self._draft, self._begun = client, workshop, draft, begun
        self._job: QueuedJob | None = None  # this page's last one
        self._seen = False  # whether its first maps were shown
        self._state = state
        self._drawn: tuple[object, ...] | None = None
        self.folder = gui.add_folder("Train", visible=False)
        with self.folder:
            self._plan = gui.add_dropdown(
                "Time",
                tuple(PLANS),
                hint="Quick: half a minute at most. Standard: two minutes at most. Paper: the paper's 30,000 scenes "
                "and 30 maps, as long as it takes. More scenes make better maps.",
            )
            self._rotation = gui.add_slider(
                "Turned by up to", 10.0, 180.0, 1.0, 90.0, hint="Degrees. A wider range is harder to learn."
            )
            self._translation = gui.add_slider(
                "Shifted by up to", 0.05, 1.0, 0.05, 0.3, hint="In halves of the longest side."
            )
            self._estimate = gui.add_html("")
            self._train = gui.add_button("Train", hint="Learn DO and Improved DO; the panes show them as they learn.")
        self._train.on_click(lambda _: self._submit())
        self._text = gui.add_html("")
        self._cancel = gui.add_button("Cancel", color="gray", visible=False, hint="End it, and keep nothing of it.")
        self._cancel.on_click(lambda _: self._end())
        self._plot = Plot(gui, height=110)
        for handle in (self._plan, self._rotation, self._translation):
            handle.on_update(lambda event: self.show_estimate() if event.client else None)

    def show_estimate(self) -> None:
        """Say how long the training of the draft will take."""
        self.folder.visible = self._draft.draft is not None
        settings, cost = self._settings(), self._draft.cost
        if settings is None or cost is None:
            self._estimate.content = caption("Measuring how long a map takes on this machine…")
        else:
            self._estimate.content = caption(
                estimate_text(settings, cost.seconds(settings), PLANS[self._plan.value].limit)
            )

    def refresh(self) -> None:
        """Show how far the trainings are."""
        job = self._shown_job()
        self._text.content = training_html(
            job, self._workshop.queue.trainings, mine=job is self._job, dark=self._state.dark
        )
        self._cancel.visible = job is not None and not job.over and (job.owner in (None, self._client.client_id))
        self._train.disabled = self._job is not None and not self._job.over
        if job is not None and job is self._job and not self._seen and job.title in self._workshop.shelf:
            self._seen = True
            self._begun(job.title)
        self._draw_curves(job)

    def draw(self, state: State) -> None:
        """Draw in the colours of a page."""
        if state.dark != self._state.dark or state.large_text != self._state.large_text:
            self._state, self._drawn = state, None
            self.refresh()

    def _settings(self) -> TrainingSettings | None:
        if self._draft.cost is None:
            return None
        return PLANS[self._plan.value].settings(self._draft.cost, self._rotation.value, self._translation.value)

    def _submit(self) -> None:
        draft, settings, cost = self._draft.draft, self._settings(), self._draft.cost
        if draft is None or settings is None or cost is None:
            return
        self._seen = False
        try:
            self._job = self._workshop.train(
                draft, settings, cost.seconds(settings), PLANS[self._plan.value].limit, self._client.client_id
            )
        except (QueueError, ShelfError) as error:
            self._client.add_notification("No training now", str(error), color="red", auto_close_seconds=8.0)
        self.refresh()

    def _end(self) -> None:
        job = self._shown_job()
        if job is not None:
            self._workshop.queue.cancel(job)

    def _shown_job(self) -> QueuedJob | None:
        """This page's own training, also when it is over, as long as no other one runs; else the one that runs."""
        trainings = self._workshop.queue.trainings
        if self._job is not None and (not self._job.over or not trainings):
            return self._job
        return trainings[0] if trainings else self._job

    def _draw_curves(self, job: QueuedJob | None) -> None:
        history = () if job is None else tuple(job.history)
        look = (job, len(history), self._state.dark, self._state.large_text)
        if look == self._drawn or len(history) < 2 or job is None:
            return
        self._drawn = look
        errors = np.log10(np.maximum(np.array([told.errors for told in history]), 1e-12))
        series: list[Any] = [{"label": "maps"}]
        for method, width in zip(TRAINED, (4, 1.5), strict=True):
            color = palette.css(palette.method_color(method, self._state.dark))
            series.append({"label": method, "stroke": color, "width": width, "points": {"show": False}})
        scales = {
            "x": {"time": False, "auto": False, "range": (0.0, float(job.maps))},
            "y": {"auto": False, "range": (min(_POWERS[0], float(errors.min())) + 0.5, 0.8)},
        }
        data = (np.arange(len(history), dtype=np.float64), *errors.T.copy())
        self._plot.restyle(data, series, scales, plain_axes(self._state, powers=_POWERS))


def estimate_text(settings: TrainingSettings, seconds: float, limit: float | None) -> str:
    """How large a training is and how long it will take; how it ends where it will not be done by its limit."""
    size = f"{settings.maps} maps of each method on {settings.samples:,} scenes"
    if limit is not None and seconds > limit:
        return (
            f"{size} would take about {in_words(seconds)}, as busy as this machine is now. After "
            f"<b>{in_words(limit)}</b> it ends, with the maps that it has: too few, perhaps."
        )
    return f"{size}: about <b>{in_words(seconds)}</b>, as busy as this machine is now."


def training_html(job: QueuedJob | None, trainings: tuple[QueuedJob, ...], *, mine: bool, dark: bool) -> str:
    """Where a training is: its place in the queue, its maps and the time that is left, or how it ended."""
    if job is None:
        return ""
    whose = f"<b>{html.escape(job.title)}</b>" + ("" if mine else " (another page's)")
    if job.over:
        if job.failure:
            return caption(f"{whose}: the training failed, and nothing of it is kept: {html.escape(job.failure)}.")
        done = job.history[-1].maps if job.history else 0
        fewer = f", with {done} of {job.maps} maps, for the time was over" if done < job.maps else ""
        return caption(f"{whose}: " + ("cancelled" if job.cancelled else f"trained and kept{fewer}"))
    behind = f"; {len(trainings) - 1} more wait" if job.running and len(trainings) > 1 else ""
    if not job.running:
        place = trainings.index(job) if job in trainings else 0
        return caption(f"{whose}: waits for {place} other training{'' if place == 1 else 's'}")
    done = job.history[-1].maps if job.history else 0
    if not done:
        return caption(f"{whose}: drawing scenes…{behind}")
    if done == job.maps:
        return caption(f"{whose}: all {done} maps are learned{behind}")
    left = time_left(job.expected, job.times, job.maps)
    methods = " &nbsp; ".join(method_span(method, dark) for method in TRAINED)
    return caption(
        f"{whose}: map {done} of {job.maps}, about <b>{in_words(left)}</b> left{behind}<br>"
        f"{methods}: mean training error"
    )
