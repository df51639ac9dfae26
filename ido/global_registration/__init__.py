"""Registering from any start (docs/global.md): what is needed of it."""

from ido.global_registration.model import GlobalModel, surface_of
from ido.global_registration.registering import Branch, Candidate, GlobalRegistration, GlobalResult, Stage
from ido.global_registration.settings import GlobalSettings

__all__ = [
    "Branch",
    "Candidate",
    "GlobalModel",
    "GlobalRegistration",
    "GlobalResult",
    "GlobalSettings",
    "Stage",
    "surface_of",
]
