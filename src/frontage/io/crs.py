"""Coordinate reference systems: parsing their names, and finding a metric one to compute in.

World coordinates are projected, metric, east-north-up (docs/conventions.md). PROJ's network is never used.
"""

import re
from functools import lru_cache
from typing import Any

import numpy as np
from pyproj import CRS
from pyproj.aoi import AreaOfInterest
from pyproj.database import query_utm_crs_info
from pyproj.exceptions import CRSError as ProjError

from frontage.errors import CrsError
from frontage.geometry.arrays import Float

LARGEST_M = 1e9
"""No coordinate in the world is as large, in whatever unit."""

# The German surveys name their systems like "urn:adv:crs:ETRS89_UTM32*DE_DHHN2016_NH" (AdV, GeoInfoDok).
_ADV = re.compile(r"urn:adv:crs:ETRS89_UTM(\d\d)(?:\*DE_(DHHN92|DHHN2016)_NH)?$")
_ADV_HEIGHTS = {"DHHN92": "5783", "DHHN2016": "7837"}

METRE_PER = {"m": 1.0, "cm": 0.01, "mm": 0.001, "ft": 0.3048, "us-ft": 1200.0 / 3937.0}
"""Metres per unit: metre, centimetre, millimetre, international foot, US survey foot."""


@lru_cache(maxsize=64)
def parse_crs(text: str, where: str = "") -> CRS:
    """Parse an authority code, compound code, URN, URL, WKT or PROJJSON.

    Raises CrsError when the CRS is unknown; `where` it was found stands in the message.
    """
    prefix = f"{where}: " if where else ""
    if match := _ADV.match(text.strip()):
        text = f"EPSG:258{match[1]}" + (f"+{_ADV_HEIGHTS[match[2]]}" if match[2] else "")
    try:
        return CRS.from_user_input(text.strip())
    except ProjError as problem:
        shown = text if len(text) < 80 else text[:80] + "..."
        raise CrsError(
            f"{prefix}unknown CRS {shown!r}; use a code such as 'EPSG:25832' or 'EPSG:25832+7837'",
            code="I201",
        ) from problem


def crs_text(crs: CRS) -> str:
    """The shortest exact name: "EPSG:25832", "EPSG:25832+7837", else WKT."""
    if crs.is_compound:
        parts = [part.to_authority(min_confidence=100) for part in crs.sub_crs_list]
        codes = [f"{part[1]}" for part in parts if part is not None]
        if parts[0] is not None and len(codes) == len(parts):
            return f"{parts[0][0]}:{'+'.join(codes)}"
    authority = crs.to_authority(min_confidence=100)
    return f"{authority[0]}:{authority[1]}" if authority else crs.to_wkt()


def horizontal(crs: CRS) -> CRS:
    """The horizontal part of a CRS, two-dimensional."""
    part = crs.sub_crs_list[0] if crs.is_compound else crs
    return part if part.is_geocentric else part.to_2d()


def vertical(crs: CRS) -> CRS | None:
    """The vertical part of a compound CRS, or None."""
    return crs.sub_crs_list[1] if crs.is_compound else None


def unit_of(crs: CRS) -> float:
    """Metres per unit of the first axis (1 for degrees, which are never scaled)."""
    return 1.0 if crs.is_geographic else float(crs.axis_info[0].unit_conversion_factor)


def is_world(crs: CRS) -> bool:
    """Whether computations can run in a CRS: projected, in metres, with east and north axes."""
    flat = horizontal(crs)
    upright = vertical(crs)
    return (
        bool(flat.is_projected)
        and abs(unit_of(flat) - 1.0) < 1e-12
        and {axis.direction for axis in flat.axis_info} == {"east", "north"}
        and (upright is None or abs(unit_of(upright) - 1.0) < 1e-12)
    )


def metric_twin(crs: CRS) -> CRS | None:
    """The same projection in metres, heights in metres; None when it is not projected east-north."""
    flat = horizontal(crs)
    if not flat.is_projected or {axis.direction for axis in flat.axis_info} != {"east", "north"}:
        return None
    flat = flat if abs(unit_of(flat) - 1.0) < 1e-12 else _in_metres(flat)
    upright = vertical(crs)
    if upright is None:
        return flat
    upright = upright if abs(unit_of(upright) - 1.0) < 1e-12 else _in_metres(upright)
    return _compound(flat, upright)


def _in_metres(crs: CRS) -> CRS:
    """The same CRS with axes in metres; the parameters of the projection keep their stated units."""
    j: dict[str, Any] = crs.to_json_dict()
    for axis in j["coordinate_system"]["axis"]:
        axis["unit"] = "metre"
    for key in ("id", "ids"):
        j.pop(key, None)
    j["name"] = f"{j['name']} in metres"
    return CRS.from_json_dict(j)


def _compound(flat: CRS, upright: CRS) -> CRS:
    """A compound CRS of its two parts."""
    from pyproj.crs import CompoundCRS

    return CompoundCRS(f"{flat.name} + {upright.name}", [flat, upright])


def utm_for(crs: CRS, longitude: float, latitude: float) -> CRS:
    """The UTM zone at a place, on the datum of the CRS where there is one, else on WGS 84.

    Raises CrsError beyond the zones, near the poles.
    """
    near = AreaOfInterest(longitude, latitude, longitude, latitude)
    geodetic = crs.geodetic_crs
    names = (
        [geodetic.name.replace(" (geocentric)", "").replace(" (geog3D)", "")] if geodetic is not None else []
    )
    for datum in [*names, "WGS 84"]:
        found = query_utm_crs_info(datum_name=datum, area_of_interest=near)
        zones = [z for z in found if re.fullmatch(re.escape(datum) + r" / UTM zone \d+[NS]", z.name)]
        if zones:
            return CRS.from_authority(zones[0].auth_name, zones[0].code)
    raise CrsError(
        f"no UTM zone at longitude {longitude:.2f}, latitude {latitude:.2f}; name a projected CRS",
        code="I203",
    )


def looks_geocentric(xyz: Float) -> bool:
    """Whether points (n, 3) can only be earth-centred, earth-fixed coordinates in metres.

    True when every ellipsoidal height lies within -1..10 km. The answer is False within 10 km of the
    equatorial plane, where projected coordinates with large northings have the same magnitude.
    """
    p = np.asarray(xyz, np.float64)
    with np.errstate(over="ignore", invalid="ignore"):
        radius = np.linalg.norm(p, axis=1)
        sin2 = (p[:, 2] / np.maximum(radius, 1.0)) ** 2
        ground = 6378137.0 * (1.0 - sin2 / 298.257)  # radius of the ellipsoid, to some metres
        height = radius - ground
    return bool(len(p) and ((height > -1000) & (height < 10000) & (np.abs(p[:, 2]) > 1e4)).all())
