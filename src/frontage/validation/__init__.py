"""Validates solids and surfaces by ISO 19107, with the error codes and tolerances of val3dity.

`validate` is the entry function for Frontage's own integer solids; `validate_shape` and `validate_feature`
take what was read from files. The levels are those of the standard: rings, polygons, shells, solids,
composites, buildings.
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
