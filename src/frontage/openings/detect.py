"""The default way to openings: evidence of beams, exact layout, borders by likelihood."""

import numpy as np

from frontage.model.estimate import Failed, Provenance
from frontage.model.facade import Facade
from frontage.model.opening import Elements, Opening
from frontage.model.scan import Scan
from frontage.openings.beams import Beams, sort_beams
from frontage.openings.borders import Place
from frontage.openings.candidates import Box, find_boxes
from frontage.openings.evidence import Evidence, weigh
from frontage.openings.inferred import infer
from frontage.openings.kinds import kind_of, numbered
from frontage.openings.measure import measure
from frontage.openings.options import OpeningOptions
from frontage.openings.outline import Outline
from frontage.openings.pooling import pool
from frontage.openings.sight import sight_lines

_FEWEST = 200  # points: below, density and noise cannot be told
_RIM = 0.1  # m beside an opening where the wall must show
_WALL = 0.4  # share of the expected beams that a rim must have on the wall
_GROUND = 0.35  # m above the ground where no wall can show below an opening
_RETURN = 0.3  # share of the expected beams that a small opening must send back from its depth
_LONE = 0.6  # m, least side of an opening that sends back less
_VISIBLE = 0.5  # share of the beams due that must have got as far as the wall there


def find_by_evidence(facade: Facade, scan: Scan, options: OpeningOptions) -> Elements | Failed:
    """Openings of a facade by the evidence of its beams (docs/openings.md)."""
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
    evidence = weigh(facade, beams)
    ground = facade.extent[1] if options.ground_z is None else options.ground_z
    boxes = find_boxes(evidence, options, lambda box, all_: _framed(evidence, box, ground, all_))
    rough = [_place(evidence, box) for box in boxes]
    sight = sight_lines(facade, scan, beams)
    outlines = pool(measure(sight, rough, evidence.raster.cell, facade.spacing))
    found = [
        _opening(o, ground, Provenance.POOLED if o.pooled else Provenance.MEASURED, box.worth, o.sure)
        for o, box in zip(outlines, boxes, strict=True)
    ]
    found += [
        _opening(i.outline, ground, Provenance.INFERRED, i.evidence, i.confidence)
        for i in infer(outlines, evidence)
    ]
    sized = [o for o in found if np.all(np.ptp(o.ring, axis=0) >= (options.min_width, options.min_height))]
    return Elements(facade.id, numbered(facade.id, sized), notes=_notes(evidence, beams))


def _framed(evidence: Evidence, box: Box, ground: float, all_sides: bool) -> bool:
    """Whether the wall shows on both sides and above or below: what is open on one side is no opening.
    With `all_sides` above and below.

    Near the ground the lower side counts as shown; the opening itself must be free of wall.
    """
    rim = max(int(np.ceil(_RIM / evidence.raster.cell)), 2)
    gap = 1  # cell on the border itself, of both
    r0, c0, r1, c1 = box.r0, box.c0, box.r1, box.c1
    sides = (
        (r0, r1, c0 - gap - rim, c0 - gap),
        (r0, r1, c1 + gap, c1 + gap + rim),
        (r0 - gap - rim, r0 - gap, c0, c1),
        (r1 + gap, r1 + gap + rim, c0, c1),
    )
    left, right, below, above = (_walled(evidence, *s) for s in sides)
    low = evidence.raster.corner[1] + r0 * evidence.raster.cell < ground + _GROUND
    inside = _walled(evidence, r0 + 1, r1 - 1, c0 + 1, c1 - 1)
    below = 1.0 if low else below
    ends = min(below, above) if all_sides else max(below, above)
    shown = min(left, right, ends) >= _WALL
    return shown and not inside > _WALL and _told(evidence, box)


def _told(evidence: Evidence, box: Box) -> bool:
    """Whether beams tell enough of a box: half of its cells say something, and it has a depth or is large and
    half visible.

    A shadow leaves cells as empty as glass does; most shadows are small or of something before the wall.
    """
    known = (evidence.llr[box.cells] != 0.0).mean() > 0.5
    visible = evidence.expected[box.cells].sum() > _VISIBLE * evidence.due[box.cells].sum()
    g = evidence.raster.cell
    sides = ((box.r1 - box.r0) * g, (box.c1 - box.c0) * g)
    returned = evidence.open[box.cells].sum() > _RETURN * evidence.expected[box.cells].sum()
    return bool(known and (returned or (visible and min(sides) > _LONE)))


def _walled(evidence: Evidence, r0: int, r1: int, c0: int, c1: int) -> float:
    """Share of the expected beams that found wall in rows [r0, r1) and columns [c0, c1)."""
    part = (slice(max(r0, 0), max(r1, 0)), slice(max(c0, 0), max(c1, 0)))
    expected = float(evidence.expected[part].sum())
    if expected < 3.0:
        return 0.0
    return float(np.minimum(evidence.solid[part], 2.0 * evidence.expected[part]).sum()) / expected


def _place(evidence: Evidence, box: Box) -> Place:
    """The box in m."""
    g, (x, z) = evidence.raster.cell, evidence.raster.corner
    return x + box.c0 * g, z + box.r0 * g, x + box.c1 * g, z + box.r1 * g


def _opening(
    outline: Outline, ground: float, provenance: Provenance, worth: float, confidence: float
) -> Opening:
    """The opening of an outline, without a number; `worth` in nats."""
    x0, z0, x1, z1 = outline.place
    ring, covariance = outline.ring
    kind = kind_of(x1 - x0, z1 - z0, z0 - ground, outline.passes)
    return Opening(
        "", kind, ring, covariance, outline.depth, outline.shape, provenance, worth, confidence, 0, 0
    )


def _notes(evidence: Evidence, beams: Beams) -> tuple[str, ...]:
    """What could not be judged."""
    inside = evidence.inside
    unknown = float((inside & (evidence.expected < 0.5) & ~evidence.seen).sum() / max(inside.sum(), 1))
    notes = [] if beams.rays else ["sensor positions are unknown: openings are gaps and recesses of the wall"]
    if unknown > 0.05:
        notes.append(f"{unknown:.0%} of the facade was not seen; openings there are not looked for")
    return tuple(notes)
