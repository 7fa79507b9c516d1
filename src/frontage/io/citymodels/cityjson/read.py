"""Reading CityJSON 1.0 to 2.0 and CityJSONSeq as a stream: all vertices, but one object at a time."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from frontage.geometry.arrays import Float
from frontage.io.citymodels.cityjson.base import transform_of, vertex_table
from frontage.io.citymodels.cityjson.objects import Corners, building_of, families
from frontage.io.citymodels.deferred import DeferredPlacement
from frontage.io.citymodels.draft import BuildingDraft
from frontage.io.citymodels.jsonstream import members

_BLOCK = 1 << 16  # vertices that are collected before they become an array


def read_cityjson(path: Path, place: DeferredPlacement) -> Iterator[BuildingDraft]:
    """Yield the buildings that touch the bounds, in the order of the file.

    A CityJSON object is read two or three times, because its vertices may stand at its end, and parts far
    from their buildings.

    Raises ValueError naming what is wrong.
    """
    model = _survey(path)
    scale, shift = _stated(model.head, place)
    templates = model.head.get("geometry-templates") or {}
    if model.goes_on:
        for feature in _features(path):
            appearance = feature.get("appearance") or {}
            vertices = vertex_table(feature.get("vertices", [])) * scale + shift
            corners = Corners.of(vertices, templates, appearance)
            objects = feature["CityObjects"]
            for key, family in families(objects).items():
                draft = building_of(key, family, objects, corners)
                if place.touches(draft.points()):
                    yield draft
        return
    appearance = model.head.get("appearance") or {}
    corners = Corners.of(model.vertices.table() * scale + shift, templates, appearance)
    found = families(model.relations)
    if place.bounded:
        found = _near(path, found, corners, place)
    yield from _families(path, found, corners)


def _survey(path: Path) -> "_Model":
    """Survey the first object of a file; of its city objects only the relations are kept."""
    model = _Model()
    for document, name, key, value in members(path, ("CityObjects", "vertices")):
        if document:
            model.goes_on = True
            break
        if name == "CityObjects" and key is not None:
            model.relations[key] = {k: value[k] for k in ("type", "parents", "children") if k in value}
        elif name == "vertices" and key is not None:
            model.vertices.add(value)
        else:
            model.head[name] = value
    return model


def _features(path: Path) -> Iterator[dict[str, Any]]:
    """Yield the objects after the first one."""
    feature: dict[str, Any] = {}
    last = 1
    for document, name, _, value in members(path):
        if document > last:
            yield _checked(feature, last)
            feature, last = {}, document
        if document:
            feature[name] = value
    yield _checked(feature, last)


def _checked(feature: dict[str, Any], number: int) -> dict[str, Any]:
    if feature.get("type") != "CityJSONFeature" or not isinstance(feature.get("CityObjects"), dict):
        raise ValueError(f"line {number + 1}: an object of type {feature.get('type')!r} instead of a feature")
    return feature


def _near(
    path: Path, found: dict[str, list[str]], corners: Corners, place: DeferredPlacement
) -> dict[str, list[str]]:
    """The families with a member that touches the bounds."""
    near = set()
    for _, name, key, value in members(path, ("CityObjects",)):
        if name == "CityObjects" and key is not None:
            points = building_of(key, [key], {key: value}, corners).points()
            near |= {key} if place.touches(points) else set()
    return {root: family for root, family in found.items() if not near.isdisjoint(family)}


def _families(path: Path, found: dict[str, list[str]], corners: Corners) -> Iterator[BuildingDraft]:
    """Yield every family as soon as all of its members have been read."""
    root_of = {member: root for root, family in found.items() for member in family}
    waiting: dict[str, dict[str, Any]] = {}
    for _, name, key, value in members(path, ("CityObjects",)):
        if name != "CityObjects" or key not in root_of:
            continue
        root = root_of[key]
        family = waiting.setdefault(root, {})
        family[key] = value
        if len(family) == len(found[root]):
            yield building_of(root, found[root], waiting.pop(root), corners)


class _Vertices:
    """A growing table of vertices that takes little memory."""

    def __init__(self) -> None:
        self._blocks: list[Float] = []
        self._rows: list[Any] = []

    def add(self, row: Any) -> None:
        """Append a vertex."""
        self._rows.append(row)
        if len(self._rows) == _BLOCK:
            self._blocks.append(vertex_table(self._rows))
            self._rows = []

    def table(self) -> Float:
        """All vertices (v, 3)."""
        return np.concatenate([*self._blocks, vertex_table(self._rows)])


@dataclass(eq=False)
class _Model:
    """The first object of a file.

    head       its members without city objects and vertices
    relations  type, parents and children of its city objects
    goes_on    whether further objects follow: the file is a sequence
    """

    head: dict[str, Any] = field(default_factory=dict)
    relations: dict[str, Any] = field(default_factory=dict)
    vertices: _Vertices = field(default_factory=_Vertices)
    goes_on: bool = False


def _stated(head: Mapping[str, Any], place: DeferredPlacement) -> tuple[Float, Float]:
    """Check the type and version, pass on the CRS, and return scale and shift (3,) of the vertices."""
    if head.get("type") != "CityJSON":
        raise ValueError(f"it is JSON of type {head.get('type')!r}, not CityJSON")
    place.state_crs((head.get("metadata") or {}).get("referenceSystem"), east_first=True)
    return transform_of(head)
