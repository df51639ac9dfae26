"""The one control beside a step's text: it acts on the page as its like in the control panel does."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Any, Literal, get_args

import viser

from ido import RANGES
from ido_viz.core.actions import Actions, at_once
from ido_viz.core.state import VALUES, State, StateError, with_values
from ido_viz.panels.control_values import STEPS
from ido_viz.teach.content import ContentError

Button = Literal["Play", "One iteration on", "Back to the start", "New seed", "Map the basin"]

_LABELS = {"pinned_map": "Map", "epsilon": "Stop below ε", "difference": "Minus reference"}
_YES_NO = {True: "on", False: "off"}


@dataclass(frozen=True, slots=True)
class StepControl:
    """What a step lets a person do.

    Args:
        name: of a button, or of the value that is set.
        choices: what the value is set to, a button for each; none for a slider.
    """

    name: str
    choices: tuple[Any, ...] = ()


def control_of(written: object, where: str) -> StepControl:
    """The control that a lesson's file names: a slider or a button, or a value with its choices, ``{seed = [4, 0]}``.

    Raises:
        ContentError: there is none of this name, or a choice is out of range.
    """
    if isinstance(written, str):
        if written not in (*RANGES, *get_args(Button)):
            known = ", ".join((*RANGES, *get_args(Button)))
            raise ContentError(f"{where}: unknown control {written!r}; known: {known}, or a value with its choices")
        return StepControl(written)
    if not isinstance(written, dict) or len(written) != 1 or not written.keys() <= VALUES:
        raise ContentError(
            f"{where}: a control is a name, or one value with its choices, as {{seed = [4, 0]}}, not {written!r}"
        )
    ((name, choices),) = written.items()
    if not isinstance(choices, list) or len(choices) < 2:
        raise ContentError(f"{where}: the control {name!r} needs an array of two or more choices")
    for choice in choices:
        try:
            with_values(State(), {name: choice})
        except StateError as error:
            raise ContentError(f"{where}: control: {error}") from error
    return StepControl(name, tuple(choices))


class ControlView:
    """The widget of a step's control.

    Args:
        gui: where it is placed.
        control: what it is.
        state: what it shows at first.
        actions: what it does.
    """

    def __init__(self, gui: viser.GuiApi, control: StepControl, state: State, actions: Actions) -> None:
        self._slider: Any = None
        self._name = name = control.name
        buttons = {
            "Play": actions.play,
            "One iteration on": lambda: actions.step(1),
            "Back to the start": lambda: actions.jump(0),
            "New seed": actions.new_seed,
            "Map the basin": actions.map_basin,
        }
        if name in buttons:
            gui.add_button(name).on_click(lambda _: buttons[name]())
        elif control.choices:
            by_label = {_shown(choice): choice for choice in control.choices}
            gui.add_button_group(_label(name), tuple(by_label)).on_click(
                at_once(lambda label: actions.set_values({name: by_label[label]}))
            )
        else:
            kind = type(STEPS[name])
            low, high = kind(RANGES[name].low), kind(RANGES[name].high)
            self._slider = gui.add_slider(_label(name), low, high, STEPS[name], kind(getattr(state.perturbation, name)))
            self._slider.on_update(at_once(lambda value: actions.set_values({name: value})))

    def follow(self, state: State) -> None:
        """Show what the page shows."""
        if self._slider is not None:
            value = getattr(state.perturbation, self._name)
            if self._slider.value != value:
                self._slider.value = value


def _label(name: str) -> str:
    return _LABELS.get(name, name.replace("_", " ").capitalize())


def _shown(choice: object) -> str:
    if isinstance(choice, bool):
        return _YES_NO[choice]
    return choice if isinstance(choice, str) else json.dumps(choice)
