"""Photographs of a simulated street, ray by ray: exact planes, boxes and balls, lens by `camera.ray`."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from frontage.geometry.arrays import Array, Float
from frontage.geometry.rigid import Rigid3
from frontage.model import Camera
from scene_parts import KERB, STREET_WIDTH, Ball, Box, HouseTruth
from scene_texture import (
    car_colour,
    ground_colour,
    hash01,
    leaf_colour,
    pane_colour,
    stone_colour,
    wall_colour,
)

if TYPE_CHECKING:
    from scenes import Scene

SKY = np.float32([0.74, 0.84, 0.95])


class Film:
    """Rays of one pass over the image and what each has met first: distance `t` (h, w), colour (h, w, 3)."""

    def __init__(self, origin: Float, direction: Array, camera: Camera, camera_from_street: Rigid3) -> None:
        self.origin, self.direction = origin, direction
        self.camera, self.camera_from_street = camera, camera_from_street
        self.t = np.full(direction.shape[:2], np.inf, np.float32)
        self.rgb = np.broadcast_to(SKY, direction.shape).copy()

    def window(self, corners: Float, margin: float = 0.03) -> tuple[slice, slice]:
        """Rows and columns that may see the convex hull of `corners` (k, 3), street frame."""
        whole = (slice(None), slice(None))
        if (self.camera_from_street.apply(corners)[:, 2] < 0.3).any():
            return whole
        uv = self.camera.project(self.camera_from_street.apply(corners))
        if not np.isfinite(uv).all():
            return whole
        h, w = self.t.shape
        (u0, v0), (u1, v1) = uv.min(0) - margin * w, uv.max(0) + margin * w
        return slice(*np.clip([int(v0), int(v1) + 1], 0, h)), slice(*np.clip([int(u0), int(u1) + 1], 0, w))

    def put(self, rows: tuple[slice, slice], where: Array, t: Array, rgb: Array) -> None:
        """Colour the rays `where` (flat index into the window), met at `t`; the caller checked nearness."""
        h, w = self.t[rows].shape
        at = np.unravel_index(where, (h, w))
        self.t[rows][at] = t
        self.rgb[rows][at] = rgb


def render_photo(scene: Scene, camera: Camera, pose: Rigid3, supersample: int = 2) -> Array:
    """The photograph (h, w, 3) uint8 RGB of `camera` at `pose` (local_from_camera)."""
    street_from_camera = scene.local_from_street.inverse @ pose
    corners = _normalised_corners(camera)
    total = np.zeros((camera.height, camera.width, 3), np.float32)
    for k in range(supersample**2):
        fu, fv = (k % supersample + 0.5) / supersample, (k // supersample + 0.5) / supersample
        film = Film(
            street_from_camera.t,
            _directions(corners, fu, fv, street_from_camera.R),
            camera,
            street_from_camera.inverse,
        )
        _shoot(film, scene)
        total += film.rgb
    return np.clip(total * (255.0 / supersample**2), 0, 255).astype(np.uint8)


def _normalised_corners(camera: Camera) -> Array:
    """x/z, y/z (h+1, w+1, 2) of the rays through pixel corners; linear between them to 1e-6."""
    u, v = np.meshgrid(np.arange(camera.width + 1.0), np.arange(camera.height + 1.0))
    ray = camera.ray(np.column_stack([u.ravel(), v.ravel()]))
    return (ray[:, :2] / ray[:, 2:]).reshape(camera.height + 1, camera.width + 1, 2).astype(np.float32)


def _directions(corners: Array, fu: float, fv: float, R: Float) -> Array:
    top = corners[:-1, :-1] * np.float32(1 - fu) + corners[:-1, 1:] * np.float32(fu)
    bottom = corners[1:, :-1] * np.float32(1 - fu) + corners[1:, 1:] * np.float32(fu)
    uv = top * np.float32(1 - fv) + bottom * np.float32(fv)
    Q = R.astype(np.float32)
    return uv[..., :1] * Q[:, 0] + uv[..., 1:] * Q[:, 1] + Q[:, 2]


def _shoot(film: Film, scene: Scene) -> None:
    _ground(film, scene.slope)
    for house in scene.houses:
        frame = scene.local_from_street.inverse @ house.local_from_facade
        _wall(film, house, frame)
        _body(film, house, frame)
        for box in house.boxes:
            _box(film, box, frame, lambda p: stone_colour(p[:, 0], p[:, 2]))
    street = Rigid3.identity("street", "street")
    for i, car in enumerate(scene.cars):
        _box(film, car, street, lambda p, i=i: car_colour(p, i))
    for tree in scene.trees:
        s, d, z = tree.centre
        trunk = Box((s - 0.13, d - 0.13, 0.0), (s + 0.13, d + 0.13, z))
        _box(film, trunk, street, lambda p: np.tile(np.float32([0.30, 0.24, 0.18]), (len(p), 1)))
        _ball(film, tree)


def _ground(film: Film, slope: float) -> None:
    o, direction = film.origin, film.direction
    down = direction[..., 2] - np.float32(slope) * direction[..., 0]
    height = o[2] - slope * o[0]
    index = np.flatnonzero(down < -1e-4)
    ray = direction.reshape(-1, 3)[index]
    t = (-height / down.ravel()[index]).astype(np.float32)
    d = o[1] + t * ray[:, 1]
    road = (d < -KERB) & (d > KERB - STREET_WIDTH)
    t = np.where(road, t * np.float32((height + 0.12) / height), t)
    s, d = o[0] + t * ray[:, 0], o[1] + t * ray[:, 1]
    near = t < 200
    film.put((slice(None), slice(None)), index[near], t[near], ground_colour(s[near], d[near]))


def _hits_plane(
    film: Film, house: HouseTruth, frame: Rigid3
) -> tuple[tuple[slice, slice], Array, Array, Array, Array]:
    """Rays that meet the wall first: window, flat index, origin (3,), ray (n, 3), t (n,), its frame."""
    w, h = house.width, house.height
    rows = film.window(frame.apply(np.array([[x, 0, z] for x in (0, w) for z in (0, h)])))
    o = frame.inverse.apply(film.origin[None])[0].astype(np.float32)
    ray = film.direction[rows].reshape(-1, 3) @ frame.R.astype(np.float32)
    with np.errstate(divide="ignore", invalid="ignore"):
        t = -o[1] / ray[:, 1]
        x, z = o[0] + t * ray[:, 0], o[2] + t * ray[:, 2]
    hit = (ray[:, 1] > 0) & (t > 0) & (t < film.t[rows].ravel()) & (x >= 0) & (x <= w) & (z >= -1) & (z <= h)
    index = np.flatnonzero(hit)
    return rows, index, o, ray[index], t[index]


def _wall(film: Film, house: HouseTruth, frame: Rigid3) -> None:
    rows, index, o, ray, t = _hits_plane(film, house, frame)
    if len(index) == 0:
        return
    x, z = o[0] + t * ray[:, 0], o[2] + t * ray[:, 2]
    rgb = wall_colour(house, x, z)
    opening = house.opening_at(x, z)
    order = np.argsort(opening, kind="stable")
    ends = np.searchsorted(opening[order], np.arange(len(house.openings) + 1))
    for i in range(len(house.openings)):
        k = order[ends[i] : ends[i + 1]]
        rgb[k] = _through(house, i, x[k], z[k], ray[k])
    film.put(rows, index, t, rgb)


def _through(house: HouseTruth, i: int, x: Array, z: Array, ray: Array) -> Array:
    """Colour of rays that enter opening i at (x, z): the recessed pane, or the reveal before it."""
    o = house.openings[i]
    step = ray * (o.depth / ray[:, 1])[:, None]
    xp, zp = x + step[:, 0], z + step[:, 2]
    inside = (xp >= o.x0) & (xp <= o.x1) & (zp >= o.z0) & (zp <= o.z1)
    with np.errstate(divide="ignore", invalid="ignore"):
        fx = np.where(xp < o.x0, (o.x0 - x) / step[:, 0], np.where(xp > o.x1, (o.x1 - x) / step[:, 0], 1.0))
        fz = np.where(zp < o.z0, (o.z0 - z) / step[:, 2], np.where(zp > o.z1, (o.z1 - z) / step[:, 2], 1.0))
    f = np.clip(np.minimum(fx, fz), 0, 1)
    xr, yr, zr = x + f * step[:, 0], f * o.depth, z + f * step[:, 2]
    return np.where(inside[:, None], pane_colour(o, xp, zp), stone_colour(yr * 9, zr + xr))


def _body(film: Film, house: HouseTruth, frame: Rigid3) -> None:
    """Side walls and roof."""
    box = Box((0.0, 0.02, 0.0), (house.width, 6.0, house.height))
    _box(film, box, frame, lambda p: np.tile(np.float32([0.6, 0.58, 0.55]), (len(p), 1)), entry_axis=0)
    top = frame.apply(
        np.array([[x, y, house.height + 0.6 * y] for x in (0, house.width) for y in (0.3, 4.3)])
    )
    rows = film.window(top)
    o = frame.inverse.apply(film.origin[None])[0]
    ray = film.direction[rows].reshape(-1, 3) @ frame.R.astype(np.float32)
    slant = ray[:, 2] - 0.6 * ray[:, 1]
    with np.errstate(divide="ignore", invalid="ignore"):
        t = ((house.height + 0.6 * (o[1] - 0.3) - o[2]) / slant).astype(np.float32)
        x, y = o[0] + t * ray[:, 0], o[1] + t * ray[:, 1]
    hit = (t > 0) & (t < film.t[rows].ravel()) & (x > 0) & (x < house.width) & (y > 0.3) & (y < 4.0)
    index = np.flatnonzero(hit)
    film.put(rows, index, t[index], np.tile(np.float32([0.5, 0.25, 0.2]), (len(index), 1)))


def _box(film: Film, box: Box, frame: Rigid3, colour: object, entry_axis: int | None = None) -> None:
    """An axis-aligned box of `frame` (slab test), coloured by `colour(points in its frame)`."""
    low, high = np.array(box.low), np.array(box.high)
    corners = np.array(
        [
            [(low, high)[a][0], (low, high)[b][1], (low, high)[c][2]]
            for a in (0, 1)
            for b in (0, 1)
            for c in (0, 1)
        ]
    )
    rows = film.window(frame.apply(corners))
    o = frame.inverse.apply(film.origin[None])[0]
    ray = film.direction[rows].reshape(-1, 3) @ frame.R.astype(np.float32)
    ray = np.where(np.abs(ray) < 1e-9, np.float32(1e-9), ray)
    a, b = ((low - o) / ray).astype(np.float32), ((high - o) / ray).astype(np.float32)
    entry = np.minimum(a, b)
    near, far = entry.max(1), np.maximum(a, b).min(1)
    hit = (near < far) & (near > 0) & (near < film.t[rows].ravel())
    if entry_axis is not None:
        hit &= entry.argmax(1) == entry_axis
    index = np.flatnonzero(hit)
    t = near[index]
    film.put(rows, index, t, colour(o + t[:, None] * ray[index]))  # type: ignore[operator]


def _ball(film: Film, ball: Ball) -> None:
    """A porous crown: rays through its gaps go on."""
    centre = np.array(ball.centre)
    rows = film.window(
        centre + ball.radius * np.array([[a, b, c] for a in (-1, 1) for b in (-1, 1) for c in (-1, 1)])
    )
    ray = film.direction[rows].reshape(-1, 3)
    to = (centre - film.origin).astype(np.float32)
    aa, ab = (ray * ray).sum(1), ray @ to
    disc = ab * ab - aa * np.float32(to @ to - ball.radius**2)
    t = (ab - np.sqrt(np.maximum(disc, 0))) / aa
    index = np.flatnonzero((disc > 0) & (t > 0) & (t < film.t[rows].ravel()))
    p = film.origin + t[index, None] * ray[index]
    cell = np.floor(p / 0.12).astype(np.int32)
    leaf = hash01(cell[:, 0] + 57 * cell[:, 1], cell[:, 2], 23) < ball.density
    film.put(rows, index[leaf], t[index[leaf]], leaf_colour(p[leaf]))
