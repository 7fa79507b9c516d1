"""Writing CityGML 2.0 and 3.0, LoD2 and LoD3: buildings as solids of thematic surfaces with openings."""

from collections.abc import Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

import numpy as np
from lxml import etree

from frontage.geometry.arrays import Float
from frontage.io.axes import north_first
from frontage.io.citymodels.citygml.appearance import Appearance
from frontage.io.citymodels.citygml.dialect import CITYGML2, CITYGML3, Dialect, Node
from frontage.io.crs import parse_crs
from frontage.io.files import whole_file
from frontage.model import Surface, WorldRef
from frontage.model.citymodel import CityBuilding, Shell, Texture

_CORNERS = 3  # of a ring, at least
_OPENINGS = ("Window", "Door")
_HELD = ("parent", "measuredHeight")  # attributes with elements of their own


def write_citygml(
    path: str | Path,
    buildings: Sequence[CityBuilding],
    world: WorldRef,
    title: str,
    version: Literal["2.0", "3.0"] = "2.0",
    left_out: Sequence[str] = (),
) -> Path:
    """Write the shells of LoD2 and LoD3 of every building, its parts and installations.

    Polygons are in local metres of `world` and are written to 0.1 mm, with the axes in the order of the
    authority of the CRS, which is named by its URN. A solid of version 3.0 refers to the polygons of the
    thematic surfaces; one of 2.0 repeats them, because GDAL and what is built on it follow no references.
    Textures lie on the polygons of the thematic surfaces and refer to their pictures. A window or door is put
    into the wall that its attribute `parent` names. Attributes of buildings, and of surfaces of LoD3, become
    generic attributes. `left_out`, sentences on what the model does not show, are its description.

    Raises FileError when the file cannot be written, CrsError, and ValueError for a building without such a
    shell.
    """
    srs = None if world.crs is None else _srs(world.crs)
    turned = world.crs is not None and srs is not None and north_first(parse_crs(world.crs))
    writer = _Writer(CITYGML2 if version == "2.0" else CITYGML3, world, srs, turned)
    shown = [s for b in buildings for s in _shown(b)]
    root = writer.dialect.make("core:CityModel", xsi_schemaLocation=writer.dialect.schema_location)
    if left_out:
        writer.dialect.add(root, "gml:description", f"Left out: {' '.join(left_out)}")
    writer.dialect.add(root, "gml:name", title)
    corners = np.vstack([s.ring for shell in shown for s in shell.surfaces])
    writer.envelope(root, world.to_world(corners))
    for b in buildings:
        writer.building(writer.dialect.add(root, "core:cityObjectMember"), b)
    writer.appearance.write(writer.dialect, root)
    etree.cleanup_namespaces(root, keep_ns_prefixes=list(writer.dialect.names))
    p = Path(path)
    with whole_file(p) as temporary, open(temporary, "wb") as file:
        etree.ElementTree(root).write(file, xml_declaration=True, encoding="UTF-8", pretty_print=True)
    return p


def _shown(building: CityBuilding) -> list[Shell]:
    found = [s for s in building.shells if _level(s) in ("2", "3")]
    if not found:
        raise ValueError(f"{building.id} has no shell of LoD2 or LoD3 that could be written")
    return found


def _level(shell: Shell) -> str:
    return shell.lod[:1]


def _kind(shell: Shell) -> str:
    """What a shell other than the building's own is, as a key of `Dialect.members`."""
    return "frame" if shell.frame_of else "installation" if shell.installation else "part"


@dataclass(eq=False)
class _Writer:
    """One file: its dialect, its world, and the identifiers that are in use.

    srs          the URN of the CRS
    north_first  whether the authority of the CRS puts north before east, which the URN obliges to
    openings     the identifiers of windows and doors by their names in the shells of LoD3
    """

    dialect: Dialect
    world: WorldRef
    srs: str | None
    north_first: bool
    given: set[str] = field(default_factory=set)
    appearance: Appearance = field(default_factory=Appearance)
    openings: dict[str, str] = field(default_factory=dict)

    def envelope(self, root: Node, xyz: Float) -> None:
        """Write the bounding box of points (n, 3) m world, with the CRS."""
        box = self.dialect.add(self.dialect.add(root, "gml:boundedBy"), "gml:Envelope", srsDimension="3")
        if self.srs:
            box.set("srsName", self.srs)
        self.dialect.add(box, "gml:lowerCorner", _numbers(self.ordered(xyz).min(0)))
        self.dialect.add(box, "gml:upperCorner", _numbers(self.ordered(xyz).max(0)))

    def ordered(self, xyz: Float) -> Float:
        """Points (n, 3) m world with the axes in the order of the CRS as it is named."""
        return xyz[:, [1, 0, 2]] if self.north_first else xyz

    def building(self, member: Node, building: CityBuilding) -> None:
        """Write a building with its parts and installations."""
        shells: dict[str, list[Shell]] = {}
        for shell in _shown(building):
            shells.setdefault(shell.part, []).append(shell)
        node = self.dialect.add(member, "bldg:Building", gml_id=self.identifier(building.id))
        inside = self.contents(node, shells.pop("", []), building.attributes)
        if building.address:
            inside["address"].append(self.dialect.address(building.address))
        for name, own in shells.items():
            kind = _kind(own[0])
            names = self.dialect.members[kind]
            holder = self.dialect.make(names.holder)
            part = self.dialect.add(holder, names.object, gml_id=self.identifier(name))
            if (opening := self.openings.get(own[0].frame_of)) is not None:
                self.dialect.relation(part, "frame of", opening)
            self.fill(part, self.contents(part, own, own[0].attributes), names.order)
            inside[kind].append(holder)
        self.fill(node, inside, self.dialect.order)

    def fill(self, node: Node, inside: Mapping[str, Sequence[Node]], order: Sequence[str]) -> None:
        """Append the contents in the order that the schema requires."""
        for name in order:
            node.extend(inside[name])

    def contents(
        self, node: Node, shells: Sequence[Shell], attributes: Mapping[str, Any]
    ) -> dict[str, list[Node]]:
        """Make the attributes, the thematic surfaces, and the solids that refer to their polygons."""
        inside: dict[str, list[Node]] = {name: [] for name in self.dialect.order}
        self.attributes(node, attributes)
        if (height := attributes.get("measuredHeight")) is not None:
            inside["height"].append(self.dialect.height(float(height)))
        for shell in shells:
            lod = _level(shell)
            names = self.dialect.members.get(_kind(shell)) if shell.part else None
            holder = self.dialect.make((names.geometry if names else self.dialect.solid).format(lod))
            if shell.frame_of:
                self.frame(holder, shell)
                inside[f"geometry{lod}"].append(holder)
                continue
            polygons = self.surfaces(inside["boundary"], shell)
            if not shell.closed or inside[f"geometry{lod}"]:
                continue
            name = self.identifier(f"solid_{polygons[0].get(self.dialect.tag('gml:id'))}")
            self.shared(self.dialect.shell(self.dialect.add(holder, "gml:Solid", gml_id=name)), polygons)
            inside[f"geometry{lod}"].append(holder)
        return inside

    def shared(self, around: Node, polygons: Sequence[Node]) -> None:
        """Append the polygons of thematic surfaces to a solid: copies without ids, or references to them."""
        name = self.dialect.tag("gml:id")
        for polygon in polygons:
            if self.dialect.version == "3.0":
                self.dialect.add(around, "gml:surfaceMember", xlink_href=f"#{polygon.get(name)}")
                continue
            again = deepcopy(polygon)
            for element in again.iter():
                element.attrib.pop(name, None)
            self.dialect.add(around, "gml:surfaceMember").append(again)

    def frame(self, holder: Node, shell: Shell) -> None:
        """Write the polygons of a window's frame, which belong to no thematic surface.

        A model holds many more of them than of others, so that no tag is looked up twice.
        """
        identifier = self.identifier(f"{shell.part}_surface")
        around = self.dialect.add(holder, "gml:MultiSurface", gml_id=identifier)
        member, polygon, exterior, interior, line, numbers, name = (
            self.dialect.tag(f"gml:{n}")
            for n in (
                "surfaceMember", "Polygon", "exterior", "interior", "LinearRing", "posList", "id",
            )
        )  # fmt: skip
        rings = [np.vstack([r, r[:1]]) for s in shell.surfaces for r in (s.ring, *s.holes)]
        points = self.ordered(self.world.to_world(np.concatenate(rings))).tolist()
        texts = [f"{x:.4f} {y:.4f} {z:.4f}" for x, y, z in points]
        begin = 0
        for k, s in enumerate(shell.surfaces):
            here = etree.SubElement(
                etree.SubElement(around, member), polygon, {name: self.identifier(f"{shell.part}_{k}")}
            )
            for number, ring in enumerate((s.ring, *s.holes)):
                end = begin + len(ring) + 1
                border = etree.SubElement(etree.SubElement(here, interior if number else exterior), line)
                corners: Node = etree.SubElement(border, numbers, srsDimension="3")
                corners.text = " ".join(texts[begin:end])
                begin = end

    def attributes(self, node: Node, attributes: Mapping[str, Any]) -> None:
        """Append generic attributes, without those that have elements of their own."""
        for name, value in attributes.items():
            if name not in _HELD:
                self.dialect.attribute(node, name, value)

    def surfaces(self, boundary: list[Node], shell: Shell) -> list[Node]:
        """Append the thematic surfaces of a shell, openings in their walls; returns all polygons."""
        groups: dict[tuple[str, str], list[Surface]] = {}
        for k, s in enumerate(s for s in shell.surfaces if len(s.ring) >= _CORNERS):
            groups.setdefault((s.source_id or f"{shell.part or 'surface'}/{k}", s.semantics), []).append(s)
        nodes: dict[str, Node] = {}
        walls: list[Node] = []
        found: list[Node] = []
        for opening in (False, True):
            for (name, semantics), own in groups.items():
                if (semantics in _OPENINGS) != opening:
                    continue
                node, polygons = self.thematic(name, own, shell, opening and bool(walls))
                found += polygons
                if opening and walls:
                    wall = nodes.get(str(shell.about.get(name, {}).get("parent", "")), walls[0])
                    self.dialect.add(wall, self.dialect.opening).append(node)
                    continue
                nodes[name] = node
                walls += [node] if semantics == "WallSurface" else []
                holder = self.dialect.make(self.dialect.boundary)
                holder.append(node)
                boundary.append(holder)
        return found

    def thematic(
        self, name: str, own: Sequence[Surface], shell: Shell, opening: bool
    ) -> tuple[Node, list[Node]]:
        """Make a thematic surface with its polygons; an opening in a shell without walls becomes a wall."""
        semantics = own[0].semantics
        if semantics in _OPENINGS and not opening:
            semantics = "WallSurface"
        clean = self.identifier(name)
        if opening and _level(shell) == "3":
            self.openings[name] = clean
        node = self.dialect.make(self.dialect.surface(semantics, opening), gml_id=clean)
        about = shell.about.get(name, {}) if _level(shell) == "3" else {}
        self.attributes(node, {**({"id": name} if about else {}), **about})
        members = self.dialect.add(
            self.dialect.add(node, self.dialect.multi.format(_level(shell))), "gml:MultiSurface"
        )
        if self.dialect.version == "3.0":
            members.set(self.dialect.tag("gml:id"), self.identifier(f"{clean}_surface"))
        texture = shell.textures.get(name)
        return node, [
            self.polygon(self.dialect.add(members, "gml:surfaceMember"), s, clean, texture) for s in own
        ]

    def polygon(self, parent: Node, surface: Surface, name: str, texture: Texture | None) -> Node:
        """Write a polygon with closed rings, which have ids where a texture refers to them."""
        name = self.identifier(f"{name}_polygon")
        polygon = self.dialect.add(parent, "gml:Polygon", gml_id=name)
        lines = []
        for place, ring in (("exterior", surface.ring), *(("interior", hole) for hole in surface.holes)):
            closed = self.ordered(self.world.to_world(np.vstack([ring, ring[:1]])))
            lines.append(self.dialect.add(self.dialect.add(polygon, f"gml:{place}"), "gml:LinearRing"))
            self.dialect.add(lines[-1], "gml:posList", _numbers(closed.ravel()), srsDimension="3")
        if texture is not None:
            rings = [self.identifier(f"{name}_ring{k}") for k in range(len(lines))]
            for line, ring_name in zip(lines, rings, strict=True):
                line.set(self.dialect.tag("gml:id"), ring_name)
            self.appearance.add(texture, name, rings)
        return polygon

    def identifier(self, text: str) -> str:
        """A new XML name made of a text: letters, digits and ".-_", beginning with a letter."""
        clean = "".join(c if c.isalnum() or c in ".-_" else "_" for c in text)
        clean = name = clean if clean[:1].isalpha() else f"id_{clean}"
        number = 2
        while name in self.given:
            name, number = f"{clean}_{number}", number + 1
        self.given.add(name)
        return name


def _srs(crs: str) -> str | None:
    """The URN of a CRS, such as "urn:ogc:def:crs:EPSG::25832"; a compound one lists its parts.

    None when it, or a part of it, has no code.
    """
    found = parse_crs(crs)
    authority = found.to_authority()
    if authority:
        return f"urn:ogc:def:crs:{authority[0]}::{authority[1]}"
    parts = [part.to_authority() for part in found.sub_crs_list]
    if not parts or None in parts:
        return None
    return "urn:ogc:def:crs," + ",".join(f"crs:{p[0]}::{p[1]}" for p in parts if p)


def _numbers(values: Float) -> str:
    return " ".join(f"{v:.4f}" for v in values)
