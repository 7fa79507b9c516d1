"""What the footprint readers hand to each other."""

from dataclasses import dataclass

from frontage.geometry.arrays import Float

Polygons = tuple[Float, ...]
"""Outer rings (k, 3), file coordinates."""


@dataclass(frozen=True, eq=False)
class Outline:
    """One building of a map: id, polygons that cover its footprint (they may overlap), address when known."""

    id: str
    polygons: Polygons
    address: str | None = None
