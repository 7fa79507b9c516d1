"""The default way to openings: evidence of beams, exact layout, borders by likelihood."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from frontage.geometry.arrays import Float
from frontage.model.estimate import Failed, Provenance
from frontage.model.facade import Facade
from frontage.model.opening import Elements, Opening, OpeningKind
from frontage.model.ortho import OrthoImage
from frontage.model.scan import Scan
from frontage.openings.borders.agreement import agreeing
from frontage.openings.borders.borders import Place
from frontage.openings.borders.measure import measure
from frontage.openings.borders.outline import Outline
from frontage.openings.closed.find import find_flush
from frontage.openings.kinds import kind_of, numbered
from frontage.openings.layout.bands import find_posts
from frontage.openings.layout.candidates import find_boxes
from frontage.openings.layout.disjoint import disjoint
from frontage.openings.layout.framing import Framing
from frontage.openings.layout.inferred import infer
from frontage.openings.layout.pooling import pool
from frontage.openings.layout.posts import Post, with_doubt, with_posts
from frontage.openings.layout.selection import Box
from frontage.openings.options import OpeningOptions
from frontage.openings.wall.beams import Beams, sort_beams
from frontage.openings.wall.evidence import Evidence, weigh
from frontage.openings.wall.noreturn import with_lost
from frontage.openings.wall.panels import without_panels
from frontage.openings.wall.sight import sight_lines
from frontage.openings.wall.standing import standing, stands

_FEWEST = 200  # points: below, density and noise cannot be told


@dataclass(frozen=True, eq=False)
class Seen:
    """What the layout is found from: beams, evidence, posts between windows, and the ground, z m."""

    beams: Beams
    evidence: Evidence
    posts: tuple[Post, ...]
    ground: float


def see(facade: Facade, scan: Scan, options: OpeningOptions) -> Seen | Failed:
    """All that the beams of a facade's working cloud say, panels as wall, posts as parts of the wall."""
    if len(facade.support) < _FEWEST:
        return Failed(
            "F401",
            f"facade {facade.id} has {len(facade.support)} points, too few to tell openings from gaps",
            "openings need about ten points across: scan closer or more densely",
        )
    beams = sort_beams(facade, scan)
    if len(beams.solid) < _FEWEST // 2:
        return Failed(
            "F402",
            f"facade {facade.id} shows hardly any wall, so openings cannot be told from it",
            "check the facade's plane, or scan it from the street",
        )
    ground = facade.extent[1] if options.ground_z is None else options.ground_z
    evidence = _evidence(facade, scan, beams, ground)
    posts = find_posts(beams, evidence, ground)
    if posts:
        beams = with_posts(beams, facade, scan, posts)
        evidence = _evidence(facade, scan, beams, ground)
    return Seen(beams, evidence, posts, ground)


def find_by_evidence(
    facade: Facade, scan: Scan, options: OpeningOptions, ortho: OrthoImage | None = None
) -> Elements | Failed:
    """Openings of a facade by the evidence of its beams (docs/openings.md); of photos, too, closed ones."""
    seen = see(facade, scan, options)
    if isinstance(seen, Failed):
        return seen
    beams, evidence, posts, ground = seen.beams, seen.evidence, seen.posts, seen.ground
    boxes = find_boxes(evidence, options, Framing(evidence, ground))
    rough = [_place(evidence, box) for box in boxes]
    sight = sight_lines(facade, scan, beams)
    measured = measure(sight, rough, max(evidence.raster.cell, facade.spacing), facade.spacing)
    pooled = pool([agreeing(o, r, evidence) for o, r in zip(measured, rough, strict=True)])
    kept = disjoint(pooled, rough, evidence)
    outlines = [with_doubt(o, posts) for o in kept if o is not None]
    worths = [box.worth for o, box in zip(kept, boxes, strict=True) if o is not None]
    kind = partial(_kind, standing(beams), evidence, ground)
    found = [
        _opening(o, kind, Provenance.POOLED if o.pooled else Provenance.MEASURED, worth, o.sure)
        for o, worth in zip(outlines, worths, strict=True)
    ]
    found += [
        _opening(i.outline, kind, Provenance.INFERRED, i.evidence, i.confidence)
        for i in infer(outlines, evidence)
    ]
    found += [
        _opening(f.outline, kind, Provenance.MEASURED, f.evidence, f.confidence)
        for f in find_flush(facade, scan, beams, evidence, outlines, ortho)
    ]
    sized = [o for o in found if np.all(np.ptp(o.ring, axis=0) >= (options.min_width, options.min_height))]
    return Elements(facade.id, numbered(facade.id, sized), notes=_notes(evidence, beams))


def _evidence(facade: Facade, scan: Scan, beams: Beams, ground: float) -> Evidence:
    """All that speaks for and against openings."""
    return without_panels(with_lost(weigh(facade, beams), facade, scan, beams), beams, ground)


def _place(evidence: Evidence, box: Box) -> Place:
    """The box in m."""
    g, (x, z) = evidence.raster.cell, evidence.raster.corner
    return x + box.c0 * g, z + box.r0 * g, x + box.c1 * g, z + box.r1 * g


def _opening(
    outline: Outline,
    kind: Callable[[Outline], OpeningKind],
    provenance: Provenance,
    worth: float,
    confidence: float,
) -> Opening:
    """The opening of an outline, without a number; `worth` in nats."""
    ring, covariance = outline.ring
    return Opening(
        "", kind(outline), ring, covariance, outline.depth, outline.shape, provenance, worth, confidence, 0, 0
    )


def _kind(before: Float, evidence: Evidence, ground: float, outline: Outline) -> OpeningKind:
    x0, z0, x1, z1 = outline.place
    return kind_of(x1 - x0, z1 - z0, z0 - ground, outline.passes, stands(before, evidence, x0, x1, z0))


def _notes(evidence: Evidence, beams: Beams) -> tuple[str, ...]:
    """What could not be judged."""
    inside = evidence.inside
    unknown = float((inside & (evidence.expected < 0.5) & ~evidence.seen).sum() / max(inside.sum(), 1))
    notes = [] if beams.rays else ["sensor positions are unknown: openings are gaps and recesses of the wall"]
    if unknown > 0.05:
        notes.append(f"{unknown:.0%} of the facade was not seen; openings there are not looked for")
    return tuple(notes)
