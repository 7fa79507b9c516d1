"""Which unknown stands in which column, which rows take part, and how the points are cut into chunks."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from frontage.geometry.arrays import Array, Bool, Float, Int
from frontage.orientation.adjustment.network import Network

_CHUNK_POINTS = 512


@dataclass(frozen=True, eq=False)
class Chunk:
    """Some points that are neighbours, and the columns of the bodies and cameras that see them.

    points    slice of the active points
    rows      slice of the active image rows
    columns   (c,) int64, sorted
    address   (r, 3, k) int64: where the product of the derivatives of each row by point coordinate and column
              is added in a table (points, 3, c + 1); the last column takes what belongs to no unknown
    """

    points: slice
    rows: slice
    columns: Int
    address: Int

    @property
    def size(self) -> int:
        """The number of points."""
        return int(self.points.stop - self.points.start)

    @property
    def local(self) -> Int:
        """For every row its columns (r, k) within the chunk; `len(columns)` where it has none."""
        return np.asarray(self.address[:, 0] % (len(self.columns) + 1), np.int64)


@dataclass(frozen=True, eq=False)
class Layout:
    """The unknowns and rows of one minimisation.

    bodies        number of bodies b; their columns are 0 .. 6 b - 1
    free          per camera the numbers of its estimated parameters; their columns follow
    mounted       per mount the numbers of its estimated parameters; their columns are the last
    columns       number u of columns of bodies, cameras and mounts
    photo_columns (p, k) int64: columns of every photo (six of the body, then the camera's, then the mount's);
                  u for padding
    points        (a,) int64: the points that take part, neighbours together
    rows          (m_a,) int64: the image rows that take part, in the order of their points
    slot          (m_a,) int64: the place of each row's point in `points`
    photo         (m_a,) int64: its photo
    surface_rows  (k_a,) int64; `surface_slot` (k_a,) likewise
    """

    bodies: int
    free: tuple[Int, ...]
    mounted: tuple[Int, ...]
    columns: int
    photo_columns: Int
    points: Int
    rows: Int
    slot: Int
    photo: Int
    surface_rows: Int
    surface_slot: Int

    @property
    def width(self) -> int:
        """The number k of columns of a row."""
        return int(self.photo_columns.shape[1])

    @property
    def first_mounted(self) -> int:
        """Where the columns of the mounts begin in `photo_columns`."""
        return 6 + max((len(f) for f in self.free), default=0)

    @property
    def all_cameras(self) -> slice:
        """The columns of the estimated parameters of all cameras."""
        return slice(6 * self.bodies, 6 * self.bodies + sum(len(f) for f in self.free))

    @property
    def all_mounts(self) -> slice:
        """The columns of the estimated parameters of all mounts."""
        return slice(self.all_cameras.stop, self.columns)

    def camera_columns(self, camera: int) -> slice:
        """The columns of the estimated parameters of a camera."""
        start = 6 * self.bodies + sum(len(f) for f in self.free[:camera])
        return slice(start, start + len(self.free[camera]))

    def mount_columns(self, mount: int) -> slice:
        """The columns of the estimated parameters of a mount."""
        start = self.all_mounts.start + sum(len(f) for f in self.mounted[:mount])
        return slice(start, start + len(self.mounted[mount]))

    @cached_property
    def rows_of_photo(self) -> tuple[Int, ...]:
        """Per photo the positions of its rows among the active ones."""
        order = np.argsort(self.photo, kind="stable")
        ends = np.cumsum(np.bincount(self.photo, minlength=len(self.photo_columns)))
        return tuple(np.split(order, ends[:-1]))

    @cached_property
    def chunks(self) -> tuple[Chunk, ...]:
        """The points in chunks."""
        starts = range(0, len(self.points), _CHUNK_POINTS)
        return tuple(self._chunk(s, min(s + _CHUNK_POINTS, len(self.points))) for s in starts)

    def _chunk(self, start: int, stop: int) -> Chunk:
        first, last = (int(i) for i in np.searchsorted(self.slot, [start, stop]))
        wide = self.photo_columns[self.photo[first:last]]
        columns = np.unique(wide)
        columns = columns[columns < self.columns]
        place = np.full(self.columns + 1, len(columns))
        place[columns] = np.arange(len(columns))
        corner = (self.slot[first:last, None] - start) * 3 + np.arange(3)
        address = corner[:, :, None] * (len(columns) + 1) + place[wide][:, None, :]
        return Chunk(slice(start, stop), slice(first, last), columns, address)

    def by_point(self, values: Array) -> Float:
        """Sums values (m_a, ...) of the image rows over each point: (a, ...)."""
        return _summed(values, self.slot, len(self.points))

    def by_surface_point(self, values: Array) -> Float:
        """Sums values (k_a, ...) of the surface rows over each point: (a, ...)."""
        return _summed(values, self.surface_slot, len(self.points))


def _summed(values: Array, slot: Int, count: int) -> Float:
    shape = values.shape[1:]
    flat = values.reshape(len(values), int(np.prod(shape)))
    sums = [np.bincount(slot, flat[:, i], count) for i in range(flat.shape[1])]
    return np.asarray(np.stack(sums, axis=1).reshape(count, *shape), np.float64)


def determined_points(network: Network, images: Bool, surfaces: Bool) -> Bool:
    """Whether each point (n,) has enough rows: two rays, or three conditions with a ray or without."""
    rays = np.bincount(network.images.point[images], minlength=len(network.points))
    rows = np.bincount(network.surfaces.point[surfaces], minlength=len(network.points))
    return np.asarray((rays >= 2) | (2 * rays + rows >= 3))


def layout_of(network: Network, images: Bool, surfaces: Bool, points: Bool) -> Layout:
    """Lays out the rows `images` (m,) and `surfaces` (k,) of the `points` (n,) that take part."""
    bodies = len(network.poses)
    free = tuple(np.flatnonzero(s > 0) for s in network.camera_sigmas)
    mounted = tuple(np.flatnonzero(np.diag(m.covariance) > 0) for m in network.photos.mounts)
    rows = np.flatnonzero(images & points[network.images.point])
    surface_rows = np.flatnonzero(surfaces & points[network.surfaces.point])
    order = _neighbours_together(network, rows, np.flatnonzero(points))
    slot_of = np.zeros(len(network.points), np.int64)
    slot_of[order] = np.arange(len(order))
    rows = rows[np.argsort(slot_of[network.images.point[rows]], kind="stable")]
    columns = 6 * bodies + sum(len(f) for f in (*free, *mounted))
    return Layout(
        bodies,
        free,
        mounted,
        columns,
        _photo_columns(network, free, mounted),
        order,
        rows,
        slot_of[network.images.point[rows]],
        network.images.photo[rows],
        surface_rows,
        slot_of[network.surfaces.point[surface_rows]],
    )


def _photo_columns(network: Network, free: tuple[Int, ...], mounted: tuple[Int, ...]) -> Int:
    photos, first = network.photos, 6 * len(network.poses)
    blocks = [6 * photos.body[:, None] + np.arange(6)]
    end = first + sum(len(f) for f in (*free, *mounted))
    for parts, number in ((free, photos.camera), (mounted, photos.mount)):
        width = [len(f) for f in parts]
        start = first + np.cumsum([0, *width])
        place = np.arange(max(width, default=0))
        table = np.where(place < np.array(width)[:, None], start[:-1, None] + place, end)
        blocks.append(table[number])
        first = int(start[-1])
    return np.concatenate(blocks, axis=1)


def _neighbours_together(network: Network, rows: Int, points: Int) -> Int:
    """Orders points by the first and the last body that sees them, so that a chunk sees few bodies."""
    body = network.photos.body[network.images.photo[rows]]
    first = np.full(len(network.points), len(network.poses))
    last = np.full(len(network.points), -1)
    np.minimum.at(first, network.images.point[rows], body)
    np.maximum.at(last, network.images.point[rows], body)
    return points[np.lexsort((last[points], first[points]))]
