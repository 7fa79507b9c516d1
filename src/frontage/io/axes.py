"""The axes of coordinate reference systems: which comes first under which name, and what they can hold."""

import numpy as np
from pyproj import CRS, Transformer
from pyproj.exceptions import ProjError

from frontage.geometry.arrays import Float
from frontage.io import crs as systems
from frontage.io.crs import LARGEST_M

_FORMAL = ("urn:", "http:", "https:")
_MARGIN_DEG = 30.0  # around the area of use: national data are kept in one zone far beyond its edges


def is_formal(name: str) -> bool:
    """Whether a name of a CRS (URN, URL) means the authority's order of axes; "EPSG:3006" is east first."""
    return name.startswith(_FORMAL)


def north_first(crs: CRS) -> bool:
    """Whether the authority of a CRS puts north (latitude) before east."""
    return bool(systems.horizontal(crs).axis_info[0].direction == "north")


def domain_of(crs: CRS | None) -> Float | None:
    """The lowest and the highest x and y (2, 2), east first, that coordinates in a CRS can have.

    That is the globe for degrees; for a projection, its area of use with a wide margin. None where it is
    unknown or not bounded.
    """
    if crs is None:
        return np.array([[-LARGEST_M] * 2, [LARGEST_M] * 2])
    if crs.is_geocentric:
        return None
    flat = systems.horizontal(crs)
    if flat.is_geographic:
        degree = flat.axis_info[0].unit_conversion_factor  # rad per unit
        half = np.pi / degree if degree else 180.0
        return np.array([[-2 * half, -half / 2], [2 * half, half / 2]]) * (1 + 1e-9)
    area = crs.area_of_use
    if area is None or area.west > area.east:
        return None
    west, east = max(area.west - _MARGIN_DEG, -180.0), min(area.east + _MARGIN_DEG, 180.0)
    south, north = max(area.south - _MARGIN_DEG, -89.0), min(area.north + _MARGIN_DEG, 89.0)
    try:
        project = Transformer.from_crs("EPSG:4326", flat, always_xy=True)
        box = np.array(project.transform_bounds(west, south, east, north)).reshape(2, 2)
    except ProjError:
        return None
    return box if np.isfinite(box).all() and (box[0] < box[1]).all() else None
