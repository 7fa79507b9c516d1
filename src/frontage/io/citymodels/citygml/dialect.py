"""The names that CityGML 2.0 and 3.0 have for the same things, and the order that their schemas require."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from lxml import etree

from frontage.io.citymodels.address import split_address

Node = Any  # an lxml element


@dataclass(frozen=True)
class Dialect:
    """The names of one version of CityGML, with prefixes; `{}` stands for the level of detail.

    `order` is the order of the contents of a building, `installation_order` that of an installation.
    """

    version: str
    names: Mapping[str, str]
    order: tuple[str, ...]
    installation_order: tuple[str, ...]
    boundary: str
    surfaces: str
    solid: str
    multi: str
    opening: str
    filled: str
    installation: str
    installation_solid: str
    part: str

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


_COMMON = {"xlink": "http://www.w3.org/1999/xlink"}

CITYGML2 = Dialect(
    "2.0",
    {
        "core": "http://www.opengis.net/citygml/2.0",
        "bldg": "http://www.opengis.net/citygml/building/2.0",
        "gen": "http://www.opengis.net/citygml/generics/2.0",
        "gml": "http://www.opengis.net/gml",
        "xAL": "urn:oasis:names:tc:ciq:xsdschema:xAL:2.0",
        **_COMMON,
    },
    ("height", "solid2", "installation", "boundary", "solid3", "part", "address"),
    ("solid2", "solid3", "boundary"),
    boundary="bldg:boundedBy",
    surfaces="bldg",
    solid="bldg:lod{}Solid",
    multi="bldg:lod{}MultiSurface",
    opening="bldg:opening",
    filled="",
    installation="bldg:outerBuildingInstallation",
    installation_solid="bldg:lod{}Geometry",
    part="bldg:consistsOfBuildingPart",
)

CITYGML3 = Dialect(
    "3.0",
    {
        "core": "http://www.opengis.net/citygml/3.0",
        "con": "http://www.opengis.net/citygml/construction/3.0",
        "bldg": "http://www.opengis.net/citygml/building/3.0",
        "gen": "http://www.opengis.net/citygml/generics/3.0",
        "gml": "http://www.opengis.net/gml/3.2",
        "xAL": "urn:oasis:names:tc:ciq:xal:3",
        **_COMMON,
    },
    ("boundary", "solid2", "solid3", "height", "installation", "address", "part"),
    ("boundary", "solid2", "solid3"),
    boundary="core:boundary",
    surfaces="con",
    solid="core:lod{}Solid",
    multi="core:lod{}MultiSurface",
    opening="con:fillingSurface",
    filled="Surface",
    installation="bldg:buildingInstallation",
    installation_solid="core:lod{}Solid",
    part="bldg:buildingPart",
)
