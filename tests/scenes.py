"""Simulated streets and walls with exact truth, for tests, the demo and the benchmarks.

``street_scene()`` and ``wall_scene()`` make a `Scene`: a `Scan` with stations and rays, and what is true
about it. ``render_photo()`` takes its photograph, ray by ray. ``write_scene()`` writes it all as files that
``frontage run`` reads; ``python tests/scenes.py OUT`` does that from the command line.
"""

import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from frontage.geometry.arrays import Array, Float
from frontage.geometry.rigid import Rigid3
from frontage.model import Scan, WorldRef
from scene_parts import (
    CAR,
    CLUTTER,
    FACADE,
    GROUND,
    INTERIOR,
    POLE,
    ROOF,
    SIDE,
    STREET_WIDTH,
    TREE,
    Ball,
    Box,
    HouseTruth,
    OpeningTruth,
    build_houses,
    street_frame,
)  # fmt: skip
from scene_render import render_photo
from scene_sampling import (
    Points,
    behind_boxes,
    car_points,
    clutter_points,
    ground_points,
    hidden_by_ball,
    hidden_by_box,
    house_points,
    join,
    pole_points,
    through_hole,
    tree_points,
)  # fmt: skip

__all__ = [
    "CAR", "CLUTTER", "FACADE", "GROUND", "INTERIOR", "POLE", "ROOF", "SIDE", "TREE",
    "HouseTruth", "OpeningTruth", "Scene", "render_photo", "street_scene", "wall_scene", "write_scene",
]  # fmt: skip

CRS = "EPSG:25832"
GRAZING = 0.05  # cosine of incidence below which a beam does not come back


@dataclass(frozen=True, eq=False)
class Scene:
    """A scan and the truth about it.

    scan     points in a local origin, stations in `origins`
    houses   facade frames (`local_from_facade`), sizes, openings, protrusions
    label    (n,) uint8 per point: GROUND FACADE INTERIOR TREE CAR ROOF POLE CLUTTER SIDE
    house    (n,) int32 per point: index into `houses`, -1 = none (interior points have one)
    """

    scan: Scan
    houses: tuple[HouseTruth, ...]
    label: Array
    house: Array
    local_from_street: Rigid3
    trees: tuple[Ball, ...] = ()
    cars: tuple[Box, ...] = ()
    slope: float = 0.0

    @property
    def world(self) -> WorldRef:
        return self.scan.world

    @property
    def length(self) -> float:
        """m along the street."""
        return max(h.s1 for h in self.houses)


def street_scene(
    seed: int = 0,
    houses: int = 5,
    spacing: float = 0.02,
    noise: float = 0.005,
    slope: float = 0.0,
    both_sides: bool = False,
    trees: bool = True,
    cars: bool = True,
    interior: bool = True,
    twins: bool = False,
    colour: bool = True,
    world_origin: tuple[int, int, int] = (691_000, 5_334_000, 520),
    azimuth: float = 0.4,
    crs: str | None = CRS,
) -> Scene:
    """A street of terraced houses, scanned from stations in the road.

    `houses` per side; `spacing` m between points on the walls; `noise` m, one sigma along the ray; `slope` is
    the rise of the ground per metre of street; `twins` makes all houses of a side alike; `azimuth` (rad)
    turns the street.
    """
    rng = np.random.default_rng(seed)
    frame = street_frame(azimuth)
    row = build_houses(rng, houses, both_sides, twins, slope, frame)
    length = max(h.s1 for h in row)
    crowns, boxes = _furniture(rng, length, slope, trees, cars)
    stations = _stations(length, slope)
    parts = [_seen(rng, i, row, frame, stations, spacing, interior) for i in range(len(row))]
    far = -STREET_WIDTH if both_sides else -STREET_WIDTH + 2.0
    parts.append(_from(rng, ground_points(rng, -3.0, length + 3.0, far, 0.0, slope, spacing * 1.5), stations))
    parts += [_from(rng, tree_points(rng, t, spacing), stations) for t in crowns]
    parts += [_from(rng, car_points(rng, i, b, spacing), stations) for i, b in enumerate(boxes)]
    if trees or cars:
        lamps = np.arange(6.0, length, 17.0)
        parts += [_from(rng, pole_points(rng, s, -2.6, slope * s, spacing), stations) for s in lamps]
    points = join([p for p, _ in parts])
    eyes = np.concatenate([e for _, e in parts])
    visible = _visible(rng, points.xyz, stations[eyes], crowns, boxes, points.label)
    scan = _scan(
        rng, points.keep(visible), eyes[visible], stations, frame, noise, colour, WorldRef(world_origin, crs)
    )
    return Scene(scan, row, points.label[visible], points.house[visible], frame, crowns, boxes, slope)


def wall_scene(
    seed: int = 0,
    width: float = 20.0,
    height: float = 12.0,
    spacing: float = 0.02,
    noise: float = 0.005,
    clutter: float = 0.6,
    azimuth: float = 0.4,
    world_origin: tuple[int, int, int] = (691_000, 5_334_000, 520),
) -> Scene:
    """A blank wall, `clutter` of whose points (share 0..1) lie elsewhere; every wall point is one house's."""
    rng = np.random.default_rng(seed)
    frame = street_frame(azimuth)
    pose = frame @ Rigid3("street", "facade", np.eye(3), np.zeros(3))
    wall = HouseTruth("H0", 0, 0.0, width, 0.0, height, 0.0, pose, (), (), (0.72, 0.45, 0.36), seed)
    from scene_sampling import grid
    from scene_texture import wall_colour

    x, z = grid(rng, 0.0, 0.0, width, height, spacing)
    front = Points.of(
        np.column_stack([x, 0 * x, z]), np.array([0, -1.0, 0]), wall_colour(wall, x, z), FACADE, 0
    )
    mess = clutter_points(rng, round(len(x) * clutter / (1 - clutter)), width, height)
    points = join([front, mess])
    stations = np.array([[width / 2, -12.0, 1.8]])
    eyes = np.zeros(len(points.xyz), np.int64)
    scan = _scan(rng, points, eyes, stations, frame, noise, True, WorldRef(world_origin, CRS))
    return Scene(scan, (wall,), points.label, points.house, frame)


def _furniture(
    rng: np.random.Generator, length: float, slope: float, trees: bool, cars: bool
) -> tuple[tuple[Ball, ...], tuple[Box, ...]]:
    """Trees on the pavement and parked cars beside the kerb, street frame."""
    crowns = []
    for s in np.arange(5.0, length, 11.0) if trees else ():
        s = float(s + rng.uniform(-1, 1))
        crowns.append(Ball((s, -3.4, slope * s + float(rng.uniform(4.0, 5.2))), float(rng.uniform(1.2, 1.8))))
    boxes = []
    for s in np.arange(2.0, length - 5.0, 9.0) if cars else ():
        s = float(s + rng.uniform(0, 2))
        z = slope * s - 0.12
        boxes.append(Box((s, -5.2, z), (s + 4.3, -3.4, z + 1.45), "car"))
    return tuple(crowns), tuple(boxes)


def _stations(length: float, slope: float) -> Float:
    """Stations (k, 3) in the middle of the road, about 8 m apart, street frame."""
    s = np.linspace(0.0, length, max(2, round(length / 8) + 1))
    return np.column_stack([s, np.full(len(s), -STREET_WIDTH / 2), slope * s + 1.7])


def _from(rng: np.random.Generator, points: Points, stations: Float) -> tuple[Points, Array]:
    """Give every point (street frame) one of the two stations nearest to it; drop averted surfaces."""
    step = stations[1, 0] - stations[0, 0] if len(stations) > 1 else 1.0
    place = np.floor(points.xyz[:, 0] / step + rng.integers(0, 2, len(points.xyz))).astype(np.int64)
    eye = np.clip(place, 0, len(stations) - 1)
    ray = stations[eye] - points.xyz
    cosine = (ray * points.normal).sum(1) / np.linalg.norm(ray, axis=1)
    facing = (cosine > GRAZING) | ~points.normal.any(1)
    return points.keep(facing), eye[facing]


def _seen(
    rng: np.random.Generator, number: int, row: tuple[HouseTruth, ...], frame: Rigid3, stations: Float,
    spacing: float, room: bool,
) -> tuple[Points, Array]:  # fmt: skip
    """A house's points that its stations see: facing them and, behind the wall, through an opening."""
    house = row[number]
    street_from_facade = frame.inverse @ house.local_from_facade
    points = house_points(rng, number, house, spacing, room).moved(street_from_facade)
    points = points.keep(~_inside_neighbour(points, house, row))
    points, eye = _from(rng, points, stations)
    facade_from_street = street_from_facade.inverse
    local, eyes = points.moved(facade_from_street), facade_from_street.apply(stations[eye])
    seen = through_hole(house, local, eyes) & ~behind_boxes(house, local.xyz, eyes)
    return points.keep(seen), eye[seen]


def _inside_neighbour(points: Points, house: HouseTruth, row: tuple[HouseTruth, ...]) -> Array:
    """True (n,) for points of a side wall (street frame) that a neighbour's body or roof covers."""
    covered = np.zeros(len(points.xyz), bool)
    s, d, z = points.xyz.T
    for other in row:
        if other.side == house.side and other is not house:
            depth = d - other.offset if other.side == 0 else -STREET_WIDTH - other.offset - d
            below = z < other.ground_z + other.height + 0.6 * np.clip(depth - 0.3, 0, None)
            covered |= (s > other.s0 - 0.01) & (s < other.s1 + 0.01) & (depth > 0) & below
    return covered & (points.label == SIDE)


def _visible(
    rng: np.random.Generator,
    xyz: Float,
    eye: Float,
    trees: tuple[Ball, ...],
    cars: tuple[Box, ...],
    label: Array,
) -> Array:
    """True (n,) where no car and no leaf stands before the point."""
    hidden = np.zeros(len(xyz), bool)
    for tree in trees:
        near = np.flatnonzero((np.abs(xyz[:, 0] - tree.centre[0]) < 12) & (label != TREE))
        hit = hidden_by_ball(eye[near], xyz[near], tree) & (rng.random(len(near)) < tree.density)
        hidden[near[hit]] = True
    for car in cars:
        near = np.flatnonzero((xyz[:, 0] > car.low[0] - 9) & (xyz[:, 0] < car.high[0] + 9) & (label != CAR))
        hidden[near[hidden_by_box(eye[near], xyz[near], car)]] = True
    return ~hidden


def _scan(
    rng: np.random.Generator, points: Points, eye: Array, stations: Float, frame: Rigid3, noise: float,
    colour: bool, world: WorldRef,
) -> Scan:  # fmt: skip
    """Noise along the ray, colours, intensity and the street frame turned into the local one."""
    ray = points.xyz - stations[eye]
    ray /= np.linalg.norm(ray, axis=1, keepdims=True)
    xyz = points.xyz + ray * rng.normal(0.0, noise, (len(ray), 1))
    lit = np.clip(points.rgb, 0, 1)
    grey = lit @ np.float32([0.3, 0.59, 0.11])
    intensity = np.clip(0.15 + 0.6 * grey + rng.normal(0, 0.02, len(grey)), 0, 1).astype(np.float32)
    rgb = (lit * 255).astype(np.uint8) if colour else None
    return Scan("simulated street", frame.apply(xyz), world, frame.apply(stations), eye.astype(np.int32),
                intensity, rgb, sigma_range=noise if noise > 0 else None)  # fmt: skip


def write_scene(folder: str | Path, scene: Scene | None = None, **options: object) -> Path:
    """Write scan.laz, photos/, colmap/, truth.json and project.toml to `folder`; see scene_files.py."""
    from scene_files import write

    return write(Path(folder), scene or street_scene(houses=3, spacing=0.03), **options)


if __name__ == "__main__":
    print(write_scene(sys.argv[1]))
