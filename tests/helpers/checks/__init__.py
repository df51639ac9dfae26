"""The checks of what lessons and presets claim, by ``lesson/id`` of a claim and ``presets/id`` of a preset."""

from __future__ import annotations

from checks import anywhere, far, learning, limits, moving, presets, results, seeing, tracing
from checks.helpers import Check

_MODULES = (seeing, moving, far, anywhere, limits, learning, results, tracing, presets)

NAMES: tuple[str, ...] = tuple(name for module in _MODULES for name in module.CHECKS)
"""Of all checks, as often as there is one of the name."""

CHECKS: dict[str, Check] = {name: check for module in _MODULES for name, check in module.CHECKS.items()}
