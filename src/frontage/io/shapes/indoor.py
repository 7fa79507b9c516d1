"""IndoorGML 1.0: the cells (rooms) as features, with the graph of states and transitions."""

from collections.abc import Callable

from lxml import etree

from frontage.io.citymodels.citygml.geometry import HREF, identifier, local, position
from frontage.model import Feature, Shape
from frontage.model.shape import CellGraph


def indoor_feature(root: etree._Element, shapes_of: Callable[[etree._Element], tuple[Shape, ...]]) -> Feature:
    """One feature for the whole file: its cells are the parts, and it has their graph.

    `shapes_of` returns the geometries below an element. Raises ValueError for a position that is not a point.
    """
    cells = _members(root, "cellSpaceMember")
    states = _members(root, "stateMember")
    transitions = _members(root, "transitionMember")
    graph = CellGraph(
        {identifier(c): _links(c, "duality")[0] if _links(c, "duality") else "" for c in cells},
        {identifier(s): _links(s, "duality")[0] if _links(s, "duality") else "" for s in states},
        {identifier(s): spot for s in states if (spot := _position(s)) is not None},
        {identifier(t): tuple(_links(t, "connects")) for t in transitions},
    )
    parts = tuple(Feature(identifier(c), local(c), shapes_of(c)) for c in cells)
    return Feature(identifier(root) or "IndoorFeatures", "IndoorFeatures", (), parts, graph)


def _members(root: etree._Element, name: str) -> list[etree._Element]:
    return [c for m in root.iter() if local(m) == name for c in m if isinstance(c.tag, str)]


def _links(element: etree._Element, name: str) -> list[str]:
    """The ids that the properties with a name refer to."""
    return [c.get(HREF, "").removeprefix("#") for c in element if local(c) == name and c.get(HREF)]


def _position(state: etree._Element) -> tuple[float, float, float] | None:
    """The point (x, y, z) of a state; None without one."""
    point = position(state)
    return None if point is None else (float(point[0]), float(point[1]), float(point[2]))
