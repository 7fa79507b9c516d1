"""Surfels: flat pieces of a scan, each of which stands for an area, however densely it was measured."""

from dataclasses import dataclass

import numpy as np

from frontage.geometry.arrays import Array, Bool, Float, Int
from frontage.geometry.rigid import Rigid3
from frontage.model import Scan

_FEWEST_POINTS = 6  # points of a surfel, at least
_LEVELS = 3  # sizes of cubes, each twice the one before
_FLAT = 0.3  # thickness of a surfel, relative to its smaller extent
_MOST_CUBES = 1 << 20  # cubes per axis


@dataclass(frozen=True, eq=False)
class Surfels:
    """Flat pieces of one scan, in the coordinates that it was given.

    xyz        (n, 3) m, centres
    normal     (n, 3) unit, towards the scanner where `oriented` (n,)
    area       (n,) m2
    thickness  (n,) m, one sigma across
    """

    xyz: Float
    normal: Float
    oriented: Bool
    area: Float
    thickness: Float

    def __len__(self) -> int:
        return len(self.xyz)

    def take(self, index: Array) -> "Surfels":
        """Returns the surfels at `index` (k,), or where a mask (n,) is set."""
        return Surfels(*(getattr(self, f)[index] for f in self.__annotations__))

    def moved(self, to_from_given: Rigid3) -> "Surfels":
        """Returns the surfels after a rigid motion."""
        return Surfels(
            to_from_given.apply(self.xyz),
            to_from_given.rotate(self.normal),
            self.oriented,
            self.area,
            self.thickness,
        )

    @property
    def upright(self) -> Bool:
        """Surfels of walls (n,): normals within 17 degrees of the horizon."""
        return np.asarray(np.abs(self.normal[:, 2]) < 0.3, np.bool_)

    @property
    def level(self) -> Bool:
        """Surfels of ground (n,): normals within 18 degrees of the plumb line, pointing up."""
        return np.asarray(self.normal[:, 2] > 0.95, np.bool_)


def merge_surfels(parts: list[Surfels]) -> Surfels:
    """Concatenates lists of surfels."""
    return Surfels(*(np.concatenate([getattr(p, f) for p in parts]) for f in Surfels.__annotations__))


def make_surfels(scan: Scan, cell: float, centre: Float, reach: float) -> Surfels:
    """Cuts the points of a scan within `reach` m of `centre` (3,) m into surfels, cube by cube.

    A surfel is the plane through the points of a cube of `cell` m, from their principal axes. Points in cubes
    that hold too few go to cubes twice as wide, and once more; the rest is dropped.
    """
    near = np.flatnonzero(np.square(scan.xyz[:, :2] - centre[:2]).sum(1) < reach * reach)
    rest = near
    parts: list[Surfels] = []
    for k in range(_LEVELS):
        if len(rest) < _FEWEST_POINTS:
            break
        xyz = scan.xyz[rest] - centre
        number, count = _cubes(xyz, cell * 2**k)
        full = count[number] >= _FEWEST_POINTS
        if full.any():
            parts.append(_pieces(scan, rest[full], xyz[full], number[full], centre))
        rest = rest[~full]
    if not parts:
        none = np.zeros(0)
        return Surfels(np.zeros((0, 3)), np.zeros((0, 3)), np.zeros(0, np.bool_), none, none)
    return merge_surfels(parts)


def _cubes(xyz: Float, cell: float) -> tuple[Int, Int]:
    """Returns the cube (n,) of every point, numbered from 0, and how many points each cube holds (k,)."""
    ijk = np.floor(xyz * (1.0 / cell)).astype(np.int64) + _MOST_CUBES // 2
    key = (ijk[:, 0] * _MOST_CUBES + ijk[:, 1]) * _MOST_CUBES + ijk[:, 2]
    _, number, count = np.unique(key, return_inverse=True, return_counts=True)
    return number.astype(np.int64), count.astype(np.int64)


def _pieces(scan: Scan, index: Int, xyz: Float, number: Int, centre: Float) -> Surfels:
    """Makes a surfel of each cube.

    index   (m,) points of the scan; `xyz` (m, 3) m about the centre; `number` (m,) their cube
    """
    _, first, number, count = np.unique(number, return_index=True, return_inverse=True, return_counts=True)
    k = len(count)
    mean = np.column_stack([np.bincount(number, xyz[:, a], k) for a in range(3)]) / count[:, None]
    d = xyz - mean[number]
    moment = np.empty((k, 3, 3))
    for a in range(3):
        for b in range(a, 3):
            moment[:, a, b] = moment[:, b, a] = np.bincount(number, d[:, a] * d[:, b], k) / (count - 1)
    values, vectors = np.linalg.eigh(moment)
    values = np.maximum(values, 0.0)
    flat = (values[:, 0] < _FLAT**2 * values[:, 1]) & (values[:, 1] > 0.02 * values[:, 2])
    normal = vectors[:, :, 0]
    sensor = scan.sensor_of(index[first]) - centre
    towards = np.einsum("ij,ij->i", normal, sensor - mean)
    oriented = np.isfinite(towards) & (np.abs(towards) > 1e-9)
    # without a ray the normal points upwards, as roofs and ground are seen from above
    sign = np.where(oriented, np.sign(np.where(oriented, towards, 1.0)), np.sign(normal[:, 2] + 1e-12))
    area = 12.0 * np.sqrt(values[:, 1] * values[:, 2])  # of a square with these variances
    s = Surfels(mean + centre, normal * sign[:, None], oriented, area, np.sqrt(values[:, 0]))
    return s.take(flat)
