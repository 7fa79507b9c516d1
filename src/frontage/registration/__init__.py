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
from frontage.registration.select import Selection, WallPoints, select_walls
from frontage.registration.strips import Strips, correct_strips

__all__ = [
    "Alternative",
    "Direction",
    "PosePrior",
    "Registered",
    "Registration",
    "RegistrationOptions",
    "Selection",
    "Strips",
    "WallOffset",
    "WallPoints",
    "correct_strips",
    "prior_of",
    "register",
    "select_walls",
]
