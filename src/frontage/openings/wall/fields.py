"""How high the stations of a scan look: above the highest beam of one of them, a wall returns fewer."""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import linprog

from frontage.geometry.arrays import Float, Int, freeze
from frontage.model.facade import Facade
from frontage.model.scan import Scan
from frontage.openings.wall.raster import WallRaster

_SHARE = 0.05  # share of a facade's beams that a station sends at least; of a vehicle, no place does
_LENGTH = 1e-3  # m, least length of a beam
_MOST_TILT = np.sin(np.radians(1.0))  # sine of a station's tilt, at most: tripods are levelled by eye
_UPRIGHT = np.array([0.0, 0.0, 1.0])
_SECTORS = 72  # of the horizon, in which the highest beam is looked for


@dataclass(frozen=True, eq=False)
class FieldOfView:
    """A station in the frame of a facade.

    eye      (3,) m, its place
    up       (3,) its axis, which is the vertical or close to it
    highest  sine of the elevation of its highest beam above the plane across that axis
    """

    eye: Float
    up: Float
    highest: float

    def __post_init__(self) -> None:
        freeze(self, eye=((3,), np.float64), up=((3,), np.float64))


def fields_of_view(facade: Facade, scan: Scan) -> tuple[FieldOfView, ...]:
    """Returns the fields of view of the stations that see a good part of a facade, from its working cloud."""
    number = len(scan.origins)
    own = scan.origin_index[facade.support]
    share = np.bincount(own[own >= 0], minlength=number) / max(len(own), 1)
    found = []
    for k in np.flatnonzero(share >= _SHARE).tolist():
        axis, highest = _upper_limit(scan, k)
        eye = facade.frame.inverse.apply(scan.origins[k][None])[0]
        found.append(FieldOfView(eye, axis @ facade.frame.R, highest))
    return tuple(found)


def _upper_limit(scan: Scan, station: int) -> tuple[Float, float]:
    """Returns the axis (3,) of a station and the sine of the elevation of its highest beam across it.

    A tripod is not quite upright, so that the station looks higher to one side than to the other. The axis
    is that of the narrowest cone around the highest beams of all directions, as far as they come near it.
    """
    own = scan.origin_index == station
    above = np.flatnonzero(own & (scan.xyz[:, 2] > scan.origins[station, 2]))
    beams = scan.xyz[above if len(above) else np.flatnonzero(own)] - scan.origins[station]
    length = np.maximum(np.sqrt(np.einsum("ij,ij->i", beams, beams)), _LENGTH)
    if not len(beams):
        return _UPRIGHT, -1.0
    sine = beams[:, 2] / length
    near = np.flatnonzero(sine >= sine.max() - 2.0 * _MOST_TILT)
    near = near[np.argsort(-sine[near], kind="stable")]
    beams = beams[near] / length[near, None]
    sector = np.floor(np.arctan2(beams[:, 1], beams[:, 0]) / (2.0 * np.pi) * _SECTORS)
    axis = _axis_of_cone(beams[np.unique(sector, return_index=True)[1]])
    return axis, float((beams @ axis).max())


def _axis_of_cone(beams: Float) -> Float:
    """Returns the axis (3,) of the cone that holds unit vectors (n, 3) with the least sum of distances.

    The axis is upright if there are fewer than three vectors, which tell nothing about a tilt.
    """
    if len(beams) < 3:
        return _UPRIGHT
    # beams @ (tilt, 1) <= sine of the cone
    across, up = beams[:, :2], beams[:, 2]
    tilt = (-_MOST_TILT, _MOST_TILT)
    found = linprog(
        [*-across.sum(0), len(beams)],
        A_ub=np.column_stack([across, -np.ones(len(beams))]),
        b_ub=-up,
        bounds=[tilt, tilt, (None, None)],
    )
    if found.x is None:
        return _UPRIGHT
    axis = np.array([*found.x[:2], 1.0], np.float64)
    return np.asarray(axis / np.linalg.norm(axis), np.float64)


def zones(fields: tuple[FieldOfView, ...], raster: WallRaster) -> Int:
    """Returns a number (h, w) for every cell: cells with the same number are seen by the same stations."""
    out = np.zeros(raster.shape, np.int64)
    if not fields:
        return out
    x, z = raster.middles(np.ones(raster.shape, np.bool_)).T
    places = np.column_stack([x, np.zeros(len(x)), z])
    for k, field in enumerate(fields):
        beam = places - field.eye
        seen = beam @ field.up <= field.highest * np.linalg.norm(beam, axis=1)
        out += seen.reshape(raster.shape).astype(np.int64) << k
    return out
