"""Validity of solids and surfaces by ISO 19107, with the error codes and tolerances of val3dity.

`validate` checks Frontage's own integer solids; `validate_shape` and `validate_feature` check what was read
from files. The order is the standard's: rings, polygons, shells, solids, composites, buildings.
"""

from frontage.validation.codes import NAMES, QIE_NAMES
from frontage.validation.tolerances import Tolerances
from frontage.validation.validate import validate, validate_feature, validate_shape

__all__ = [
    "NAMES",
    "QIE_NAMES",
    "Tolerances",
    "validate",
    "validate_feature",
    "validate_shape",
]
