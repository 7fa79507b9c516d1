"""Geometries in GML 3 (CityGML 1 to 3 and any other application), for validation.

Rings are handed over as they stand, with their closing points. References (xlink:href) within the file are
followed. Entities are not resolved, DTDs and the network not used.
"""

import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from lxml import etree

from frontage.geometry.arrays import Float
from frontage.io.degrees import refuse_degrees
from frontage.io.shapes_indoor import indoor_feature
from frontage.model import Feature, Shape, Surfaces
from frontage.model.shape import ShapeKind

_SOLIDS: dict[str, ShapeKind] = {"MultiSolid": "MultiSolid", "CompositeSolid": "CompositeSolid"}
_SURFACES: dict[str, ShapeKind] = {
    "MultiSurface": "MultiSurface",
    "CompositeSurface": "CompositeSurface",
    "Surface": "MultiSurface",
    "PolyhedralSurface": "MultiSurface",
    "TriangulatedSurface": "MultiSurface",
    "Tin": "MultiSurface",
    "OrientableSurface": "MultiSurface",
    "Polygon": "MultiSurface",
}
_GEOMETRIES = ("Solid", *_SOLIDS, *_SURFACES)
_FACES = ("Polygon", "PolygonPatch", "Triangle", "Rectangle")
_CURVED = (
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
_OWN = re.compile(r"(?=[A-Z])\w*(Installation|Furniture|Room|BuildingUnit|Storey|ConstructiveElement)$")
_PART = re.compile(r"(Building|Bridge|Tunnel)Part$")  # objects have capitals, properties have not
_LOD = re.compile(r"lod(\d(?:\.\d)?)")
_HREF = "{http://www.w3.org/1999/xlink}href"
_DEPTH = 60  # references to references: more than this is a circle

Ring = Float
Face = tuple[list[Ring], str]


def read_gml(path: Path) -> tuple[str, list[Feature]]:
    """The name of the format and every feature with its geometries.

    Raises lxml's XMLSyntaxError on damaged XML, ValueError naming what is wrong, UnsupportedFormat for
    coordinates in degrees.
    """
    parser = etree.XMLParser(resolve_entities=False, no_network=True, load_dtd=False, huge_tree=False)
    tree = etree.parse(str(path), parser)
    if tree.docinfo.doctype:
        raise ValueError("it has a document type declaration, which is not accepted")
    root = tree.getroot()
    names = (e.get("srsName") for e in root.iter() if isinstance(e.tag, str))
    refuse_degrees(path, next((name for name in names if name), None))
    reader = _Reader(root)
    if _local(root) == "IndoorFeatures":
        return "IndoorGML", [indoor_feature(root, reader.shapes_below)]
    kind = "CityGML" if _local(root) == "CityModel" else "GML"
    members = _members(root) or reader.geometries(root)
    return kind, [f for k, e in enumerate(members) for f in reader.features(e, k)]


def _local(element: etree._Element) -> str:
    """The tag without its namespace; comments and instructions have none."""
    return etree.QName(element).localname if isinstance(element.tag, str) else ""


def _members(root: etree._Element) -> list[etree._Element]:
    """The features of a collection."""
    return [
        child
        for member in root
        if _local(member) in ("cityObjectMember", "featureMember", "featureMembers", "member")
        for child in member
        if isinstance(child.tag, str) and _local(child) != "Appearance"
    ]


def _id(element: etree._Element) -> str:
    return next((str(v) for k, v in element.attrib.items() if etree.QName(k).localname == "id"), "")


class _Reader:
    """Follows references within one document."""

    def __init__(self, root: etree._Element) -> None:
        self._by_id = {_id(e): e for e in root.iter() if isinstance(e.tag, str) and _id(e)}

    def features(self, element: etree._Element, number: int) -> list[Feature]:
        """A feature, and those inside it that are things of their own (rooms, installations)."""
        below = self.geometries(element)
        parts = [e for e in below if _PART.match(_local(e))]
        others = [e for e in below if _OWN.match(_local(e))]
        shapes = self._shapes([e for e in below if e not in parts and e not in others])
        inside = [f for k, p in enumerate(parts) for f in self.features(p, k)]
        name = _id(element) or f"{_local(element)}{number}"
        own = Feature(name, _local(element), tuple(shapes), tuple(inside))
        rest = [f for k, o in enumerate(others) for f in self.features(o, k)]
        return [own, *rest]

    def shapes_below(self, element: etree._Element) -> tuple[Shape, ...]:
        """Every geometry at or below an element."""
        return tuple(self._shapes(self.geometries(element)))

    def geometries(self, element: etree._Element) -> list[etree._Element]:
        """The outermost geometries and features at or below an element."""
        if _local(element) in _GEOMETRIES:
            return [element]
        found = []
        for child in element:
            name = _local(child)
            stop = name in _GEOMETRIES or _PART.match(name) or _OWN.match(name)
            found += [child] if stop else self.geometries(child) if name else []
        return found

    def _shapes(self, geometries: list[etree._Element]) -> list[Shape]:
        """Geometries as shapes; surfaces that a solid refers to are checked with the solid."""
        used = {
            href[1:]
            for g in geometries
            if _local(g) == "Solid" or _local(g) in _SOLIDS
            for e in g.iter()
            if isinstance(e.tag, str) and (href := e.get(_HREF, "")).startswith("#")
        }
        shapes = []
        for g in geometries:
            name = _local(g)
            faces = {_id(e) for e in g.iter() if _local(e) in _FACES} if name in _SURFACES else set()
            if name in _SURFACES and (_id(g) in used or (faces and faces <= used)):
                continue
            shapes.append(self._shape(g))
        return shapes

    def _shape(self, geometry: etree._Element) -> Shape:
        name = _local(geometry)
        above = [m[1] for e in geometry.iterancestors() if (m := _LOD.match(_local(e)))]
        lod = above[0] if above else ""
        if name == "Solid":
            return Shape("Solid", (self._solid(geometry),), lod, _id(geometry))
        if name in _SOLIDS:
            solids = tuple(self._solid(s) for s in self._solids(geometry, 0))
            return Shape(_SOLIDS[name], solids, lod, _id(geometry))
        surfaces = _surfaces(self._faces(geometry, 0))
        return Shape(_SURFACES[name], ((surfaces,),), lod, _id(geometry))

    def _solids(self, geometry: etree._Element, depth: int) -> Iterator[etree._Element]:
        """The solids of an aggregate, those of aggregates inside it too."""
        for member in geometry:
            for child in self._targets(member, depth):
                if _local(child) == "Solid":
                    yield child
                elif _local(child) in _SOLIDS:
                    yield from self._solids(child, depth + 1)

    def _solid(self, solid: etree._Element) -> tuple[Surfaces, ...]:
        """Outer shell, then inner ones."""
        sides = [e for name in ("exterior", "interior") for e in solid if _local(e) == name]
        return tuple(_surfaces([f for t in self._targets(e, 0) for f in self._faces(t, 0)]) for e in sides)

    def _targets(self, member: etree._Element, depth: int) -> list[etree._Element]:
        """The children of a property, or what it refers to."""
        href = member.get(_HREF) if isinstance(member.tag, str) else None
        if href is None:
            return [c for c in member if isinstance(c.tag, str)]
        if not href.startswith("#"):
            raise ValueError(f"a reference to another file ({href})")
        if href[1:] not in self._by_id:
            raise ValueError(f"a reference to {href}, which is not in the file")
        if depth > _DEPTH:
            raise ValueError(f"references that run in a circle ({href})")
        return [self._by_id[href[1:]]]

    def _faces(self, surface: etree._Element, depth: int) -> list[Face]:
        """Polygons of a surface of any kind, turned where an OrientableSurface says so."""
        name = _local(surface)
        if name in _FACES:
            return [_polygon(surface)]
        if name in _CURVED:
            raise ValueError(f"a curved surface ({name})")
        faces = [f for m in surface for t in self._targets(m, depth) for f in self._faces(t, depth + 1)]
        if name == "OrientableSurface" and surface.get("orientation") == "-":
            return [([r[::-1] for r in rings], label) for rings, label in faces]
        return faces


def _surfaces(faces: list[Face]) -> Surfaces:
    return Surfaces.of([rings for rings, _ in faces], explicit=True, names=[label for _, label in faces])


def _polygon(polygon: etree._Element) -> Face:
    """The rings of a polygon, its outer one first, and its gml:id."""
    outer = [_ring(e) for e in polygon if _local(e) in ("exterior", "outerBoundaryIs")]
    inner = [_ring(e) for e in polygon if _local(e) in ("interior", "innerBoundaryIs")]
    return (outer[:1] or [np.zeros((0, 3))]) + inner, _id(polygon)


def _ring(boundary: etree._Element) -> Ring:
    """posList, coordinates, or a row of pos, as (k, 3); two dimensions lie at height 0."""
    rows: list[Float] = []
    for e in boundary.iter():
        name = _local(e)
        if name in _CURVED:
            raise ValueError(f"a curved ring ({name})")
        if name in ("posList", "pos", "coordinates"):
            text = (e.text or "").replace(",", " ") if name == "coordinates" else e.text or ""
            values = np.array(text.split(), np.float64)
            size = _dimension(e) if name != "pos" else len(values)
            if size not in (2, 3) or len(values) % size:
                raise ValueError("a ring with a broken list of coordinates")
            xyz = np.zeros((len(values) // size, 3))
            xyz[:, :size] = values.reshape(-1, size)
            rows.append(xyz)
    return np.concatenate(rows) if rows else np.zeros((0, 3))


def _dimension(element: etree._Element) -> int:
    """srsDimension of the element or what it stands in; 3 where nobody says."""
    said = element.get("srsDimension") or element.get("dimension")
    above = (a.get("srsDimension") for a in element.iterancestors())
    return int(said or next((v for v in above if v), 3))
