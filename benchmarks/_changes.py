"""Changes of a scan that must not change what is found in it, or only a little."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from frontage.geometry.arrays import Float
from frontage.model import Scan

TURN_DEG = 37.0  # about the vertical: no multiple of the raster's symmetry
NOISE_M = 0.003
CROP = 0.2  # share of the length of the street that is cut off


@dataclass(frozen=True, eq=False)
class Changed:
    """A changed scan.

    back  takes points (n, 3) m of the changed scan to where they were before
    kept  tells which places (n, 3) m, before the change, are still in the scan with their surroundings
    """

    scan: Scan
    back: Callable[[Float], Float]
    kept: Callable[[Float], bool]


def _same(p: Float) -> Float:
    return p


def _all(_: Float) -> bool:
    return True


def shuffled(scan: Scan, seed: int = 1) -> Changed:
    """Put the points in another order."""
    return Changed(scan.take(np.random.default_rng(seed).permutation(len(scan))), _same, _all)


def thinned(scan: Scan, part: int, seed: int = 2) -> Changed:
    """Keep one point in `part`, drawn at random."""
    chosen = np.random.default_rng(seed).choice(len(scan), len(scan) // part, replace=False)
    return Changed(scan.take(np.sort(chosen)), _same, _all)


def moved(scan: Scan, axes: Float) -> Changed:
    """Turn or mirror the scan, with its beams without return, by an orthogonal matrix (3, 3)."""
    lost = tuple(replace(one, axes=axes @ one.axes) for one in scan.no_returns)
    turned = replace(scan, xyz=scan.xyz @ axes.T, origins=scan.origins @ axes.T, grid=None, no_returns=lost)
    return Changed(turned, lambda p: p @ axes, _all)


def turned(scan: Scan) -> Changed:
    """Turn the scan about the vertical."""
    c, s = np.cos(np.radians(TURN_DEG)), np.sin(np.radians(TURN_DEG))
    return moved(scan, np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]))


def mirrored(scan: Scan) -> Changed:
    """Swap left and right."""
    return moved(scan, np.diag([-1.0, 1.0, 1.0]))


def noisy(scan: Scan, seed: int = 3) -> Changed:
    """Add noise to every coordinate."""
    noise = np.random.default_rng(seed).normal(0.0, NOISE_M, scan.xyz.shape)
    return Changed(replace(scan, xyz=scan.xyz + noise), _same, _all)


def colourless(scan: Scan) -> Changed:
    """Drop colour and intensity."""
    return Changed(replace(scan, rgb=None, intensity=None), _same, _all)


def sightless(scan: Scan) -> Changed:
    """Drop the sensor positions, and with them the beams without return."""
    unknown = np.full(len(scan), -1, np.int32)
    bare = replace(scan, origins=np.empty((0, 3)), origin_index=unknown, grid=None, no_returns=())
    return Changed(replace(bare, local_from_scanner=None), _same, _all)


def cropped(scan: Scan, along: Float, ends: tuple[float, float], margin: float = 0.5) -> Changed:
    """Cut off one end.

    along   (3,) horizontal unit vector
    ends    m along it, where the largest facade begins and ends
    margin  m beside the cut in which nothing is compared
    """
    cut = ends[0] + CROP * (ends[1] - ends[0])
    rest = scan.take(np.flatnonzero(scan.xyz @ along > cut))
    return Changed(rest, _same, lambda p: bool((p @ along).min() > cut + margin))
