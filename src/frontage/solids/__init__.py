"""Solids: are they valid? ISO 19107 with the error codes and tolerances of val3dity.

``validate(solid)`` for Frontage's own integer solids, `validate_shape` and `validate_feature` for what was
read from files. The order is the standard's: rings, polygons, shells, solids, composites, buildings.
"""

from frontage.solids.codes import NAMES, QIE_NAMES
from frontage.solids.tolerances import Tolerances
from frontage.solids.validate import validate, validate_feature, validate_shape

__all__ = ["NAMES", "QIE_NAMES", "Tolerances", "validate", "validate_feature", "validate_shape"]
