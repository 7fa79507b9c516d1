"""The default way to openings: evidence of beams, exact layout, borders by likelihood."""

import numpy as np

from frontage.geometry.arrays import Float
from frontage.model.estimate import Estimate, Failed, Provenance
from frontage.model.facade import Facade
from frontage.model.opening import Elements, Opening
from frontage.model.scan import Scan
from frontage.openings.beams import Beams, sort_beams
from frontage.openings.borders import Border, Strips
from frontage.openings.candidates import Box, find_boxes
from frontage.openings.evidence import Evidence, weigh
from frontage.openings.kinds import kind_of, numbered
from frontage.openings.options import OpeningOptions
from frontage.openings.shapes import find_circle, find_head, ring_of

Place = tuple[float, float, float, float]

_FEWEST = 200  # points: below, density and noise cannot be told
_RIM = 0.1  # m beside an opening where the wall must show
_WALL = 0.4  # share of the expected beams that a rim must have on the wall
_GROUND = 0.35  # m above the ground where no wall can show below an opening
_RETURN = 0.3  # share of the expected beams that a small opening must send back from its depth
_LONE = 0.6  # m, least side of an opening that sends back less
_VISIBLE = 0.5  # share of the beams due that must have got as far as the wall there
_CIRCLE = 10.0  # nats that a circle must gain over a square
_BAND = 0.12  # m around a cell's border where the border is searched: half a pier
_HUG = 0.04  # m off the borders, where reveals are not taken for the frame


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
    strips = (Strips(beams, 0), Strips(beams, 1))
    found = [_measured(facade, beams, evidence, strips, box, ground) for box in boxes]
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


def _measured(
    facade: Facade, beams: Beams, evidence: Evidence, strips: tuple[Strips, Strips], box: Box, ground: float
) -> Opening:
    """The opening of a box: borders, shape, depth and kind."""
    g, (cx, cz) = evidence.raster.cell, evidence.raster.corner
    rough = (cx + box.c0 * g, cz + box.r0 * g, cx + box.c1 * g, cz + box.r1 * g)
    place, borders = _borders(strips, rough, g, 0.0)
    shape, place, rise = _shape(evidence, strips[0], box, place)
    if shape not in ("rectangle", "circle"):
        x0, _, x1, top = place
        (x0, z0, x1, _), borders = _borders(strips, place, g, rise)
        place = (x0, z0, x1, top)
    x0, z0, x1, z1 = place
    depth, passes = _depth(beams, x0, z0, x1, z1 - rise)
    ring, weights = ring_of(shape, place, rise)
    variance = np.array([b.sigma for b in borders]) ** 2
    return Opening(
        "",
        kind_of(x1 - x0, z1 - z0, z0 - ground, passes),
        ring,
        (weights * variance) @ weights.T,
        depth,
        shape,
        Provenance.MEASURED,
        box.worth,
        float(np.mean([b.gain > np.log(100.0) for b in borders])),
        0,
        0,
    )


def _shape(evidence: Evidence, strips: Strips, box: Box, place: Place) -> tuple[str, Place, float]:
    """Shape, box and rise of the head, m, of an opening that was measured as a rectangle."""
    x0, z0, x1, z1 = place
    reach = max(0.6 * (x1 - x0), 0.3)
    around = ((x0 - 0.3 * (x1 - x0), x1 + 0.3 * (x1 - x0)), (z0 - reach, z1 + reach))
    solid, opened = (strips.around(kind, *around) for kind in (0, 1))
    density = float(evidence.expected[box.cells].mean()) / evidence.raster.cell**2
    radius, gain = find_circle(solid, opened, place, density)
    if gain > _CIRCLE:
        x, z = (x0 + x1) / 2, (z0 + z1) / 2
        return "circle", (x - radius, z - radius, x + radius, z + radius), 0.0
    head = find_head(solid, opened, place, density, min(reach, 0.3 * (x1 - x0)))
    if head.shape == "rectangle":
        return head.shape, place, 0.0
    return head.shape, (x0, z0, x1, head.top), head.rise


def _borders(
    strips: tuple[Strips, Strips], rough: Place, cell: float, rise: float
) -> tuple[Place, list[Border]]:
    """Box and borders left, right, bottom, top; two rounds, for each needs the others. The sides end where a
    head of that rise begins.
    """
    x0, z0, x1, z1 = rough
    borders: list[Border] = []
    for band in (max(_BAND, 2.0 * cell), max(_BAND / 2, 1.5 * cell)):
        wide, high = (x1 - x0) / 2, (z1 - z0) / 2
        side = (z0, max(z1 - rise, z0 + 0.2 * (z1 - z0)))
        borders = [
            strips[0].locate(x0, 1, min(band, wide), wide, side),
            strips[0].locate(x1, -1, min(band, wide), wide, side),
            strips[1].locate(z0, 1, min(band, high), high, (x0, x1)),
            strips[1].locate(z1, -1, min(band, high), high, (x0, x1)),
        ]
        x0, x1, z0 = (b.at for b in borders[:3])
        z1 = borders[3].at if rise == 0.0 else z1
    return (x0, z0, x1, z1), borders


def _depth(beams: Beams, x0: float, z0: float, x1: float, z1: float) -> tuple[Estimate[float] | None, float]:
    """Depth of the frame behind the wall, and the share of the beams that reach the room (0 without any).

    The frame is the foremost of the surfaces that hold a fifth of what the densest one holds: panes,
    curtains and rooms lie behind it. Bins of 1 cm; the mean of the points within 2 cm of the peak.
    """
    p = beams.open
    cut_x, cut_z = min(_HUG, 0.2 * (x1 - x0)), min(_HUG, 0.2 * (z1 - z0))
    inside = (p[:, 0] > x0 + cut_x) & (p[:, 0] < x1 - cut_x) & (p[:, 1] > z0 + cut_z) & (p[:, 1] < z1 - cut_z)
    d = beams.open_depth[inside]
    if len(d) == 0:
        return None, 0.0
    passes = float((d > 1.0).mean())
    near = d[d < 1.0]
    if len(near) < 15:
        return None, passes
    number, edge = np.histogram(near, np.arange(beams.least, 1.02, 0.01))
    smooth: Float = np.convolve(number, [0.25, 0.5, 0.25], "same")
    first = int(np.argmax(smooth >= 0.2 * smooth.max()))
    while first + 1 < len(smooth) and smooth[first + 1] > smooth[first]:
        first += 1
    peak = float(edge[first] + 0.005)
    some = near[np.abs(near - peak) < 0.02]
    if len(some) < 8:
        return None, passes
    sigma2 = float(some.var()) / len(some) + 0.25 * beams.sigma**2
    return Estimate(float(some.mean()), np.array([[sigma2]]), float(len(some) - 1)), passes


def _notes(evidence: Evidence, beams: Beams) -> tuple[str, ...]:
    """What could not be judged."""
    inside = evidence.inside
    unknown = float((inside & (evidence.expected < 0.5) & ~evidence.seen).sum() / max(inside.sum(), 1))
    notes = [] if beams.rays else ["sensor positions are unknown: openings are gaps and recesses of the wall"]
    if unknown > 0.05:
        notes.append(f"{unknown:.0%} of the facade was not seen; openings there are not looked for")
    return tuple(notes)
