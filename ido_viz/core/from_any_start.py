"""The methods that register a scene wherever it lies, as a shape offers them."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable, Mapping
from functools import lru_cache

from ido import Cloud, Maps, Model
from ido.global_registration import GlobalModel, GlobalRegistration, ManyStarts
from ido.methods import MANY_STARTS, Method
from ido_viz.core.background import Report, Shared

GLOBAL = "Global"
"""The global method with all that it assumes of a scene; without parts of it, it is in the experiments alone."""

_KEPT = 4  # shapes whose fields are kept, 60 MB each
_ASKING = threading.Lock()  # two pages that ask at once must get the same


def names_from_any_start(learned: Iterable[str]) -> tuple[str, ...]:
    """Names of these methods, for a shape with learned methods of these names."""
    known = tuple(learned)
    return (GLOBAL, *(name for name, one in MANY_STARTS.items() if one in known))


def method_from_any_start(
    name: str, cloud: Callable[[], Cloud], maps: Mapping[str, Callable[[], Maps]], model: Model, report: Report
) -> Method:
    """One of these methods by name. The fields of its shape are made when they are first asked for, for all pages.

    Args:
        name: one of `names_from_any_start`.
        cloud: the shape's; always the same function for the same shape.
        maps: the shape's, by the names of its learned methods.
        model: what its result is shown on.
        report: told how far the fields are; what it raises ends the waiting for them.
    """
    with _ASKING:
        shared = _fields(cloud)
    fields = shared.get(report)
    starts = None if name == GLOBAL else ManyStarts(maps[MANY_STARTS[name]]())
    return Method.from_any_start(name, GlobalRegistration(fields, starts=starts), model)


@lru_cache(maxsize=_KEPT)
def _fields(cloud: Callable[[], Cloud]) -> Shared[GlobalModel]:
    def made(report: Report) -> GlobalModel:
        report("preparing the shape, once")
        return GlobalModel.of(cloud().points)

    return Shared(made)
