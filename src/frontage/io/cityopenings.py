"""The windows and doors of a CityJSON model, for scoring it."""

import json
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from frontage.geometry.arrays import Float
from frontage.io.files import reading, require_file

_KINDS = ("Window", "Door")
_DEPTH = {"MultiSurface": 0, "CompositeSurface": 0, "Solid": 1, "MultiSolid": 2, "CompositeSolid": 2}


@dataclass(frozen=True, eq=False)
class CityOpening:
    """A Window or Door surface: outer ring (k, 3) m in the file's coordinates, its attributes."""

    kind: str
    ring: Float
    about: dict[str, Any]


def read_city_openings(path: str | Path) -> tuple[CityOpening, ...]:
    """Every Window and Door surface of the finest level of every object. Raises FileError."""
    p = require_file(path)
    with reading(p, "CityJSON"):
        model = json.loads(p.read_text("utf-8-sig"))
        if model.get("type") != "CityJSON":
            raise ValueError(f"JSON of type {model.get('type')!r}")
        vertices = np.asarray(model["vertices"], np.float64).reshape(-1, 3)
        if "transform" in model:
            vertices = vertices * model["transform"]["scale"] + model["transform"]["translate"]
        return tuple(
            opening
            for thing in model["CityObjects"].values()
            for geometry in _finest(thing.get("geometry", []))
            for opening in _openings(geometry, vertices)
        )


def _finest(geometries: list[dict[str, Any]]) -> list[dict[str, Any]]:
    levels = [float(g.get("lod", 0)) for g in geometries]
    return [g for g, level in zip(geometries, levels, strict=True) if level == max(levels)]


def _openings(geometry: dict[str, Any], vertices: Float) -> Iterator[CityOpening]:
    """Surfaces of a geometry whose class is a window's or door's."""
    semantics = geometry.get("semantics")
    if semantics is None or geometry["type"] not in _DEPTH:
        return
    boundaries, values = geometry["boundaries"], semantics["values"]
    for _ in range(_DEPTH[geometry["type"]]):
        boundaries = [surface for shell in boundaries for surface in shell]
        values = [value for shell in values for value in shell]
    for surface, value in zip(boundaries, values, strict=True):
        about = {} if value is None else semantics["surfaces"][value]
        if about.get("type") in _KINDS:
            yield CityOpening(about["type"], vertices[np.asarray(surface[0], np.int64)], about)
