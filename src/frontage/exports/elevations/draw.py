"""Draws the elevation of a facade: outline, openings, bars, protrusions, levels, dimensions."""

from collections.abc import Iterator

import numpy as np

from frontage.exports.elevations.measures import dimensions, levels
from frontage.exports.survey import SurveyedBuilding
from frontage.geometry.arrays import Float
from frontage.geometry.ring import box_sigmas
from frontage.io.drawings.elevation import Elevation, Label, Line, Underlay, sheet_for
from frontage.model import Elements, Facade, Opening, Protrusion, Provenance

UNCERTAIN_M = 0.025
"""A border known worse than this is dashed: half a millimetre on paper at 1:50, twice the width of a line."""


def draw_elevation(
    building: SurveyedBuilding,
    facade: Facade,
    elements: Elements | None,
    underlay: Underlay | None,
    datum: str,
) -> Elevation:
    """Return the drawing of a facade in its own plane, with true heights above the datum.

    underlay  its ortho-image, with the corner in the facade frame
    datum     what heights refer to, such as "above DHHN2016 height"

    Lengths are true in the plane. A facade that leans by a degree is drawn up to 1.5 mm too high at 10 m.
    """
    zero = facade.height_of_zero
    found = elements or Elements(facade.id, ())
    bounds = bounds_of(facade, found)
    sheet = sheet_for(bounds[2] - bounds[0], bounds[3] - bounds[1])
    marks = levels(building, facade, found)
    up = np.array([0.0, zero])
    return Elevation(
        facade=facade.id,
        zero=zero,
        sheet=sheet,
        bounds=bounds,
        lines=tuple(_lines(facade, found, up)),
        dimensions=dimensions(facade, found, zero, bounds, sheet),
        levels=marks,
        labels=tuple(_label(o, up, sheet.metres(1.6)) for o in found.openings),
        title=title_block(building, facade, elements, datum, pictured=underlay is not None),
        underlay=None if underlay is None else _raised(underlay, zero),
    )


def bounds_of(facade: Facade, found: Elements) -> tuple[float, float, float, float]:
    """Return x0, h0, x1, h1 m of everything that is on a facade; h is the height above the datum."""
    zero = facade.height_of_zero
    rings = [facade.outline, *(o.ring for o in found.openings), *(p.ring for p in found.protrusions)]
    corners = np.vstack(rings)
    (x0, z0), (x1, z1) = corners.min(0), corners.max(0)
    return float(x0), float(z0 + zero), float(x1), float(z1 + zero)


def _lines(facade: Facade, found: Elements, up: Float) -> Iterator[Line]:
    """Yield all lines, those in front last."""
    yield Line("OUTLINE", facade.outline + up, tag=facade.id)
    for p in found.protrusions:
        facts = (("front", float(p.front.value)),)
        name = "WALL_LINES" if p.kind.is_body else "PROTRUSIONS"
        yield Line(name, p.ring + up, _vague_protrusion(p), p.id, facts)
    for o in found.openings:
        depth = () if o.depth is None else (("depth", float(o.depth.value)),)
        yield Line(f"OPENING_{o.kind.name}", o.ring + up, _vague_opening(o), o.id, depth)
        for bar in o.bars:
            vague = bar.provenance is Provenance.INFERRED or not bar.sigma <= UNCERTAIN_M
            yield Line("BARS", bar.ring + up, vague, o.id)


def _vague_opening(o: Opening) -> bool:
    """Whether an opening was never seen, or one of its borders is known badly or to no known degree."""
    sigmas = box_sigmas(o.ring, o.ring_covariance)
    return o.provenance is Provenance.INFERRED or not all(s <= UNCERTAIN_M for s in sigmas)


def _vague_protrusion(p: Protrusion) -> bool:
    return p.provenance is Provenance.INFERRED or not p.sigma <= UNCERTAIN_M


def _label(o: Opening, up: Float, above: float) -> Label:
    """Return the short name of an opening, just above its upper border."""
    (x0, _), (x1, z1) = o.ring.min(0), o.ring.max(0)
    return Label(o.id.rsplit("/", 1)[-1], (float(x0 + x1) / 2, float(z1 + up[1]) + above))


def title_block(
    building: SurveyedBuilding, facade: Facade, elements: Elements | None, datum: str, *, pictured: bool
) -> tuple[str, ...]:
    """Return the lines of the title block, with what the drawing leaves out.

    pictured  whether there is an ortho-image; `datum` as in `draw_elevation`
    """
    about = [
        f"Elevation of facade {facade.id}" + (f", {building.address}" if building.address else ""),
        f"Lengths in metres; heights {datum}. CRS {_crs(facade)}.",
        f"Plane known to {1000 * facade.sigma_plane:.1f} mm; points on {100 * facade.coverage:.0f} % of it.",
        f"Dashed: inferred, or borders known no better than {100 * UNCERTAIN_M:g} cm (one sigma).",
    ]
    if elements is None:
        about.append("Left out: openings, which were not found or not looked for.")
    if not pictured:
        about.append("Left out: the ortho-image, which there is none of.")
    return tuple(about)


def _crs(facade: Facade) -> str:
    crs = facade.world.crs
    return "unknown" if crs is None else (crs if len(crs) < 40 else crs.split('"')[1])


def _raised(underlay: Underlay, zero: float) -> Underlay:
    (x, z) = underlay.corner
    return Underlay(underlay.path, underlay.jpeg, (x, z + zero), underlay.size, underlay.pixels)
