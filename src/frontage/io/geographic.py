"""Latitude, longitude and true heading of world positions: what GPS and compass measure."""

import numpy as np
from pyproj import Geod, Transformer

from frontage.geometry.arrays import Float
from frontage.io.crs import horizontal, parse_crs

_AHEAD_M = 10.0  # far enough that the bearing keeps its digits


def latitude_longitude(xy: Float, crs: str) -> Float:
    """Latitude and longitude (n, 2) in degrees (WGS 84) of world positions (n, 2) m.

    Raises CrsError for an unknown CRS.
    """
    to_globe = Transformer.from_crs(horizontal(parse_crs(crs)), "EPSG:4326", always_xy=True)
    longitude, latitude = to_globe.transform(xy[:, 0], xy[:, 1])
    return np.column_stack([latitude, longitude])


def true_heading(xy: Float, direction: Float, crs: str) -> float:
    """The true heading (degrees clockwise from north) of a `direction` (2,) at `xy` (2,) m world.

    Raises CrsError for an unknown CRS.
    """
    step = np.asarray(direction[:2], np.float64) / max(float(np.hypot(*direction[:2])), 1e-12)
    (lat0, lon0), (lat1, lon1) = latitude_longitude(np.stack([xy[:2], xy[:2] + _AHEAD_M * step]), crs)
    azimuth, _, _ = Geod(ellps="WGS84").inv(lon0, lat0, lon1, lat1)
    return float(azimuth) % 360.0
