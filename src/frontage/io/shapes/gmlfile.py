"""Reading the geometries of GML 3 (CityGML 1 to 3 and any other application) for validation.

Rings are kept as they are, with their closing points. References (xlink:href) within the file are followed.
Entities are not resolved, and neither DTDs nor the network are used.
"""

import re
from pathlib import Path

from lxml import etree

from frontage.io.citymodels.citygml.geometry import (
    FACES,
    HREF,
    bounded,
    identifier,
    local,
    polygons,
    rings,
    solids,
    targets,
)
from frontage.io.degrees import refuse_degrees
from frontage.io.shapes.indoor import indoor_feature
from frontage.model import Feature, Polygons, Shape
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
_OWN = re.compile(r"(?=[A-Z])\w*(Installation|Furniture|Room|BuildingUnit|Storey|ConstructiveElement)$")
_PART = re.compile(
    r"(Building|Bridge|Tunnel)Part$"
)  # names of objects begin with a capital, names of properties do not
_GML = "opengis.net/"  # in the namespaces of GML, CityGML and IndoorGML
_LOD = re.compile(r"lod(\d(?:\.\d)?)")


def read_gml(path: Path) -> tuple[str, list[Feature]]:
    """Read every feature with its geometries; returns them with the name of the format.

    Raises lxml's XMLSyntaxError on damaged XML, ValueError naming what is wrong, and UnsupportedFormat for
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
    if local(root) == "IndoorFeatures":
        return "IndoorGML", [indoor_feature(root, reader.shapes_below)]
    if not any(isinstance(e.tag, str) and _GML in e.tag for e in root.iter()):
        raise ValueError(f"it is XML without any GML (its root is {local(root)})")
    kind = "CityGML" if local(root) == "CityModel" else "GML"
    members = _members(root) or reader.geometries(root)
    return kind, [f for k, e in enumerate(members) for f in reader.features(e, k)]


def _members(root: etree._Element) -> list[etree._Element]:
    """The features of a collection."""
    return [
        child
        for member in root
        if local(member) in ("cityObjectMember", "featureMember", "featureMembers", "member")
        for child in member
        if isinstance(child.tag, str) and local(child) != "Appearance"
    ]


class _Reader:
    """Makes features of one document, following its references."""

    def __init__(self, root: etree._Element) -> None:
        by_id = {identifier(e): e for e in root.iter() if isinstance(e.tag, str) and identifier(e)}
        self._find = bounded(by_id)

    def features(self, element: etree._Element, number: int) -> list[Feature]:
        """A feature, and the features inside it that count on their own (rooms of a bridge, furniture).

        The children of a building are parts of it: val3dity judges them together.
        """
        below = self.geometries(element)
        inner = [e for e in below if _OWN.match(local(e))]
        whole = local(element) == "Building"
        parts = [e for e in below if _PART.match(local(e)) or (whole and e in inner)]
        others = [] if whole else inner
        shapes = self._shapes([e for e in below if e not in parts and e not in others])
        inside = [f for k, p in enumerate(parts) for f in self.features(p, k)]
        name = identifier(element) or f"{local(element)}{number}"
        own = Feature(name, local(element), tuple(shapes), tuple(inside))
        rest = [f for k, o in enumerate(others) for f in self.features(o, k)]
        return [own, *rest]

    def shapes_below(self, element: etree._Element) -> tuple[Shape, ...]:
        """Every geometry at or below an element."""
        return tuple(self._shapes(self.geometries(element)))

    def geometries(self, element: etree._Element) -> list[etree._Element]:
        """The outermost geometries and features at or below an element."""
        if local(element) in _GEOMETRIES:
            return [element]
        found = []
        for child in element:
            name = local(child)
            if name and child.get(HREF) is not None and _LOD.match(name):
                targets(child, self._find)  # what it refers to is checked where it stands
            stop = name in _GEOMETRIES or _PART.match(name) or _OWN.match(name)
            found += [child] if stop else self.geometries(child) if name else []
        return found

    def _shapes(self, geometries: list[etree._Element]) -> list[Shape]:
        """Geometries as shapes, without the surfaces that solids refer to: these are checked with them."""
        used = {
            href[1:]
            for g in geometries
            if local(g) == "Solid" or local(g) in _SOLIDS
            for e in g.iter()
            if isinstance(e.tag, str) and (href := e.get(HREF, "")).startswith("#")
        }
        shapes = []
        for g in geometries:
            name = local(g)
            faces = {identifier(e) for e in g.iter() if local(e) in FACES} if name in _SURFACES else set()
            if name in _SURFACES and (identifier(g) in used or (faces and faces <= used)):
                continue
            shapes.append(self._shape(g))
        return shapes

    def _shape(self, geometry: etree._Element) -> Shape:
        name = local(geometry)
        above = [m[1] for e in geometry.iterancestors() if (m := _LOD.match(local(e)))]
        lod = above[0] if above else ""
        if name == "Solid":
            return Shape("Solid", (self._solid(geometry),), lod, identifier(geometry))
        if name in _SOLIDS:
            bodies = tuple(self._solid(s) for s in solids(geometry, self._find))
            return Shape(_SOLIDS[name], bodies, lod, identifier(geometry))
        return Shape(_SURFACES[name], ((self._surfaces(geometry),),), lod, identifier(geometry))

    def _solid(self, solid: etree._Element) -> tuple[Polygons, ...]:
        """The outer shell of a solid, then the inner ones."""
        sides = [e for name in ("exterior", "interior") for e in solid if local(e) == name]
        return tuple(self._surfaces(*targets(e, self._find)) for e in sides)

    def _surfaces(self, *surfaces: etree._Element) -> Polygons:
        """The polygons of surfaces of any kind. Raises ValueError for curves and broken references."""
        faces = []
        for surface in surfaces:
            for polygon, turned in polygons(surface, self._find, _refuse):
                own = rings(polygon)
                faces.append(([r[::-1] for r in own] if turned else own, identifier(polygon)))
        return Polygons.of([own for own, _ in faces], explicit=True, names=[name for _, name in faces])


def _refuse(trouble: str) -> None:
    raise ValueError(trouble)
