"""Writing CityGML 2.0, LoD2: buildings as solids of roof, wall and ground surfaces."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from lxml import etree

from frontage.geometry.arrays import Float
from frontage.io.address import split_address
from frontage.io.crs import parse_crs
from frontage.io.files import whole_file
from frontage.model import Surface, WorldRef
from frontage.model.citymodel import CityBuilding, Shell

_NAMES = {
    "core": "http://www.opengis.net/citygml/2.0",
    "bldg": "http://www.opengis.net/citygml/building/2.0",
    "gml": "http://www.opengis.net/gml",
    "xAL": "urn:oasis:names:tc:ciq:xsdschema:xAL:2.0",
    "xlink": "http://www.w3.org/1999/xlink",
}
_MANY = 3  # corners of a ring at least

_Node = Any  # an lxml element


def write_citygml(path: str | Path, buildings: Sequence[CityBuilding], world: WorldRef, title: str) -> Path:
    """Write the LoD2 shell of every building; polygons are in local metres of `world`, written to 0.1 mm.

    Raises FileError (cannot be written), CrsError, ValueError for a building without a shell of LoD2.
    """
    root = etree.Element(_tag("core:CityModel"), nsmap=_NAMES)
    _add(root, "gml:name", title)
    rings = [world.to_world(s.ring) for b in buildings for s in _lod2(b).surfaces]
    _envelope(root, np.vstack(rings), world.crs)
    for b in buildings:
        _building(_add(root, "core:cityObjectMember"), b, world)
    p = Path(path)
    with whole_file(p) as temporary:
        etree.ElementTree(root).write(
            str(temporary), xml_declaration=True, encoding="UTF-8", pretty_print=True
        )
    return p


def _tag(name: str) -> str:
    prefix, local = name.split(":")
    return f"{{{_NAMES[prefix]}}}{local}"


def _add(parent: _Node, name: str, text: str | None = None, **attributes: str) -> _Node:
    """A child element; attributes are named prefix_local."""
    named = {_tag(k.replace("_", ":", 1)) if "_" in k else k: v for k, v in attributes.items()}
    element: _Node = etree.SubElement(parent, _tag(name), named)
    element.text = text
    return element


def _lod2(building: CityBuilding) -> Shell:
    found = [shell for shell in building.shells if shell.lod.startswith("2")]
    if not found:
        raise ValueError(f"{building.id} has no shell of LoD2")
    return found[0]


def _envelope(root: _Node, xyz: Float, crs: str | None) -> None:
    box = _add(_add(root, "gml:boundedBy"), "gml:Envelope", srsDimension="3")
    if crs is not None and (name := _srs(crs)):
        box.set("srsName", name)
    _add(box, "gml:lowerCorner", _numbers(xyz.min(0)))
    _add(box, "gml:upperCorner", _numbers(xyz.max(0)))


def _srs(crs: str) -> str | None:
    """The URN of a CRS code, of a compound its parts' ("urn:ogc:def:crs,crs:EPSG::25832,crs:EPSG::7837")."""
    found = parse_crs(crs)
    authority = found.to_authority()
    if authority:
        return f"urn:ogc:def:crs:{authority[0]}::{authority[1]}"
    parts = [part.to_authority() for part in found.sub_crs_list]
    if not parts or None in parts:
        return None
    return "urn:ogc:def:crs," + ",".join(f"crs:{p[0]}::{p[1]}" for p in parts if p)


def _building(member: _Node, building: CityBuilding, world: WorldRef) -> None:
    """Attributes, the solid that refers to its polygons, the surfaces that hold them, the address."""
    shell = _lod2(building)
    name = _identifier(building.id)
    node = _add(member, "bldg:Building", gml_id=name)
    height = building.attributes.get("measuredHeight")
    if height is not None:
        _add(node, "bldg:measuredHeight", f"{float(height):.2f}", uom="m")
    solid = _add(_add(node, "bldg:lod2Solid"), "gml:Solid", gml_id=f"{name}_solid")
    shared = _add(_add(solid, "gml:exterior"), "gml:CompositeSurface")
    for number, surface in enumerate(s for s in shell.surfaces if len(s.ring) >= _MANY):
        part = f"{name}_s{number}"
        _add(shared, "gml:surfaceMember", xlink_href=f"#{part}_polygon")
        _surface(_add(node, "bldg:boundedBy"), surface, part, world)
    if building.address:
        _address(_add(node, "bldg:address"), building.address)


def _identifier(text: str) -> str:
    """An XML name: letters, digits, dot, dash and underscore, a letter first."""
    clean = "".join(c if c.isalnum() or c in ".-_" else "_" for c in text)
    return clean if clean[:1].isalpha() else f"id_{clean}"


def _surface(parent: _Node, surface: Surface, name: str, world: WorldRef) -> None:
    node = _add(parent, f"bldg:{surface.semantics}", gml_id=name)
    members = _add(_add(node, "bldg:lod2MultiSurface"), "gml:MultiSurface")
    polygon = _add(_add(members, "gml:surfaceMember"), "gml:Polygon", gml_id=f"{name}_polygon")
    for place, ring in (("exterior", surface.ring), *(("interior", hole) for hole in surface.holes)):
        closed = world.to_world(np.vstack([ring, ring[:1]]))
        line = _add(_add(polygon, f"gml:{place}"), "gml:LinearRing")
        _add(line, "gml:posList", _numbers(closed.ravel()), srsDimension="3")


def _numbers(values: Float) -> str:
    return " ".join(f"{v:.4f}" for v in values)


def _address(parent: _Node, address: str) -> None:
    number, street = split_address(address)
    node = _add(_add(parent, "core:Address"), "core:xalAddress")
    country = _add(_add(node, "xAL:AddressDetails"), "xAL:Country")
    place = _add(_add(country, "xAL:Locality", Type="Town"), "xAL:Thoroughfare", Type="Street")
    if number:
        _add(place, "xAL:ThoroughfareNumber", number)
    _add(place, "xAL:ThoroughfareName", street)
