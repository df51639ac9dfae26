"""The explorer as a person uses it, whatever shows it: what is seen, what is done, and what must be true of both."""

from __future__ import annotations

import time
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache

import numpy as np

from ido_viz.core.library import shipped_library
from ido_viz.core.run import MethodRun, Run, compute
from ido_viz.core.state import LAST, State, decode

AT_THE_START = State(playing=False, replay=False)
AT_THE_END = replace(AT_THE_START, iteration=LAST)

PATIENCE = 90.0  # seconds; only a failing test waits that long, or a machine that is very slow
BETWEEN_CONTROLS = 60  # milliseconds: a panel sends the input of one control at a time
SETTLING = 400  # milliseconds in which a late frame would show
LOOKS = 25, 120  # milliseconds between two looks at a page, at first and at last: each look costs it several

SLIDERS = {
    "Noise": 0.2,
    "Points": 0.25,
    "Outliers": 0.9,
    "Incomplete": 0.15,
    "Rotation": 0.6,
    "Translation": 0.75,
}
"""The sliders, and to which share of its track each is dragged."""

Numbers = dict[str, tuple[str, str]]
"""The readout: for each row what it says of the left and of the right pane."""


@lru_cache(maxsize=64)
def independent_run(state: State) -> Run:
    """The run of a state, computed by the test itself."""
    return compute(state, shipped_library())


def next_update(side: MethodRun, points: np.ndarray, k: int) -> str:
    """What the readout must say of the next update, computed anew from the histogram."""
    at_end = k == side.trajectory.iterations
    if at_end and (side.maps is None or side.trajectory.stop == "iteration limit"):
        return "–"
    if side.maps is None:
        return f"{side.trajectory.update_norms[k]:.4f}"
    D = side.maps.maps[min(k, len(side.maps.maps) - 1)]
    return f"{np.linalg.norm(D @ side.maps.histogram(points, side.trajectory.x[k])):.4f}"


def numbers_of(state: State) -> Numbers:
    """What the readout must say for a state."""
    run = independent_run(replace(state, iteration=0, playing=False))
    rows: list[tuple[str, ...]] = []
    for side in run.sides:
        n = side.trajectory.iterations
        k = n if state.iteration == LAST else min(state.iteration, n)
        rows.append(
            (
                f"{k} / {n}",
                next_update(side, run.scene.points, k),
                f"{side.scores.accuracy[k]:.3f}",
                f"{side.scores.rmse[k]:.4f}",
                f"{side.scores.rotation[k]:.2f}°",
                f"{side.scores.translation[k]:.4f}",
                "not yet" if k < n else str(side.trajectory.stop),
            )
        )
    names = ("Iteration", "Next update", "PointAcc", "PointRMSE", "Rotation error", "Translation error", "Stops")
    return {name: (left, right) for name, left, right in zip(names, *rows, strict=True)}


class AnyExplorer(ABC):
    """One open page."""

    @abstractmethod
    def pause(self, milliseconds: int = BETWEEN_CONTROLS) -> None:
        """Wait as people do between two controls."""

    # What can be seen

    @abstractmethod
    def readout(self) -> list[list[str]]:
        """The table of numbers, row by row."""

    @abstractmethod
    def verdicts(self) -> list[str]:
        """What is said of each pane over the canvas."""

    @abstractmethod
    def code(self) -> str:
        """What the Share box holds."""

    @abstractmethod
    def notifications(self) -> list[str]:
        """The messages on the page."""

    @abstractmethod
    def is_playing(self) -> bool:
        """Whether the play button offers to pause."""

    @abstractmethod
    def step(self) -> str | None:
        """Where the lesson is, in words; None when there is none."""

    @abstractmethod
    def slider_value(self, label: str) -> float:
        """Where a slider's thumb is."""

    @abstractmethod
    def options(self, label: str) -> list[str]:
        """What a menu offers."""

    # What can be done

    @abstractmethod
    def press(self, button: str) -> None:
        """Press a button, in its tab."""

    @abstractmethod
    def drag(self, label: str, *shares: float, steps: int = 12) -> float:
        """Drag a slider's thumb to shares of its track, one after another; where it ends."""

    @abstractmethod
    def choose(self, label: str, option: str) -> None:
        """Choose from a menu."""

    @abstractmethod
    def tick(self, label: str) -> None:
        """Tick or untick a box."""

    @abstractmethod
    def paste(self, code: str) -> None:
        """Paste a code into the Share box."""

    @abstractmethod
    def open_tab(self, name: str) -> None:
        """Open a tab of a panel."""

    # What must be true

    def numbers(self) -> Numbers:
        """What the readout says."""
        return {name: (left, right) for name, left, right in self.readout()[1:]}

    def methods(self) -> tuple[str, str]:
        """The names above the readout's columns."""
        _, left, right = self.readout()[0]
        return left, right

    def wait_until(self, what: str, condition: Callable[[], object]) -> None:
        """Wait until something is true."""
        deadline = time.monotonic() + PATIENCE
        pause, longest = LOOKS
        while not condition():
            assert time.monotonic() < deadline, f"waited in vain for: {what}; the page has {self.readout()}"
            self.pause(pause)
            pause = min(pause * 3 // 2, longest)

    def iteration(self) -> int:
        """The iteration that is shown, of the method that is ahead."""
        return max(int(cell.split("/")[0]) for cell in self.numbers()["Iteration"])

    def last_iteration(self) -> int:
        """The last iteration, of the method that takes longer."""
        return max(int(cell.split("/")[1]) for cell in self.numbers()["Iteration"])

    def state(self) -> State:
        """The state of the Share box; it is kept up while nothing plays."""
        return decode(self.code())

    def slider_in_state(self, label: str) -> float:
        """What the state has of one of `SLIDERS`."""
        return getattr(self.state().perturbation, label.lower())

    def expect_numbers(self, state: State) -> None:
        """Wait until the readout says what it must for a state."""
        expected = numbers_of(state)
        self.wait_until(f"the numbers {expected}", lambda: self.numbers() == expected)

    def expect_to_agree(self) -> State:
        """Wait until the readout fits the Share box, and see that it stays so; the state."""
        self.wait_until("readout and state to agree", lambda: self.numbers() == numbers_of(self.state()))
        state = self.state()
        self.pause(SETTLING)
        assert self.state() == state, "the state changed by itself"
        assert self.numbers() == numbers_of(state), "the readout changed by itself"
        return state

    def expect_alive(self) -> None:
        """See that the page still reacts: first and next iteration are shown."""
        self.press("First (R)")
        self.wait_until("the first iteration", lambda: self.iteration() == 0)
        self.pause()
        self.press("Next (N)")
        self.wait_until("the next iteration", lambda: self.iteration() == 1)

    def expect_step(self, number: int, of: int) -> None:
        """Wait until a lesson is at a step."""
        self.wait_until(f"step {number}", lambda: self.step() == f"Step {number} of {of}")
