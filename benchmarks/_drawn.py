"""Buildings drawn from upright boxes, with windows and doors, as CityJSON of LoD3 and LoD2.

Coordinates of a drawing, m: x to the right as seen from the street, y into the building, z up. The street
lies at y < 0 and the ground at z = 0. A drawing may be bent along its front and lean when it is written.
"""

import json
from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import shapely

from frontage.geometry.arrays import Bool, Float

Box = tuple[float, float, float, float, float, float]
PLACE = np.array([678_300.0, 5_403_400.0, 372.0])  # of the origin of every drawing, EPSG:32632
TURN = np.radians(24.0)  # of every drawing: walls follow neither axis
STEP_M = 0.0005  # of the grid of vertices
ARC = 16  # edges of a round head
LOD2_M = (0.15, 0.15, 0.1)  # standard deviation of the shift of the LoD2 model


@dataclass(frozen=True)
class Hole:
    """A window or door: its outline (x, z), or (y, z) in a side wall, of a wall across an axis at a place.

    axis, sign  0 and -1: a wall that faces -x; 1 and -1: a wall that faces the street
    place, depth  m, of the wall along the axis, and from the wall to the leaf or frame
    """

    outline: shapely.Polygon
    axis: int
    sign: int
    place: float
    depth: float
    kind: str


@dataclass
class Drawing:
    """Boxes that are filled or emptied in turn; `body` are the boxes of its LoD2 model.

    bends  places x m, from left to right, where the whole front turns, by degrees: away from the street where
           they are positive; no opening crosses one
    lean   m towards the street per m of height
    """

    boxes: list[tuple[Box, bool]] = field(default_factory=list)
    body: list[tuple[Box, bool]] = field(default_factory=list)
    holes: list[Hole] = field(default_factory=list)
    bends: list[tuple[float, float]] = field(default_factory=list)
    lean: float = 0.0

    def house(self, x0: float, x1: float, y0: float, y1: float, z0: float, z1: float) -> None:
        """Add a box that the LoD2 model has as well."""
        self.body.append(((x0, x1, y0, y1, z0, z1), True))
        self.add(x0, x1, y0, y1, z0, z1)

    def add(self, x0: float, x1: float, y0: float, y1: float, z0: float, z1: float) -> None:
        """Fill a box."""
        self.boxes.append(((x0, x1, y0, y1, z0, z1), True))

    def cut(self, x0: float, x1: float, y0: float, y1: float, z0: float, z1: float) -> None:
        """Empty a box."""
        self.boxes.append(((x0, x1, y0, y1, z0, z1), False))

    def window(
        self,
        x0: float,
        x1: float,
        z0: float,
        z1: float,
        y: float = 0.0,
        depth: float = 0.15,
        head: str = "flat",
    ) -> None:
        """Put a window into the wall at y m that faces the street; `head` is flat, round or pointed."""
        self.holes.append(Hole(_outline(x0, x1, z0, z1, head), 1, -1, y, depth, "Window"))

    def door(
        self, x0: float, x1: float, z1: float, y: float = 0.0, depth: float = 0.15, z0: float = 0.0
    ) -> None:
        """Put a door into the wall at y m that faces the street."""
        self.holes.append(Hole(_outline(x0, x1, z0 + 0.02, z1, "flat"), 1, -1, y, depth, "Door"))

    def side_window(
        self, y0: float, y1: float, z0: float, z1: float, x: float, sign: int, depth: float = 0.15
    ) -> None:
        """Put a window into the wall at x m that faces -x or x."""
        self.holes.append(Hole(shapely.box(y0, z0, y1, z1), 0, sign, x, depth, "Window"))

    def write(self, path: Path, name: str) -> None:
        """Write the LoD3 model."""
        _write(path, name, "3", self._faces(self.boxes, self.holes), np.zeros(3))

    def write_lod2(self, path: Path, name: str, rng: np.random.Generator) -> None:
        """Write the LoD2 model, shifted as a surveyed one is."""
        _write(path, name, "2", self._faces(self.body, []), rng.normal(0.0, LOD2_M))

    def _faces(self, boxes: list[tuple[Box, bool]], holes: list[Hole]) -> list[tuple[str, str, list[Float]]]:
        """Return the kind, name and rings (k, 3) m of all faces of the building, which is bent and leans."""
        ends = [float(f(box[a] for box, _ in self.boxes)) for f, a in ((min, 0), (max, 1))]
        plan = np.array([(ends[0], 0.0), *self.bends, (ends[1], 0.0)])
        return [
            (kind, about, [_bent(_leaning(ring, self.lean), plan) for ring in rings])
            for kind, about, rings in _surfaces(boxes, holes, self.bends)
        ]


def _outline(x0: float, x1: float, z0: float, z1: float, head: str) -> shapely.Polygon:
    """Return the outline of an opening."""
    if head == "flat":
        return shapely.box(x0, z0, x1, z1)
    half, middle = (x1 - x0) / 2.0, (x0 + x1) / 2.0
    if head == "round":
        angle = np.linspace(0.0, np.pi, ARC + 1)
        arc = half * np.column_stack([np.cos(angle), np.sin(angle)])
    else:  # two arcs about the opposite springing points
        angle = np.linspace(0.0, np.pi / 3.0, ARC // 2 + 1)
        right = half * np.column_stack([2.0 * np.cos(angle) - 1.0, 2.0 * np.sin(angle)])
        arc = np.concatenate([right, right[-2::-1] * [-1.0, 1.0]])
    return shapely.Polygon([(x0, z0), (x1, z0), *(arc + np.array([middle, z1 - arc[:, 1].max()]))])


def _leaning(ring: Float, lean: float) -> Float:
    """Return a ring (k, 3) m moved towards the street by `lean` m per m of height."""
    return ring - np.outer(ring[:, 2] * lean, [0.0, 1.0, 0.0])


def _bent(ring: Float, plan: Float) -> Float:
    """Return a ring (k, 3) m of a straight drawing as it lies on a front that turns.

    plan (n, 2): places x m and turns in degrees; those of the ends are zero. Lines of equal x become mitres.
    """
    x, turn = plan[:, 0], np.radians(plan[:, 1])
    heading = np.cumsum(turn)
    step = np.diff(x)[:, None] * np.column_stack([np.cos(heading), np.sin(heading)])[:-1]
    corner = np.cumsum(np.concatenate([[[x[0], 0.0]], step]), axis=0)
    middle = heading - turn / 2.0
    mitre = np.column_stack([-np.sin(middle), np.cos(middle)]) / np.cos(turn / 2.0)[:, None]
    k = np.clip(np.searchsorted(x, ring[:, 0] + 1e-9, side="right") - 1, 0, len(x) - 2)
    t, y = ((ring[:, 0] - x[k]) / (x[k + 1] - x[k]))[:, None], ring[:, 1:2]
    at = (1.0 - t) * (corner[k] + y * mitre[k]) + t * (corner[k + 1] + y * mitre[k + 1])
    return np.column_stack([at, ring[:, 2]])


def _surfaces(
    boxes: list[tuple[Box, bool]], holes: list[Hole], bends: list[tuple[float, float]]
) -> Iterator[tuple[str, str, list[Float]]]:
    """Yield the kind, name and rings (k, 3) m of all faces, each seen counter-clockwise from outside.

    They are parted at the bends, so that they stay plane.
    """
    edges = [np.unique(np.round([b[2 * a : 2 * a + 2] for b, _ in boxes], 4)) for a in range(3)]
    filled = np.zeros([len(e) - 1 for e in edges], np.bool_)
    for box, is_filled in boxes:
        part = (slice(*np.searchsorted(edges[a], np.round(box[2 * a : 2 * a + 2], 4))) for a in range(3))
        filled[tuple(part)] = is_filled
    for axis in range(3):
        for sign in (-1, 1):
            for place, area in _areas(filled, edges, axis, sign):
                own = [h for h in holes if (h.axis, h.sign) == (axis, sign) and abs(h.place - place) < 1e-3]
                wall = area.difference(shapely.union_all([h.outline for h in own]))
                kind = _kind(axis, sign, place)
                parts = [p for strip in _parted(wall, axis, bends) for p in shapely.get_parts(strip)]
                for number, part in enumerate(p for p in parts if p.area > 0.0):
                    yield kind, f"{kind}{axis}{sign}{place:.3f}-{number}", _rings(part, axis, sign, place)
    for number, hole in enumerate(holes):
        leaf = hole.place - hole.sign * hole.depth
        yield hole.kind, f"opening{number}", _rings(hole.outline, hole.axis, hole.sign, leaf)


def _parted(area: shapely.Geometry, axis: int, bends: list[tuple[float, float]]) -> list[shapely.Geometry]:
    """Return the parts of a face across an axis between the bends."""
    if axis == 0 or not bends:
        return [area]
    ends = [-1e4, *(x for x, _ in bends), 1e4]
    return [area.intersection(shapely.box(a, -1e4, b, 1e4)) for a, b in pairwise(ends)]


def _areas(
    filled: Bool, edges: list[Float], axis: int, sign: int
) -> Iterator[tuple[float, shapely.Geometry]]:
    """Yield the place of every plane across an axis with the area of its faces that face `sign`."""
    grown = np.pad(np.moveaxis(filled, axis, 0), ((1, 1), (0, 0), (0, 0)))
    shown = grown[:-1] & ~grown[1:] if sign > 0 else grown[1:] & ~grown[:-1]
    u, v = (edges[a] for a in range(3) if a != axis)
    for place, cells in zip(edges[axis], shown, strict=True):
        i, j = np.nonzero(cells)
        if len(i):
            yield float(place), shapely.union_all(shapely.box(u[i], v[j], u[i + 1], v[j + 1])).simplify(0.0)


def _kind(axis: int, sign: int, place: float) -> str:
    """Return what a face is called in a city model."""
    if axis < 2:
        return "WallSurface"
    return "RoofSurface" if sign > 0 else "GroundSurface" if place < 0.01 else "OuterCeilingSurface"


def _rings(polygon: shapely.Polygon, axis: int, sign: int, place: float) -> list[Float]:
    """Return the rings (k, 3) m of a polygon in a plane across an axis."""
    straight = (sign > 0) != (axis == 1)  # x, z seen from y > 0 runs to the left
    oriented = shapely.geometry.polygon.orient(polygon, 1.0 if straight else -1.0)
    rings = (np.asarray(r.coords)[:-1] for r in (oriented.exterior, *oriented.interiors))
    return [np.insert(r, axis, place, axis=1) for r in rings]


def _write(
    path: Path, name: str, lod: str, surfaces: list[tuple[str, str, list[Float]]], shift: Float
) -> None:
    """Write faces as one building of a CityJSON 2.0 file."""
    c, s = np.cos(TURN), np.sin(TURN)
    axes = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    known: dict[tuple[int, ...], int] = {}
    faces = []
    for _, _, rings in surfaces:
        grid = [np.round((ring @ axes.T + shift) / STEP_M).astype(np.int64).tolist() for ring in rings]
        faces.append([[known.setdefault(tuple(p), len(known)) for p in ring] for ring in grid])
    table = [{"type": kind, "id": f"{name}-{about}"} for kind, about, _ in surfaces]
    solid = lod == "2"
    geometry: dict[str, Any] = {
        "type": "Solid" if solid else "MultiSurface",
        "lod": lod,
        "boundaries": [faces] if solid else faces,
    }
    numbers = list(range(len(faces)))
    geometry["semantics"] = {"surfaces": table, "values": [numbers] if solid else numbers}
    model = {
        "type": "CityJSON",
        "version": "2.0",
        "metadata": {"referenceSystem": "https://www.opengis.net/def/crs/EPSG/0/32632"},
        "transform": {"scale": [STEP_M] * 3, "translate": PLACE.tolist()},
        "CityObjects": {name: {"type": "Building", "geometry": [geometry]}},
        "vertices": [list(p) for p in known],
    }
    path.write_text(json.dumps(model))
