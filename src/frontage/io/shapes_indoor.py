"""IndoorGML 1.0: the cells (rooms) as features, with the graph of states and transitions."""

from collections.abc import Callable

import numpy as np
from lxml import etree

from frontage.model import Feature, Shape
from frontage.model.shape import CellGraph

_HREF = "{http://www.w3.org/1999/xlink}href"


def indoor_feature(root: etree._Element, shapes_of: Callable[[etree._Element], tuple[Shape, ...]]) -> Feature:
    """One feature for the file: its cells as parts, with their graph.

    `shapes_of` gives the geometries below an element. Raises ValueError on a position that is no point.
    """
    cells = _members(root, "cellSpaceMember")
    states = _members(root, "stateMember")
    transitions = _members(root, "transitionMember")
    graph = CellGraph(
        {_id(c): _links(c, "duality")[0] if _links(c, "duality") else "" for c in cells},
        {_id(s): _links(s, "duality")[0] if _links(s, "duality") else "" for s in states},
        {_id(s): spot for s in states if (spot := _position(s)) is not None},
        {_id(t): tuple(_links(t, "connects")) for t in transitions},
    )
    parts = tuple(Feature(_id(c), _local(c), shapes_of(c)) for c in cells)
    return Feature(_id(root) or "IndoorFeatures", "IndoorFeatures", (), parts, graph)


def _members(root: etree._Element, name: str) -> list[etree._Element]:
    return [c for m in root.iter() if _local(m) == name for c in m if isinstance(c.tag, str)]


def _local(element: etree._Element) -> str:
    return etree.QName(element).localname if isinstance(element.tag, str) else ""


def _id(element: etree._Element) -> str:
    return next((str(v) for k, v in element.attrib.items() if etree.QName(k).localname == "id"), "")


def _links(element: etree._Element, name: str) -> list[str]:
    """What the properties of a name refer to."""
    return [c.get(_HREF, "").removeprefix("#") for c in element if _local(c) == name and c.get(_HREF)]


def _position(state: etree._Element) -> tuple[float, float, float] | None:
    """The point of a state; None without one, or in two dimensions."""
    text = next((e.text or "" for e in state.iter() if _local(e) == "pos"), "")
    values = np.array(text.split(), np.float64)
    return (float(values[0]), float(values[1]), float(values[2])) if len(values) == 3 else None
