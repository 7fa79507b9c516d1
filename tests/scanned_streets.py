"""Streets that `frontage.simulate` draws and scans in memory, with what is true of every point.

`terrace` makes a row of houses in a few seconds; the same arguments give the same bytes. Nothing is written.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from frontage.geometry.arrays import Array
from frontage.model import Scan, merge_scans
from frontage.simulate.scene import House, Part, Scene
from frontage.simulate.sensors.instrument import ScannerSpec
from frontage.simulate.sensors.recording import Echo
from frontage.simulate.sensors.terrestrial import scan_stations
from frontage.simulate.spec import SceneSpec
from frontage.simulate.street.build import build_street

_STATION_EVERY_M = 8.0  # along the street
_STREET_WIDTH_M = 14.0
_NOTHING = 255  # part of what lies on nothing


@dataclass(frozen=True, eq=False)
class ScannedStreet:
    """A scan of a simulated street and the truth about each of its n points.

    scan    all stations together, in the local frame of `scene`
    part    (n,) uint8 `Part` that a point lies on; 255 for what lies on nothing: strays, echoes mixed of two
            surfaces, mirror images in panes
    house   (n,) int32 index into `houses`; -1 for what belongs to no house
    front   (n,) bool, whether a point lies on the street front of its house: wall, openings and fittings,
            but no room, roof or side wall
    """

    scene: Scene
    scan: Scan
    part: Array
    house: Array
    front: Array

    @property
    def houses(self) -> tuple[House, ...]:
        return self.scene.houses

    def span(self, house: int) -> tuple[float, float]:
        """Returns where a house begins and ends along the street, m in the street frame."""
        return street_span(self.scene, self.houses[house])

    def front_of(self, house: int) -> Array:
        """(n,) bool, the points on the street front of one house."""
        return np.asarray(self.front & (self.house == house))


def street_span(scene: Scene, house: House) -> tuple[float, float]:
    """Returns where a house begins and ends along the street, m in the street frame."""
    xy = house.footprint
    s = scene.local_from_street.inverse.apply(np.column_stack([xy, np.zeros(len(xy))]))[:, 0]
    return float(s.min()), float(s.max())


def scan_scene(scene: Scene, spacing: float, stations: int | None = None, **scanner: Any) -> ScannedStreet:
    """Scans a scene from stations in the road, with beams `spacing` m apart at 10 m; more keys of
    `ScannerSpec` may be given. Without `stations` there is one for every 8 m of houses.
    """
    length = max(s1 for _, s1 in (street_span(scene, h) for h in scene.houses))
    spec = ScannerSpec.model_validate(
        {"stations": stations or max(2, round(length / _STATION_EVERY_M)), "spacing": spacing, "subrays": 1}
        | {"field": 180, "lowest": -25, "highest": 60}  # towards the houses
        | scanner
    )
    recorded = scan_stations(scene, spec, scene.seed)
    surface = np.concatenate([r.surface for r in recorded])
    echo = np.concatenate([r.echo for r in recorded])
    real = (surface >= 0) & ~np.isin(echo, (Echo.MIXED, Echo.GHOST, Echo.STRAY))
    on_front = np.array([s.facade == 0 and s.part != Part.ROOM for s in scene.surfaces])
    return ScannedStreet(
        scene,
        merge_scans([r.scan for r in recorded]),
        np.where(real, scene.parts[surface], _NOTHING).astype(np.uint8),
        np.where(real, np.array([s.house for s in scene.surfaces])[surface], -1).astype(np.int32),
        real & on_front[surface],
    )


def terrace(
    seed: int,
    houses: int | Sequence[dict[str, Any]] = 4,
    spacing: float = 0.08,
    twins: bool = False,
    obstacles: bool = True,
    **spec: Any,
) -> ScannedStreet:
    """Scans a row of upright houses that stand wall to wall.

    `houses` is their number or their tables in the words of `HouseSpec`; `twins` builds the second and all
    others like the first; with `obstacles` trees, cars and lamps stand before them. More keys of `SceneSpec`
    may be given.
    """
    count = houses if isinstance(houses, int) else len(houses)
    tables = [{}] * count if isinstance(houses, int) else list(houses)
    plain = {"gap": 0.0, "lean": 0.0}
    row = [{"twin": True} if twins and k else plain | table for k, table in enumerate(tables)]
    things = {"trees": count, "cars": count, "lamps": 2} if obstacles else {"trees": 0, "cars": 0, "lamps": 0}
    drawn = SceneSpec.model_validate(
        {"seed": seed, "house": row, "opposite": False, "setting": "terrace", "slope": 0.0, "people": 0}
        | {"street_width": _STREET_WIDTH_M, "hedges": False}
        | things
        | spec
    )
    return scan_scene(build_street(drawn), spacing, field=360 if drawn.opposite else 180)
