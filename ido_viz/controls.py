"""The control panel: widgets that show a state and are read back into one."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, TypeVar, get_args

import numpy as np
import viser

from ido import RANGES, Perturbation
from ido.perturbation import LARGEST_SEED, OutlierKind
from ido_viz.export import ExportFolder, Shown
from ido_viz.library import Library
from ido_viz.readout import readout_html
from ido_viz.run import Run
from ido_viz.state import EPSILON_RANGE, LONGEST_RUN, BinOrder, State, encode
from ido_viz.sweeps import Choice

_STEPS = {"noise": 0.001, "points": 10, "outliers": 10, "incomplete": 0.01, "rotation": 1.0, "translation": 0.01}
_HINTS = {
    "noise": "Standard deviation of the Gaussian noise on every point, in model units (the model fits in ±1).",
    "points": "Points drawn from the full cloud, before some are removed.",
    "outliers": "Points added that belong to nothing.",
    "incomplete": "Share of the points removed, all on one side of a random plane.",
    "rotation": "Angle in degrees about a random axis. The maps are trained on up to 90°.",
    "translation": "Distance in a random direction, in model units. The maps are trained on up to 0.3.",
}
_PREPARING = (
    '<div style="margin:0 8px;font-size:12px">Preparing. On the very first start the numerical loops are '
    "compiled, which takes some seconds.</div>"
)


@dataclass(frozen=True, slots=True)
class Actions:
    """What the buttons do; each is called on a thread of the server and returns at once."""

    changed: Callable[[], None]
    play: Callable[[], None]
    step: Callable[[int], None]
    jump: Callable[[int], None]
    new_seed: Callable[[], None]
    paper_defaults: Callable[[], None]
    apply_code: Callable[[str], None]
    cancel: Callable[[], None]
    compare: Callable[[], None]
    cancel_comparison: Callable[[], None]
    show_method: Callable[[str, str], None]
    open_scene: Callable[[Choice], None]
    open_page: Callable[[State], None]
    inspect: Callable[[dict[str, Any]], None]
    redraw: Callable[[], None]
    shown: Shown


class Controls:
    """All widgets of one page. `read` gives the newest values; `show` writes a state into the widgets."""

    def __init__(self, client: viser.ClientHandle, library: Library, state: State, actions: Actions) -> None:
        gui = client.gui
        self._library = library
        self._inputs: dict[str, Any] = {}
        self._actions = actions
        self._playback(gui, state, actions)
        self._scene(gui, state, actions)
        self._methods(gui, state)
        self._view(gui, state)
        self._share(gui, actions)
        ExportFolder(client, actions.shown)
        for handle in self._inputs.values():
            handle.on_update(self._on_input)
        for label, key, act in (
            ("Play or pause", "P", actions.play),
            ("Next iteration", "N", lambda: actions.step(1)),
            ("Back one iteration", "B", lambda: actions.step(-1)),
            ("Restart at iteration 0", "R", lambda: actions.jump(0)),
        ):
            gui.add_command(label, hotkey=key).on_trigger(_plain(act))  # type: ignore[arg-type]

    def _playback(self, gui: viser.GuiApi, state: State, actions: Actions) -> None:
        self._play = gui.add_button("Play (P)", icon=viser.Icon.PLAYER_PLAY, hint="Play or pause, also with the key P.")
        self._play.on_click(_plain(actions.play))
        moves: dict[str, Callable[[], None]] = {
            "First (R)": lambda: actions.jump(0),
            "Back (B)": lambda: actions.step(-1),
            "Next (N)": lambda: actions.step(1),
            "Last": lambda: actions.jump(-1),
        }
        buttons = gui.add_button_group("Step", tuple(moves))
        buttons.on_click(lambda event: moves[event.target.value]())
        self._scrub = gui.add_slider("Iteration", 0, 1, 1, 0, hint="Drag through the registration.")
        self._scrub.on_update(lambda event: actions.jump(int(event.target.value)) if event.client else None)
        self._inputs["speed"] = gui.add_slider(
            "Speed", 1, 60, 1, state.speed, hint="Iterations a second while playing."
        )
        self._readout = gui.add_html(_PREPARING)
        self._cancel = gui.add_button("Cancel what is computed", color="gray", visible=False)
        self._cancel.on_click(_plain(actions.cancel))

    def _scene(self, gui: viser.GuiApi, state: State, actions: Actions) -> None:
        with gui.add_folder("Perturb the scene"):
            self._inputs["shape"] = gui.add_dropdown(
                "Shape", tuple(self._library.subjects), initial_value=state.shape, hint=self._shape_hint()
            )
            paper = Perturbation()
            for name, allowed in RANGES.items():
                whole = name in ("points", "outliers")
                kind = int if whole else float
                self._inputs[name] = gui.add_slider(
                    name.capitalize(),
                    kind(allowed.low),
                    kind(allowed.high),
                    kind(_STEPS[name]),
                    kind(np.clip(getattr(state.perturbation, name), allowed.low, allowed.high)),
                    marks=((kind(getattr(paper, name)), f"{getattr(paper, name):g}"),),
                    hint=_HINTS[name] + " The mark is the paper's default.",
                )
            self._inputs["outlier_kind"] = gui.add_dropdown(
                "Outlier kind",
                get_args(OutlierKind),
                initial_value=state.perturbation.outlier_kind,
                hint="Uniform: spread over a cube. Structured: one compact ball, as on the paper's real data.",
            )
            self._inputs["seed"] = gui.add_number(
                "Seed", state.perturbation.seed, min=0, max=LARGEST_SEED, step=1, hint="The same seed, the same scene."
            )
            scene_buttons = {"New seed": actions.new_seed, "Paper defaults": actions.paper_defaults}
            gui.add_button_group("Scene", tuple(scene_buttons)).on_click(
                lambda event: scene_buttons[event.target.value]()
            )

    def _methods(self, gui: viser.GuiApi, state: State) -> None:
        with gui.add_folder("Methods and stopping"):
            for name in ("left", "right"):
                self._inputs[name] = gui.add_dropdown(
                    f"{name.capitalize()} pane", self._library.methods(state.shape), initial_value=getattr(state, name)
                )
            self._inputs["epsilon"] = gui.add_number(
                "Stop below ε",
                state.epsilon,
                min=EPSILON_RANGE[0],
                max=EPSILON_RANGE[1],
                step=0.0005,
                hint="DO and Improved DO end when the update norm is below this. The paper says 0.005.",
            )
            self._inputs["max_iterations"] = gui.add_number(
                "Most iterations",
                state.max_iterations,
                min=1,
                max=LONGEST_RUN,
                step=1,
                hint="DO's and Improved DO's. Paper: 1000.",
            )

    def _view(self, gui: viser.GuiApi, state: State) -> None:
        with gui.add_folder("View"):
            self._inputs["order"] = gui.add_dropdown(
                "Order bins by", get_args(BinOrder), initial_value=state.order, hint="Within each side of a block."
            )
            self._inputs["difference"] = gui.add_checkbox(
                "Histogram minus reference", state.difference, hint="Show the difference instead of both."
            )
            self._inputs["follow"] = gui.add_checkbox(
                "Maps follow the iteration", state.pinned_map == 0, hint="Otherwise the map below is shown."
            )
            self._inputs["pinned_map"] = gui.add_slider(
                "Map", 1, 30, 1, max(1, state.pinned_map), disabled=state.pinned_map == 0
            )
            self._inputs["ghost"] = gui.add_checkbox("Where it belongs", state.ghost, hint="Ground truth, in green.")
            self._inputs["dark"] = gui.add_checkbox("Dark", state.dark)

    def _share(self, gui: viser.GuiApi, actions: Actions) -> None:
        with gui.add_folder("Share", expand_by_default=False):
            self._code = gui.add_text("State", "", hint="Copy this code, or paste one to get exactly its page.")
            self._code.on_update(lambda event: actions.apply_code(event.target.value) if event.client else None)

    def _shape_hint(self) -> str:
        return "; ".join(f"{name}: {subject.title}" for name, subject in self._library.subjects.items())

    def _on_input(self, event: viser.GuiEvent[Any]) -> None:
        if event.client is not None:
            self._actions.changed()

    def read(self, state: State) -> tuple[State, bool]:
        """The state with the widgets' newest values, and whether they all were usable as they are.

        Nonsense is brought into range.
        """
        value = {name: handle.value for name, handle in self._inputs.items()}
        perturbation = Perturbation(
            **{name: _within(value[name], r.low, r.high, getattr(Perturbation(), name)) for name, r in RANGES.items()},
            outlier_kind=value["outlier_kind"],
            seed=_within(value["seed"], 0, LARGEST_SEED, 0),
        )
        known = self._library.methods(value["shape"])
        newest = replace(
            state,
            shape=value["shape"],
            perturbation=perturbation,
            left=value["left"] if value["left"] in known else known[0],
            right=value["right"] if value["right"] in known else known[1],
            epsilon=_within(value["epsilon"], *EPSILON_RANGE, State().epsilon),
            max_iterations=_within(value["max_iterations"], 1, LONGEST_RUN, State().max_iterations),
            speed=_within(value["speed"], 1, 60, State().speed),
            order=value["order"],
            difference=value["difference"],
            pinned_map=0 if value["follow"] else _within(value["pinned_map"], 1, 30, 1),
            ghost=value["ghost"],
            dark=value["dark"],
        )
        wanted = _widget_values(newest)
        return newest, all(value[name] == wanted[name] for name in wanted)

    def show(self, state: State) -> None:
        """Write a state into the widgets, those that differ from it alone."""
        known = self._library.methods(state.shape)
        for name in ("left", "right"):
            if self._inputs[name].options != known:
                self._inputs[name].options = known
        for name, value in _widget_values(state).items():
            if self._inputs[name].value != value:
                self._inputs[name].value = value

    def show_run(self, run: Run, state: State, iteration: int) -> None:
        """Write what only shows: the readouts and the labels."""
        self._readout.content = readout_html(run, iteration)
        label = "Pause (P)" if state.playing else "Play (P)"
        if self._play.label != label:
            self._play.label = label
            self._play.icon = viser.Icon.PLAYER_PAUSE if state.playing else viser.Icon.PLAYER_PLAY
        if self._inputs["pinned_map"].disabled != (state.pinned_map == 0):
            self._inputs["pinned_map"].disabled = state.pinned_map == 0

    def show_cancel(self, shown: bool) -> None:
        """Show or hide the button that cancels slow methods."""
        if self._cancel.visible != shown:
            self._cancel.visible = shown

    def show_iteration(self, run: Run, state: State, iteration: int) -> None:
        """Write the iteration, and, when nothing plays, the code."""
        last = max(1, run.iterations)
        if self._scrub.max != last:
            if self._scrub.value > last:
                self._scrub.value = last
            self._scrub.max = last
        if self._scrub.value != iteration:
            self._scrub.value = iteration
        if not state.playing:
            code = encode(state)
            if self._code.value != code:
                self._code.value = code


def _widget_values(state: State) -> dict[str, Any]:
    """What each widget holds for a state."""
    values: dict[str, Any] = {name: getattr(state.perturbation, name) for name in (*RANGES, "outlier_kind", "seed")}
    for name in (
        "shape",
        "left",
        "right",
        "epsilon",
        "max_iterations",
        "speed",
        "order",
        "difference",
        "ghost",
        "dark",
    ):
        values[name] = getattr(state, name)
    values["follow"] = state.pinned_map == 0
    if state.pinned_map:
        values["pinned_map"] = state.pinned_map
    return values


def _plain(act: Callable[[], None]) -> Callable[[Any], None]:
    """An event callback that does without the event."""
    return lambda _: act()


Number = TypeVar("Number", int, float)


def _within(value: Any, low: float, high: float, default: Number) -> Number:
    """A number brought into a range, of the default's kind; the default if it is none at all."""
    if not isinstance(value, int | float) or not math.isfinite(value):
        return default
    return type(default)(min(max(value, low), high))
