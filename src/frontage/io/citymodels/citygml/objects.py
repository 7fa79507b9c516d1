"""Buildings of CityGML 1, 2 and 3: solids, thematic surfaces, openings, parts and installations."""

import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field

import numpy as np
from lxml import etree

from frontage.geometry.arrays import Float
from frontage.io.citymodels.citygml.attributes import address_of, attributes_of
from frontage.io.citymodels.citygml.geometry import (
    SOLIDS,
    Find,
    identifier,
    local,
    polygons,
    position,
    rings,
    solids,
    targets,
)
from frontage.io.citymodels.draft import BuildingDraft, DraftFace, DraftShell, Value
from frontage.model import OPENING_SURFACES

_CLASSES = {
    "WallSurface": "WallSurface",
    "RoofSurface": "RoofSurface",
    "GroundSurface": "GroundSurface",
    "ClosureSurface": "ClosureSurface",
    "OuterCeilingSurface": "OuterCeilingSurface",
    "OuterFloorSurface": "OuterFloorSurface",
    **{name: name for name in OPENING_SURFACES},
    **{surface.citygml3: name for name, surface in OPENING_SURFACES.items()},
}
_PROPERTY = re.compile(r"lod(\d)(Solid|MultiSurface|FootPrint|RoofEdge|Geometry|ImplicitRepresentation)$")
_PARTS = ("BuildingPart", "BuildingInstallation", "BuildingConstructiveElement")
_OTHER = re.compile(  # not the building's shell: rooms, furniture, interior installations, texts
    r"interior|buildingRoom|buildingFurniture|buildingUnit|buildingSubdivision|address$|appearance|generic"
    r"|generalizesTo|relatedTo|externalReference"
)
_LEVEL0 = {"FootPrint": "GroundSurface", "RoofEdge": "RoofSurface"}


@dataclass(eq=False)
class _ThematicSurface:
    """The thematic surface that a geometry stands in: class, id, attributes."""

    semantics: str | None = None
    id: str = ""
    about: dict[str, Value] = field(default_factory=dict)


@dataclass(eq=False)
class _GeometryProperty:
    """A geometry property: level of detail, kind ("Solid", "FootPrint", ...), element, thematic surface."""

    lod: str
    kind: str
    element: etree._Element
    owner: _ThematicSurface


@dataclass(eq=False)
class _Polygon:
    """A polygon of a level: its element (None when it is placed by a matrix) and its face."""

    element: etree._Element | None
    face: DraftFace


class _Reader:
    """Fills the draft of one building; `find` looks up references."""

    def __init__(self, draft: BuildingDraft, find: Find) -> None:
        self._draft = draft
        self._find = find

    def read(self, element: etree._Element, part: str = "") -> None:
        """Read the shells of a building, then those of its parts."""
        properties: list[_GeometryProperty] = []
        parts: list[etree._Element] = []
        self._collect(element, _ThematicSurface(), properties, parts)
        for lod in dict.fromkeys(p.lod for p in properties):
            self._draft.shells += self._level(lod, [p for p in properties if p.lod == lod], part)
        for k, child in enumerate(parts):
            first = len(self._draft.shells)
            self.read(child, identifier(child) or f"{self._draft.id}/{local(child)}{k}")
            about = attributes_of(child)
            for shell in self._draft.shells[first:]:
                installation = shell.installation or local(child) == "BuildingInstallation"
                shell.describe(installation, shell.attributes or about)

    def _collect(
        self,
        children: Iterable[etree._Element],
        owner: _ThematicSurface,
        properties: list[_GeometryProperty],
        parts: list[etree._Element],
    ) -> None:
        """Collect the geometry properties with their thematic surfaces, and separately the parts."""
        for child in children:
            name = local(child)
            if not name or _OTHER.match(name):
                continue
            if match := _PROPERTY.match(name):
                properties.append(_GeometryProperty(match[1], match[2], child, owner))
            elif name in _PARTS:
                parts += [] if _is_inside(child) else [child]
            else:
                inner = _thematic(child, owner) if name in _CLASSES else owner
                self._collect(self._targets(child), inner, properties, parts)

    def _targets(self, element: etree._Element) -> list[etree._Element]:
        try:
            return targets(element, self._find)
        except ValueError as problem:
            self._draft.problems.append(str(problem))
            return []

    def _level(self, lod: str, properties: list[_GeometryProperty], part: str) -> list[DraftShell]:
        """The shells of one level: its solids, and one open shell with the surfaces that no solid shares."""
        closed: list[list[_Polygon]] = []
        loose: list[_Polygon] = []
        for p in properties:
            for g in self._targets(p.element):
                if local(g) == "Solid":
                    closed.append(list(self._solid(g, p)))
                elif local(g) in SOLIDS:
                    closed += [list(self._solid(s, p)) for s in solids(g, self._find)]
                elif local(g) == "ImplicitGeometry":
                    loose += self._implicit(g, p)
                else:
                    loose += self._surface(g, p)
        loose = _without_shared(closed, loose)
        shells = [DraftShell(lod, [q.face for q in solid], True, part) for solid in closed]
        return shells + ([DraftShell(lod, [q.face for q in loose], False, part)] if loose else [])

    def _solid(self, solid: etree._Element, p: _GeometryProperty) -> Iterator[_Polygon]:
        """The polygons of the outer shell of a solid."""
        for side in solid:
            if local(side) == "exterior":
                for surface in self._targets(side):
                    yield from self._surface(surface, p)
            elif local(side) == "interior":
                self._draft.problems.append("an inner shell of a solid")

    def _surface(self, surface: etree._Element, p: _GeometryProperty) -> Iterator[_Polygon]:
        trouble = self._draft.problems.append
        for element, turned in polygons(surface, self._find, trouble):
            try:
                found = rings(element)
            except ValueError as problem:
                trouble(str(problem))
                found = []
            face = _face(found, element, p)
            if turned:  # its textures lie on the other side
                face.rings, face.names = [r[::-1] for r in found], ()
            yield _Polygon(element, face)

    def _implicit(self, geometry: etree._Element, p: _GeometryProperty) -> Iterator[_Polygon]:
        """A prototype that a matrix and a reference point put in place (CityGML 2.0, 10.6.2)."""
        members = {local(c): c for c in geometry}
        if not {"transformationMatrix", "referencePoint"} <= set(members):
            self._draft.problems.append("an implicit geometry without matrix or reference point")
            return
        matrix = np.array((members["transformationMatrix"].text or "").split(), np.float64)
        anchor = position(members["referencePoint"])
        shape = next(
            (c for n, c in members.items() if n in ("relativeGMLGeometry", "relativeGeometry")), None
        )
        if matrix.shape != (16,) or shape is None or anchor is None:
            self._draft.problems.append("an implicit geometry that is kept in another file or is broken")
            return
        for target in self._targets(shape):
            for q in self._surface(target, p):
                q.face.rings = [_moved(r, matrix.reshape(4, 4)) + anchor for r in q.face.rings]
                yield _Polygon(None, q.face)


def building_of(element: etree._Element, number: int, find: Find) -> BuildingDraft:
    """Make a draft of a Building element with its parts and installations.

    `number` names a building without an id, and `find` looks up references. The draft's problems name what
    cannot be read.
    """
    draft = BuildingDraft(identifier(element) or f"building{number}")
    draft.attributes = attributes_of(element)
    draft.address, further = address_of(element)
    if further:
        draft.attributes["further_addresses"] = "; ".join(further)
    _Reader(draft, find).read(element)
    return draft


def _is_inside(part: etree._Element) -> bool:
    """Whether an installation of CityGML 3 states that it lies inside the building."""
    return any(local(c) == "relationToConstruction" and (c.text or "").strip() == "inside" for c in part)


def _thematic(element: etree._Element, above: _ThematicSurface) -> _ThematicSurface:
    about = attributes_of(element)
    if above.id:
        about["parent"] = above.id
    return _ThematicSurface(_CLASSES[local(element)], identifier(element), about)


def _face(found: list[Float], element: etree._Element, p: _GeometryProperty) -> DraftFace:
    owner, name = p.owner, identifier(element)
    about = dict(owner.about)
    if name and owner.id:
        about["surface"] = owner.id
    lines = [identifier(e) for e in element.iter("{*}LinearRing")]
    return DraftFace(found, owner.semantics or _LEVEL0.get(p.kind), name or owner.id, about, lines)


def _without_shared(closed: list[list[_Polygon]], loose: list[_Polygon]) -> list[_Polygon]:
    """Give the polygons of solids the classes of the thematic surfaces that share them.

    A polygon is shared when the solid refers to it, or when it has the same corners. Returns the loose
    polygons that no solid shares.
    """
    by_element = {q.element: q for q in loose if q.element is not None}
    by_corners = {_corners(q.face): q for q in loose}
    shared: set[int] = set()
    for solid in closed:
        for q in solid:
            twin = by_element.get(q.element) if q.element is not None else None
            twin = twin or (by_corners.get(_corners(q.face)) if q.face.rings else None)
            if twin is not None:
                shared.add(id(twin))
                q.face.semantics, q.face.id, q.face.about = (
                    twin.face.semantics,
                    twin.face.id or q.face.id,
                    twin.face.about,
                )
                if _same_corners(q.face, twin.face):
                    q.face.names = twin.face.names  # which textures refer to
    return [q for q in loose if id(q) not in shared]


def _same_corners(one: DraftFace, other: DraftFace) -> bool:
    """Whether two polygons have the same corners in the same order."""
    return len(one.rings) == len(other.rings) and all(
        np.array_equal(a, b) for a, b in zip(one.rings, other.rings, strict=True)
    )


def _corners(face: DraftFace) -> frozenset[tuple[float, ...]]:
    """The corners of the outer ring, rounded to 1 mm, without an order."""
    return frozenset(map(tuple, np.round(face.rings[0], 3).tolist())) if face.rings else frozenset()


def _moved(ring: Float, matrix: Float) -> Float:
    out = np.column_stack([ring, np.ones(len(ring))]) @ matrix.T
    return out[:, :3] / out[:, 3:]
