"""The footprints inside CityGML 1, 2 and 3. Entities are not resolved, DTDs and the network not used."""

import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from lxml import etree

from frontage.geometry.arrays import Float
from frontage.io.outlines import Outline, Polygons

_GROUND = "GroundSurface"
_LOD = re.compile(r"lod(\d)")
_GEOGRAPHIC = re.compile(r"(^|:)(4326|4258|4979|4937)$")


def citygml_outlines(path: Path) -> tuple[list[Outline], str | None]:
    """Every building with its ground polygons (or its coarsest geometry), and the CRS that the file names.

    Raises lxml's XMLSyntaxError on damaged XML, ValueError when it is no city model.
    """
    parser = etree.XMLParser(resolve_entities=False, no_network=True, load_dtd=False, huge_tree=False)
    tree = etree.parse(str(path), parser)
    root = tree.getroot()
    if tree.docinfo.doctype:
        raise ValueError("it has a document type declaration, which is not accepted")
    if _local(root) != "CityModel":
        raise ValueError(f"its root is {_local(root)}, not CityModel")
    srs = next((e.get("srsName") for e in root.iter() if isinstance(e.tag, str) and e.get("srsName")), None)
    srs = (
        None if srs is not None and srs.startswith("#") else srs
    )  # a local engineering CRS defined in the file
    formal = srs is not None and srs.startswith(
        ("urn:", "http")
    )  # these forms keep the authority's axis order
    swap = srs is not None and formal and bool(_GEOGRAPHIC.search(srs.split("/")[-1]))
    buildings = [e for e in root.iter() if _local(e) == "Building"]
    found = [_outline(b, k, swap) for k, b in enumerate(buildings, 1)]
    return [o for o in found if o.polygons], srs


def _local(element: etree._Element) -> str:
    """The tag without its namespace; comments and instructions have none."""
    return etree.QName(element).localname if isinstance(element.tag, str) else ""


def _outline(building: etree._Element, number: int, swap: bool) -> Outline:
    name = next(
        (v for k, v in building.attrib.items() if etree.QName(k).localname == "id"), f"building{number}"
    )
    return Outline(str(name), _polygons(building, swap), _address(building))


def _polygons(building: etree._Element, swap: bool) -> Polygons:
    """Ground surfaces, else the coarsest level of detail, else every polygon; latitude first is turned."""
    ground = [p for e in building.iter() if _local(e) == _GROUND for p in _rings(e)]
    if not ground:
        levels = sorted((m[1], k) for k, e in enumerate(building.iter()) if (m := _LOD.match(_local(e))))
        elements = list(building.iter())
        for lod in dict.fromkeys(level for level, _ in levels):
            ground = [p for level, k in levels if level == lod for p in _rings(elements[k])]
            if ground:
                break
    ground = ground or list(_rings(building))
    return tuple(p[:, [1, 0, 2]] if swap else p for p in ground)


def _rings(element: etree._Element) -> Iterator[Float]:
    """Outer rings (k, 3) of the polygons below an element."""
    for polygon in element.iter():
        if _local(polygon) == "exterior" and (ring := _ring(polygon)) is not None:
            yield ring


def _ring(exterior: etree._Element) -> Float | None:
    """posList, or a row of pos or Point, as (k, 3)."""
    texts, dimension = [], 3
    for e in exterior.iter():
        if _local(e) in ("posList", "pos"):
            texts.append(e.text or "")
            dimension = int(e.get("srsDimension", dimension))
    values = np.array(" ".join(texts).split(), np.float64)
    if not len(values):
        return None
    if len(values) % dimension:
        raise ValueError("a ring with a broken coordinate list")
    ring = values.reshape(-1, dimension)
    return ring if dimension == 3 else np.column_stack([ring, np.zeros(len(ring))])


def _address(building: etree._Element) -> str | None:
    """ "number street" of the first xAL address, or None."""
    text = {
        _local(e): (e.text or "").strip()
        for e in building.iter()
        if _local(e) in ("ThoroughfareName", "ThoroughfareNumber", "NameElement", "Number")
    }
    street = text.get("ThoroughfareName") or text.get("NameElement")
    number = text.get("ThoroughfareNumber") or text.get("Number")
    return " ".join(v for v in (number, street) if v) or None if street else None
