"""Features of a mesh with their properties: EXT_mesh_features and EXT_structural_metadata of glTF.

A feature is what a person would click on: a window, a door. Its vertices carry its number, and a table holds
what is known of it, column by column.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from frontage.geometry.arrays import Float

MESH_FEATURES, STRUCTURAL_METADATA = "EXT_mesh_features", "EXT_structural_metadata"
FEATURE_ID = "_FEATURE_ID_0"
_UNKNOWN = -9999  # stands for a number that is not known
_ALIGNED = 8  # bytes: columns begin at multiples

Value = str | float | int | None
AddView = Callable[[bytes, int], int]
"""Takes the bytes of a column and the alignment; returns the number of their buffer view."""


@dataclass(frozen=True, eq=False)
class Property:
    """A column of a feature table.

    kind    "text", "real", "whole", or "points": a list of points (k, 3) per feature
    values  one per feature; None = not known
    """

    name: str
    kind: Literal["text", "real", "whole", "points"]
    about: str
    values: Sequence[Value | Float]


@dataclass(frozen=True, eq=False)
class FeatureTable:
    """Features of one class; their numbers are their rows."""

    name: str
    count: int
    properties: tuple[Property, ...]


def metadata(table: FeatureTable, add: AddView) -> dict[str, Any]:
    """Return the extension EXT_structural_metadata of a file with one table."""
    schema = {
        "id": "frontage",
        "classes": {table.name: {"properties": {p.name: _described(p) for p in table.properties}}},
    }
    columns = {p.name: _column(p, add) for p in table.properties}
    held = {"name": f"{table.name}s", "class": table.name, "count": table.count, "properties": columns}
    return {"schema": schema, "propertyTables": [held]}


def marked(table: FeatureTable, present: int) -> dict[str, Any]:
    """Return the extension EXT_mesh_features of a primitive that shows `present` features of the table.

    Vertices of nothing have the number behind the last one.
    """
    ids = {"featureCount": present, "nullFeatureId": table.count, "attribute": 0, "propertyTable": 0}
    return {"featureIds": [{**ids, "label": f"{table.name}s"}]}


def _described(p: Property) -> dict[str, Any]:
    about: dict[str, Any] = {"description": p.about}
    if p.kind == "text":
        return {**about, "type": "STRING", "noData": ""}
    if p.kind == "points":
        return {**about, "type": "VEC3", "componentType": "FLOAT64", "array": True}
    number = {"type": "SCALAR", "componentType": "FLOAT64" if p.kind == "real" else "INT32"}
    return {**about, **number, "noData": _UNKNOWN}


def _column(p: Property, add: AddView) -> dict[str, int]:
    if p.kind in ("real", "whole"):
        known = [_UNKNOWN if v is None else v for v in p.values]
        return {"values": add(np.array(known, "<f8" if p.kind == "real" else "<i4").tobytes(), _ALIGNED)}
    if p.kind == "text":
        rows = [str(v or "").encode() for v in p.values]
        sizes, offsets = [len(row) for row in rows], "stringOffsets"
        data = b"".join(rows)
    else:
        points = [np.asarray(v, "<f8").reshape(-1, 3) for v in p.values]
        sizes, offsets = [len(own) for own in points], "arrayOffsets"
        data = b"".join(own.tobytes() for own in points)
    ends = np.concatenate([[0], np.cumsum(sizes)]).astype("<u4")
    # A buffer view may not be empty.
    return {"values": add(data or b"\0", _ALIGNED), offsets: add(ends.tobytes(), _ALIGNED)}
