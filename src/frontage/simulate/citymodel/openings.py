"""The windows and doors of a city model, found in its walls."""

from collections.abc import Sequence, Set
from dataclasses import dataclass

import numpy as np
import shapely

from frontage.geometry.arrays import Float
from frontage.geometry.ring import convex_ring, polygon_ring, ring_area
from frontage.model import Shell, Surface
from frontage.simulate.citymodel.walls import ModelWall, area_vector, polygons
from frontage.simulate.meshing import inset

KINDS = ("Window", "Door")
_REACH = (-0.5, 1.2)  # m before and behind a wall, where its windows are looked for
_LEAST = 0.15  # m: smaller openings are no windows
_OWN = 0.5  # share of a hole that its windows fill, and of a window in its hole
_INSIDE = 0.7  # share of a window within the wall's outline
_FLUSH = 0.02  # m behind the wall, up to which a window in a hole lies in it
_BURIED = 0.08  # m behind a wall without a hole, up to which a window was meant to lie in it
_DETAILED = 4  # polygons: a window of more has a frame of its own
_FRAME = 0.02  # m: the least width of a frame
_SMOOTH = 0.0005  # m that a ring may lose in details
_OVERLAP = 0.2  # share of the smaller of two windows, from which on they are one


@dataclass(frozen=True, eq=False)
class ModelOpening:
    """An opening: its wall's number, "Window" or "Door", the hole's ring (k, 2) m (x, z), frame of the wall.

    depth, glass  m behind the wall to the front of the frame and to the pane; None where not modelled
    bars          number of upright and of level ones; None where the model does not say
    """

    wall: int
    kind: str
    ring: Float
    depth: float | None
    glass: float | None
    bars: tuple[int, int] | None


@dataclass(eq=False)
class _Candidate:
    """A window's faces in its wall: outline (x, z) and whether that is one flat polygon's."""

    wall: int
    kind: str
    faces: list[int]
    outline: shapely.Polygon
    own_hole: bool = False


def find_openings(
    faces: Sequence[Surface], shells: Sequence[Shell], walls: Sequence[ModelWall]
) -> tuple[list[ModelOpening], set[int], int]:
    """Openings, the numbers of the faces that belong to them, and how many windows and doors have no wall.

    The hole in the wall is the opening where the wall has one, else the outline of its faces.
    """
    boxes = _boxes(walls)
    candidates: list[_Candidate] = []
    lost = 0
    for kind, group in _groups(faces, shells):
        found = _hosted(faces, kind, group, walls, boxes)
        candidates += [found] if found else []
        lost += found is None
    merged: list[_Candidate] = []
    for number in sorted({c.wall for c in candidates}):
        own = [c for c in candidates if c.wall == number]
        merged += _merged(_in_holes(own, walls[number].area()))
    told = {name: about for shell in shells for name, about in shell.about.items()}
    openings: list[ModelOpening] = []
    taken: set[int] = set()
    for c in merged:
        ring = _ring(c.outline)
        if ring is None:
            lost += 1
            continue
        taken |= set(c.faces)
        bars = next((b for k in c.faces if (b := _bars(told.get(faces[k].source_id, {})))), None)
        depth, glass = _depths(faces, c, walls[c.wall])
        openings.append(ModelOpening(c.wall, c.kind, ring, depth, glass, bars))
    return openings, taken, lost


def reveals_of(
    faces: Sequence[Surface], walls: Sequence[ModelWall], openings: Sequence[ModelOpening]
) -> Set[int]:
    """Numbers of the wall faces that are sides of openings: they run from the hole's border into the wall."""
    gone: set[int] = set()
    middle = np.array([f.ring.mean(0) for f in faces]).reshape(-1, 3)
    for opening in openings:
        wall = walls[opening.wall]
        deep = (opening.glass or opening.depth or 0.0) + 0.1
        at = wall.seen(middle)
        low, high = opening.ring.min(0) - 0.02, opening.ring.max(0) + 0.02
        inside = (at[:, [0, 2]] >= low) & (at[:, [0, 2]] <= high)
        near = np.flatnonzero(inside.all(1) & (at[:, 1] > 0.0) & (at[:, 1] < deep))
        border = shapely.LinearRing(opening.ring)
        for k in near.tolist():
            ring = wall.seen(faces[k].ring)
            on = shapely.distance(border, shapely.points(ring[:, [0, 2]])) < 0.01
            if faces[k].semantics not in KINDS and on.all() and ring[:, 1].max() < deep:
                gone.add(k)
    return gone


def _groups(faces: Sequence[Surface], shells: Sequence[Shell]) -> list[tuple[str, list[int]]]:
    """Faces of each window and door: those that name one object, or share its id."""
    told = {name: about for shell in shells for name, about in shell.about.items()}
    found: dict[tuple[str, str], list[int]] = {}
    for k, face in enumerate(faces):
        if face.semantics in KINDS:
            owner = told.get(face.source_id, {}).get("surface") or face.source_id.split("#")[0]
            found.setdefault((face.semantics, str(owner)), []).append(k)
    return [(kind, group) for (kind, _), group in found.items()]


def _boxes(walls: Sequence[ModelWall]) -> Float:
    """Lowest and highest corner (w, 2, 3) m of every wall, local, as far as its windows reach."""
    out = []
    for wall in walls:
        xz = shapely.get_coordinates(shapely.union_all(list(wall.pieces.values())))
        xyz = wall.local_from_wall.apply(np.insert(xz, 1, 0.0, axis=1))
        out.append([xyz.min(0) - _REACH[1], xyz.max(0) + _REACH[1]])
    return np.array(out).reshape(-1, 2, 3)


def _hosted(
    faces: Sequence[Surface], kind: str, group: list[int], walls: Sequence[ModelWall], boxes: Float
) -> _Candidate | None:
    """The wall in which a window shows the largest outline; near walls come before far ones."""
    points = np.concatenate([faces[k].ring for k in group])
    near = (points.min(0) >= boxes[:, 0]).all(1) & (points.max(0) <= boxes[:, 1]).all(1)
    best, found = 0.0, None
    for number in np.flatnonzero(near).tolist():
        at = walls[number].seen(points)
        if at[:, 1].min() < _REACH[0] or at[:, 1].max() > _REACH[1]:
            continue
        outline = shapely.convex_hull(shapely.multipoints(at[:, [0, 2]]))
        if len(group) == 1 and isinstance(outline, shapely.Polygon):
            single = shapely.Polygon(at[:, [0, 2]])
            outline = single if single.is_valid else outline
        if not isinstance(outline, shapely.Polygon) or outline.area < _LEAST**2:
            continue
        # the hull: a door that reaches the wall's foot is a notch in it, not a hole
        whole = shapely.convex_hull(shapely.union_all(list(walls[number].pieces.values())))
        share = outline.intersection(whole).area / outline.area
        score = outline.area * share / (1 + 3 * abs(float(np.median(at[:, 1]))))
        if share >= _INSIDE and score > best:
            best, found = score, _Candidate(number, kind, group, outline)
    return found


def _in_holes(own: list[_Candidate], area: shapely.Geometry) -> list[_Candidate]:
    """Windows of one wall; those that fill a hole of it take its outline, together where they share it."""
    holes = [shapely.Polygon(ring) for part in polygons(area) for ring in part.interiors]
    out: list[_Candidate] = []
    within: dict[int, list[_Candidate]] = {}
    for c in own:
        share = [c.outline.intersection(h).area / c.outline.area for h in holes]
        if share and max(share) > _OWN:
            within.setdefault(int(np.argmax(share)), []).append(c)
        else:
            c.own_hole = c.outline.intersection(area).area < (1 - _INSIDE) * c.outline.area
            out.append(c)
    for k, those in within.items():
        filled = shapely.union_all([c.outline for c in those]).intersection(holes[k]).area
        if filled < _OWN * holes[k].area:
            out += those
            continue
        kind = max(those, key=lambda c: c.outline.area).kind
        out.append(_Candidate(those[0].wall, kind, [f for c in those for f in c.faces], holes[k], True))
    return out


def _merged(own: list[_Candidate]) -> list[_Candidate]:
    """Windows of one wall, those that overlap as one; what touches others is cut back to stand free."""
    out: list[_Candidate] = []
    for c in sorted(own, key=lambda c: (not c.own_hole, -c.outline.area)):
        for other in out:
            shared = c.outline.intersection(other.outline).area
            if shared > _OVERLAP * min(c.outline.area, other.outline.area):
                other.faces += c.faces
                if not other.own_hole:
                    both = shapely.get_coordinates([other.outline, c.outline])
                    other.outline = shapely.Polygon(convex_ring(both))
                break
        else:
            rest = polygons(c.outline.difference(shapely.union_all([o.outline for o in out])))
            if rest:
                c.outline = max(rest, key=lambda p: float(p.area))
                out.append(c)
    return sorted(out, key=lambda c: (round(c.outline.bounds[1], 1), c.outline.bounds[0]))


def _ring(outline: shapely.Polygon) -> Float | None:
    """The outline's ring without details, from its lower left corner on; None where no frame fits in it."""
    x0, z0, x1, z1 = outline.bounds
    if min(x1 - x0, z1 - z0) < _LEAST:
        return None
    plain = shapely.Polygon(outline.exterior).simplify(_SMOOTH)
    for polygon in (plain, outline.convex_hull, shapely.box(x0, z0, x1, z1)):
        if isinstance(polygon, shapely.Polygon) and polygon.is_valid:
            ring = polygon_ring(polygon)
            if has_inset(ring, _FRAME):
                return np.roll(ring, -int(np.argmin(ring.sum(1))), axis=0)
    return None


def has_inset(ring: Float, width: float) -> bool:
    """Whether a frame of some width (m) fits into a ring (k, 2)."""
    inner = inset(ring, width)
    return bool(shapely.Polygon(inner).is_valid and ring_area(inner) > 0)


def _depths(
    faces: Sequence[Surface], c: _Candidate, wall: ModelWall
) -> tuple[float, float] | tuple[float, None] | tuple[None, None]:
    """How far the frame and the pane lie behind the wall; None where the window lies in it."""
    inward = wall.local_from_wall.R[:, 1]
    rows = []
    for k in c.faces:
        vector = area_vector(faces[k].ring)
        size = float(np.linalg.norm(vector))
        if abs(vector @ inward) > 0.9 * size and size > 0.1 * c.outline.area:
            y = float(wall.seen(faces[k].ring)[:, 1].mean())
            rows.append((y, size, bool(faces[k].holes)))
    if not rows:
        return None, None
    front = min(y for y, _, _ in rows)
    detailed = len(c.faces) > _DETAILED
    if not detailed and front <= (_FLUSH if c.own_hole else _BURIED):
        return None, None
    front = max(front, 0.01)
    panes = [(size, y) for y, size, holed in rows if not holed and y > front]
    if not detailed or not panes:
        return front, None
    glass = max(panes)[1]
    return glass - min(glass - front, 0.05), glass


def _bars(about: object) -> tuple[int, int] | None:
    """Numbers of bars as a run's and a simulated scene's LoD3 have them."""
    if not isinstance(about, dict):
        return None
    counts = [about.get(f"n_{axis}") for axis in ("vertical", "horizontal")]
    vertical, horizontal = (int(c) if isinstance(c, int | float) and 0 <= c < 9 else None for c in counts)
    return None if vertical is None or horizontal is None else (vertical, horizontal)
