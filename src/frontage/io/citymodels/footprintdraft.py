"""A footprint of a map as a draft: its outline, and its height where attributes state one."""

import re
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

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
_METRES = re.compile(r"\s*([-+]?\d+(?:[.,]\d+)?)\s*m?\s*$")


def footprint_draft(
    name: str, polygons: Sequence[Sequence[Float]], properties: Mapping[str, Any]
) -> BuildingDraft:
    """A building of a map from its polygons (rings (k, 3), NaN for unknown heights) and its attributes.

    The height (m above ground) comes from an attribute such as "height". The height of the ground comes from
    the coordinates, else from an attribute such as "ground_z", else it is 0.
    """
    lower = {str(k).lower(): v for k, v in properties.items()}
    height, ground = _metres(lower, _HEIGHTS), _metres(lower, _GROUNDS)
    draft = BuildingDraft(name, address=readable_address(properties), attributes=_values(properties))
    draft.height = height
    if height is not None and height <= 0.0:
        draft.height = None
        draft.problems.append(f"a height of {height:g} m")
    faces = []
    for rings in polygons:
        heights = np.concatenate([np.zeros(0), *(r[:, 2] for r in rings)])
        known = heights[np.isfinite(heights)]
        foot = float(known.min()) if len(known) and known.any() else ground if ground is not None else 0.0
        faces.append(
            DraftFace([np.column_stack([r[:, :2], np.full(len(r), foot)]) for r in rings], "GroundSurface")
        )
    draft.shells = [DraftShell("0", faces, False)] if faces else []
    return draft


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
