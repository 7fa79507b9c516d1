"""Box-shaped houses on flat ground: a city model, and scans of it with known sensor positions."""

from dataclasses import dataclass, replace

import numpy as np

from frontage.geometry.arrays import Array, Float
from frontage.geometry.rigid import Rigid3
from frontage.model import CityBuilding, CityModel, Scan, Shell, Surface, WorldRef
from frontage.registration import PosePrior

WORLD = WorldRef(np.array([500_000, 5_400_000, 0]), "EPSG:25832")
SIZE = (9.0, 10.0, 8.0)


@dataclass(frozen=True)
class BoxHouse:
    """A box-shaped house.

    x, y                  m, middle of the foot of its front
    width, depth, height  m
    turn                  rad, heading of the axis into the house
    """

    x: float
    y: float
    width: float = 9.0
    depth: float = 10.0
    height: float = 8.0
    turn: float = 0.0

    @property
    def frame(self) -> Rigid3:
        c, s = np.cos(self.turn), np.sin(self.turn)
        R = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
        return Rigid3("local", "box", R, np.array([self.x, self.y, 0.0]))

    def faces(self) -> list[tuple[str, Float]]:
        """Semantics and rings (4, 3), counter-clockwise from outside."""
        w, d, h = self.width / 2, self.depth, self.height
        p = np.array([[i, j, k] for k in (0, h) for i, j in ((-w, 0), (w, 0), (w, d), (-w, d))], float)
        p = self.frame.apply(p)
        rings = [[0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]]
        walls = [("WallSurface", p[r]) for r in rings]
        return [*walls, ("RoofSurface", p[[4, 5, 6, 7]]), ("GroundSurface", p[[3, 2, 1, 0]])]


STREET = (
    BoxHouse(-10, 6),
    BoxHouse(0, 6.4, height=10),
    BoxHouse(9, 6, height=7),
    BoxHouse(-6, -7, turn=np.pi),
    BoxHouse(5, -7.5, turn=np.pi + 0.1, height=9),
    BoxHouse(24, 0, width=14, turn=-np.pi / 2, height=9),
)
ALONE = (BoxHouse(0, 8, width=30),)


def model_of(boxes: tuple[BoxHouse, ...], shift: Array | None = None) -> CityModel:
    """Returns the houses as an LoD1 model, each moved by its row of `shift` (b, 3) m."""
    move = np.zeros((len(boxes), 3)) if shift is None else shift
    shells = [
        Shell("1.2", tuple(Surface(r + move[k], s, f"B{k}-{n}") for n, (s, r) in enumerate(b.faces())))
        for k, b in enumerate(boxes)
    ]
    return CityModel(tuple(CityBuilding(f"B{k}", (s,)) for k, s in enumerate(shells)), WORLD)


def scan_of(
    boxes: tuple[BoxHouse, ...], place: Array, seed: int = 0, step: float = 0.07, noise: float = 0.004
) -> Scan:
    """Returns the points of walls and ground that are visible from `place` (3,) m, in true coordinates."""
    rng = np.random.default_rng(seed)
    parts = [_ground(place, rng)]
    for b in boxes:
        for semantics, ring in b.faces():
            if semantics == "WallSurface":
                parts.append(_wall(ring, place, step, noise, rng))
    xyz = np.concatenate(parts)
    hidden = np.zeros(len(xyz), np.bool_)
    for b in boxes:
        hidden |= _blocked(b, place, xyz)
    xyz = xyz[~hidden & (np.linalg.norm(xyz - place, axis=1) < 60)]
    return Scan(f"S{seed}", xyz, WORLD, place[None], np.zeros(len(xyz), np.int32))


def _ground(place: Array, rng: np.random.Generator) -> Float:
    n = 60_000
    return np.column_stack([place[:2] + rng.uniform(-25, 25, (n, 2)), rng.normal(0, 0.005, n)])


def _wall(ring: Float, place: Array, step: float, noise: float, rng: np.random.Generator) -> Float:
    a, b = ring[1] - ring[0], ring[3] - ring[0]
    normal = np.cross(a, b) / np.linalg.norm(np.cross(a, b))
    if (place - ring[0]) @ normal <= 0.1:
        return np.zeros((0, 3))
    n = int(np.linalg.norm(a) * np.linalg.norm(b) / step**2)
    u, v = rng.uniform(0, 1, (2, n))
    return ring[0] + u[:, None] * a + v[:, None] * b + rng.normal(0, noise, n)[:, None] * normal


def _blocked(b: BoxHouse, place: Array, xyz: Float) -> Array:
    """Returns which lines of sight (n,) end inside the house or pass through it (slab test)."""
    start = b.frame.inverse.apply(place[None])[0]
    end = b.frame.inverse.apply(xyz)
    low = np.array([-b.width / 2, 0, 0]) + 0.05
    high = np.array([b.width / 2, b.depth, b.height]) - 0.05
    d = end - start
    d = np.where(np.abs(d) < 1e-9, 1e-9, d)
    t = np.stack([(low - start) / d, (high - start) / d])
    enter, leave = t.min(0).max(1), t.max(0).min(1)
    return (enter < np.minimum(leave, 1.0)) & (leave > 0) & (enter > 0)


@dataclass(frozen=True, eq=False)
class MisplacedScan:
    """A scan as GPS and compass would place it, its prior and its true correction."""

    scan: Scan
    prior: PosePrior
    true: Rigid3


def misplaced(
    scan: Scan, shift: Array, heading: float, sigma: tuple[float, float] = (2.5, 7.5), level: float = 0.0
) -> MisplacedScan:
    """Turns a scan by `heading` degrees about its place, tilts it by `level` degrees, shifts it by (3,) m."""
    c, s = np.cos(np.radians(heading)), np.sin(np.radians(heading))
    tilt = np.radians(level)
    lean = np.array([[1, 0, 0], [0, np.cos(tilt), -np.sin(tilt)], [0, np.sin(tilt), np.cos(tilt)]])
    R = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]) @ lean
    place = scan.origins[0]
    wrong = Rigid3("given", "local", R, place + shift - R @ place)
    given = replace(scan, xyz=wrong.apply(scan.xyz), origins=wrong.apply(scan.origins))
    prior = PosePrior(
        given.origins[0], np.array([sigma[0], sigma[0], 1.0]), np.radians(sigma[1]), np.radians(0.1)
    )
    return MisplacedScan(given, prior, wrong.inverse)
