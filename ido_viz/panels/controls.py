"""The control panel: widgets that show a state and are read back into one."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, get_args

import numpy as np
import viser

from ido import RANGES, Perturbation
from ido.perturbation import LARGEST_SEED, OutlierKind
from ido_viz.core.actions import Actions, at_once, plain
from ido_viz.core.frame import Frame
from ido_viz.core.library import Library
from ido_viz.core.state import EPSILON_RANGE, LONGEST_RUN, BinOrder, Overlay, Part, State
from ido_viz.panels.control_values import STEPS, values_of, with_values
from ido_viz.panels.playback import PREPARING, Playback
from ido_viz.panels.reach import reach_html
from ido_viz.panels.readout import readout_html
from ido_viz.panels.sharing import ShareFolder

_HINTS = {
    "noise": "Standard deviation of the Gaussian noise on every point, in model units (the model fits in ±1).",
    "points": "Points drawn from the full cloud, before some are removed.",
    "outliers": "Points added that belong to nothing.",
    "incomplete": "Share of the points removed, all on one side of a random plane.",
    "rotation": "Angle in degrees about a random axis.",
    "translation": "Distance in a random direction, in model units.",
}


class Controls:
    """The widgets that a state is made of. `read` gives the newest values; `show` writes a state into the widgets.

    Args:
        client: the page.
        library: shapes and methods on offer.
        state: what the page begins with.
        actions: what the buttons do.
    """

    def __init__(self, client: viser.ClientHandle, library: Library, state: State, actions: Actions) -> None:
        gui = client.gui
        self._library = library
        self._inputs: dict[str, Any] = {}
        self._playback = Playback(gui, state, actions)
        self._inputs["speed"] = self._playback.speed
        self.parts: dict[Part, list[Any]] = {}
        """What a lecturer can hide."""
        with self._part(gui, "scene"):
            self._scene(gui, state)
            self._reach = gui.add_html("")
        with self._part(gui, "scores"):
            self._readout = gui.add_html(PREPARING)
        tabs = gui.add_tab_group()
        self.tabs = {name: tabs.add_tab(name) for name in ("Scene", "Learn", "Methods", "View", "Share")}
        """Below the sliders; others may add to them."""
        with self.tabs["Scene"], self._part(gui, "scene"):
            self._draw_of_scene(gui, state, actions)
        with self.tabs["Methods"], self._part(gui, "methods"):
            self._methods(gui, state)
        with self.tabs["View"], self._part(gui, "view"):
            self._view(gui, state, actions)
        with self.tabs["Share"], self._part(gui, "share"):
            self._share = ShareFolder(gui, state, actions)
        for handle in self._inputs.values():
            handle.on_update(at_once(lambda _: actions.changed()))
        for label, key, act in (
            ("Play or pause", "P", actions.play),
            ("Next iteration", "N", lambda: actions.step(1)),
            ("Back one iteration", "B", lambda: actions.step(-1)),
            ("Restart at iteration 0", "R", lambda: actions.jump(0)),
            ("Look inside the next iteration", "I", actions.look_inside),
            ("Reset view", "V", actions.reset_view),
        ):
            gui.add_command(label, hotkey=key).on_trigger(plain(act))  # type: ignore[arg-type]
        gui.add_command("Clear the selection", hotkey="escape").on_trigger(plain(actions.clear))
        gui.add_command("Undo", hotkey="Z", modifier="cmd/ctrl").on_trigger(plain(actions.undo))
        gui.add_command("Redo", hotkey="Z", modifier="cmd/ctrl+shift").on_trigger(plain(actions.redo))

    def _part(self, gui: viser.GuiApi, part: Part) -> viser.GuiFolderHandle:
        """A nameless folder that a lecturer can hide."""
        folder = gui.add_folder(None)
        self.parts.setdefault(part, []).append(folder)
        return folder

    def _scene(self, gui: viser.GuiApi, state: State) -> None:
        self._inputs["shape"] = gui.add_dropdown(
            "Shape", tuple(self._library.subjects), initial_value=state.shape, hint=self._shape_hint()
        )
        paper = Perturbation()
        values = values_of(state)
        for name, allowed in RANGES.items():
            kind = int if name in ("points", "outliers") else float
            self._inputs[name] = gui.add_slider(
                name.capitalize(),
                kind(allowed.low),
                kind(allowed.high),
                kind(STEPS[name]),
                kind(np.clip(values[name], allowed.low, allowed.high)),
                marks=((kind(getattr(paper, name)), f"{getattr(paper, name):g}"),),
                hint=_HINTS[name] + " The mark is the paper's default.",
            )

    def _draw_of_scene(self, gui: viser.GuiApi, state: State, actions: Actions) -> None:
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
        gui.add_button_group(
            "Draw", tuple(scene_buttons), hint="Draw another scene, or take the paper's values with the same seed."
        ).on_click(at_once(lambda button: scene_buttons[button]()))
        self._inputs["replay"] = gui.add_checkbox(
            "Play a change", state.replay, hint="Play the registration from its start whenever the scene is changed."
        )

    def _methods(self, gui: viser.GuiApi, state: State) -> None:
        for name in ("left", "right"):
            self._inputs[name] = gui.add_dropdown(
                f"{name.capitalize()} pane",
                self._library.methods(state.shape),
                initial_value=getattr(state, name),
                hint=f"Any method can stand on the {name}. Slow ones compute in the background.",
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

    def _view(self, gui: viser.GuiApi, state: State, actions: Actions) -> None:
        reset = gui.add_button("Reset view (V)", color="gray", hint="See both panes whole again, also with the key V.")
        reset.on_click(plain(actions.reset_view))
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
            "Map",
            1,
            max(2, state.pinned_map),  # as many as the methods have, once they are drawn
            1,
            max(1, state.pinned_map),
            disabled=state.pinned_map == 0,
            hint="Which map is shown, when the maps do not follow the iteration.",
        )
        self._inputs["ghost"] = gui.add_checkbox("Where it belongs", state.ghost, hint="Ground truth, in green.")
        self._inputs["handles"] = gui.add_checkbox(
            "Handles", state.handles, hint="Rings and arrows by which the scene can be turned and shifted."
        )
        self._inputs["error_vectors"] = gui.add_checkbox(
            "Error vectors", state.error_vectors, hint="A line from each scene point to where it belongs."
        )
        self._inputs["overlay"] = gui.add_dropdown(
            "Overlay",
            get_args(Overlay),
            initial_value=state.overlay,
            hint="Draw the scene a second time in each pane, and its histogram in grey: at the pose of the other "
            "method, or of the iteration below.",
        )
        self._inputs["overlaid_iteration"] = gui.add_number(
            "At iteration",
            state.overlaid_iteration,
            min=0,
            max=LONGEST_RUN,
            step=1,
            hint="Which iteration is laid over; beyond the last one, the last.",
        )
        self._inputs["dark"] = gui.add_checkbox("Dark", state.dark, hint="Light on dark, for a dim room.")
        self._inputs["large_text"] = gui.add_checkbox(
            "Large text", state.large_text, hint="Larger text everywhere, for a projector."
        )

    def _shape_hint(self) -> str:
        return "; ".join(f"{name}: {subject.title}" for name, subject in self._library.subjects.items())

    def read(self, state: State) -> tuple[State, bool]:
        """The state with the widgets' newest values, and whether they all were usable as they are.

        Nonsense is brought into range.
        """
        values = {name: handle.value for name, handle in self._inputs.items()}
        newest = with_values(state, values, self._library, self._inputs["pinned_map"].max)
        wanted = values_of(newest)
        return replace(newest, hidden=self._share.hidden), all(values[name] == wanted[name] for name in wanted)

    def show(self, state: State) -> None:
        """Write a state into the widgets, those that differ from it alone."""
        known = self._library.methods(state.shape)
        for name in ("left", "right"):
            if self._inputs[name].options != known:
                self._inputs[name].options = known
        self._offer_shapes()
        values = values_of(state)
        self._inputs["pinned_map"].max = max(self._inputs["pinned_map"].max, state.pinned_map)
        for name, value in values.items():
            if self._inputs[name].value != value:
                self._inputs[name].value = value

        self._share.show(state)

    def _offer_shapes(self) -> None:
        shapes, menu = tuple(self._library.subjects), self._inputs["shape"]
        if menu.options != shapes:
            menu.options, menu.hint = shapes, self._shape_hint()

    def draw(self, frame: Frame, *, may_cancel: bool) -> None:
        """Write what only shows: the readouts and the labels."""
        self._offer_shapes()
        reach = reach_html(frame)
        if self._reach.content != reach:
            self._reach.content = reach
        self._playback.draw(frame)
        readout = readout_html(frame)
        if self._readout.content != readout:
            self._readout.content = readout
        self._playback.show_cancel(may_cancel)
        slider = self._inputs["pinned_map"]
        if slider.disabled != (frame.state.pinned_map == 0):
            slider.disabled = frame.state.pinned_map == 0
        most = max(2, frame.state.pinned_map, *(len(side.run.maps.maps) for side in frame.sides if side.run.maps))
        if slider.max != most:
            if slider.value > most:
                slider.value = most
            slider.max = most

    def show_iteration(self, frame: Frame) -> None:
        """Write the iteration."""
        self._playback.show_iteration(frame)

    def show_code(self, state: State) -> None:
        """Write a state's code."""
        self._share.show_code(state)
