"""Reading the geometries of CityJSON 1.0 to 2.0, CityJSONSeq, JSON-FG and tu3djson for validation."""

import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from frontage.errors import UnsupportedFormat
from frontage.geometry.arrays import Float
from frontage.io.citymodels.cityjson.base import template_of, transform_of, vertex_table
from frontage.io.citymodels.jsonstream import parse_json
from frontage.io.degrees import refuse_degrees
from frontage.model import Feature, Polygons, Shape

_SURFACES = ("MultiSurface", "CompositeSurface")
_SOLIDS = ("MultiSolid", "CompositeSolid")


def read_json(path: Path) -> tuple[str, list[Feature]]:
    """Read the features of a file in one of the four formats; returns them with the name of the format.

    Raises ValueError naming what is wrong, and UnsupportedFormat for other kinds of JSON.
    """
    try:
        return _read(path, path.read_text("utf-8-sig"))
    except KeyError as problem:
        raise ValueError(f"the member {problem.args[0]} is missing") from problem


def _read(path: Path, text: str) -> tuple[str, list[Feature]]:
    try:
        data = parse_json(text)
    except json.JSONDecodeError:
        if path.suffix.lower() != ".jsonl" and '"CityJSONFeature"' not in text:
            raise
        return "CityJSONSeq", _sequence(path, text)
    if not isinstance(data, dict):
        raise ValueError("it does not hold a JSON object")
    kind = data.get("type")
    if kind == "CityJSON":
        refuse_degrees(path, _crs(data))
        return f"CityJSON {data.get('version', '')}".strip(), _cityjson(data, data)
    if kind == "tu3djson":
        return "tu3djson", [_tu3d(f, k) for k, f in enumerate(data["features"])]
    if kind in ("FeatureCollection", "Feature"):
        features = data.get("features", [data])
        return "JSON-FG", [_jsonfg(path, f, k) for k, f in enumerate(features)]
    raise UnsupportedFormat(path, f"JSON of type {kind!r} cannot be validated", "name a CityJSON file")


def _crs(head: Mapping[str, Any]) -> str | None:
    """The CRS that a CityJSON object states."""
    metadata = head.get("metadata") or {}
    stated = metadata.get("referenceSystem") if isinstance(metadata, dict) else None
    return stated if isinstance(stated, str) else None


def _sequence(path: Path, text: str) -> list[Feature]:
    """Read CityJSONSeq: the first line states how coordinates are packed, every further line is a feature."""
    head: Any = None
    features: list[Feature] = []
    for number, line in enumerate(text.splitlines(), 1):
        if not line.strip():
            continue
        try:
            data = parse_json(line)
            if head is None:
                head = data
                if data.get("type") != "CityJSON":
                    raise ValueError("the first line is not a CityJSON object")
                transform_of(data)
                refuse_degrees(path, _crs(data))
            elif data.get("type") == "CityJSONFeature":
                features += _cityjson(data, head)
            else:
                raise ValueError(f"an object of type {data.get('type')!r} instead of a feature")
        except UnsupportedFormat:
            raise
        except KeyError as problem:
            raise ValueError(f"line {number}: the member {problem.args[0]} is missing") from problem
        except (ValueError, TypeError) as problem:
            raise ValueError(f"line {number}: {problem}") from problem
    return features


def _cityjson(data: Any, head: Any) -> list[Feature]:
    """The city objects of a CityJSON object or feature.

    The children of a building, and parts of anything, belong to its feature: val3dity judges them together.
    As in val3dity, a single CityJSON object of any version may lack its transform.
    """
    unpacked = data is head and head.get("transform") is None
    scale, shift = (np.ones(3), np.zeros(3)) if unpacked else transform_of(head)
    vertices = vertex_table(data["vertices"]) * scale + shift
    templates = head.get("geometry-templates") or {}
    objects = data["CityObjects"]
    if not isinstance(objects, dict) or not all(isinstance(o, dict) for o in objects.values()):
        raise ValueError("its CityObjects is not an object of objects")
    owner = _owners(objects)
    own: dict[str, list[Feature]] = {}
    for name, o in objects.items():
        shapes = tuple(_geometries(o, vertices, templates, name))
        own.setdefault(owner[name], []).append(Feature(name, str(o["type"]), shapes))
    return [_joined(name, members) for name, members in own.items()]


def _joined(name: str, members: Sequence[Feature]) -> Feature:
    """The feature of that name with the others as its parts."""
    whole = next(f for f in members if f.id == name)
    return replace(whole, parts=tuple(f for f in members if f is not whole))


def _owners(objects: Mapping[str, Any]) -> dict[str, str]:
    """The object that each object is judged with: the topmost one above it, in a circle one of the circle."""
    above: dict[str, str] = {}
    for name, o in objects.items():
        for parent in _names(o, "parents")[:1]:
            part = str(o.get("type")).endswith("Part")
            if parent in objects and (part or objects[parent].get("type") == "Building"):
                above[name] = parent
        for child in _names(o, "children") if o.get("type") == "Building" else ():
            if child in objects:
                above.setdefault(child, name)
    owner: dict[str, str] = {}
    for name in objects:
        path: dict[str, None] = {}
        top = name
        while top in above and top not in owner and top not in path:
            path[top] = None
            top = above[top]
        top = owner.get(top, top)
        owner |= dict.fromkeys([*path, top], top)
    return owner


def _names(city_object: Mapping[str, Any], member: str) -> list[str]:
    stated = city_object.get(member) or []
    if not isinstance(stated, list) or not all(isinstance(name, str) for name in stated):
        raise ValueError(f"{member} is not a list of names")
    return stated


def _geometries(city_object: Any, vertices: Float, templates: Any, name: str) -> Iterable[Shape]:
    stated = city_object.get("geometry") or ()
    if isinstance(stated, dict | str):
        raise ValueError(f"{name}: its geometry is not a list")
    for number, geometry in enumerate(stated):
        try:
            shape = _geometry(geometry, vertices, templates)
        except KeyError as problem:
            raise ValueError(f"{name}, geometry {number}: no member {problem.args[0]}") from problem
        except (IndexError, ValueError) as problem:
            raise ValueError(f"{name}, geometry {number}: {problem}") from problem
        except TypeError as problem:
            text = "its boundaries are not nested as its type requires"
            raise ValueError(f"{name}, geometry {number}: {text}") from problem
        if shape is not None:
            yield shape


def _geometry(geometry: Any, vertices: Float, templates: Any) -> Shape | None:
    """One geometry as a shape; None for points and lines."""
    if not isinstance(geometry, dict):
        raise ValueError("it is not an object")
    if geometry["type"] != "GeometryInstance":
        return _shape(geometry, vertices)
    return _shape(*template_of(geometry, vertices, templates))


def _shape(geometry: Any, vertices: Float) -> Shape | None:
    kind, boundaries = geometry["type"], geometry["boundaries"]
    lod = str(geometry.get("lod", ""))
    if kind in _SURFACES:
        return Shape(kind, ((_surfaces(boundaries, vertices),),), lod)
    if kind == "Solid" or kind in _SOLIDS:
        solids = [boundaries] if kind == "Solid" else _list(boundaries)
        shells = tuple(tuple(_surfaces(s, vertices) for s in _list(solid)) for solid in solids)
        return Shape(kind, shells, lod)
    if kind in ("MultiPoint", "MultiLineString"):
        return None
    raise ValueError(f"a geometry of type {kind!r}")


def _surfaces(polygons: Any, vertices: Float) -> Polygons:
    """Polygons of vertex numbers. Raises TypeError for other nestings, ValueError for unknown vertices."""
    rings = [ring for polygon in _list(polygons) for ring in _list(polygon)]
    numbers = [i for ring in rings for i in _list(ring)]
    if not all(type(i) is int for i in numbers):
        raise TypeError("something else where vertex numbers should be")
    if wrong := [i for i in numbers if not 0 <= i < len(vertices)]:
        raise ValueError(f"a face names vertex {wrong[0]}, but there are only 0 to {len(vertices) - 1}")
    ids = np.array(numbers, np.int64)
    faces = np.cumsum([0, *(len(polygon) for polygon in polygons)])
    return Polygons(vertices[ids], np.cumsum([0, *(len(ring) for ring in rings)]), faces)


def _list(value: Any) -> list[Any]:
    if not isinstance(value, list):
        raise TypeError("something else where a list should be")
    return value


def _tu3d(feature: Any, number: int) -> Feature:
    geometry = feature["geometry"]
    shape = _shape(geometry, vertex_table(geometry["vertices"]))
    name = str(feature.get("id", f"feature{number}"))
    return Feature(name, str(feature.get("type", "")), () if shape is None else (shape,))


def _jsonfg(path: Path, feature: Any, number: int) -> Feature:
    """A feature of JSON-FG whose place is a Polyhedron or MultiPolyhedron; plain GeoJSON has no solids."""
    place = feature.get("place") or {}
    kind = place.get("type")
    if kind not in ("Polyhedron", "MultiPolyhedron"):
        raise UnsupportedFormat(
            path,
            f"feature {number} has no Polyhedron as its place",
            "plain GeoJSON holds no solids that could be validated",
        )
    solids = [place["coordinates"]] if kind == "Polyhedron" else place["coordinates"]
    shells = tuple(tuple(Polygons.of(shell, explicit=True) for shell in solid) for solid in solids)
    shape = Shape("Solid" if kind == "Polyhedron" else "MultiSolid", shells)
    name = str(feature.get("id", f"feature{number}"))
    return Feature(name, str(feature.get("featureType", "Feature")), (shape,))
