"""What the coordinates of a scan can resolve: steps of 32-bit floats, and units that were not stated."""

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from frontage.errors import FileError
from frontage.geometry.arrays import Array, Float
from frontage.io.scans.subset import spacing
from frontage.model import Scan

_TOLD_STEP_M = 1.0001e-3  # coarser steps show in the relief of a facade
_REFUSED_STEP_M = 0.05  # half a brick's height: no edge of an opening can be measured
_SAMPLE = 100_000  # points that are examined
_MANY = 1000  # so many coordinates do not lie at the multiples of a step by chance
_DISTINCT = 5  # different values: a wall along an axis has one
_FINER = 16  # times the widest step: axes with finer steps than a share of it are not judged
_ROUNDING = 0.2  # of a step: text and LAS round what they write
_ABSURD = 1e12  # file units: such coordinates are dropped elsewhere
_TALL = 1000.0  # m; no street is as high
_WIDE = 1.0  # m between neighbouring points: no facade can be seen in it
_STREET_M = (1.5, 300.0)  # the height of a street scene, in whatever unit
_UNITS = (("millimetres", "mm", 1e-3), ("centimetres", "cm", 1e-2))


def require_fine_steps(
    path: Path,
    stored: Array,
    to_local: Callable[[Float], Float],
    notes: list[str],
    *,
    single: bool = False,
    scales: Float | None = None,
) -> None:
    """Compare the steps of the stored coordinates (n, 3), as they stand in the file, with what facades need.

    Coordinates that a program once held as 32-bit floats keep their steps in every format: 0.5 m at a
    northing of 5,403,000 m. `single` says that the file stores 32-bit floats; otherwise this is found from
    the values. `scales` (3,) are the steps of a file that stores integers. `to_local` takes file coordinates
    to metres, and `notes` gets a sentence for steps of more than a millimetre.

    Raises FileError when the steps are 5 cm or more.
    """
    some = np.asarray(stored[:: max(1, len(stored) // _SAMPLE)], np.float64)
    some = some[(np.abs(some) < _ABSURD).all(axis=1)]
    if not len(some):
        return
    grid = np.zeros(3) if scales is None else np.asarray(scales, np.float64)
    floats = _float_steps(some, single)
    ends = to_local(np.vstack([some[:1], some[:1] + np.diag(np.maximum(grid, floats))]))
    step = float(np.linalg.norm(ends[1:] - ends[0], axis=1).max())
    if step <= _TOLD_STEP_M:
        return
    what = f"its coordinates are stored in steps of {step:.3g} m"
    if floats.max() > grid.max():
        what = f"{what} (32-bit floats as large as {np.abs(some).max():.0f})"
    advice = "export the scan with finer steps: 64-bit floats, or a shift that you state as offset"
    if step >= _REFUSED_STEP_M:
        raise FileError(path, f"{what}, too coarse for facades", advice, code="I116")
    notes.append(f"{path.name}: {what}: depths and edges are no better than that; {advice}")


def _float_steps(xyz: Float, single: bool) -> Float:
    """The steps (3,) of coordinates (n, 3) that are, or once were, 32-bit floats; 0 where they are not."""
    steps = np.spacing(np.abs(xyz).astype(np.float32)).astype(np.float64)
    widest: Float = steps.max(axis=0)
    if single:
        return widest
    least = max(_TOLD_STEP_M, widest.max() / _FINER)
    coarse = [k for k in range(3) if widest[k] >= least and len(xyz) >= _MANY]
    found = [_are_multiples(xyz[:, k], steps[:, k]) for k in coarse]
    return widest if found and all(found) else np.zeros(3)


def _are_multiples(values: Float, steps: Float) -> bool:
    """Whether all values (n,) lie at multiples of their steps, to the rounding of decimals, and differ."""
    turns = values / steps
    return bool((np.abs(turns - np.rint(turns)) <= _ROUNDING).all()) and len(np.unique(values)) >= _DISTINCT


def unit_notes(path: Path, scans: Sequence[Scan], stated: str | None) -> list[str]:
    """A sentence when the scene is so large that its coordinates must be in smaller units than metres."""
    if stated is not None:
        return []
    low, high = (
        np.array([np.quantile(s.xyz[:: max(1, len(s) // _SAMPLE), 2], q) for s in scans])
        for q in (0.01, 0.99)
    )
    height = float(high.max() - low.min())
    apart = float(np.median([spacing(s, 500) for s in scans])) if height > _TALL else 0.0
    if height <= _TALL or apart <= _WIDE:
        return []
    fits = [u for u in _UNITS if _STREET_M[0] <= height * u[2] <= _STREET_M[1]]
    name, short, _ = fits[0] if fits else _UNITS[0]
    return [
        f"{path.name}: taken as metres, the scene is {height:.0f} m high and its points are {apart:.3g} m "
        f'apart; if its coordinates are in {name}, state units = "{short}"'
    ]
