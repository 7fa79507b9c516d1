"""Geometries of GML 3: polygons and their rings, and references within a file."""

from collections.abc import Callable, Iterator, Mapping

import numpy as np
from lxml import etree

from frontage.geometry.arrays import Float

SOLIDS = ("MultiSolid", "CompositeSolid")
FACES = ("Polygon", "PolygonPatch", "Triangle", "Rectangle")
CURVED = (
    "Arc",
    "ArcString",
    "Circle",
    "Bezier",
    "BSpline",
    "CubicSpline",
    "Clothoid",
    "Cone",
    "Sphere",
    "Cylinder",
)
HREF = "{http://www.w3.org/1999/xlink}href"
_IDS = ("{http://www.opengis.net/gml}id", "{http://www.opengis.net/gml/3.2}id")
_USES, _USES_MORE = 8, 1000  # of an element by references, on average: a polygon bounds two solids
_DEPTH = 60  # longer chains of references are circles

Ring = Float
Find = Callable[[str], "etree._Element | None"]
"""Returns the element with a gml:id, or None."""


def local(element: etree._Element) -> str:
    """The tag without its namespace; "" for comments and processing instructions."""
    tag = element.tag
    return tag.rpartition("}")[2] if isinstance(tag, str) else ""


def identifier(element: etree._Element) -> str:
    """The gml:id of an element, or ""."""
    return element.get(_IDS[0]) or element.get(_IDS[1]) or element.get("id") or ""


def bounded(by_id: Mapping[str, etree._Element]) -> Find:
    """Return a function that finds elements, but not many times each: references can multiply without end."""
    left = _USES * len(by_id) + _USES_MORE

    def find(name: str) -> etree._Element | None:
        nonlocal left
        left -= 1
        if left < 0:
            raise ValueError("references that multiply")
        return by_id.get(name)

    return find


def targets(member: etree._Element, find: Find, depth: int = 0) -> list[etree._Element]:
    """The children of a property, or the element that it refers to.

    Raises ValueError for a reference to another file, to an element that does not exist, or in a circle.
    """
    href = member.get(HREF) if isinstance(member.tag, str) else None
    if href is None:
        return [c for c in member if isinstance(c.tag, str)]
    if not href.startswith("#"):
        raise ValueError(f"a reference to another file ({href})")
    target = find(href[1:])
    if target is None:
        raise ValueError(f"a reference to {href}, which is not in the file")
    if depth > _DEPTH:
        raise ValueError(f"references that run in a circle ({href})")
    return [target]


def polygons(
    surface: etree._Element, find: Find, trouble: Callable[[str], None], depth: int = 0
) -> Iterator[tuple[etree._Element, bool]]:
    """Yield the polygons of a surface of any kind, and whether an OrientableSurface reverses them.

    `trouble` is called with a phrase for every curved surface and every broken reference; it may raise.
    """
    name = local(surface)
    if name in FACES:
        yield surface, False
        return
    if name in CURVED:
        trouble(f"a curved surface ({name})")
        return
    turned = name == "OrientableSurface" and surface.get("orientation") == "-"
    for member in surface:
        try:
            inside = targets(member, find, depth)
        except ValueError as problem:
            trouble(str(problem))
            continue
        for target in inside:
            for face, turned_inside in polygons(target, find, trouble, depth + 1):
                yield face, turned_inside != turned


def solids(geometry: etree._Element, find: Find, depth: int = 0) -> Iterator[etree._Element]:
    """Yield the solids of an aggregate and of the aggregates inside it."""
    for member in geometry:
        for child in targets(member, find, depth):
            if local(child) == "Solid":
                yield child
            elif local(child) in SOLIDS:
                yield from solids(child, find, depth + 1)


def rings(polygon: etree._Element) -> list[Ring]:
    """The rings (k, 3) of a polygon as the file states them, the outer one first. Raises ValueError."""
    outer = [_ring(e) for e in polygon if local(e) in ("exterior", "outerBoundaryIs")]
    inner = [_ring(e) for e in polygon if local(e) in ("interior", "innerBoundaryIs")]
    return (outer[:1] or [np.zeros((0, 3))]) + inner


def _ring(boundary: etree._Element) -> Ring:
    """The points (k, 3) of a posList, of coordinates or of a row of pos; 2-D points get height 0."""
    rows: list[Float] = []
    for e in boundary.iter():
        name = local(e)
        if name in CURVED:
            raise ValueError(f"a curved ring ({name})")
        if name in ("posList", "pos", "coordinates"):
            rows.append(_coordinates(e, name))
    return np.concatenate(rows) if rows else np.zeros((0, 3))


def _coordinates(element: etree._Element, name: str) -> Float:
    text = (element.text or "").replace(",", " ") if name == "coordinates" else element.text or ""
    try:
        values = np.array(text.split(), np.float64)
    except ValueError as problem:
        raise ValueError("a coordinate that is not a number") from problem
    size = _dimension(element) if name != "pos" else len(values)
    if size not in (2, 3) or len(values) % size:
        raise ValueError("a ring with a broken list of coordinates")
    xyz = np.zeros((len(values) // size, 3))
    xyz[:, :size] = values.reshape(-1, size)
    return xyz


def _dimension(element: etree._Element) -> int:
    """The srsDimension of the element or of the nearest one around it; 3 where none states it."""
    said = element.get("srsDimension") or element.get("dimension")
    above = (a.get("srsDimension") for a in element.iterancestors())
    return int(said or next((v for v in above if v), 3))


def position(element: etree._Element) -> Float | None:
    """The point (3,) in or below an element; None without one or for a 2-D point."""
    text = next((e.text or "" for e in element.iter() if local(e) == "pos"), "")
    values = np.array(text.split(), np.float64)
    return values if values.shape == (3,) else None
