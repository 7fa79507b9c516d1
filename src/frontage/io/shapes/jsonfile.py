"""Reading the geometries of CityJSON 1.0 to 2.0, CityJSONSeq, JSON-FG and tu3djson for validation."""

import json
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from frontage.errors import UnsupportedFormat
from frontage.geometry.arrays import Float
from frontage.io.citymodels.cityjson.base import template_of, transform_of
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
        data = json.loads(text)
    except json.JSONDecodeError:
        if path.suffix.lower() != ".jsonl" and '"CityJSONFeature"' not in text:
            raise
        return "CityJSONSeq", _sequence(path, text)
    if not isinstance(data, dict):
        raise ValueError("it does not hold a JSON object")
    kind = data.get("type")
    if kind == "CityJSON":
        refuse_degrees(path, data.get("metadata", {}).get("referenceSystem"))
        return f"CityJSON {data.get('version', '')}".strip(), _cityjson(data, data)
    if kind == "tu3djson":
        return "tu3djson", [_tu3d(f, k) for k, f in enumerate(data["features"])]
    if kind in ("FeatureCollection", "Feature"):
        features = data.get("features", [data])
        return "JSON-FG", [_jsonfg(path, f, k) for k, f in enumerate(features)]
    raise UnsupportedFormat(path, f"JSON of type {kind!r} cannot be validated", "name a CityJSON file")


def _sequence(path: Path, text: str) -> list[Feature]:
    """Read CityJSONSeq: the first line states how coordinates are packed, every further line is a feature."""
    head: Any = None
    features: list[Feature] = []
    for number, line in enumerate(text.splitlines(), 1):
        if not line.strip():
            continue
        try:
            data = json.loads(line)
            if head is None:
                head = data
                if data.get("type") != "CityJSON":
                    raise ValueError("the first line is not a CityJSON object")
                transform_of(data)
                refuse_degrees(path, data.get("metadata", {}).get("referenceSystem"))
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
    """The city objects of a CityJSON object or feature; parts of buildings are parts of their features."""
    scale, shift = transform_of(head)
    vertices = np.array(data["vertices"], np.float64).reshape(-1, 3) * scale + shift
    templates = head.get("geometry-templates", {})
    objects = data["CityObjects"]
    if not isinstance(objects, dict):
        raise ValueError("its CityObjects is not an object")
    shapes = {name: tuple(_geometries(o, vertices, templates, name)) for name, o in objects.items()}
    part_of = {
        name: parents[0]
        for name, o in objects.items()
        if o["type"].endswith("Part") and (parents := o.get("parents")) and parents[0] in objects
    }
    children: dict[str, list[str]] = {}
    for name, parent in part_of.items():
        children.setdefault(parent, []).append(name)

    def feature(name: str) -> Feature:
        parts = tuple(feature(child) for child in children.get(name, ()))
        return Feature(name, objects[name]["type"], shapes[name], parts)

    return [feature(name) for name in objects if name not in part_of]


def _geometries(city_object: Any, vertices: Float, templates: Any, name: str) -> Iterable[Shape]:
    for number, geometry in enumerate(city_object.get("geometry", ())):
        try:
            shape = _geometry(geometry, vertices, templates)
        except KeyError as problem:
            raise ValueError(f"{name}, geometry {number}: no member {problem.args[0]}") from problem
        except (IndexError, ValueError) as problem:
            raise ValueError(f"{name}, geometry {number}: {problem}") from problem
        except TypeError as problem:
            text = "its boundaries are not nested as its type requires"
            raise ValueError(f"{name}, geometry {number}: {text} ({problem})") from problem
        if shape is not None:
            yield shape


def _geometry(geometry: Any, vertices: Float, templates: Any) -> Shape | None:
    """One geometry as a shape; None for points and lines."""
    if geometry["type"] != "GeometryInstance":
        return _shape(geometry, vertices)
    return _shape(*template_of(geometry, vertices, templates))


def _shape(geometry: Any, vertices: Float) -> Shape | None:
    kind, boundaries = geometry["type"], geometry["boundaries"]
    lod = str(geometry.get("lod", ""))
    if kind in _SURFACES:
        return Shape(kind, ((_surfaces(boundaries, vertices),),), lod)
    if kind == "Solid":
        return Shape("Solid", (tuple(_surfaces(s, vertices) for s in boundaries),), lod)
    if kind in _SOLIDS:
        return Shape(kind, tuple(tuple(_surfaces(s, vertices) for s in solid) for solid in boundaries), lod)
    if kind in ("MultiPoint", "MultiLineString"):
        return None
    raise ValueError(f"a geometry of type {kind!r}")


def _surfaces(polygons: Sequence[Sequence[Sequence[int]]], vertices: Float) -> Polygons:
    """Polygons of vertex numbers."""
    sizes = [len(ring) for polygon in polygons for ring in polygon]
    ids = np.array([i for polygon in polygons for ring in polygon for i in ring], np.int64)
    if ids.ndim != 1:
        raise TypeError("lists where vertex numbers should be")
    if len(ids) and (ids.min() < 0 or ids.max() >= len(vertices)):
        raise ValueError(f"a face names vertex {ids.max()}, but there are only {len(vertices)}")
    faces = np.cumsum([0, *(len(polygon) for polygon in polygons)])
    return Polygons(vertices[ids], np.cumsum([0, *sizes]), faces)


def _tu3d(feature: Any, number: int) -> Feature:
    geometry = feature["geometry"]
    shape = _shape(geometry, np.array(geometry["vertices"], np.float64).reshape(-1, 3))
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
