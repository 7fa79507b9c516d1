"""Whether the stated position of a sensor can be right: could it have measured these points?

A laser sees the first surface along every beam. From its true position the points of a scan therefore show
one surface per direction; only silhouettes, glass and leaves show two. From a wrong position, walls lie in
front of other walls. The tests are coarse on purpose: a position that passes is not proven, but one that
fails is wrong.
"""

from dataclasses import replace

import numpy as np

from frontage.geometry.arrays import Array, Float
from frontage.geometry.rigid import Rigid3
from frontage.io.columns import PointColumns
from frontage.model import Scan

_FEW = 2000  # points of one position: fewer are not judged by their directions
_SAMPLE = 200_000  # points of one position that are examined
_PER_CELL = 16  # points of a cell of directions, on average: four in each quarter
_MOST_SIDE = 2048  # cells along the side of the cube of directions: 0.04 degrees
_FEW_CELLS = 200  # with points in all quarters: fewer are not judged
_GAP_M, _GAP_SHARE = 0.5, 0.05  # between two surfaces, in m and as a share of the range
_TWO_SURFACES = 0.15
"""Share of the directions with two surfaces that is too much. Stations of a street with trees in front of the
houses have up to 0.05; positions amid a merged cloud, or below its ground, have 0.1 to 0.5."""
_FARTHEST_M = 6000.0  # the longest range of terrestrial laser scanners (the makers' data sheets)
_NEAREST_M, _NEAR_SHARE = 0.2, 0.01  # no scanner measures so near; a cloud around a wrong position does
_FINEST_STEP = 3e-5  # rad between neighbouring beams, finer than scanners measure in practice


def states_no_position(pose: Rigid3, has_raster: bool) -> bool:
    """Whether a pose is only a placeholder: no rotation, and no translation or one by whole metres.

    Programs that merge scans write such poses; the whole metres are the shift that they subtracted.
    A scan with a raster is the work of one scanner, and its pose is believed.
    """
    return not has_raster and np.array_equal(pose.R, np.eye(3)) and bool((pose.t == np.rint(pose.t)).all())


def forget_scanner(c: PointColumns, keep_pose: bool) -> None:
    """Take the origin out of the columns of a scan that states none, with a note.

    `keep_pose` keeps the pose all the same: a scan that will be registered needs one to start from.
    """
    c.origins = c.origin_index = None
    if not keep_pose:
        c.pose = None
    c.notes.append(
        f"{c.name}: it has no scan grid, and its pose is only a placeholder, as in merged clouds: where its "
        f"points were measured from is unknown"
    )


def with_possible_origins(scan: Scan) -> Scan:
    """The scan without the origins that cannot have measured their points; a note says so.

    The points of such an origin have an unknown origin. A scan whose origins are all possible is returned as
    it is.
    """
    if not scan.has_origins:
        return scan
    wrong = _impossible(scan)
    if not wrong:
        return scan
    index = scan.origin_index.copy()
    index[np.isin(index, list(wrong))] = -1
    why, many = next(iter(wrong.values())), len(scan.origins)
    note = (
        f"{scan.name}: {len(wrong)} of the {many} stated positions of the sensor cannot be right ({why}) and "
        f"are not used: where their points were measured from is unknown"
        if many > 1
        else f"{scan.name}: the stated position of the sensor cannot be right ({why}) and is not used: where "
        f"its points were measured from is unknown"
    )
    none = (index < 0).all()
    return replace(
        scan,
        origins=np.empty((0, 3)) if none else scan.origins,
        origin_index=index,
        no_returns=() if none else tuple(n for n in scan.no_returns if n.origin not in wrong),
        notes=(*scan.notes, note),
    )


def _impossible(scan: Scan) -> dict[int, str]:
    """The origins that cannot be right, with the reason."""
    known = np.flatnonzero(scan.origin_index >= 0)
    used = np.flatnonzero(np.bincount(scan.origin_index[known], minlength=len(scan.origins)))
    some = known[:: max(1, len(known) // _SAMPLE)]
    reason = _by_range(np.linalg.norm(scan.xyz[some] - scan.origins[scan.origin_index[some]], axis=1))
    if reason:
        return dict.fromkeys(used.tolist(), reason)
    if len(known) < _FEW * len(used):
        return {}  # a trajectory: every position has few points
    order = known[np.argsort(scan.origin_index[known], kind="stable")]
    starts = np.searchsorted(scan.origin_index[order], used)
    found = {}
    for origin, rows in zip(used.tolist(), np.split(order, starts[1:]), strict=True):
        if len(rows) >= _FEW and (reason := _by_direction(scan, rows, scan.origins[origin])):
            found[origin] = reason
    return found


def _by_range(ranges: Float) -> str:
    """What is impossible about the ranges (n,) m of points; empty when nothing is."""
    middle = float(np.median(ranges))
    if middle > _FARTHEST_M:
        return f"it lies {middle / 1000:.0f} km from its points"
    near = float((ranges < _NEAREST_M).mean())
    return f"{near:.0%} of its points lie within {_NEAREST_M} m of it" if near > _NEAR_SHARE else ""


def _by_direction(scan: Scan, rows: Array, origin: Float) -> str:
    """What is impossible about the directions of the points of one origin; empty when nothing is."""
    if scan.return_number is not None:  # later returns lie behind the first by nature
        rows = rows[scan.return_number[rows] <= 1]
    stride = max(1, len(rows) // _SAMPLE)
    ray = scan.xyz[rows[::stride]] - origin
    ranges = np.linalg.norm(ray, axis=1)
    ray, ranges = ray[ranges > 0], ranges[ranges > 0]
    if len(ray) < _FEW:
        return ""
    if reason := _by_range(ranges):
        return reason
    side, cell, quarter = _cells(ray)
    density = len(ray) * stride / len(np.unique(cell))
    if side == _MOST_SIDE and density > (2.0 / side / _FINEST_STEP) ** 2:
        return "its points lie closer together than the beams of any scanner"
    cells, two = _surfaces(cell, quarter, ranges)
    if cells >= _FEW_CELLS and two > _TWO_SURFACES * cells:
        return f"{two / cells:.0%} of the directions from it show two surfaces, one behind the other"
    return ""


def _cells(ray: Float) -> tuple[int, Array, Array]:
    """Cells of directions of about `_PER_CELL` points each, on the six sides of a cube.

    Returns the number of cells along a side, and the cell (n,) and the quarter 0..3 of it (n,) of every ray.
    """
    axis = np.abs(ray).argmax(1)
    main = np.take_along_axis(ray, axis[:, None], 1)[:, 0]
    plane = [np.take_along_axis(ray, ((axis + k) % 3)[:, None], 1)[:, 0] / np.abs(main) for k in (1, 2)]
    sheet = axis * 2 + (main > 0)
    side = 8
    while True:
        fine = [np.minimum(((v + 1.0) * side).astype(np.int64), 2 * side - 1) for v in plane]
        cell = (sheet * side + fine[0] // 2) * side + fine[1] // 2
        if side == _MOST_SIDE or len(ray) < 2 * _PER_CELL * len(np.unique(cell)):
            return side, cell, fine[0] % 2 * 2 + fine[1] % 2
        side *= 2


def _surfaces(cell: Array, quarter: Array, ranges: Float) -> tuple[int, int]:
    """The number of cells with points in all quarters, and of those among them with two surfaces.

    Two surfaces: the largest gap between the ranges in the cell is wide, and the points in front of it as
    well as those behind it fill all quarters. A silhouette divides a cell, so that neither side fills it.
    """
    order = np.lexsort((ranges, cell))
    cell, quarter, r = cell[order], 1 << quarter[order], ranges[order]
    starts = np.flatnonzero(np.diff(cell, prepend=cell[0] - 1))
    number = np.repeat(np.arange(len(starts)), np.diff(starts, append=len(cell)))
    gap = np.append(np.diff(r), 0.0)
    gap[np.append(starts[1:], len(cell)) - 1] = 0.0
    widest = np.maximum.reduceat(gap, starts)
    at = np.full(len(starts), -1)
    hits = np.flatnonzero((gap == widest[number]) & (gap > 0))[::-1]
    at[number[hits]] = hits  # the first of equal gaps stays
    behind = np.arange(len(cell)) > at[number]
    near, far = (np.bitwise_or.reduceat(np.where(s, quarter, 0), starts) for s in (~behind, behind))
    wide = widest > np.maximum(_GAP_M, _GAP_SHARE * r[np.maximum(at, 0)])
    return int(((near | far) == 15).sum()), int(((near == 15) & (far == 15) & wide).sum())
