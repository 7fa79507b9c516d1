"""What the specifications of 3D Tiles 1.1 and of two extensions of glTF 2.0 demand of what Frontage writes.

`TILESET`, `MESH_FEATURES` and `STRUCTURAL_METADATA` are JSON schemas of our own, written from the text of the
specifications. They allow only what Frontage uses, so they are stricter than the published ones. `published`
gives those where they are kept beside the checkout.
"""

import json
import os
from functools import cache
from pathlib import Path
from typing import Any

import pytest
from jsonschema import Draft202012Validator
from referencing import Registry
from referencing.jsonschema import DRAFT202012

from realdata import DATA

FOLDER = "FRONTAGE_TILES_SCHEMAS"
"""Environment variable: a folder with the published schemas, from the repositories 3d-tiles and glTF."""

Json = dict[str, Any]


def _numbers(count: int) -> Json:
    return {"type": "array", "items": {"type": "number"}, "minItems": count, "maxItems": count}


def _only(required: Json, **optional: Json) -> Json:
    """The schema of an object with these members and no others."""
    return {"type": "object", "properties": {**required, **optional}, "required": list(required),
            "additionalProperties": False}  # fmt: skip


def _one_of_key(**members: Json) -> Json:
    return {"oneOf": [_only({name: schema}) for name, schema in members.items()]}


_COUNT = {"type": "integer", "minimum": 0}
_TEXT = {"type": "string"}
_NAME = {"type": "string", "pattern": "^[a-zA-Z_][a-zA-Z0-9_]*$"}
_ERROR = {"type": "number", "minimum": 0}
_LONGITUDE, _LATITUDE = (
    {"type": "number", "minimum": -limit, "maximum": limit} for limit in (3.14159266, 1.5707964)
)
_REGION = {**_numbers(6), "prefixItems": [_LONGITUDE, _LATITUDE, _LONGITUDE, _LATITUDE]}
_TILE = _only(
    {"boundingVolume": _one_of_key(box=_numbers(12), region=_REGION), "geometricError": _ERROR},
    content=_only({"uri": {**_TEXT, "pattern": r"^[^/\\:]+\.glb$"}}),
    refine={"enum": ["ADD", "REPLACE"]},
    transform=_numbers(16),
    children={"type": "array", "items": {"$ref": "#/$defs/tile"}, "minItems": 1},
    extras={"type": "object"},
)
TILESET = {
    **_only({
        "asset": _only({"version": {"const": "1.1"}}, generator=_TEXT, extras={"type": "object"}),
        "geometricError": _ERROR,
        "root": {"allOf": [{"$ref": "#/$defs/tile"}, {"required": ["refine"]}]},
    }),
    "$defs": {"tile": _TILE},
}  # fmt: skip

MESH_FEATURES = _only({"featureIds": {"type": "array", "minItems": 1, "items": _only(
    {"featureCount": {"type": "integer", "minimum": 1}},
    nullFeatureId=_COUNT, label=_NAME, attribute=_COUNT, propertyTable=_COUNT,
)}})  # fmt: skip

_PROPERTY = {
    "oneOf": [
        _only({"type": {"const": "STRING"}}, noData=_TEXT, description=_TEXT),
        _only({"type": {"const": "SCALAR"}, "componentType": {"enum": ["FLOAT64", "INT32"]}},
              noData={"type": "number"}, description=_TEXT),
        _only({"type": {"const": "VEC3"}, "componentType": {"const": "FLOAT64"}, "array": {"const": True}},
              description=_TEXT),
    ]
}  # fmt: skip
_CLASS = _only({"properties": {"type": "object", "propertyNames": _NAME, "minProperties": 1,
                               "additionalProperties": _PROPERTY}})  # fmt: skip
_COLUMN = _only({"values": _COUNT}, stringOffsets=_COUNT, arrayOffsets=_COUNT)
_TABLE = _only(
    {"class": _NAME, "count": {"type": "integer", "minimum": 1}},
    name=_TEXT, properties={"type": "object", "minProperties": 1, "additionalProperties": _COLUMN},
)  # fmt: skip
STRUCTURAL_METADATA = _only({
    "schema": _only({"id": _NAME, "classes": {"type": "object", "propertyNames": _NAME,
                                              "additionalProperties": _CLASS}}),
    "propertyTables": {"type": "array", "minItems": 1, "items": _TABLE},
})  # fmt: skip


def own(schema: Json) -> Draft202012Validator:
    """The check by a schema of ours."""
    return Draft202012Validator(schema)


def published(name: str) -> Draft202012Validator:
    """The check by a published schema, such as "tileset.schema.json"; skips the test where it is absent."""
    folder = Path(os.environ.get(FOLDER, DATA / "schemas" / "3d-tiles"))
    if not folder.is_dir():
        pytest.skip(f"the schemas of 3D Tiles are absent: name their folder in {FOLDER}")
    files = _files(folder)
    start = files[name][0]
    registry: Registry[Any] = Registry(retrieve=lambda uri: DRAFT202012.create_resource(_read(uri, files)))
    return Draft202012Validator({"$ref": start.as_uri()}, registry=registry)


def _read(uri: str, files: dict[str, list[Path]]) -> Json:
    """The schema of a URI, from another folder if the one that it names has no such file."""
    path = Path(uri.removeprefix("file://"))
    found = path if path.is_file() else files[path.name][0]
    return {**json.loads(found.read_text()), "$id": found.as_uri()}


@cache
def _files(folder: Path) -> dict[str, list[Path]]:
    found = dict[str, list[Path]]()
    for path in sorted(folder.resolve().rglob("*.schema.json"), key=lambda p: (len(p.parts), p)):
        found.setdefault(path.name, []).append(path)
    return found
