"""Measures the openings of a facade: borders, shape, depth, and what they have in common."""

from collections.abc import Sequence
from functools import partial

import numpy as np

from frontage.geometry.arrays import Float
from frontage.model.masonry import MASONRY
from frontage.openings.borders.circles import Circle, find_circle
from frontage.openings.borders.depth import AROUND, density_beside, find_depth, find_wall
from frontage.openings.borders.edges import FEW, EdgeTraits, SolidSide, footprint
from frontage.openings.borders.fan import fan_of
from frontage.openings.borders.locate import CLOSE, WIDTHS, Border, find_borders
from frontage.openings.borders.outline import Outline
from frontage.openings.borders.shapes import Head, bare_ring, find_head, strays
from frontage.openings.boxes import Box
from frontage.openings.wall.crossings import CrossingBeams
from frontage.openings.wall.evidence import PER_CELL

_CIRCLE = 10.0  # nats that a circle must gain over a square
_FEWER = 3  # beams that a circle must put on their side more than an arch does: about as many nats
_SAME = 0.003  # m: the faces of one facade agree no better
_WIDENING = np.linspace(1e-4, 5e-4, 41)  # rad, one sigma, of beams: from diffraction to 2 mrad (1/e2)
_ROOM = 1.0  # m behind the wall from which points lie in the room
_ENOUGH = 3  # openings that tell what their facade has in common


def measure(
    beams: CrossingBeams,
    boxes: Sequence[Box],
    cell: float | Sequence[float],
    spacing: float | Sequence[float],
    others: Sequence[Outline] = (),
    flat: bool = False,
) -> list[Outline]:
    """Measures the openings whose `boxes` are known to about two cells.

    `cell` and `spacing` are the sides of cells and the distances between beams, m, for all boxes or for each.
    Every opening is measured twice: first by itself, then with the blur of edges and the depth of sills and
    surrounds that the whole facade shows, where an opening's own points do not tell them. `others` were
    measured before and show it as well. With `flat`, all heads are taken as straight.
    """
    cells, spacings = (np.broadcast_to(m, len(boxes)).tolist() for m in (cell, spacing))
    alone = EdgeTraits(all_blurs=beams.rays)  # only lines of sight tell the blur
    first = [
        _outline(beams, box, alone, cell=c, spacing=s, flat=flat)
        for box, c, s in zip(boxes, cells, spacings, strict=True)
    ]
    traits = facade_edge_traits([*others, *first])
    walls = np.array([o.wall for o in (*others, *first) if o.wall is not None])
    return [
        _outline(beams, o.place, traits, cell=s, spacing=s, known=o, walls=walls)
        for o, s in zip(first, spacings, strict=True)
    ]


def facade_edge_traits(outlines: list[Outline]) -> EdgeTraits:
    """Returns what the edges of a facade share: the likeliest blur, the median faces, the footprint."""
    if not outlines:
        return EdgeTraits()
    scores = np.sum([b.scores for o in outlines for b in o.borders if len(b.scores)], axis=0)
    faces: list[SolidSide | None] = []
    for side in range(4):
        y = np.array(
            [o.borders[side].edge.face.y for o in outlines if o.borders[side].edge.face.points >= FEW]
        )
        if len(y) < _ENOUGH:
            faces.append(None)
            continue
        middle = float(np.median(y))
        spread = 1.4826 * float(np.median(np.abs(y - middle)))
        faces.append(SolidSide(middle, max(spread, _SAME), len(y)))
    # without rays, the shadows of edges are as wide as any blur
    if not any(o.has_rays for o in outlines):
        return EdgeTraits(faces=tuple(faces))
    return EdgeTraits(WIDTHS[int(np.argmax(scores))], tuple(faces), _widening(outlines))


def _widening(outlines: list[Outline]) -> float:
    """Returns the angle rad, one sigma, by which beams widen, as the mixed echoes tell it."""
    mixed = np.array([b.edge.mixed for o in outlines for b in o.borders])
    due = [float(mixed[:, 1] @ footprint(mixed[:, 2], float(w))) for w in _WIDENING]
    return float(np.interp(mixed[:, 0].sum(), due, _WIDENING)) if due[-1] > 0.0 else float(_WIDENING[0])


def _outline(
    beams: CrossingBeams,
    box: Box,
    traits: EdgeTraits,
    *,
    cell: float,
    spacing: float,
    known: Outline | None = None,
    walls: Float | None = None,
    flat: bool = False,
) -> Outline:
    """Measures one opening; `known` is its first outline, `walls` (n,) m the depths of all walls.

    With `flat`, its head is taken as straight; otherwise its beams tell the shape.
    """
    around = beams.around(box, AROUND)
    near = around.around(box, CLOSE)
    wall = find_wall(around, box)  # borders end at the masonry around the opening, even where that is relief
    if wall is not None:
        near = near.behind(wall[0])
    rise = known.rise if known else 0.0
    depth = known.depth if known else find_depth(around, box, 0.0, cell / 2, wall=wall)
    frame = None if depth is None else depth.value
    loose = known is not None and _loose(known, beams.wall)
    search = partial(find_borders, near, frame=frame, spacing=spacing, traits=traits, loose=loose)
    wide = max(cell, PER_CELL * spacing) if known is None else cell
    tries = [search(box, cell=c, rise=rise) for c in dict.fromkeys((cell, wide))]
    place, borders = max(tries, key=lambda t: sum(b.gain for b in t[1]))
    shape, spread = "rectangle", None
    if not flat:
        shape, place, rise, spread = _shape(near, place, borders, frame=frame, blur=traits.blur, known=known)
    if rise > 0.0 and known is None:
        place, borders = search(place, cell=spacing, rise=rise)
    slack = 2.0 * max(borders[0].sigma, borders[1].sigma)
    into = _depths_into(near, place)
    return Outline(
        shape,
        place,
        rise,
        _covariance(shape, borders, spread),
        tuple(borders),
        find_depth(around, place, rise, slack, walls),
        _deeper(into, _ROOM),
        None if wall is None else wall[0],
        sunken=_deeper(into, MASONRY.half_brick),
        behind=len(into) / max(_beams_due(near, place), 1.0),
    )


def _covariance(shape: str, borders: list[Border], spread: Float | None) -> Float:
    """Returns the covariance (5, 5) m2 of left, right, bottom, top and rise.

    `spread` (2, 2) m2 is that of top and rise, None where the head is straight.
    """
    covariance = np.diag([*(b.sigma**2 for b in borders), 0.0])
    if shape == "circle" and spread is not None:
        covariance[:4, :4] = np.eye(4) * spread[0, 0]
    elif spread is not None:
        covariance[3:, 3:] = spread
        if borders[3].gain <= 0.0:  # nothing shows where the head ends
            covariance[3, 3] += borders[3].sigma ** 2
    return covariance


def _loose(outline: Outline, wall: float) -> bool:
    """Returns whether what stands before the wall beside an opening does not go around it (shutters)."""
    left, right, _, top = (b.edge.face.y for b in outline.borders)
    return min(left, right) < -wall and abs(min(left, right) - top) > wall


def _shape(
    near: CrossingBeams,
    place: Box,
    borders: list[Border],
    *,
    frame: float | None,
    blur: float,
    known: Outline | None,
) -> tuple[str, Box, float, Float | None]:
    """Returns shape, box, rise m, and covariance (2, 2) m2 of top and rise (None: straight head)."""
    if known is not None and known.shape == "rectangle":
        return "rectangle", place, 0.0, None
    x0, z0, x1, z1 = place
    told = ("rectangle", 0.0) if known is None else (known.shape, known.rise)
    fan = fan_of(
        near, place, face=borders[3].edge.face.y, frame=frame, density=density_beside(near, place), head=told
    )
    found = find_circle(fan, place, blur)
    if known is not None and known.shape == "circle":
        return ("circle", place, 0.0, None) if found is None else _circle(found)
    head = find_head(fan, place, blur, None if known is None else Head(known.shape, z1, known.rise, 0.0))
    if known is None and found is not None and found.gain > _CIRCLE:
        arch = bare_ring(head.shape, (x0, z0, x1, head.top if head.rise else z1), head.rise)
        if strays(fan, bare_ring("circle", found.box, 0.0)) + _FEWER < strays(fan, arch):
            return _circle(found)
    if head.shape == "rectangle" or head.top - head.rise <= z0:
        return "rectangle", place, 0.0, None
    return head.shape, (x0, z0, x1, head.top), head.rise, _spread(head)


def _circle(found: Circle) -> tuple[str, Box, float, Float | None]:
    """Returns the shape of a circle.

    A centre is known half as well as a radius: all beams determine the radius, half of them x, half z.
    """
    return "circle", found.box, 0.0, np.diag([3.0 * found.sigma**2 + 1e-6, 0.0])


def _spread(head: Head) -> Float:
    """Returns the covariance (2, 2) m2 of the top and the rise of a head."""
    top, both, rise = head.covariance
    return np.array([[top + 1e-6, both], [both, rise + 1e-6]])


def _depths_into(near: CrossingBeams, place: Box) -> Float:
    """Returns the depths (n,) m at which the beams into an opening end behind the wall."""
    x0, z0, x1, z1 = place
    x, z = near.place
    return np.asarray(near.depth[(x > x0) & (x < x1) & (z > z0) & (z < z1) & (near.depth > near.wall)])


def _deeper(into: Float, depth: float) -> float:
    """Returns the share of the beams into an opening, whose depths (n,) m are given, that end deeper."""
    return float((into > depth).mean()) if len(into) else 0.0


def _beams_due(near: CrossingBeams, place: Box) -> float:
    """Returns how many beams a wall in the place of an opening would return."""
    x0, z0, x1, z1 = place
    return density_beside(near, place) * (x1 - x0) * (z1 - z0)
