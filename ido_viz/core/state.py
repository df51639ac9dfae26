"""Everything that decides what a page shows, as one frozen value, and its short code for sharing."""

from __future__ import annotations

import base64
import binascii
import json
import zlib
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, fields, replace
from functools import lru_cache
from typing import Any, Literal, get_args

from ido import RANGES, Perturbation
from ido.registration import EPSILON, MAX_ITERATIONS

BinOrder = Literal["reference value", "model index", "elevation", "azimuth", "contribution"]
Coloring = Literal["height", "whole update", "towards the truth", "ρx", "ρy", "ρz", "φx", "φy", "φz"]
Overlay = Literal["nothing", "other method", "another iteration"]
Pane = Literal["left", "right"]
Part = Literal[
    "lessons", "presets", "scores", "scene", "methods", "view", "share", "download", "upper charts", "lower charts"
]
NO_START: tuple[float, ...] = ()
"""The start pose that the sliders make."""

NO_CAMERA: tuple[float, ...] = ()
"""The camera that shows both panes whole."""

NORMAL_SPEED = 15
"""The speed at which a run takes as long as `pacing` says."""

NO_POINT = -1
"""Number of the inspected model point when there is none."""

LAST = -1
"""Iteration that stands for the last one, however many there are."""

LONGEST_RUN = 5000
LONGEST_NAME = 100
"""Of a block, letters."""

FARTHEST = 20.0
"""Of a start pose and the camera, model units."""

BEATS = 5
"""Of the slow motion of an iteration."""

MOST_MAPS = 1000
"""Highest number of a map that can be pinned."""

EPSILON_RANGE = (1e-5, 0.1)
_CODE = "ido1-"


class StateError(ValueError):
    """A state or its code cannot be used; the message says why."""


@dataclass(frozen=True, slots=True, kw_only=True)
class State:
    """What a page shows.

    Args:
        shape: name of the shape.
        perturbation: makes the scene.
        start: how the scene was moved by hand after that, exponential coordinates (6 numbers); `NO_START` for not.
        left: method of the left pane.
        right: method of the right pane.
        epsilon: stopping threshold of the update norm.
        max_iterations: limit of all iterations.
        iteration: k, the poses after k updates are shown; `LAST` for the end.
        inside: how far the slow motion of the next iteration is, in beats; 0 for none.
        playing: whether the iteration moves on by itself.
        speed: how fast it plays, see `pacing`; 15 is normal.
        replay: whether another scene is played from its start.
        order: how the bins of each side of a block are ordered in charts and heatmaps.
        difference: show histogram minus reference.
        pinned_map: number of the map in the heatmap, 0 to follow the iteration.
        ghost: show where the scene belongs.
        handles: show handles to turn and shift the scene by.
        error_vectors: draw a line from each scene point to where it belongs.
        overlay: what else is drawn in each pane, and in its histogram: the scene at another pose.
        overlaid_iteration: the other iteration, for that overlay.
        inspected: number of the model point that is looked into; `NO_POINT` for none.
        scene_point: number of the scene point that it is asked about; `NO_POINT` for all alike.
        inspected_pane: whose method is looked into.
        question: name of the block whose question colours the scene points.
        coloring: what the model points' colours mean: height, or their share in the next update, in what of it leads
            to the true pose, or in one of its numbers. The shares listed, and the order by contribution, are those.
        against_reference: shares of what differs from the reference alone.
        camera: where from it is seen, see `geometry.Camera` (6 numbers); `NO_CAMERA` for both panes whole.
        dark: dark page.
        large_text: larger text, for a projector.
        hidden: parts of the page that a lecturer has taken away, in the order of `Part`.

    Raises:
        StateError: a value is unknown or out of range.
    """

    shape: str = "bunny"
    perturbation: Perturbation = field(default_factory=Perturbation)
    start: tuple[float, ...] = NO_START
    left: str = "DO"
    right: str = "Improved DO"
    epsilon: float = EPSILON
    max_iterations: int = MAX_ITERATIONS
    iteration: int = 0
    inside: float = 0.0
    playing: bool = True
    speed: int = NORMAL_SPEED
    replay: bool = True
    order: BinOrder = "reference value"
    difference: bool = False
    pinned_map: int = 0
    ghost: bool = True
    handles: bool = True
    error_vectors: bool = False
    overlay: Overlay = "nothing"
    overlaid_iteration: int = 0
    inspected: int = NO_POINT
    scene_point: int = NO_POINT
    inspected_pane: Pane = "right"
    question: str = "front / back"
    coloring: Coloring = "height"
    against_reference: bool = False
    camera: tuple[float, ...] = NO_CAMERA
    dark: bool = False
    large_text: bool = False
    hidden: tuple[Part, ...] = ()

    def __post_init__(self) -> None:
        for f in fields(self):
            kind = Perturbation if f.name == "perturbation" else type(f.default)
            if type(getattr(self, f.name)) is not kind and not (kind is float and type(getattr(self, f.name)) is int):
                raise StateError(f"{f.name} must be of the kind {kind.__name__}, not {getattr(self, f.name)!r}")
        choices = {
            "order": BinOrder,
            "overlay": Overlay,
            "inspected_pane": Pane,
            "coloring": Coloring,
        }
        for name, known in choices.items():
            if getattr(self, name) not in get_args(known):
                raise StateError(f"unknown {name} {getattr(self, name)!r}; known: {', '.join(get_args(known))}")
        if self.hidden != tuple(part for part in get_args(Part) if part in self.hidden):
            raise StateError(f"hidden must name parts of the page, each once: {', '.join(get_args(Part))}")
        limits = {
            "epsilon": EPSILON_RANGE,
            "max_iterations": (1, LONGEST_RUN),
            "iteration": (LAST, LONGEST_RUN),
            "inside": (0, BEATS),
            "speed": (1, 60),
            "pinned_map": (0, MOST_MAPS),
            "overlaid_iteration": (0, LONGEST_RUN),
            "inspected": (NO_POINT, 1_000_000),
            "scene_point": (NO_POINT, 1_000_000),
        }
        for name, (low, high) in limits.items():
            if not low <= getattr(self, name) <= high:
                raise StateError(f"{name} must lie between {low:g} and {high:g}, not {getattr(self, name)}")
        for name in ("start", "camera"):
            numbers = getattr(self, name)
            if numbers and not (len(numbers) == 6 and all(_is_moderate(number) for number in numbers)):
                raise StateError(f"{name} must be six numbers between -{FARTHEST:g} and {FARTHEST:g}, or none")
        if len(self.question) > LONGEST_NAME:
            raise StateError(f"question must have at most {LONGEST_NAME} letters")
        for name, allowed in RANGES.items():
            if not allowed.low <= getattr(self.perturbation, name) <= allowed.high:
                raise StateError(f"{name} must lie between {allowed.low:g} and {allowed.high:g} on a page")


def _is_moderate(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) <= FARTHEST


OF_SCENE = frozenset(f.name for f in fields(Perturbation))
"""Names of what a scene is made by."""

VALUES: frozenset[str] = OF_SCENE | {f.name for f in fields(State)} - {"perturbation"}
"""Names of all that a page shows, the scene's values among them."""


def with_values(state: State, values: Mapping[str, Any]) -> State:
    """A state with other values, given by their names in `VALUES`.

    Raises:
        StateError: a value is unknown or out of range.
    """
    unknown = values.keys() - VALUES
    if unknown:
        raise StateError(f"unknown {', '.join(sorted(unknown))}; known: {', '.join(sorted(VALUES))}")
    perturbation = state.perturbation
    for name in (name for name in values if name in OF_SCENE):
        try:
            perturbation = replace(perturbation, **{name: values[name]})
        except TypeError as error:
            raise StateError(f"{name} must be a number, not {values[name]!r}") from error
        except ValueError as error:
            raise StateError(str(error)) from error
    return replace(state, perturbation=perturbation, **{n: v for n, v in values.items() if n not in OF_SCENE})


@lru_cache(maxsize=64)  # a page asks several times with each frame
def encode(state: State) -> str:
    """The short code of a state: what differs from the defaults, as text that survives mail and chat."""
    default = State()
    changed: dict[str, Any] = {f.name: getattr(state, f.name) for f in fields(State)}
    changed = {name: value for name, value in changed.items() if value != getattr(default, name)}
    if "perturbation" in changed:
        plain = asdict(default.perturbation)
        changed["perturbation"] = {n: v for n, v in asdict(state.perturbation).items() if v != plain[n]}
    packed = zlib.compress(json.dumps(changed, separators=(",", ":")).encode(), level=9)
    return _CODE + base64.urlsafe_b64encode(packed).decode().rstrip("=")


def decode(code: str) -> State:
    """The state of a code that `encode` made.

    Raises:
        StateError: not such a code, cut off, of another version, or with values out of range.
    """
    code = code.strip()
    if not code.startswith(_CODE):
        raise StateError(f"a code starts with {_CODE!r}; copy it whole from the page's Share box")
    text = code.removeprefix(_CODE)
    try:
        packed = base64.urlsafe_b64decode(text + "=" * (-len(text) % 4))
        unpacking = zlib.decompressobj()
        values = json.loads(unpacking.decompress(packed, 10_000))
        if not unpacking.eof:
            raise StateError("the code is damaged or cut off; copy it whole")
        if not isinstance(values, dict):
            raise StateError("the code holds no state")
        perturbation = Perturbation(**values.pop("perturbation", {}))
        lists = {name: tuple(values.pop(name, ())) for name in ("hidden", "start", "camera")}
        return State(perturbation=perturbation, **lists, **values)
    except StateError:
        raise
    except (binascii.Error, zlib.error, UnicodeDecodeError, json.JSONDecodeError, RecursionError) as error:
        raise StateError("the code is damaged or cut off; copy it whole") from error
    except (TypeError, ValueError, OverflowError) as error:
        raise StateError(f"the code does not fit this version: {error}") from error
