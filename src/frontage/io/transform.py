"""The choice of a transformation between two coordinate reference systems, and its accuracy."""

import warnings

import numpy as np
from pyproj import CRS, Transformer
from pyproj.aoi import AreaOfInterest
from pyproj.transformer import TransformerGroup

from frontage.errors import CrsError
from frontage.geometry.arrays import Float
from frontage.io import crs as systems


def best_transformer(name: str, source: CRS, target: CRS, points: Float, notes: list[str]) -> Transformer:
    """The best installed transformation at points (n, 3) in `source`.

    `notes` gets its accuracy when that is 0.1 m or worse, or when a better one needs grids that are missing.

    Raises CrsError when there is none, or only one of unknown accuracy (PROJ's "ballpark" transformations).
    """
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # a missing grid is reported below
        group = TransformerGroup(source, target, always_xy=True, area_of_interest=_area(source, points))  # type: ignore[arg-type]
    usable = [t for t in group.transformers if np.isfinite(t.transform(*points[0])).all()]
    if not usable:
        raise CrsError(
            f"{name}: coordinates such as {show(points[0])} cannot be transformed from {source.name} "
            f"to {target.name}; check the crs stated for this file",
            code="I204",
        )
    best = usable[0]
    missing = sorted(
        {g.short_name for op in group.unavailable_operations for g in op.grids if not g.available}
    )
    grids = f" (missing grids: {', '.join(missing[:3])})" if missing else ""
    if best.accuracy is None or best.accuracy < 0:
        raise CrsError(
            f"{name}: no transformation of known accuracy from {source.name} to {target.name} is "
            f"installed{grids}; install the grids for PROJ, or choose another target CRS",
            code="I205",
        )
    if not group.best_available or best.accuracy >= 0.1:
        notes.append(f"{name}: {source.name} to {target.name} is good to {best.accuracy:g} m{grids}")
    return best


def _area(source: CRS, points: Float) -> AreaOfInterest | None:
    """The area of points (n, 3) in degrees; None when it is unknown."""
    flat = source if source.is_geocentric else systems.horizontal(source)
    degrees = "EPSG:4979" if source.is_geocentric else "EPSG:4326"
    lon, lat = Transformer.from_crs(flat, degrees, always_xy=True).transform(*points[:1000].T)[:2]
    if not (np.isfinite(lon).all() and np.isfinite(lat).all()):
        return None
    return AreaOfInterest(float(lon.min()), float(lat.min()), float(lon.max()), float(lat.max()))


def within(crs: CRS, points: Float) -> bool:
    """Whether points (n, 3) in a CRS lie within its area of use, or at most 3 degrees outside it."""
    area = crs.area_of_use
    place = _area(crs, points)
    if place is None:
        return False
    if area is None:
        return True
    return (
        area.west - 3 <= place.west_lon_degree
        and place.east_lon_degree <= area.east + 3
        and area.south - 3 <= place.south_lat_degree
        and place.north_lat_degree <= area.north + 3
    )


def show(point: Float) -> str:
    """A point (3,) as text for a message."""
    return "(" + ", ".join(f"{v:.6g}" for v in point) + ")"
