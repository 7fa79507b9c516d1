"""The tables of a run: buildings, facades, openings, protrusions, photos and stations, each with its place.

A wall is vertical, so a map shows it as a line: facades, openings and protrusions have a layer of lines at
their lower border, a layer of outlines (polygons with heights), and a layer of elevations with the same rows.
The elevations, those of window bars as well, are in the plane of the facade: x to the right, as in the facade
frame, and height above the datum, as in `products/rasters`.
"""

from collections.abc import Iterable
from math import atan2, degrees, isfinite

import numpy as np
import shapely

from frontage.exports.survey import Survey, SurveyedBuilding, heights, in_world, window_to_wall
from frontage.exports.tables.columns import BARS, BUILDINGS, FACADES, OPENINGS, PHOTOS, PROTRUSIONS, STATIONS
from frontage.geometry.arrays import Float
from frontage.geometry.ring import box_sigmas, ring_area, ring_area_sigma, span_sigma
from frontage.io.tables.table import Column, Table, Value
from frontage.model import Elements, Facade, Opening, Photo, Protrusion
from frontage.model.opening import DOORS

Row = tuple[Value, ...]
Wall = tuple[Facade, Float, float, Row]
"""Something on a wall: facade, outline (k, 2) m, depth y m of its plane, row."""


def survey_tables(survey: Survey) -> tuple[Table, ...]:
    """Return all layers of a run. Lengths are in m, heights above the datum of the CRS."""
    return (
        _buildings(survey),
        *_walls("facade", FACADES, _facades(survey)),
        *_walls("opening", OPENINGS, _openings(survey)),
        *_walls("protrusion", PROTRUSIONS, _protrusions(survey)),
        _bars(survey),
        _photos(survey),
        _stations(survey),
    )


def _buildings(survey: Survey) -> Table:
    rows, plans = [], []
    for b in survey.buildings:
        tops = [heights(facade, facade.outline).max() for facade, _ in b.fronts]
        judged = any(elements is not None for _, elements in b.fronts)
        count = sum(1 for _ in b.openings) if judged else None
        rows.append((b.id, b.address, b.ground, float(max(tops)) if tops else None, len(b.fronts), count,
                     *window_to_wall(b.fronts), b.source or None, "; ".join(b.missing) or None))  # fmt: skip
        plans.append(None if b.plan is None else shapely.Polygon(b.plan))
    about = " ".join(("Buildings: footprints, or hulls of their points.", *survey.left_out))
    return Table("buildings", about, BUILDINGS, tuple(rows), "POLYGON", tuple(plans), height=False)


def _walls(name: str, columns: tuple[Column, ...], found: list[Wall]) -> tuple[Table, Table, Table]:
    """Return the lines in plan, the outlines and the elevations of what is on walls."""
    rows = tuple(row for *_, row in found)
    lines = tuple(shapely.LineString(_foot(facade, ring, y)) for facade, ring, y, _ in found)
    outlines = tuple(shapely.Polygon(in_world(facade, ring, y)) for facade, ring, y, _ in found)
    plan, upright = f"{name.capitalize()}s: lines in plan", f"{name.capitalize()}s: outlines on the wall"
    return (
        Table(f"{name}s", plan, columns, rows, "LINESTRING", lines),
        Table(f"{name}_outlines", upright, columns, rows, "POLYGON", outlines),
        _elevations(name, columns, rows, [(facade, ring) for facade, ring, *_ in found]),
    )


def _elevations(
    name: str, columns: tuple[Column, ...], rows: tuple[Row, ...], found: Iterable[tuple[Facade, Float]]
) -> Table:
    """Return outlines (k, 2) m in the planes of their facades, with heights above the datum."""
    about = f"{name.capitalize()}s: outlines in the plane of the facade (x to the right, height above datum)"
    places = tuple(shapely.Polygon(ring + np.array([0.0, facade.height_of_zero])) for facade, ring in found)
    return Table(f"{name}_elevations", about, columns, rows, "POLYGON", places, height=False, in_world=False)


def _foot(facade: Facade, ring: Float, y: float) -> Float:
    """Return the lower border of a ring's box in the world (2, 3), from the left as seen from the street."""
    (x0, z0), (x1, _) = ring.min(0), ring.max(0)
    return in_world(facade, np.array([[x0, z0], [x1, z0]]), y)


def _facades(survey: Survey) -> list[Wall]:
    return [
        (facade, facade.outline, 0.0, _facade_row(b, facade, elements))
        for b in survey.buildings
        for facade, elements in b.fronts
    ]


def _facade_row(b: SurveyedBuilding, facade: Facade, elements: Elements | None) -> Row:
    (x0, z0, x1, z1), z = facade.extent, heights(facade, facade.outline)
    outward = -facade.frame.R[:, 1]
    openings = None if elements is None else elements.openings
    return (
        facade.id, b.id, b.address, x1 - x0, z1 - z0, abs(ring_area(facade.outline)),
        float(z.min()), float(z.max()), _bearing(outward), known(facade.sigma_plane), facade.roughness,
        facade.spacing, facade.coverage,
        None if openings is None else len(openings),
        None if openings is None else sum(o.kind in DOORS for o in openings),
        *window_to_wall(((facade, elements),)),
        str(facade.local_from_facade.provenance),
    )  # fmt: skip


def _openings(survey: Survey) -> list[Wall]:
    return [
        (facade, o.ring, elements.wall_y(o), opening_row(b, facade, elements, o))
        for b in survey.buildings
        for facade, elements, o in b.openings
    ]


def opening_row(b: SurveyedBuilding, facade: Facade, elements: Elements, o: Opening) -> Row:
    """Return what is known of an opening, in the order of the columns `OPENINGS`."""
    z, (width, height) = heights(facade, o.ring, elements.wall_y(o)), np.ptp(o.ring, axis=0)
    spans = (span_sigma(o.ring, o.ring_covariance, axis) for axis in (0, 1))
    sigmas = (*box_sigmas(o.ring, o.ring_covariance), *spans)
    depth = o.depth
    return (
        o.id, b.id, b.address, facade.id, str(o.kind), o.shape, o.floor, o.number, o.bay, o.on or None,
        float(width), float(height), abs(ring_area(o.ring)), float(z.min()), float(z.max()),
        None if depth is None else float(depth.value),
        *(known(sigma) for sigma in sigmas),
        None if depth is None else known(float(depth.sigma[0])),
        known(ring_area_sigma(o.ring, o.ring_covariance)),
        *_glazing(o),
        str(o.provenance), o.confidence, "; ".join(o.photos) or None,
    )  # fmt: skip


def _glazing(o: Opening) -> Row:
    """Return the numbers of mullions and transoms, the frame's width, and the layout's confidence."""
    g = o.glazing
    if g is None:
        return (None,) * 4
    width = None if g.frame_width is None else float(g.frame_width.value)
    return (*g.counts, width, g.confidence) if g.resolved else (None, None, width, None)


def _protrusions(survey: Survey) -> list[Wall]:
    return [
        (facade, p.ring, float(p.front.value), protrusion_row(b, facade, p))
        for b in survey.buildings
        for facade, elements in b.fronts
        for p in (() if elements is None else elements.protrusions)
    ]


def protrusion_row(b: SurveyedBuilding, facade: Facade, p: Protrusion) -> Row:
    """Return what is known of a protrusion, in the order of the columns `PROTRUSIONS`."""
    front = float(p.front.value)
    z, (width, height) = heights(facade, p.ring, front), np.ptp(p.ring, axis=0)
    return (
        p.id, b.id, b.address, facade.id, str(p.kind), float(width), float(height), float(z.min()),
        float(z.max()), front, known(p.sigma), known(float(p.front.sigma[0])), str(p.provenance),
        p.confidence,
    )  # fmt: skip


def _bars(survey: Survey) -> Table:
    found = [(b, f, o, bar) for b in survey.buildings for f, _, o in b.openings for bar in o.bars]
    rows = tuple(
        (o.id, b.id, b.address, f.id, bar.axis,
         bar.position + (f.height_of_zero if bar.axis == "horizontal" else 0.0), bar.width, known(bar.sigma),
         known(bar.sigma_width), str(bar.provenance))
        for b, f, o, bar in found
    )  # fmt: skip
    return _elevations("bar", BARS, rows, [(f, bar.ring) for _, f, _, bar in found])


def _photos(survey: Survey) -> Table:
    rows, places = [], []
    for photo in survey.photos:
        assert photo.local_from_camera is not None  # `Survey.photos` are oriented
        view = photo.pose.rotate(np.array([[0.0, 0.0, 1.0]]))[0]
        rows.append((
            photo.id, photo.camera.model, photo.camera.width, photo.camera.height, _bearing(view),
            degrees(atan2(view[2], np.hypot(view[0], view[1]))), *_position_sigmas(photo),
            str(photo.local_from_camera.provenance),
        ))  # fmt: skip
        places.append(shapely.Point(survey.world.to_world(photo.pose.t)))
    about = "Photos: where they were taken"
    return Table("photos", about, PHOTOS, tuple(rows), "POINT", tuple(places))


def _position_sigmas(photo: Photo) -> Row:
    """Return the standard errors of the position along the world's axes; zeros mean not known."""
    assert photo.local_from_camera is not None
    sigmas = photo.local_from_camera.sigma[:3]
    return tuple(known(float(v)) for v in sigmas) if sigmas.any() else (None,) * 3


def _stations(survey: Survey) -> Table:
    rows = tuple((number,) for number in range(1, len(survey.stations) + 1))
    places = tuple(shapely.Point(at) for at in survey.stations)
    return Table("stations", "Positions of the scanner", STATIONS, rows, "POINT", places)


def _bearing(direction: Float) -> float:
    """Return the bearing of a direction (3,), clockwise from grid north, 0 <= degrees < 360."""
    return degrees(atan2(direction[0], direction[1])) % 360.0


def known(value: float) -> float | None:
    """Return a number; None for one that is infinite or no number, which stands for "not known"."""
    return value if isfinite(value) else None
