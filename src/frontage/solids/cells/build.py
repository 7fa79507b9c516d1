"""A host solid and what is on its facades become one finer, closed solid (paper B, section 3.2.3)."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import shapely
from shapely.geometry import LineString, Polygon
from shapely.ops import substring

from frontage.geometry.arrays import Float
from frontage.geometry.rigid import Rigid3
from frontage.model import Failed, Solid
from frontage.solids.cells.carve import carve
from frontage.solids.cells.clearance import Clearance
from frontage.solids.cells.contract import SHORTEST, Node
from frontage.solids.cells.partition import Partition, partition
from frontage.solids.cells.placing import Area, Draft, Placed, place, raised, removed
from frontage.solids.hosts.reseat import reseat
from frontage.solids.hosts.walls import Wall, find_again, find_walls
from frontage.solids.log import Log
from frontage.solids.relief import GRID, BuildOptions, Built, FacadeReliefs, Relief
from frontage.solids.rims import rings_of, unmatched

_ROUNDS = 8
_TRIM = 4.0  # 0.1 mm


def build_solid(
    host: Solid, facades: Sequence[FacadeReliefs], options: BuildOptions | None = None
) -> Built | Failed:
    """Cut openings into a closed host solid and put protrusions before it.

    The host's grid starts at the origin of the local frame that the facades are in. Facades are taken in
    their order, reliefs in theirs; what cannot be placed is in `Built.failed`, what was changed in `notes`.
    """
    options = options or BuildOptions()
    if unmatched(host.faces):
        edges = len(unmatched(host.faces))
        return Failed("S301", f"{host.building}: the host is not closed ({edges} free edges)", "repair it")
    log = Log()
    if options.reseat:
        host = reseat(host, facades, options, log)
    solid, offsets = host, dict[str, float]()
    for facade in facades:
        solid = _with_facade(solid, facade, options, log, offsets)
    built = {f.opening for f in solid.faces}
    kept = {i: d for i, d in offsets.items() if i in built}
    return Built(solid, host, kept, tuple(log.failed), tuple(log.notes))


def _with_facade(
    solid: Solid, facade: FacadeReliefs, options: BuildOptions, log: Log, offsets: dict[str, float]
) -> Solid:
    """The solid with one facade's reliefs."""
    if not facade.reliefs:
        return solid
    walls = find_walls(solid, facade, options)
    if not walls:
        hint = "check the registration, or raise max_offset"
        log.failed.append(
            Failed(
                "S310", f"{facade.id}: no wall of the host lies where it was measured; {_count(facade)}", hint
            )
        )
        return solid
    motions = [w.local_from_wall.inverse @ facade.local_from_facade for w in walls]
    regions = [_region(w) for w in walls]
    groups: dict[int, list[Draft]] = {}
    for relief in facade.reliefs:
        drafts = [_draft(relief, m) for m in motions]
        if not all(d.polygon.is_valid and d.polygon.area > 0 for d in drafts):
            log.refuse("S312", relief, "its outline crosses itself or has no area", "repair the outline")
            continue
        share = [float(r.intersection(d.polygon).area) for r, d in zip(regions, drafts, strict=True)]
        best = int(np.argmax(share))
        if share[best] == 0.0:
            log.refuse("S310", relief, "lies on no wall of the host", "check outline and registration")
            continue
        offsets |= dict.fromkeys(_names(relief), -float(_on_wall(relief.ring, motions[best])[:, 1].mean()))
        groups.setdefault(best, []).append(drafts[best])
    first = solid
    for number, own in sorted(groups.items()):
        wall = find_again(solid, first, walls[number])
        if wall is None:
            for d in own:
                log.refuse("S310", d.relief, "its wall was already cut by another one", "merge the facades")
            continue
        solid = _with_wall(solid, wall, own if options.depth else _flattened(own, log), options, log)
    return solid


def _with_wall(solid: Solid, wall: Wall, drafts: Sequence[Draft], options: BuildOptions, log: Log) -> Solid:
    """The solid with reliefs on one wall; as it was if none has a place."""
    placed = place(_area(solid, wall), drafts, options, log)
    placed = _limited(placed, Clearance.of(solid, wall, options.gap), options, log)
    placed = _levelled(placed, options.gap * GRID)
    parts, placed = _unpinched(wall, placed, options, log)
    if not placed:
        return solid
    finer = carve(solid, wall, parts, placed)
    if unmatched(finer.faces):
        for p in placed:
            log.refuse("S399", p.relief, "the cut would leave the solid open", "please report this case")
        return solid
    return finer


def _count(facade: FacadeReliefs) -> str:
    number = sum(len(_names(r)) for r in facade.reliefs)
    return f"{number} element{'s' if number > 1 else ''} left out"


def _names(relief: Relief) -> list[str]:
    """A relief and all that lies on it."""
    return [relief.id, *(name for r in relief.inside for name in _names(r))]


def _draft(relief: Relief, wall_from_facade: Rigid3) -> Draft:
    grid = np.rint(_on_wall(relief.ring, wall_from_facade)[:, [0, 2]] * GRID)
    inside = tuple(_draft(r, wall_from_facade) for r in relief.inside)
    polygon = Polygon(grid) if len(grid) > 2 and np.isfinite(grid).all() else Polygon()
    return Draft(relief, polygon, inside)


def _on_wall(ring: Float, wall_from_facade: Rigid3) -> Float:
    """A ring (k, 2) of the measured plane in the axes of the wall (k, 3) m."""
    return wall_from_facade.apply(np.column_stack([ring[:, 0], np.zeros(len(ring)), ring[:, 1]]))


def _flattened(drafts: Sequence[Draft], log: Log) -> list[Draft]:
    """Protrusions replaced by what is on them."""
    flat: list[Draft] = []
    for d in drafts:
        if d.relief.depth is not None and d.relief.depth < 0:
            log.notes.append(f"{d.relief.id}: a protrusion, left out of the model without depth")
            flat += _flattened(d.inside, log)
        else:
            flat.append(d)
    return flat


def _region(wall: Wall) -> shapely.Geometry:
    return shapely.union_all(list(wall.polygons), grid_size=1.0)


def _area(solid: Solid, wall: Wall) -> Area:
    """Where reliefs may go on a wall, and the lines of the ground."""
    place_of = {i: n for n, i in wall.nodes.items()}
    users: dict[int, set[int]] = {}
    for k, face in enumerate(solid.faces):
        for ring in rings_of(face):
            for i in ring:
                users.setdefault(i, set()).add(k)
    edged = {i for e in wall.border if e not in wall.ground for i in e}
    lines = []
    for edge, ground in wall.ground.items():
        line = LineString([place_of[edge[0]], place_of[edge[1]]])
        ends = [_TRIM if i not in edged and users[i] - {ground, *wall.faces} else 0.0 for i in edge]
        if line.length > 2 * _TRIM:
            lines.append(substring(line, ends[0], line.length - ends[1]))
    region = _region(wall)
    seams = [p.boundary.difference(region.boundary.buffer(1.0)) for p in wall.polygons[1:]]
    parts = [g for s in seams for g in shapely.get_parts(s) if isinstance(g, LineString)]
    return Area(region, shapely.union_all(lines), tuple(parts))


def _limited(placed: list[Placed], clearance: Clearance, options: BuildOptions, log: Log) -> list[Placed]:
    """Reliefs made shallower where they would meet another face of the host."""
    k = 0
    while k < len(placed):
        one = placed[k]
        base = placed[one.parent].height if one.parent >= 0 else 0
        free = clearance.free(one.polygon, one.height)
        if (
            free != one.height
            and abs(free - base) >= options.gap * GRID
            and (free > base) == (one.height > base)
        ):
            log.notes.append(
                f"{one.relief.id}: {abs(free - base) / GRID:.3f} m deep, no more is free behind it"
            )
            placed = raised(placed, k, free)
        elif free != one.height and one.height < base:
            log.refuse("S315", one.relief, "meets another part of the building", "check its depth")
            placed = removed(placed, k)
            continue
        elif free != one.height:
            log.notes.append(f"{one.relief.id}: made flush, there is no room for its depth")
            placed = raised(placed, k, base)
        k += 1
    return placed


def _levelled(placed: list[Placed], gap: float) -> list[Placed]:
    """Touching reliefs with a step between them that would be a sliver at one height, until none is left.

    One that went to the height of a neighbour may have come near that of another one.
    """
    polygons = np.array([p.polygon for p in placed], object)
    i, j = shapely.STRtree(polygons).query(polygons, "dwithin", _TRIM)
    parent = np.array([p.parent for p in placed])
    pairs = (i < j) & (parent[i] == parent[j])
    i, j = i[pairs], j[pairs]
    while True:
        height = np.array([p.height for p in placed])
        step = np.abs(height[i] - height[j])
        slivers = np.flatnonzero((step > 0) & (step < gap))
        if not len(slivers):
            return placed
        pair = [int(k[slivers[0]]) for k in (i, j)]
        shallower = min((placed[k].height for k in pair), key=abs)
        for k in pair:
            placed = raised(placed, k, shallower)


def _unpinched(
    wall: Wall, placed: list[Placed], options: BuildOptions, log: Log
) -> tuple[Partition, list[Placed]]:
    """The partition, with corners cut where the solid would touch itself along an edge."""
    parts = partition(wall, placed)
    for last in range(_ROUNDS + 1):
        nodes = parts.pinched()
        if not nodes:
            break
        for node in nodes:
            placed = _corner_cut(placed, node, options, log, refuse=last == _ROUNDS)
        parts = partition(wall, placed)
    return parts, placed


def _corner_cut(
    placed: list[Placed], node: Node, options: BuildOptions, log: Log, refuse: bool
) -> list[Placed]:
    """The last relief at a node without its corner there."""
    half = options.gap * GRID / 2
    point = shapely.Point(node)
    here = [k for k, p in enumerate(placed) if p.polygon.boundary.dwithin(point, SHORTEST)]
    here = [k for k in here if placed[k].height] or here
    if not here:
        return placed
    one = placed[here[-1]]
    square = shapely.box(node[0] - half, node[1] - half, node[0] + half, node[1] + half)
    rest = shapely.difference(one.polygon, square, grid_size=1.0)
    if refuse or not isinstance(rest, Polygon) or rest.interiors:
        log.refuse("S316", one.relief, "touches another opening in a point", "separate or join the two")
        return removed(placed, here[-1])
    log.notes.append(
        f"{one.relief.id}: {half / GRID:g} m cut off a corner that touched another one in a point"
    )
    placed = list(placed)
    placed[here[-1]] = replace(one, polygon=rest)
    return placed
