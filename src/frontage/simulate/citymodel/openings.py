"""Finds the windows and doors of a city model in its walls."""

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
_REACH_M = (-0.5, 1.2)  # y range in front of and behind a wall in which its windows are looked for
_LEAST_M = 0.15  # least width and height of an opening
_HOLE_SHARE = 0.5  # least share of a hole that its windows fill, and of a window that lies in its hole
_WALL_SHARE = 0.7  # least share of a window that lies within the wall's outline
_FLUSH_M = 0.02  # depth behind a wall up to which a window in a hole counts as flush
_BURIED_M = 0.08  # depth behind a wall without a hole up to which a window was meant to be flush
_DETAILED = 4  # polygons; a window with more of them has a frame of its own
_FRAME_M = 0.02  # least width of a frame
_SMOOTH_M = 0.0005  # tolerance of simplified outlines
_OVERLAP = 0.2  # share of the smaller of two windows from which on they are merged


@dataclass(frozen=True, eq=False)
class ModelOpening:
    """An opening of a city model.

    wall    number of its wall
    kind    "Window" or "Door"
    ring    outline (k, 2) m (x, z) of the hole, in the frame of the wall
    depth   m, from the wall to the front of the frame; None where it is not modelled
    glass   m, from the wall to the pane; None where it is not modelled
    bars    number of upright bars and of transoms; None where the model does not say
    """

    wall: int
    kind: str
    ring: Float
    depth: float | None
    glass: float | None
    bars: tuple[int, int] | None


@dataclass(eq=False)
class _Candidate:
    """The faces of a window in its wall, their outline (x, z), and whether the wall has a hole for it."""

    wall: int
    kind: str
    faces: list[int]
    outline: shapely.Polygon
    own_hole: bool = False


def find_openings(
    faces: Sequence[Surface], shells: Sequence[Shell], walls: Sequence[ModelWall]
) -> tuple[list[ModelOpening], set[int], int]:
    """Find the openings of a building.

    An opening is the hole in the wall or, where the wall has none, the outline of the window's faces. Returns
    the openings, the numbers of the faces that belong to them, and how many windows and doors have no wall.
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
    """Return the numbers of the faces that are reveals: they run from the border of an opening inwards."""
    gone: set[int] = set()
    middle = np.array([f.ring.mean(0) for f in faces]).reshape(-1, 3)
    for opening in openings:
        wall = walls[opening.wall]
        deep = (opening.glass or opening.depth or 0.0) + 0.1
        at = wall.to_wall(middle)
        low, high = opening.ring.min(0) - 0.02, opening.ring.max(0) + 0.02
        inside = (at[:, [0, 2]] >= low) & (at[:, [0, 2]] <= high)
        near = np.flatnonzero(inside.all(1) & (at[:, 1] > 0.0) & (at[:, 1] < deep))
        border = shapely.LinearRing(opening.ring)
        for k in near.tolist():
            ring = wall.to_wall(faces[k].ring)
            on = shapely.distance(border, shapely.points(ring[:, [0, 2]])) < 0.01
            if faces[k].semantics not in KINDS and on.all() and ring[:, 1].max() < deep:
                gone.add(k)
    return gone


def _groups(faces: Sequence[Surface], shells: Sequence[Shell]) -> list[tuple[str, list[int]]]:
    """Groups the faces of each window and door: those that name the same object, or share its id."""
    told = {name: about for shell in shells for name, about in shell.about.items()}
    found: dict[tuple[str, str], list[int]] = {}
    for k, face in enumerate(faces):
        if face.semantics in KINDS:
            owner = told.get(face.source_id, {}).get("surface") or face.source_id.split("#")[0]
            found.setdefault((face.semantics, str(owner)), []).append(k)
    return [(kind, group) for (kind, _), group in found.items()]


def _boxes(walls: Sequence[ModelWall]) -> Float:
    """Returns the lowest and highest corner (w, 2, 3) m local of every wall, as far as its windows reach."""
    out = []
    for wall in walls:
        xz = shapely.get_coordinates(shapely.union_all(list(wall.pieces.values())))
        xyz = wall.local_from_wall.apply(np.insert(xz, 1, 0.0, axis=1))
        out.append([xyz.min(0) - _REACH_M[1], xyz.max(0) + _REACH_M[1]])
    return np.array(out).reshape(-1, 2, 3)


def _hosted(
    faces: Sequence[Surface], kind: str, group: list[int], walls: Sequence[ModelWall], boxes: Float
) -> _Candidate | None:
    """Finds the wall in which a window has the largest outline, preferring near walls; None without one."""
    points = np.concatenate([faces[k].ring for k in group])
    near = (points.min(0) >= boxes[:, 0]).all(1) & (points.max(0) <= boxes[:, 1]).all(1)
    best, found = 0.0, None
    for number in np.flatnonzero(near).tolist():
        at = walls[number].to_wall(points)
        if at[:, 1].min() < _REACH_M[0] or at[:, 1].max() > _REACH_M[1]:
            continue
        outline = shapely.convex_hull(shapely.multipoints(at[:, [0, 2]]))
        if len(group) == 1 and isinstance(outline, shapely.Polygon):
            single = shapely.Polygon(at[:, [0, 2]])
            outline = single if single.is_valid else outline
        if not isinstance(outline, shapely.Polygon) or outline.area < _LEAST_M**2:
            continue
        # the hull, because a door that reaches the wall's foot is a notch in it and not a hole
        whole = shapely.convex_hull(shapely.union_all(list(walls[number].pieces.values())))
        share = outline.intersection(whole).area / outline.area
        score = outline.area * share / (1 + 3 * abs(float(np.median(at[:, 1]))))
        if share >= _WALL_SHARE and score > best:
            best, found = score, _Candidate(number, kind, group, outline)
    return found


def _in_holes(own: list[_Candidate], area: shapely.Geometry) -> list[_Candidate]:
    """Gives windows that fill a hole of their wall the outline of that hole, merging those that share one."""
    holes = [shapely.Polygon(ring) for part in polygons(area) for ring in part.interiors]
    out: list[_Candidate] = []
    within: dict[int, list[_Candidate]] = {}
    for c in own:
        share = [c.outline.intersection(h).area / c.outline.area for h in holes]
        if share and max(share) > _HOLE_SHARE:
            within.setdefault(int(np.argmax(share)), []).append(c)
        else:
            c.own_hole = c.outline.intersection(area).area < (1 - _WALL_SHARE) * c.outline.area
            out.append(c)
    for k, those in within.items():
        filled = shapely.union_all([c.outline for c in those]).intersection(holes[k]).area
        if filled < _HOLE_SHARE * holes[k].area:
            out += those
            continue
        kind = max(those, key=lambda c: c.outline.area).kind
        out.append(_Candidate(those[0].wall, kind, [f for c in those for f in c.faces], holes[k], True))
    return out


def _merged(own: list[_Candidate]) -> list[_Candidate]:
    """Merges windows of one wall that overlap, and cuts back those that only touch others."""
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
    """Returns the outline without details, from its lower left corner on; None if no frame fits into it."""
    x0, z0, x1, z1 = outline.bounds
    if min(x1 - x0, z1 - z0) < _LEAST_M:
        return None
    plain = shapely.Polygon(outline.exterior).simplify(_SMOOTH_M)
    for polygon in (plain, outline.convex_hull, shapely.box(x0, z0, x1, z1)):
        if isinstance(polygon, shapely.Polygon) and polygon.is_valid:
            ring = polygon_ring(polygon)
            if frame_fits(ring, _FRAME_M):
                return np.roll(ring, -int(np.argmin(ring.sum(1))), axis=0)
    return None


def frame_fits(ring: Float, width: float) -> bool:
    """Check whether a frame of some width (m) fits into a ring (k, 2)."""
    inner = inset(ring, width)
    return bool(shapely.Polygon(inner).is_valid and ring_area(inner) > 0)


def _depths(
    faces: Sequence[Surface], c: _Candidate, wall: ModelWall
) -> tuple[float, float] | tuple[float, None] | tuple[None, None]:
    """Returns how far (m) the frame and the pane lie behind the wall; None where the window is flush."""
    inward = wall.local_from_wall.R[:, 1]
    rows = []
    for k in c.faces:
        vector = area_vector(faces[k].ring)
        size = float(np.linalg.norm(vector))
        if abs(vector @ inward) > 0.9 * size and size > 0.1 * c.outline.area:
            y = float(wall.to_wall(faces[k].ring)[:, 1].mean())
            rows.append((y, size, bool(faces[k].holes)))
    if not rows:
        return None, None
    front = min(y for y, _, _ in rows)
    detailed = len(c.faces) > _DETAILED
    if not detailed and front <= (_FLUSH_M if c.own_hole else _BURIED_M):
        return None, None
    front = max(front, 0.01)
    panes = [(size, y) for y, size, holed in rows if not holed and y > front]
    if not detailed or not panes:
        return front, None
    glass = max(panes)[1]
    return glass - min(glass - front, 0.05), glass


def _bars(about: object) -> tuple[int, int] | None:
    """Returns the numbers of bars where a surface has them as attributes, as in LoD3 models of our own."""
    if not isinstance(about, dict):
        return None
    counts = [about.get(f"n_{axis}") for axis in ("vertical", "horizontal")]
    vertical, horizontal = (int(c) if isinstance(c, int | float) and 0 <= c < 9 else None for c in counts)
    return None if vertical is None or horizontal is None else (vertical, horizontal)
