"""Scans placed on a city model, with honest statistics (paper B, section 2.1)."""

from frontage.registration.georeference import prior_of, register
from frontage.registration.options import RegistrationOptions
from frontage.registration.result import (
    Alternative,
    Direction,
    PosePrior,
    Registered,
    Registration,
    WallOffset,
)

__all__ = [
    "Alternative",
    "Direction",
    "PosePrior",
    "Registered",
    "Registration",
    "RegistrationOptions",
    "WallOffset",
    "prior_of",
    "register",
]
