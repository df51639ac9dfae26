"""The fragment of a page's address, what follows `#`: the state's code, and the step of a lesson that is read."""

from __future__ import annotations

from dataclasses import dataclass, replace
from ipaddress import ip_address
from urllib.parse import parse_qs, quote, urlsplit

from ido_viz.core.inside import STEP
from ido_viz.core.state import State, StateError, encode

LONGEST_FRAGMENT = 2000
"""Characters."""


@dataclass(frozen=True, slots=True)
class Fragment:
    """What a fragment says.

    Args:
        code: of a state; empty for none.
        step: of a lesson, as ``histogram/3``; empty for none.
    """

    code: str = ""
    step: str = ""

    def __str__(self) -> str:
        parts = {"lesson": self.step, "state": self.code}
        return "&".join(f"{name}={quote(value)}" for name, value in parts.items() if value)


def read_fragment(text: str) -> Fragment:
    """What a fragment says, which may be empty.

    Raises:
        StateError: it is too long, or not such a fragment.
    """
    if len(text) > LONGEST_FRAGMENT:
        raise StateError(f"it has more than {LONGEST_FRAGMENT} characters after #")
    try:
        values = parse_qs(text, strict_parsing=bool(text), errors="strict", max_num_fields=2)
    except ValueError as error:
        raise StateError("after # stands state=CODE or lesson=NAME, and no more") from error
    if values.keys() - {"state", "lesson"}:
        raise StateError("after # stands state=CODE or lesson=NAME, and no more")
    return Fragment(code=values.get("state", [""])[0], step=values.get("lesson", [""])[0])


def shared(state: State) -> State:
    """What is told of a state to others: while it plays, the same from its start, for the iteration runs away."""
    if not state.playing:
        return state
    return replace(state, inside=min(state.inside, STEP)) if state.inside else replace(state, iteration=0)


def fragment_of(state: State, step: str) -> str:
    """The fragment of a page that shows a state, and a step of a lesson."""
    return str(Fragment(encode(shared(state)), step))


def opens_elsewhere(link: str) -> bool:
    """Whether other machines can open a link; those of this machine alone begin with its name for itself."""
    name = urlsplit(link).hostname or ""
    try:
        return not ip_address(name).is_loopback
    except ValueError:
        return name != "localhost"
