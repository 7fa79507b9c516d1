"""How high the stations of a scan look: above the highest beam of one of them, a wall returns fewer."""

from dataclasses import dataclass

import numpy as np

from frontage.geometry.arrays import Float, Int, freeze
from frontage.model.facade import Facade
from frontage.model.scan import Scan
from frontage.openings.wall.raster import WallRaster

_SHARE = 0.05  # share of a facade's beams that a station sends at least; of a vehicle, no place does
_LENGTH = 1e-3  # m, least length of a beam


@dataclass(frozen=True, eq=False)
class FieldOfView:
    """A station in the frame of a facade.

    eye      (3,) m, its place
    up       (3,) the vertical
    highest  sine of the elevation of its highest beam
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
    some = np.flatnonzero(share >= _SHARE)
    eyes = facade.frame.inverse.apply(scan.origins[some])
    return tuple(
        FieldOfView(eye, facade.frame.R[2], _highest(scan, k))
        for eye, k in zip(eyes, some.tolist(), strict=True)
    )


def _highest(scan: Scan, station: int) -> float:
    """Returns the sine of the elevation of a station's highest beam."""
    own = scan.origin_index == station
    above = np.flatnonzero(own & (scan.xyz[:, 2] > scan.origins[station, 2]))
    rows = above if len(above) else np.flatnonzero(own)
    x, y, z = (scan.xyz[rows, k] - scan.origins[station, k] for k in range(3))
    return float((z / np.maximum(np.sqrt(x * x + y * y + z * z), _LENGTH)).max(initial=-1.0))


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
