"""Buildings of CityJSON 1.0 to 2.0: every geometry with its semantics, and parts and installations."""

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from frontage.geometry.arrays import Float
from frontage.io.citymodels.address import readable_address
from frontage.io.citymodels.cityjson.base import template_of
from frontage.io.citymodels.draft import BuildingDraft, DraftFace, DraftShell, Value
from frontage.model.citymodel import Texture

_PARTS = ("BuildingPart", "BuildingInstallation", "BuildingConstructiveElement")
_SURFACES = ("MultiSurface", "CompositeSurface")
_NOTHING = ("MultiPoint", "MultiLineString")
_BAD = (IndexError, TypeError, KeyError, ValueError, AttributeError)


@dataclass(frozen=True, eq=False)
class Corners:
    """What the numbers in geometries refer to.

    vertices   (v, 3) in file coordinates
    templates  of the model
    images     file names of the pictures
    places     (p, 2) texture coordinates
    """

    vertices: Float
    templates: Mapping[str, Any]
    images: Sequence[str] = ()
    places: Float = field(default_factory=lambda: np.zeros((0, 2)))

    @classmethod
    def of(cls, vertices: Float, templates: Mapping[str, Any], appearance: Mapping[str, Any]) -> "Corners":
        """Make the corners with the pictures of an `appearance` member."""
        images = [str(t.get("image", "")) for t in appearance.get("textures") or ()]
        places = np.array(appearance.get("vertices-texture") or [], np.float64).reshape(-1, 2)
        return cls(vertices, templates, images, places)


def families(objects: Mapping[str, Any]) -> dict[str, list[str]]:
    """The keys of every building with those of its parts and installations, in the file's order."""
    kinds = {key: o.get("type") for key, o in objects.items()}
    above = {
        key: parent
        for key, o in objects.items()
        if kinds[key] in _PARTS
        for parent in (o.get("parents") or [])[:1]
        if parent in objects
    }
    for key, o in objects.items():
        for child in o.get("children") or ():
            if kinds.get(child) in _PARTS and kinds[key] in ("Building", *_PARTS):
                above.setdefault(child, key)
    found: dict[str, list[str]] = {}
    for key, kind in kinds.items():
        if kind == "Building" or (kind == "BuildingPart" and key not in above):
            found[key] = [key]
    for key in above:
        root, steps = key, 0
        while root in above and steps < len(above):
            root, steps = above[root], steps + 1
        if root in found:
            found[root].append(key)
    return found


def building_of(
    key: str, family: Sequence[str], objects: Mapping[str, Any], corners: Corners
) -> BuildingDraft:
    """Make a draft of a building with its parts; the draft's problems name what cannot be read."""
    o = objects[key]
    attributes = o.get("attributes") or {}
    draft = BuildingDraft(key, address=_address(o, attributes), attributes=values(attributes))
    for member in family:
        part = "" if member == key else member
        first = len(draft.shells)
        for geometry in objects[member].get("geometry") or ():
            try:
                draft.shells += _geometry(geometry, corners, part, draft.problems)
            except _BAD as problem:
                draft.problems.append(f"a broken geometry ({_said(problem)})")
        for shell in draft.shells[first:]:
            about = values(objects[member].get("attributes") or {}) if part else {}
            shell.describe(objects[member].get("type") == "BuildingInstallation", about)
    return draft


def values(attributes: Mapping[str, Any]) -> dict[str, Value]:
    """Attributes as texts and numbers; nested values become JSON texts."""
    return {
        str(k): v if isinstance(v, str | int | float) else json.dumps(v, ensure_ascii=False)
        for k, v in attributes.items()
        if v is not None
    }


def _said(problem: Exception) -> str:
    named = f"no {problem}" if isinstance(problem, KeyError) else str(problem)
    return " ".join(named.split())[:80]


def _address(o: Mapping[str, Any], attributes: Mapping[str, Any]) -> str | None:
    """The first address of a building; CityJSON 1.0 holds one, later versions a list."""
    stated = o.get("address") or {}
    first = stated[0] if isinstance(stated, list) and stated else stated
    return readable_address(attributes) or (readable_address(first) if isinstance(first, dict) else None)


def _geometry(geometry: Any, corners: Corners, part: str, problems: list[str]) -> Iterator[DraftShell]:
    """Yield the shells of one geometry; a template is put in its place."""
    kind, boundaries = geometry["type"], geometry["boundaries"]
    lod = str(geometry.get("lod", ""))
    if kind == "GeometryInstance":
        template, placed = template_of(geometry, corners.vertices, corners.templates)
        yield from _geometry(template, Corners(placed, {}), part, problems)
        return
    semantics = geometry.get("semantics") or {}
    table, given = semantics.get("surfaces") or [], semantics.get("values")
    themes = list((geometry.get("texture") or {}).values())
    painted = themes[0].get("values") if themes else None
    if kind in _SURFACES:
        faces = _faces(boundaries, given, table, corners, problems)
        _assign_textures(faces, painted, corners)
        yield DraftShell(lod, faces, False, part)
    elif kind in ("Solid", "MultiSolid", "CompositeSolid"):
        solids = [boundaries] if kind == "Solid" else boundaries
        numbers, pictures = ([given], [painted]) if kind == "Solid" else (given, painted)
        for k, solid in enumerate(solids):
            faces = _faces(solid[0], _item(_item(numbers, k), 0), table, corners, problems)
            _assign_textures(faces, _item(_item(pictures, k), 0), corners)
            yield DraftShell(lod, faces, True, part)
            problems += ["an inner shell of a solid"] * (len(solid) - 1)
    elif kind not in _NOTHING:
        raise ValueError(f"of type {kind!r}")


def _item(values: Any, k: int) -> Any:
    """Item k of a list of semantic values; None where the list is null or shorter."""
    return values[k] if isinstance(values, list) and k < len(values) else None


def _faces(
    polygons: Sequence[Any], given: Any, table: Sequence[Any], corners: Corners, problems: list[str]
) -> list[DraftFace]:
    """Make the polygons with their semantics; broken ones have no rings, and `problems` names them."""
    faces = []
    for k, polygon in enumerate(polygons):
        try:
            rings = [_ring(ring, corners.vertices) for ring in polygon]
            number = _item(given, k)
            meaning = table[number] if number is not None else {}
            faces.append(
                DraftFace(rings, meaning.get("type"), str(meaning.get("id", "")), _about(meaning, table))
            )
        except _BAD as problem:
            problems.append(f"a broken polygon ({_said(problem)})")
            faces.append(DraftFace([]))
    return faces


def _assign_textures(faces: Sequence[DraftFace], given: Any, corners: Corners) -> None:
    """Give polygons their textures: per ring, the file has a picture's number and those of places."""
    for k, face in enumerate(faces):
        rings = _item(given, k)
        try:
            if rings and rings[0] and rings[0][0] is not None:
                places = tuple(corners.places[np.asarray(r[1:], np.int64)] for r in rings)
                face.texture = Texture(corners.images[rings[0][0]], places)
        except _BAD:
            continue  # a wall is kept although its picture is missing


def _ring(numbers: Any, vertices: Float) -> Float:
    ids = np.asarray(numbers)
    if ids.ndim != 1 or ids.dtype.kind not in "iu" or not len(ids):
        raise ValueError("a ring that is not a list of vertex numbers")
    if ids.min() < 0 or ids.max() >= len(vertices):
        raise ValueError("a vertex number that is not in the file")
    found: Float = vertices[ids]
    return found


def _about(meaning: Mapping[str, Any], table: Sequence[Any]) -> dict[str, Value]:
    """The attributes of a semantic surface; `parent` is the id of the wall that a window belongs to."""
    about = values({k: v for k, v in meaning.items() if k not in ("type", "id", "parent", "children")})
    parent = meaning.get("parent")
    if isinstance(parent, int) and 0 <= parent < len(table) and table[parent].get("id"):
        about["parent"] = str(table[parent]["id"])
    return about
