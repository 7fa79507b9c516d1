"""Points of a simulated street: surfaces on jittered grids, seen from stations, thinned where hidden."""

from dataclasses import dataclass

import numpy as np

from frontage.geometry.arrays import Array, Float
from frontage.geometry.rigid import Rigid3
from scene_parts import (
    CAR,
    CLUTTER,
    FACADE,
    GROUND,
    INTERIOR,
    KERB,
    POLE,
    ROOF,
    SIDE,
    STREET_WIDTH,
    TREE,
    Ball,
    Box,
    HouseTruth,
)  # fmt: skip
from scene_texture import (
    car_colour,
    ground_colour,
    leaf_colour,
    pane_colour,
    pane_is_solid,
    stone_colour,
    wall_colour,
)

Rng = np.random.Generator


@dataclass
class Points:
    """Points with normals (zero = seen from everywhere), colours 0..1, labels and house numbers (-1 none)."""

    xyz: Float
    normal: Float
    rgb: Array
    label: Array
    house: Array

    @staticmethod
    def of(xyz: Float, normal: Array, rgb: Array, label: int, house: int = -1) -> "Points":
        n = len(xyz)
        return Points(xyz, np.broadcast_to(normal, (n, 3)).astype(float), np.asarray(rgb, np.float32),
                      np.full(n, label, np.uint8), np.full(n, house, np.int32))  # fmt: skip

    def keep(self, where: Array) -> "Points":
        return Points(
            self.xyz[where], self.normal[where], self.rgb[where], self.label[where], self.house[where]
        )

    def moved(self, pose: Rigid3) -> "Points":
        return Points(pose.apply(self.xyz), pose.rotate(self.normal), self.rgb, self.label, self.house)


def join(parts: list[Points]) -> Points:
    return Points(
        *(np.concatenate([getattr(p, f) for p in parts]) for f in ("xyz", "normal", "rgb", "label", "house"))
    )


def grid(rng: Rng, u0: float, v0: float, u1: float, v1: float, spacing: float) -> tuple[Float, Float]:
    """A jittered grid over a rectangle: u (n,), v (n,)."""
    nu, nv = max(1, round((u1 - u0) / spacing)), max(1, round((v1 - v0) / spacing))
    u, v = np.meshgrid((np.arange(nu) + 0.5) / nu, (np.arange(nv) + 0.5) / nv)
    u = u0 + (u1 - u0) * (u.ravel() + rng.uniform(-0.4, 0.4, u.size) / nu)
    v = v0 + (v1 - v0) * (v.ravel() + rng.uniform(-0.4, 0.4, v.size) / nv)
    return u, v


def box_points(rng: Rng, box: Box, spacing: float) -> tuple[Float, Float]:
    """The six faces of a box: xyz (n, 3) and outward normals (n, 3)."""
    lo, hi = np.array(box.low), np.array(box.high)
    xyz, normals = [], []
    for axis in range(3):
        a, b = (axis + 1) % 3, (axis + 2) % 3
        for end, sign in ((lo, -1.0), (hi, 1.0)):
            u, v = grid(rng, lo[a], lo[b], hi[a], hi[b], spacing)
            p = np.empty((len(u), 3))
            p[:, a], p[:, b], p[:, axis] = u, v, end[axis]
            xyz.append(p)
            normals.append(np.broadcast_to(np.eye(3)[axis] * sign, p.shape))
    return np.vstack(xyz), np.vstack(normals)


def house_points(rng: Rng, number: int, house: HouseTruth, spacing: float, interior: bool) -> Points:
    """Wall, reveals, frames, glass, protrusions, roof, side walls of a house, in its facade frame."""
    x, z = grid(rng, 0.0, 0.0, house.width, house.height, spacing)
    solid = house.opening_at(x, z) < 0
    x, z = x[solid], z[solid]
    parts = [
        Points.of(
            np.column_stack([x, 0 * x, z]), np.array([0, -1.0, 0]), wall_colour(house, x, z), FACADE, number
        )
    ]
    parts += [
        p
        for i in range(len(house.openings))
        for p in _opening_points(rng, number, house, i, spacing, interior)
    ]
    for box in house.boxes:
        xyz, normal = box_points(rng, box, spacing)
        front = (xyz[:, 1] < -1e-9) & (normal[:, 1] < 0.5)
        xyz, normal = xyz[front], normal[front]
        parts.append(Points.of(xyz, normal, stone_colour(xyz[:, 0], xyz[:, 2]), FACADE, number))
    return join([*parts, *_body_points(rng, number, house, spacing)])


def _body_points(rng: Rng, number: int, house: HouseTruth, spacing: float) -> list[Points]:
    """The roof above the eaves and the two side walls (seen only where a neighbour is lower or missing)."""
    x, u = grid(rng, 0.0, 0.0, house.width, 4.0, spacing * 1.5)
    roof = np.column_stack([x, 0.3 + u, house.height + 0.6 * u])
    up = np.array([0, -0.6, 1.0]) / np.hypot(0.6, 1.0)
    red = np.tile(np.float32([0.5, 0.25, 0.2]), (len(x), 1))
    out = [Points.of(roof, up, red, ROOF, number)]
    for end, sign in ((0.0, -1.0), (house.width, 1.0)):
        y, z = grid(rng, 0.02, 0.0, 6.0, house.height, spacing * 1.5)
        xyz = np.column_stack([np.full(len(y), end), y, z])
        grey = np.tile(np.float32([0.6, 0.58, 0.55]), (len(y), 1))
        out.append(Points.of(xyz, np.array([sign, 0, 0]), grey, SIDE, number))
    return out


def _opening_points(
    rng: Rng, number: int, house: HouseTruth, index: int, spacing: float, interior: bool
) -> list[Points]:
    o = house.openings[index]
    x, z = grid(rng, o.x0, o.z0, o.x1, o.z1, spacing)
    solid = pane_is_solid(o, x, z) | (rng.random(len(x)) < 0.08)  # glass sends few beams back
    xyz = np.column_stack([x, np.full(len(x), o.depth), z])[solid]
    out = [Points.of(xyz, np.array([0, -1.0, 0]), pane_colour(o, x, z)[solid], FACADE, number)]
    reveals = Box((o.x0, 0.0, o.z0), (o.x1, o.depth, o.z1))
    xyz, normal = box_points(rng, reveals, spacing)
    inner = np.abs(normal[:, 1]) < 0.5
    colour = stone_colour(xyz[inner, 1] * 9, xyz[inner, 2] + xyz[inner, 0])
    out.append(Points.of(xyz[inner], -normal[inner], colour, FACADE, number))
    if interior and o.kind != "door":
        room = Box((o.x0 - 1.2, o.depth + 0.1, o.z0 - 0.9), (o.x1 + 1.2, 4.0, o.z1 + 0.5))
        xyz, normal = box_points(rng, room, spacing * 2)
        behind = normal[:, 1] > -0.5
        grey = np.tile(np.float32([0.35, 0.32, 0.30]), (int(behind.sum()), 1))
        out.append(Points.of(xyz[behind], -normal[behind], grey, INTERIOR, number))
    return out


def through_hole(house: HouseTruth, points: Points, eye: Float) -> Array:
    """True (n,) where the ray from `eye` (n, 3) to the point passes the wall through an opening, or need not.

    Both in the facade frame. Roofs and side walls are not behind the wall.
    """
    y, ye = points.xyz[:, 1], eye[:, 1]
    behind = (y > 1e-6) & ((points.label == FACADE) | (points.label == INTERIOR))
    share = np.where(behind, -ye / np.where(behind, y - ye, 1.0), 0.0)
    cross = eye + share[:, None] * (points.xyz - eye)
    return ~behind | (house.opening_at(cross[:, 0], cross[:, 2]) >= 0)


def ground_points(
    rng: Rng, s0: float, s1: float, d0: float, d1: float, slope: float, spacing: float
) -> Points:
    """Pavements and a road 12 cm lower, street frame."""
    s, d = grid(rng, s0, d0, s1, d1, spacing)
    road = (d < -KERB) & (d > KERB - STREET_WIDTH)
    z = slope * s - 0.12 * road
    return Points.of(np.column_stack([s, d, z]), np.zeros(3), ground_colour(s, d), GROUND)


def tree_points(rng: Rng, tree: Ball, spacing: float) -> Points:
    """A porous crown and its trunk, street frame."""
    n = int(min(60_000, 3.0 * (tree.radius / spacing) ** 2))
    v = rng.normal(size=(n, 3))
    r = tree.radius * rng.uniform(0.35, 1.0, n) ** 0.5
    xyz = np.array(tree.centre) + v / np.linalg.norm(v, axis=1, keepdims=True) * r[:, None]
    crown = Points.of(xyz, np.zeros(3), leaf_colour(xyz), TREE)
    height = tree.centre[2] - 0.7 * tree.radius
    a, z = grid(rng, 0.0, 0.0, 2 * np.pi, height, spacing)
    trunk = np.column_stack([tree.centre[0] + 0.13 * np.cos(a), tree.centre[1] + 0.13 * np.sin(a), z])
    bark = np.tile(np.float32([0.30, 0.24, 0.18]), (len(a), 1))
    return join([crown, Points.of(trunk, np.column_stack([np.cos(a), np.sin(a), 0 * a]), bark, TREE)])


def car_points(rng: Rng, number: int, box: Box, spacing: float) -> Points:
    xyz, normal = box_points(rng, box, spacing)
    return Points.of(xyz, normal, car_colour(xyz, number), CAR)


def pole_points(rng: Rng, s: float, d: float, z: float, spacing: float) -> Points:
    """A street lamp: a post 7 m high, street frame."""
    a, h = grid(rng, 0.0, 0.0, 2 * np.pi, 7.0, spacing)
    xyz = np.column_stack([s + 0.07 * np.cos(a), d + 0.07 * np.sin(a), z + h])
    dark = np.tile(np.float32([0.2, 0.2, 0.2]), (len(a), 1))
    return Points.of(xyz, np.column_stack([np.cos(a), np.sin(a), 0 * a]), dark, POLE)


def clutter_points(rng: Rng, count: int, width: float, height: float) -> Points:
    """Outliers about a wall, facade frame: a volume, two blobs and a room's back wall behind it."""
    volume = rng.uniform((-1, -3, 0), (width + 1, 3, height + 1), (count // 2, 3))
    blob = rng.normal(size=(count // 4, 3)) * (1.2, 0.8, 1.2) + np.array([width / 3, -2.0, height / 3])
    rest = count - len(volume) - len(blob)
    back = np.column_stack([rng.uniform(0, width, rest), np.full(rest, 2.5), rng.uniform(0, height, rest)])
    xyz = np.vstack([volume, blob, back])
    return Points.of(xyz, np.zeros(3), np.tile(np.float32([0.4, 0.5, 0.4]), (count, 1)), CLUTTER)


def hidden_by_ball(eye: Float, xyz: Float, ball: Ball) -> Array:
    """True (n,) where the segment from eye (n, 3) to xyz (n, 3) passes within the ball's radius."""
    ray = xyz - eye
    share = np.clip(((np.array(ball.centre) - eye) * ray).sum(1) / (ray * ray).sum(1), 0.0, 1.0)
    gap = eye + share[:, None] * ray - np.array(ball.centre)
    return (gap * gap).sum(1) < ball.radius**2


def hidden_by_box(eye: Float, xyz: Float, box: Box) -> Array:
    """True (n,) where the segment from eye to xyz enters the box before it ends (slab test)."""
    ray = xyz - eye
    ray = np.where(np.abs(ray) < 1e-12, 1e-12, ray)
    a, b = (np.array(box.low) - eye) / ray, (np.array(box.high) - eye) / ray
    near, far = np.minimum(a, b).max(1), np.maximum(a, b).min(1)
    return (near < far) & (far > 0) & (near < 1 - 1e-4)


def behind_boxes(house: HouseTruth, xyz: Float, eye: Float) -> Array:
    """True (n,) where a cornice, sill or balcony hides the point from `eye` (n, 3), facade frame."""
    hidden = np.zeros(len(xyz), bool)
    for box in house.boxes:
        (x0, _, z0), (x1, _, z1) = box.low, box.high
        x, _, z = xyz.T
        near = np.flatnonzero((x > x0 - 3) & (x < x1 + 3) & (z > z0 - 0.05) & (z < z1 + 6) & ~hidden)
        hidden[near[hidden_by_box(eye[near], xyz[near], box)]] = True
    return hidden
