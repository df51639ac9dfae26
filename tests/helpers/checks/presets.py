"""Checks of what the presets are known for."""

from __future__ import annotations

from checks.helpers import LEFT, RIGHT, Check, all_of, at, both_in_place, both_wrong, ends, page_of_preset
from ido_viz.core.verdict import Verdict

CHECKS: dict[str, Check] = {
    "presets/defaults": both_in_place,
    "presets/half-is-missing": both_in_place,
    "presets/many-outliers": all_of(both_in_place, lambda run: int((~run.scene.is_outlier).sum()) == 280),
    "presets/turned": all_of(both_wrong, at(page_of_preset("turned", rotation=60.0), both_in_place)),
    "presets/moved": all_of(both_wrong, at(page_of_preset("moved", translation=0.3), both_in_place)),
    "presets/only-improved-do-fails": all_of(ends(Verdict.IN_PLACE, LEFT), ends(Verdict.WRONG_POSE, RIGHT)),
    "presets/only-do-fails": all_of(ends(Verdict.WRONG_POSE, LEFT), ends(Verdict.IN_PLACE, RIGHT)),
    "presets/stops-too-early": all_of(both_wrong, at(page_of_preset("stops-too-early", epsilon=0.001), both_in_place)),
    "presets/ball-of-outliers": all_of(both_wrong, at(page_of_preset("ball-of-outliers", outliers=0), both_in_place)),
}
