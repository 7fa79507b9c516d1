"""3D Tiles 1.1 (OGC 22-025r4): buildings as binary glTF, placed on the earth, in levels of detail.

A tile is placed by a matrix from its own metres to geocentric coordinates. It is the derivative of the
transformation at the middle of the tile: over 50 m it differs from the exact one by less than 0.1 mm in plan.
"""

import json
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from pyproj import CRS, Transformer

from frontage.errors import CrsError
from frontage.geometry.arrays import Float
from frontage.io.crs import horizontal, parse_crs, vertical
from frontage.io.files import whole_file
from frontage.io.transform import best_transformer
from frontage.model import WorldRef

_STEP_M = 10.0  # of the differences that the derivative is taken from
_GEODETIC, _GEOCENTRIC = "EPSG:4979", "EPSG:4978"


@dataclass(frozen=True, eq=False)
class Level:
    """A level of detail: its file beside the tileset, and by how many metres it differs from the truth."""

    uri: str
    error: float


@dataclass(frozen=True, eq=False)
class Tile:
    """A building.

    centre       (3,) m local: the origin of its files
    low, high    (3,) m from the centre: its bounding box
    levels       from the coarsest to the finest
    """

    name: str
    centre: Float
    low: Float
    high: Float
    levels: tuple[Level, ...]


def write_tileset(path: Path, tiles: Sequence[Tile], world: WorldRef, left_out: Sequence[str] = ()) -> None:
    """Write `tileset.json`. Raises FileError when that fails.

    Heights of a CRS that names no height datum, or one whose geoid is not installed, are taken as heights
    above the ellipsoid; `asset.extras` of the file says so, and how good the place is, and what the tiles do
    not show (`left_out`). Without a CRS, or with one that no transformation leads out of, tiles stay in local
    metres.
    """
    place = _Place(world)
    corners = np.concatenate([tile.centre + c for tile in tiles for c in (tile.low, tile.high)]).reshape(
        -1, 3
    )
    size = float(np.linalg.norm(corners.max(0) - corners.min(0)))
    children = [_building(tile, place) for tile in tiles]
    # Buildings are added one by one, as they come; a finer level replaces its coarser one.
    root = {"boundingVolume": place.volume(corners), "geometricError": size, "refine": "ADD",
            "children": children}  # fmt: skip
    about = {"crs": world.crs, "origin": [int(v) for v in world.origin], "heights": place.heights,
             "notes": place.notes, "left_out": list(left_out)}  # fmt: skip
    asset = {"version": "1.1", "generator": "Frontage", "extras": about}
    text = json.dumps({"asset": asset, "geometricError": 2 * size, "root": root}, indent=1)
    with whole_file(path) as temporary:
        temporary.write_text(text + "\n", "utf-8")


def geocentric_from_local(world: WorldRef, at: Float) -> Float:
    """Return the matrix (4, 4) from local metres to the coordinates of tilesets, exact at `at` (3,) m local.

    These are geocentric, or local where the tiles are not placed on the earth.
    """
    about = _Place(world).matrix(at)
    to_origin = np.eye(4)
    to_origin[:3, 3] = -at
    return np.asarray(about @ to_origin)


def _building(tile: Tile, place: "_Place") -> dict[str, Any]:
    """Return a tile whose child replaces it by the next finer level, and so on."""
    box = _box(tile.low, tile.high)
    made: dict[str, Any] | None = None
    for level in reversed(tile.levels):
        made = {"boundingVolume": box, "geometricError": level.error, "content": {"uri": level.uri},
                **({"children": [made]} if made else {})}  # fmt: skip
    assert made is not None  # a tile has a level
    return {
        **made,
        "refine": "REPLACE",
        "transform": place.matrix(tile.centre).T.ravel().tolist(),
        "extras": {"name": tile.name},
    }


def _box(low: Float, high: Float) -> dict[str, Any]:
    """Return the bounding volume between two corners (3,) m of a tile."""
    half, middle = (high - low) / 2, (high + low) / 2
    return {"box": [*middle.tolist(), *np.diag(half).ravel().tolist()]}


class _Place:
    """Where local metres lie on the earth."""

    def __init__(self, world: WorldRef) -> None:
        self._world = world
        self._to_degrees: Transformer | None = None
        self._heights_known = False
        self.notes: list[str] = []
        if world.crs is not None:
            self._find(parse_crs(world.crs))

    def _find(self, crs: CRS) -> None:
        at = np.asarray(self._world.origin, np.float64)[None]
        for known, source in ((True, crs), (False, horizontal(crs).to_3d())):
            if known and vertical(crs) is None:
                continue
            try:
                self._to_degrees = best_transformer("3D Tiles", source, CRS(_GEODETIC), at, self.notes)
                self._heights_known = known
                return
            except CrsError:
                continue

    @cached_property
    def _to_geocentric(self) -> Transformer:
        return Transformer.from_crs(_GEODETIC, _GEOCENTRIC, always_xy=True)

    @property
    def heights(self) -> str:
        """What the heights of the tiles are, with the height of the geoid that was added."""
        if self._to_degrees is None:
            return "z of the scans: the tiles are not placed on the earth"
        if not self._heights_known:
            return "z of the CRS, taken as height above the ellipsoid (geoid height 0 m)"
        z = float(self._world.origin[2])
        added = float(self._degrees(np.zeros((1, 3)))[0, 2]) - z
        return f"above the ellipsoid: z of the CRS and a geoid height of {added:.2f} m"

    def matrix(self, centre: Float) -> Float:
        """Return the matrix (4, 4) from metres about a place (3,) m local to geocentric or local metres."""
        made = np.eye(4)
        if self._to_degrees is None:
            made[:3, 3] = centre
            return made
        steps = np.concatenate([np.zeros((1, 3)), _STEP_M * np.eye(3), -_STEP_M * np.eye(3)])
        found = self._geocentric(centre + steps)
        made[:3, :3] = (found[1:4] - found[4:]).T / (2 * _STEP_M)
        made[:3, 3] = found[0]
        return made

    def volume(self, corners: Float) -> dict[str, Any]:
        """Return the bounding volume of corners (n, 3) m local: a region of the earth, or a box."""
        low, high = corners.min(0), corners.max(0)
        if self._to_degrees is None:
            return _box(low, high)
        eight = np.array(np.meshgrid(*zip(low, high, strict=True))).reshape(3, -1).T
        lon, lat, h = self._degrees(eight).T
        west, south, east, north = np.radians([lon.min(), lat.min(), lon.max(), lat.max()]).tolist()
        return {"region": [west, south, east, north, float(h.min()), float(h.max())]}

    def _degrees(self, local: Float) -> Float:
        assert self._to_degrees is not None
        return np.column_stack(self._to_degrees.transform(*self._world.to_world(local).T))

    def _geocentric(self, local: Float) -> Float:
        return np.column_stack(self._to_geocentric.transform(*self._degrees(local).T))
