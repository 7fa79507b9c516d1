"""The openings of one wall, without its protrusions: layout, borders, and what the rows and columns tell."""

from collections.abc import Iterable, Sequence

import numpy as np

from frontage.model.estimate import Provenance
from frontage.model.opening import Opening
from frontage.model.ortho import OrthoImage
from frontage.model.scan import Scan
from frontage.openings.balustrades import are_balustrades
from frontage.openings.borders.agreement import is_head_open, with_supported_borders
from frontage.openings.borders.measure import measure
from frontage.openings.borders.outline import Outline
from frontage.openings.borders.sills import with_sill
from frontage.openings.borders.spandrels import with_spandrel
from frontage.openings.closed.find import find_closed_openings
from frontage.openings.flights import points_before, top_of_flight
from frontage.openings.hidden import is_foot_hidden, is_foot_unknown, judge_foot, lowest_foot
from frontage.openings.kinds import in_reading_order, kind_of
from frontage.openings.layout.abutting import parted_at_steps
from frontage.openings.layout.columns import divided_by_columns
from frontage.openings.layout.densities import find_at_densities, spacing_at
from frontage.openings.layout.division import divided_alike
from frontage.openings.layout.forms import is_known
from frontage.openings.layout.inferred import infer
from frontage.openings.layout.overlaps import without_overlaps
from frontage.openings.layout.pattern import revise, settled
from frontage.openings.layout.pooling import pool
from frontage.openings.layout.posts import with_post_borders
from frontage.openings.layout.support import are_openings, have_jambs, odd_heads, without_unsupported
from frontage.openings.lintels import have_lintels
from frontage.openings.observe import ObservedWall
from frontage.openings.options import OpeningOptions
from frontage.openings.slopes import are_roofs
from frontage.openings.wall.crossings import CrossingBeams, crossing_beams
from frontage.openings.wall.foreground import foreground_points, is_foreground_at_foot


def find_on_wall(
    scan: Scan,
    wall: ObservedWall,
    options: OpeningOptions,
    ortho: OrthoImage | None = None,
) -> tuple[Opening, ...]:
    """Finds the openings of one wall from its evidence (paper B, section 3.2.2), in reading order.

    First the openings that the beams show; then those that rows and columns of them predict where nothing saw
    the wall; then those that are closed level with the wall and look different from it. Openings smaller than
    the options allow are left out. They have no id, floor or bay yet: `catalog` numbers whole buildings.
    """
    facade = wall.facade
    beams = crossing_beams(facade, scan, wall.beams)
    outlines, found = _measured(scan, beams, wall, options)
    found += [
        (i.outline, Provenance.INFERRED, i.evidence, i.confidence) for i in infer(outlines, wall.evidence)
    ]
    found += [
        (c.outline, Provenance.MEASURED, c.evidence, c.confidence)
        for c in find_closed_openings(facade, scan, wall.beams, wall.evidence, outlines, ortho=ortho)
        if not any(niche.fills(c.outline.place) for niche in wall.blind)
    ]
    openings = _openings(scan, wall, beams, found)
    least = (options.min_width, options.min_height)
    return in_reading_order([o for o in openings if np.all(np.ptp(o.ring, axis=0) >= least)])


Found = tuple[Outline, Provenance, float, float]
"""An outline, its provenance, its evidence in nats, and its confidence."""


def _measured(
    scan: Scan, beams: CrossingBeams, wall: ObservedWall, options: OpeningOptions
) -> tuple[list[Outline], list[Found]]:
    """Finds the openings that the beams show: the best layout of rectangles, then their measured borders."""
    facade, evidence = wall.facade, wall.evidence
    places = find_at_densities(wall.rasters, options, wall.ground, wall.posts)
    places = divided_by_columns(divided_alike(places))
    rough = [p.box for p in places]
    spacing = spacing_at(rough, evidence, facade.spacing)
    cell = [max(p.evidence.raster.cell, s) for p, s in zip(places, spacing, strict=True)]
    measured = measure(beams, rough, cell, spacing)
    open_ = {k for k, p in enumerate(places) if is_head_open(measured[k], p.box, p.evidence)}
    flat = sorted(open_.union(odd_heads(measured)))
    cells, spacings = ([sides[k] for k in flat] for sides in (cell, spacing))
    straight = measure(beams, [rough[k] for k in flat], cells, spacings, measured, flat=True)
    for k, outline in zip(flat, straight, strict=True):
        measured[k] = outline
    supported = (with_supported_borders(o, p.box, p.evidence) for o, p in zip(measured, places, strict=True))
    checked = [with_spandrel(with_sill(o, beams), beams) for o in supported]
    told = zip(checked, places, _are_real(checked, wall, scan), strict=True)
    real = [(outline, p.box, p.worth) for outline, p, is_one in told if is_one]
    pooled = pool([outline for outline, *_ in real])
    hidden = [is_foot_hidden(outline, evidence, wall.ground) for outline in pooled]
    revisions = revise(pooled, evidence, hidden)
    if revisions:
        predicted = [r.proposal.place for r in revisions]
        spacing = spacing_at(predicted, evidence, facade.spacing)
        told_again = measure(beams, predicted, spacing, spacing, others=measured)
        gone = {k for r in revisions for k in r.instead}
        real = [one for k, one in enumerate(real) if k not in gone]
        real += [
            (settled(r, o), r.proposal.place, r.evidence) for r, o in zip(revisions, told_again, strict=True)
        ]
        pooled = pool([outline for outline, *_ in real])
    separate = without_overlaps(pooled, [place for _, place, _ in real], evidence)
    kept = without_unsupported(separate, wall.ground)
    outlines, found = [], []
    for (_, _, worth), one in zip(real, kept, strict=True):
        for own in [] if one is None else parted_at_steps(one, beams):
            own = with_post_borders(own, wall.posts)
            provenance = Provenance.POOLED if own.pooled else Provenance.MEASURED
            outlines.append(own)
            found.append((own, provenance, worth, own.sure))
    return outlines, found


def _are_real(outlines: Sequence[Outline], wall: ObservedWall, scan: Scan) -> list[bool]:
    """Returns which outlines are openings: told, with jambs and lintels, and neither roof nor balustrade."""
    facade, places = wall.facade, [o.place for o in outlines]
    others = zip(
        are_roofs(places, wall.beams.points, facade.spacing), are_balustrades(places, wall, scan), strict=True
    )
    framed = zip(have_jambs(outlines, facade), have_lintels(outlines, facade, scan), strict=True)
    told = zip(are_openings(outlines), framed, others, strict=True)
    return [is_one and all(frame) and not any(other) for is_one, frame, other in told]


def _openings(
    scan: Scan, wall: ObservedWall, beams: CrossingBeams, found: Sequence[Found]
) -> Iterable[Opening]:
    """Makes openings of outlines, with kinds by their size, their place and what stands before them."""
    before = foreground_points(wall.beams)
    seen = [o for o, *_ in found if is_known(o)[2]]
    ground = _grounds(scan, wall, [o for o, *_ in found])
    hidden = [is_foot_unknown(o, seen, wall.evidence, g) for (o, *_), g in zip(found, ground, strict=True)]
    known = [outline for (outline, *_), unknown in zip(found, hidden, strict=True) if not unknown]
    for one, unknown, base in zip(found, hidden, ground, strict=True):
        outline, provenance, worth, confidence = one
        x0, z0, x1, z1 = outline.place
        on_steps = is_foreground_at_foot(before, wall.evidence, x0, x1, z0)
        kind = kind_of(x1 - x0, z1 - z0, z0 - base, outline.passes, on_steps)
        if unknown:
            lowest = lowest_foot(outline, [o for o, *_ in found if o is not outline], base)
            foot = judge_foot(outline, known, beams, wall.evidence, base, lowest)
            kind, outline = foot.kind, outline.with_foot(foot.at, foot.sigma)
        ring, covariance = outline.ring
        yield Opening(
            id="",
            kind=kind,
            ring=ring,
            ring_covariance=covariance,
            depth=outline.depth,
            shape=outline.shape,
            provenance=provenance,
            evidence=worth,
            confidence=confidence,
            floor=0,
            bay=0,
        )


def _grounds(scan: Scan, wall: ObservedWall, outlines: Sequence[Outline]) -> list[float]:
    """Returns for each outline the height z m of what a door in its place stands on.

    That is the last of the steps before it, where its foot is not seen, and otherwise the ground.
    """
    unseen = [bool(o.borders) and not o.borders[2].is_seen for o in outlines]
    if not any(unseen):
        return [wall.ground] * len(outlines)
    before = points_before(wall.facade, scan)
    tops = [
        top_of_flight(before, o.place, wall.ground) if u else None
        for o, u in zip(outlines, unseen, strict=True)
    ]
    return [wall.ground if top is None else top for top in tops]
