"""Pages on one click: scenes that are known to be registered, and scenes that are known to fail."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import viser

from ido import Perturbation
from ido_viz.charts import caption
from ido_viz.lesson import BOTH, LEFT, RIGHT, Check, at, ends
from ido_viz.run import Run
from ido_viz.state import State


@dataclass(frozen=True, slots=True)
class Preset:
    """A page that is known to go well, or not to.

    Args:
        label: on its button.
        hint: what is known of it.
        state: the whole page.
        check: whether what is known holds for the run of its state.
        good: whether both methods end in place.
    """

    label: str
    hint: str
    state: State
    check: Check
    good: bool


def both(*checks: Check) -> Check:
    """Whether all of several things hold."""

    def check(run: Run) -> bool:
        return all(each(run) for each in checks)

    return check


_IN_PLACE, _WRONG = ends("in place", *BOTH), ends("wrong pose", *BOTH)
_EARLY = State(perturbation=Perturbation(seed=7, translation=0.5), epsilon=0.005, speed=20)
_BALL = State(shape="urban", perturbation=Perturbation(seed=1, outlier_kind="structured"))
_TURNED = Perturbation(seed=1, rotation=120.0)
_MOVED = Perturbation(translation=0.9)

PRESETS: tuple[Preset, ...] = (
    Preset(
        "Paper's defaults", "The scene that the page begins with. Both end in place.", State(), _IN_PLACE, good=True
    ),
    Preset(
        "Half is missing",
        "50% cut away; the training had at most 30%. Both end in place.",
        State(perturbation=Perturbation(seed=3, incomplete=0.5)),
        _IN_PLACE,
        good=True,
    ),
    Preset(
        "600 outliers",
        "Twice as many as the training had, among 280 true points. Both end in place.",
        State(perturbation=Perturbation(outliers=600)),
        both(_IN_PLACE, lambda run: int((~run.scene.is_outlier).sum()) == 280),
        good=True,
    ),
    Preset(
        "Turned by 120°",
        "The training had at most 90°. Both end in a wrong pose; at 60° the same scene ends in place.",
        State(perturbation=_TURNED),
        both(_WRONG, at(State(perturbation=replace(_TURNED, rotation=60.0)), _IN_PLACE)),
        good=False,
    ),
    Preset(
        "Moved by 0.9",
        "The training had at most 0.3. Both end in a wrong pose; at 0.3 the same scene ends in place.",
        State(perturbation=_MOVED),
        both(_WRONG, at(State(perturbation=replace(_MOVED, translation=0.3)), _IN_PLACE)),
        good=False,
    ),
    Preset(
        "Only Improved DO fails",
        "600 outliers and another seed: DO ends in place, Improved DO in a wrong pose.",
        State(perturbation=Perturbation(seed=4, outliers=600)),
        both(ends("in place", LEFT), ends("wrong pose", RIGHT)),
        good=False,
    ),
    Preset(
        "Only DO fails",
        "Turned by 90°: Improved DO ends in place, DO in a wrong pose.",
        State(perturbation=Perturbation(seed=4, rotation=90.0)),
        both(ends("wrong pose", LEFT), ends("in place", RIGHT)),
        good=False,
    ),
    Preset(
        "Stops too early",
        "The paper's ε = 0.005, moved by 0.5: both stop in a wrong pose. With ε = 0.001 both end in place.",
        _EARLY,
        both(_WRONG, at(replace(_EARLY, epsilon=0.001), _IN_PLACE)),
        good=False,
    ),
    Preset(
        "A ball of outliers",
        "The urban scan with 300 outliers in one ball: both end in a wrong pose. Without the ball, both in place.",
        _BALL,
        both(_WRONG, at(replace(_BALL, perturbation=replace(_BALL.perturbation, outliers=0)), _IN_PLACE)),
        good=False,
    ),
)

_GROUPS = (
    (True, "Known to be registered", viser.Icon.CIRCLE_CHECK, (70, 110, 95)),
    (False, "Known to fail", viser.Icon.ALERT_TRIANGLE, (135, 95, 65)),
)
"""Good or not, with the title, the icon and the colour (white text on it can be read)."""


class PresetPanel:
    """A button for each preset, in the current container.

    Args:
        gui: where they are placed.
        open_state: opens a page; called on a thread of the server.
    """

    def __init__(self, gui: viser.GuiApi, open_state: Callable[[State], None]) -> None:
        self.buttons: dict[str, viser.GuiButtonHandle] = {}
        for good, title, icon, color in _GROUPS:
            gui.add_html(caption(title))
            for preset in PRESETS:
                if preset.good == good:
                    button = gui.add_button(preset.label, icon=icon, color=color, hint=preset.hint)
                    button.on_click(lambda _, state=preset.state: open_state(state))
                    self.buttons[preset.label] = button
