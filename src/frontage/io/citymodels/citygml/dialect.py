"""The names that CityGML 2.0 and 3.0 have for the same things, and the order that their schemas require."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from lxml import etree

from frontage.io.citymodels.address import split_address

Node = Any  # an lxml element


@dataclass(frozen=True)
class Member:
    """The names of a kind of object that a building holds, with prefixes; `{}` is the level of detail.

    holder    the property of the building
    object    the object in it
    geometry  the property with its solid, or with the surfaces of a frame
    order     of its contents
    """

    holder: str
    object: str
    geometry: str
    order: tuple[str, ...]


@dataclass(frozen=True)
class Dialect:
    """The names of one version of CityGML, with prefixes; `{}` stands for the level of detail.

    schemas  where the official schema of a prefix is published
    order    of the contents of a building
    members  by kind: "part", "installation", "frame" (of a window, with its bars)
    """

    version: str
    names: Mapping[str, str]
    schemas: Mapping[str, str]
    order: tuple[str, ...]
    boundary: str
    surfaces: str
    solid: str
    multi: str
    opening: str
    filled: str
    members: Mapping[str, Member]

    def tag(self, name: str) -> str:
        """A name with prefix in lxml's notation."""
        prefix, local = name.split(":")
        return f"{{{self.names[prefix]}}}{local}"

    def make(self, name: str, text: str | None = None, /, **attributes: str) -> Node:
        """Make an element; the names of attributes with a prefix are written prefix_local."""
        named = {self.tag(k.replace("_", ":", 1)) if "_" in k else k: v for k, v in attributes.items()}
        element: Node = etree.Element(self.tag(name), named, nsmap=dict(self.names))
        element.text = text
        return element

    def add(self, parent: Node, name: str, text: str | None = None, /, **attributes: str) -> Node:
        """Make an element and append it to `parent`."""
        element = self.make(name, text, **attributes)
        parent.append(element)
        return element

    @property
    def schema_location(self) -> str:
        """The value of xsi:schemaLocation: pairs of a namespace and its schema."""
        return " ".join(f"{self.names[prefix]} {place}" for prefix, place in self.schemas.items())

    def surface(self, semantics: str, opening: bool = False) -> str:
        """The name of the element of a thematic surface, or of an opening in one."""
        if opening:
            return f"{self.surfaces}:{semantics}{self.filled}"
        core = self.version == "3.0" and semantics == "ClosureSurface"
        return f"{'core' if core else self.surfaces}:{semantics}"

    def attribute(self, parent: Node, name: str, value: str | float | int) -> None:
        """Append a generic attribute to `parent`."""
        kind = "int" if isinstance(value, int) else "double" if isinstance(value, float) else "string"
        text = repr(float(value)) if kind == "double" else str(value)
        if self.version == "2.0":
            element = self.add(parent, f"gen:{kind}Attribute", name=name)
        else:
            holder = self.add(parent, "core:genericAttribute")
            element = self.add(holder, f"gen:{kind.capitalize()}Attribute")
            self.add(element, "gen:name", name)
        self.add(element, "gen:value", text)

    def relation(self, parent: Node, kind: str, other: str) -> None:
        """Append the relation to another object of the file, which only version 3.0 knows."""
        if self.version == "3.0":
            relation = self.add(self.add(parent, "core:relatedTo"), "core:CityObjectRelation")
            self.add(relation, "core:relationType", kind)
            self.add(relation, "core:relatedTo", xlink_href=f"#{other}")

    def height(self, value: float) -> Node:
        """Make the element with the building's height in m."""
        if self.version == "2.0":
            return self.make("bldg:measuredHeight", f"{value:.2f}", uom="m")
        holder = self.make("con:height")
        height = self.add(holder, "con:Height")
        for name, text in (
            ("highReference", "highestPoint"),
            ("lowReference", "lowestPoint"),
            ("status", "measured"),
        ):
            self.add(height, f"con:{name}", text)
        self.add(height, "con:value", f"{value:.2f}", uom="m")
        return holder

    def address(self, address: str) -> Node:
        """Make the element with an address "number street"."""
        number, street = split_address(address)
        holder = self.make("bldg:address")
        node = self.add(self.add(holder, "core:Address"), "core:xalAddress")
        if self.version == "3.0":
            place = self.add(self.add(node, "xAL:Address"), "xAL:Thoroughfare")
            self.add(place, "xAL:NameElement", street)
            if number:
                self.add(place, "xAL:Number", number)
            return holder
        country = self.add(self.add(node, "xAL:AddressDetails"), "xAL:Country")
        place = self.add(self.add(country, "xAL:Locality", Type="Town"), "xAL:Thoroughfare", Type="Street")
        if number:
            self.add(place, "xAL:ThoroughfareNumber", number)
        self.add(place, "xAL:ThoroughfareName", street)
        return holder

    def shell(self, solid: Node) -> Node:
        """Append the element that holds the polygons of a solid's outer shell."""
        exterior = self.add(solid, "gml:exterior")
        return self.add(exterior, "gml:CompositeSurface" if self.version == "2.0" else "gml:Shell")


_COMMON = {"xlink": "http://www.w3.org/1999/xlink", "xsi": "http://www.w3.org/2001/XMLSchema-instance"}
_PUBLISHED = "http://schemas.opengis.net/citygml/"
_ORDER2 = ("height", "geometry2", "installation", "frame", "boundary", "geometry3", "part", "address")
_ORDER3 = ("boundary", "geometry2", "geometry3", "height", "frame", "installation", "address", "part")
_INSTALLATION2 = Member(
    "bldg:outerBuildingInstallation",
    "bldg:BuildingInstallation",
    "bldg:lod{}Geometry",
    ("geometry2", "geometry3", "boundary"),
)

CITYGML2 = Dialect(
    "2.0",
    {
        "core": "http://www.opengis.net/citygml/2.0",
        "bldg": "http://www.opengis.net/citygml/building/2.0",
        "app": "http://www.opengis.net/citygml/appearance/2.0",
        "gen": "http://www.opengis.net/citygml/generics/2.0",
        "gml": "http://www.opengis.net/gml",
        "xAL": "urn:oasis:names:tc:ciq:xsdschema:xAL:2.0",
        **_COMMON,
    },
    {
        "core": f"{_PUBLISHED}2.0/cityGMLBase.xsd",
        "bldg": f"{_PUBLISHED}building/2.0/building.xsd",
        "gen": f"{_PUBLISHED}generics/2.0/generics.xsd",
        "app": f"{_PUBLISHED}appearance/2.0/appearance.xsd",
    },
    _ORDER2,
    boundary="bldg:boundedBy",
    surfaces="bldg",
    solid="bldg:lod{}Solid",
    multi="bldg:lod{}MultiSurface",
    opening="bldg:opening",
    filled="",
    members={
        "part": Member("bldg:consistsOfBuildingPart", "bldg:BuildingPart", "bldg:lod{}Solid", _ORDER2),
        "installation": _INSTALLATION2,
        "frame": _INSTALLATION2,  # version 2.0 has no constructive elements
    },
)

CITYGML3 = Dialect(
    "3.0",
    {
        "core": "http://www.opengis.net/citygml/3.0",
        "con": "http://www.opengis.net/citygml/construction/3.0",
        "bldg": "http://www.opengis.net/citygml/building/3.0",
        "app": "http://www.opengis.net/citygml/appearance/3.0",
        "gen": "http://www.opengis.net/citygml/generics/3.0",
        "gml": "http://www.opengis.net/gml/3.2",
        "xAL": "urn:oasis:names:tc:ciq:xal:3",
        **_COMMON,
    },
    {
        name: f"{_PUBLISHED}3.0/{file}.xsd"
        for name, file in (
            ("core", "core"),
            ("con", "construction"),
            ("bldg", "building"),
            ("gen", "generics"),
            ("app", "appearance"),
        )
    },
    _ORDER3,
    boundary="core:boundary",
    surfaces="con",
    solid="core:lod{}Solid",
    multi="core:lod{}MultiSurface",
    opening="con:fillingSurface",
    filled="Surface",
    members={
        "part": Member("bldg:buildingPart", "bldg:BuildingPart", "core:lod{}Solid", _ORDER3),
        "installation": Member(
            "bldg:buildingInstallation",
            "bldg:BuildingInstallation",
            "core:lod{}Solid",
            ("boundary", "geometry2", "geometry3"),
        ),
        "frame": Member(
            "bldg:buildingConstructiveElement",
            "bldg:BuildingConstructiveElement",
            "core:lod{}MultiSurface",
            ("geometry2", "geometry3"),
        ),
    },
)
