"""Registering from any start (docs/global.md): what is needed of it."""

from ido.global_registration.confidence import Confidence
from ido.global_registration.evidence import Evidence
from ido.global_registration.global_method import GlobalRegistration, polish
from ido.global_registration.global_result import Branch, Candidate, GlobalResult, Stage
from ido.global_registration.many_starts import ManyStarts
from ido.global_registration.model import GlobalModel, surface_of
from ido.global_registration.settings import GlobalSettings

__all__ = [
    "Branch",
    "Candidate",
    "Confidence",
    "Evidence",
    "GlobalModel",
    "GlobalRegistration",
    "GlobalResult",
    "GlobalSettings",
    "ManyStarts",
    "Stage",
    "polish",
    "surface_of",
]
