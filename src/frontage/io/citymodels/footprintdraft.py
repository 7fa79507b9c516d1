"""A footprint of a map as a draft: its outline, and its height where attributes state one."""

import re
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import shapely

from frontage.geometry.arrays import Float
from frontage.io.citymodels.address import readable_address
from frontage.io.citymodels.draft import BuildingDraft, DraftFace, DraftShell, Value

_HEIGHTS = ("height", "measuredheight", "building_height", "building:height", "height_m", "hoehe")
_GROUNDS = (
    "ground_z",
    "ground",
    "ground_height",
    "ground_elevation",
    "base_z",
    "base_elevation",
    "elevation",
)
_CORNERS = 3  # of a ring, at least
_FAR = 1e12  # coordinates beyond are refused where their CRS is known
_METRES = re.compile(r"\s*([-+]?\d+(?:[.,]\d+)?)\s*m?\s*$")


def footprint_draft(
    name: str, polygons: Sequence[Sequence[Float]], properties: Mapping[str, Any]
) -> BuildingDraft:
    """A building of a map from its polygons (rings (k, 3), NaN for unknown heights) and its attributes.

    The height (m above ground) comes from an attribute such as "height". The height of the ground comes from
    the coordinates, else from an attribute such as "ground_z", else it is 0. A polygon whose rings cross is
    divided into simple ones, and a problem tells of it.
    """
    lower = {str(k).lower(): v for k, v in properties.items()}
    height, ground = _metres(lower, _HEIGHTS), _metres(lower, _GROUNDS)
    draft = BuildingDraft(name, address=readable_address(properties), attributes=_values(properties))
    draft.height = height
    if height is not None and height <= 0.0:
        draft.height = None
        draft.problems.append(f"a height of {height:g} m")
    faces = []
    for rings in (simple for stated in polygons for simple in _simple(stated, draft.problems)):
        heights = np.concatenate([np.zeros(0), *(r[:, 2] for r in rings)])
        known = heights[np.isfinite(heights)]
        foot = float(known.min()) if len(known) and known.any() else ground if ground is not None else 0.0
        faces.append(
            DraftFace([np.column_stack([r[:, :2], np.full(len(r), foot)]) for r in rings], "GroundSurface")
        )
    draft.shells = [DraftShell("0", faces, False)] if faces else []
    return draft


def _simple(rings: Sequence[Float], problems: list[str]) -> list[Sequence[Float]]:
    """The polygon as it is, or its simple parts where its rings cross themselves or each other."""
    usable = len(rings) and all(len(r) >= _CORNERS and (np.abs(r[:, :2]) < _FAR).all() for r in rings)
    drawn = shapely.Polygon(rings[0][:, :2], [r[:, :2] for r in rings[1:]]) if usable else None
    if drawn is None or drawn.is_valid:
        return [rings]
    parts = [p for q in shapely.get_parts(shapely.make_valid(drawn)) for p in shapely.get_parts(q)]
    areas = [p for p in parts if isinstance(p, shapely.Polygon) and p.area > 0]
    if not areas:
        return [rings]  # without area: told where it is used
    problems.append(f"a footprint that crosses itself ({len(areas)} parts made of it)")
    heights = np.concatenate([r[:, 2] for r in rings])
    known = heights[np.isfinite(heights)]
    foot = float(known.min()) if len(known) else np.nan
    outlines = [[shapely.get_coordinates(r) for r in (p.exterior, *p.interiors)] for p in areas]
    return [[np.column_stack([xy, np.full(len(xy), foot)]) for xy in rings] for rings in outlines]


def _metres(properties: Mapping[str, Any], names: Sequence[str]) -> float | None:
    """The first of the named attributes that is a number, in m."""
    for name in names:
        value = properties.get(name)
        match = _METRES.match(str(value)) if isinstance(value, str | int | float) else None
        if match:
            return float(match[1].replace(",", "."))
    return None


def _values(properties: Mapping[str, Any]) -> dict[str, Value]:
    return {str(k): v for k, v in properties.items() if isinstance(v, str | int | float)}
