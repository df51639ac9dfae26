"""Registering from any start (docs/global.md): what is needed of it."""

from ido.global_registration.confidence import Confidence
from ido.global_registration.evidence import Evidence
from ido.global_registration.global_method import Branch, Candidate, GlobalRegistration, GlobalResult, Stage, polish
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
