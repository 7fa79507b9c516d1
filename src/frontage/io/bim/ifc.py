"""Writing IFC 4.3 (ISO 16739-1:2024): walls, openings, windows and doors of measured facades."""

import uuid
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from frontage.errors import MissingExtra
from frontage.geometry.rigid import Rigid3
from frontage.io.bim.parts import BimBuilding, Body, Part, Value, Void
from frontage.io.crs import parse_crs, vertical
from frontage.io.files import whole_file
from frontage.model import WorldRef

SCHEMA = "IFC4X3_ADD2"
PROPERTIES = "Frontage_Measured"
"""The name of the property set with what was measured of an element."""

_FILLINGS = {"window": ("IfcWindow", "WINDOW"), "door": ("IfcDoor", "DOOR"), "gate": ("IfcDoor", "GATE")}
_COMMON = {"IfcWall": "Pset_WallCommon", "IfcWindow": "Pset_WindowCommon", "IfcDoor": "Pset_DoorCommon"}
_PRECISION_M = 1e-5
_NO_TIME = "1970-01-01T00:00:00"  # equal runs give equal files

Entity = Any


def write_ifc(
    path: Path,
    buildings: Sequence[BimBuilding],
    world: WorldRef,
    title: str,
    left_out: Sequence[str] = (),
) -> None:
    """Write buildings as IFC 4.3, in local metres that a map conversion takes to the CRS of `world`.

    A world without CRS has no map conversion; then the placement of the site is its origin. `left_out`,
    sentences on what the model does not show, are the description of the project.

    Raises MissingExtra without ifcopenshell, FileError when the file cannot be written.
    """
    try:
        import ifcopenshell
        import ifcopenshell.guid
    except ImportError as error:
        raise MissingExtra("writing IFC", "bim") from error
    file = ifcopenshell.file(schema=SCHEMA)
    _Writer(file, ifcopenshell.guid.compress, world).project(buildings, title, " ".join(left_out))
    header = file.header
    header.file_name.name, header.file_name.time_stamp = path.name, _NO_TIME
    header.file_name.preprocessor_version = header.file_name.originating_system = "Frontage"
    with whole_file(path) as temporary:
        temporary.write_text(file.to_string(), "utf-8")


class _Writer:
    """One file: entities are made in the order in which they refer to each other."""

    def __init__(self, file: Any, compress: Any, world: WorldRef) -> None:
        self._file, self._compress, self._world = file, compress, world
        self._space = uuid.uuid5(uuid.NAMESPACE_OID, f"{world.crs} {world.origin.tolist()}")
        self._body: Entity = None

    def make(self, kind: str, **values: Any) -> Entity:
        return self._file.create_entity(kind, **values)

    def rooted(self, kind: str, key: str, **values: Any) -> Entity:
        """Make an entity with a GlobalId that follows from its place in the world and its `key`."""
        number = uuid.uuid5(self._space, f"{kind} {key}")
        return self.make(kind, GlobalId=self._compress(number.hex), **values)

    def project(self, buildings: Sequence[BimBuilding], title: str, left_out: str) -> None:
        """Make the project with its site and buildings."""
        context = self._context()
        units = [self.make("IfcSIUnit", UnitType=f"{kind}UNIT", Name=name) for kind, name in
                 (("LENGTH", "METRE"), ("AREA", "SQUARE_METRE"), ("VOLUME", "CUBIC_METRE"),
                  ("PLANEANGLE", "RADIAN"))]  # fmt: skip
        about = f"Left out: {left_out}" if left_out else None
        project = self.rooted("IfcProject", "", Name=title, Description=about,
                              RepresentationContexts=[context],
                              UnitsInContext=self.make("IfcUnitAssignment", Units=units))  # fmt: skip
        located = self._map(context)
        origin = np.zeros(3) if located else self._world.origin
        site_place = self._placement(None, Rigid3("world", "site", np.eye(3), np.asarray(origin, float)))
        site = self.rooted("IfcSite", "", Name="Site", ObjectPlacement=site_place, CompositionType="ELEMENT")
        self._aggregate(project, [site])
        made = [self._building(b, site_place) for b in buildings]
        if made:
            self._aggregate(site, made)

    def _context(self) -> Entity:
        origin = self._axes(Rigid3("world", "site", np.eye(3), np.zeros(3)))
        context = self.make("IfcGeometricRepresentationContext", ContextType="Model",
                            CoordinateSpaceDimension=3, Precision=_PRECISION_M,
                            WorldCoordinateSystem=origin)  # fmt: skip
        kind = "IfcGeometricRepresentationSubContext"
        self._body = self.make(kind, ContextIdentifier="Body", ContextType="Model", ParentContext=context,
                               TargetView="MODEL_VIEW")  # fmt: skip
        return context

    def _map(self, context: Entity) -> bool:
        """State where the local coordinates lie in the CRS; returns whether that is known."""
        if self._world.crs is None:
            return False
        crs = parse_crs(self._world.crs)
        plan, upright = (crs.sub_crs_list or [crs])[0], vertical(crs)
        code = plan.to_authority()
        named = self.make("IfcProjectedCRS", Name=":".join(code) if code else plan.name,
                          Description=plan.name, VerticalDatum=upright.name if upright else None)  # fmt: skip
        x, y, z = (float(v) for v in self._world.origin)
        self.make("IfcMapConversion", SourceCRS=context, TargetCRS=named, Eastings=x, Northings=y,
                  OrthogonalHeight=z, XAxisAbscissa=1.0, XAxisOrdinate=0.0, Scale=1.0)  # fmt: skip
        return True

    def _building(self, b: BimBuilding, site: Entity) -> Entity:
        place = self.make("IfcLocalPlacement", PlacementRelTo=site, RelativePlacement=self._axes(None))
        building = self.rooted("IfcBuilding", b.id, Name=b.id, LongName=b.address, ObjectPlacement=place,
                               CompositionType="ELEMENT")  # fmt: skip
        elements = [element for part in b.parts for element in self._part(part, place)]
        if elements:
            self.rooted("IfcRelContainedInSpatialStructure", b.id, RelatedElements=elements,
                        RelatingStructure=building)  # fmt: skip
        return building

    def _part(self, part: Part, building: Entity) -> Iterable[Entity]:
        """Make a wall or a thing on it with its voids; yields it, and what fills its voids."""
        place = self._placement(building, part.frame)
        wall = part.kind == "wall"
        kind = "IfcWall" if wall else "IfcBuildingElementProxy"
        own = self.rooted(kind, part.id, Name=part.id, ObjectType=None if wall else part.kind,
                          ObjectPlacement=place, Representation=self._shape(part.body),
                          PredefinedType="SOLIDWALL" if wall else "USERDEFINED")  # fmt: skip
        self._describe(own, part.id, part.about)
        yield own
        for void in part.voids:
            yield from self._void(void, own, place)

    def _void(self, void: Void, holder: Entity, place: Entity) -> Iterable[Entity]:
        here = self.make("IfcLocalPlacement", PlacementRelTo=place, RelativePlacement=self._axes(None))
        hole = self.rooted("IfcOpeningElement", void.id, Name=void.id, ObjectPlacement=here,
                           Representation=self._shape(void.body),
                           PredefinedType="RECESS" if void.recess else "OPENING")  # fmt: skip
        self.rooted("IfcRelVoidsElement", void.id, RelatingBuildingElement=holder, RelatedOpeningElement=hole)
        if void.filling is None:
            self._describe(hole, void.id, void.about)
            return
        kind, predefined = _FILLINGS[void.kind]
        width, height = np.ptp(void.body.ring, axis=0).tolist()
        there = self.make("IfcLocalPlacement", PlacementRelTo=here, RelativePlacement=self._axes(None))
        filling = self.rooted(kind, void.id, Name=void.id, ObjectPlacement=there,
                              Representation=self._shape(void.filling), OverallHeight=height,
                              OverallWidth=width, PredefinedType=predefined)  # fmt: skip
        self.rooted(
            "IfcRelFillsElement", void.id, RelatingOpeningElement=hole, RelatedBuildingElement=filling
        )
        self._describe(filling, void.id, void.about)
        yield filling

    def _shape(self, body: Body) -> Entity:
        """Make the prism: its outline lies at the back, seen from the street, and is drawn to the front."""
        points = [self.make("IfcCartesianPoint", Coordinates=p) for p in body.ring.tolist()]
        outline = self.make("IfcArbitraryClosedProfileDef", ProfileType="AREA",
                            OuterCurve=self.make("IfcPolyline", Points=[*points, points[0]]))  # fmt: skip
        towards = np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]])  # columns: x, z and -y of the facade frame
        place = self._axes(Rigid3("facade", "outline", towards, np.array([0.0, body.back, 0.0])))
        prism = self.make("IfcExtrudedAreaSolid", SweptArea=outline,
                          Position=place, ExtrudedDirection=self._direction([0.0, 0.0, 1.0]),
                          Depth=body.back - body.front)  # fmt: skip
        shape = self.make("IfcShapeRepresentation", ContextOfItems=self._body,
                          RepresentationIdentifier="Body", RepresentationType="SweptSolid",
                          Items=[prism])  # fmt: skip
        return self.make("IfcProductDefinitionShape", Representations=[shape])

    def _describe(self, element: Entity, key: str, about: Any) -> None:
        """Attach what was measured, and the standard set of properties for elements of this kind."""
        sets = [(PROPERTIES, about)]
        if (common := _COMMON.get(element.is_a())) is not None:
            sets.append((common, {"Reference": key, "IsExternal": True}))
        for name, values in sets:
            found = [self._property(k, v) for k, v in values.items() if v is not None]
            if found:
                own = self.rooted("IfcPropertySet", f"{key} {name}", Name=name, HasProperties=found)
                self.rooted("IfcRelDefinesByProperties", f"{key} {name}", RelatedObjects=[element],
                            RelatingPropertyDefinition=own)  # fmt: skip

    def _property(self, name: str, value: Value) -> Entity:
        kind = "IfcIdentifier" if name == "Reference" else {
            bool: "IfcBoolean", int: "IfcInteger", float: "IfcReal"}.get(type(value), "IfcText")  # fmt: skip
        return self.make(
            "IfcPropertySingleValue", Name=name, NominalValue=self.make(kind, wrappedValue=value)
        )

    def _aggregate(self, whole: Entity, parts: list[Entity]) -> None:
        self.rooted("IfcRelAggregates", whole.GlobalId, RelatingObject=whole, RelatedObjects=parts)

    def _placement(self, above: Entity, frame: Rigid3) -> Entity:
        return self.make("IfcLocalPlacement", PlacementRelTo=above, RelativePlacement=self._axes(frame))

    def _axes(self, frame: Rigid3 | None) -> Entity:
        """Make a frame; None stands for the one above."""
        at = np.zeros(3) if frame is None else frame.t
        point = self.make("IfcCartesianPoint", Coordinates=[float(v) for v in at])
        if frame is None:
            return self.make("IfcAxis2Placement3D", Location=point)
        return self.make("IfcAxis2Placement3D", Location=point, Axis=self._direction(frame.R[:, 2].tolist()),
                         RefDirection=self._direction(frame.R[:, 0].tolist()))  # fmt: skip

    def _direction(self, ratios: list[float]) -> Entity:
        return self.make("IfcDirection", DirectionRatios=ratios)
