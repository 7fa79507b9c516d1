"""Registration: scans placed on a city model, with honest statistics (paper B, section 2.1).

GPS, compass and level place a scan roughly; a coarse search and a robust adjustment place it on the walls of
the city model. The errors of the model itself are estimated as well, so that every pose comes with a
covariance, and directions that the data do not determine are named. The entry function is `register`;
`correct_strips` treats mobile recordings and `select_walls` finds the points of each wall.
"""

from frontage.registration.georeference import prior_of, register
from frontage.registration.options import RegistrationOptions
from frontage.registration.result import (
    Alternative,
    Direction,
    PosePrior,
    RegisteredScan,
    Registration,
    WallOffset,
)
from frontage.registration.select import Selection, WallPoints, select_walls
from frontage.registration.strips import Strips, correct_strips

__all__ = [
    "Alternative",
    "Direction",
    "PosePrior",
    "RegisteredScan",
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
