"""Reading E57 (ASTM E2807): scans with pose, grid, lost beams, intensity and colour (extra `e57`)."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from pyproj import CRS

from frontage.errors import CrsError, FileError, MissingExtra
from frontage.geometry.arrays import Array, Float
from frontage.geometry.rigid import Rigid3, rotation_from_quaternion
from frontage.io.columns import PointColumns, normalised, to_scan
from frontage.io.crs import parse_crs
from frontage.io.files import reading, require_file
from frontage.io.placement import Placement
from frontage.io.poses import given_pose
from frontage.io.scans.e57xml import check_e57
from frontage.io.scans.origins import forget_scanner, states_no_position
from frontage.io.scans.precision import require_fine_steps
from frontage.io.scans.request import ScanRequest
from frontage.model import Scan

_CARTESIAN = ("cartesianX", "cartesianY", "cartesianZ")
_SPHERICAL = ("sphericalRange", "sphericalAzimuth", "sphericalElevation")
_COLOURS = ("colorRed", "colorGreen", "colorBlue")
# Indices are read as doubles: pye57 0.4.19 fills int64 buffers as if they were int32.
_DTYPES = {
    "intensity": np.float64,
    "rowIndex": np.float64,
    "columnIndex": np.float64,
    "returnIndex": np.float64,
    "cartesianInvalidState": np.int8,
    "sphericalInvalidState": np.int8,
    "timeStamp": np.float64,
    **dict.fromkeys(_COLOURS, np.float32),
    **dict.fromkeys(_CARTESIAN + _SPHERICAL, np.float64),
}
_MOST_SHARED = 0.01  # share of the beams whose grid cell is taken already; more means wrong indices
_MOST_CELLS = 200  # grid cells per point; more means wrong indices
_NOT_UNIT = 0.01  # from the length 1 of a quaternion; more means another convention or damage
_FEW_POINTS = 2000  # of every scan, enough to decide where the file lies


@contextmanager
def opened(path: str | Path) -> Iterator[Any]:
    """Open a file with pye57 and close it afterwards; every failure inside the block becomes one FileError.

    Raises FileError, and MissingExtra when pye57 is not installed.
    """
    p = require_file(path)
    try:
        import pye57
    except ImportError as problem:
        raise MissingExtra("reading E57", "e57") from problem
    with reading(p, "E57"):
        check_e57(p)
    with reading(p, "E57"):
        e57 = pye57.E57(str(p))
        try:
            yield e57
        finally:
            e57.close()


def read_e57(path: str | Path, request: ScanRequest) -> list[Scan]:
    """Read every scan of an E57 file, placed by its pose; scan grids keep the file's own rows and columns.

    Raises FileError (missing, truncated, corrupt, no points), CrsError, MissingExtra.
    """
    p = require_file(path)
    notes: list[str] = []
    with opened(p) as e57:
        crs = _crs(e57, p, notes)
        scans = [(k, *_read(e57, k)) for k in range(e57.scan_count)]
    kept = [s for s in scans if len(s[2]["xyz"])]
    if not kept:
        raise FileError(p, "holds no points", "export it again", code="I105")
    if len(kept) < len(scans):
        notes.append(f"{p.name}: {len(scans) - len(kept)} scans without points were left out")
    some = np.vstack(
        [pose.apply(d["xyz"][d["valid"]][:: max(1, len(d["xyz"]) // _FEW_POINTS)]) for _, pose, d in kept]
    )
    if not len(some):
        raise FileError(p, "holds no points with coordinates", "export it again", code="I105")
    place = request.placement.place(crs, some)
    shared = normalised([d.get("intensity") for _, _, d in kept])
    return [
        _scan(p, k, pose, d, i, place=place, sigmas=request.sigmas, notes=notes)
        for (k, pose, d), i in zip(kept, shared, strict=True)
        if d["valid"].any()
    ]


def _crs(e57: Any, path: Path, notes: list[str]) -> CRS | None:
    """The CRS of coordinateMetadata; text that is not a CRS is left out with a note."""
    root = e57.root
    text = root["coordinateMetadata"].value().strip() if root.isDefined("coordinateMetadata") else ""
    if not text:
        return None
    try:
        return parse_crs(text, str(path))
    except CrsError:
        notes.append(f"{path.name}: its coordinate metadata is not a CRS that PROJ knows and was left out")
        return None


def _read(e57: Any, number: int) -> tuple[Rigid3, dict[str, Array]]:
    """The pose and the columns of a scan: xyz (n, 3) in its frame, valid (n,), and its attributes."""
    from pye57 import libe57

    header = e57.get_header(number)
    n = int(header.point_count)
    present = [f for f in header.point_fields if f in _DTYPES]
    arrays = {f: np.zeros(n, _DTYPES[f]) for f in present}
    if n:
        buffers = libe57.VectorSourceDestBuffer()
        for name, array in arrays.items():
            buffers.append(libe57.SourceDestBuffer(e57.image_file, name, array, n, True, True))
        reader = header.points.reader(buffers)
        if reader.read() != n:
            raise ValueError(f"scan {number + 1} is truncated")
        reader.close()
    xyz, valid = _coordinates(arrays, n)
    data: dict[str, Array] = {"xyz": xyz, "valid": valid}
    if not set(_CARTESIAN) <= arrays.keys():
        data["spherical"] = np.array(True)  # only a scanner measures angles
    if set(_COLOURS) <= arrays.keys():
        data["rgb"] = _colour(header, np.column_stack([arrays[c] for c in _COLOURS]))
    for name, field in (
        ("intensity", "intensity"),
        ("time", "timeStamp"),
        ("row", "rowIndex"),
        ("column", "columnIndex"),
        ("return", "returnIndex"),
    ):
        if field in arrays:
            data[name] = arrays[field]
    if header.node.isDefined("indexBounds"):
        bounds = header["indexBounds"]
        for name in ("row", "column"):
            if bounds.isDefined(f"{name}Minimum") and bounds.isDefined(f"{name}Maximum"):
                ends = [bounds[f"{name}{end}"].value() for end in ("Minimum", "Maximum")]
                data[f"{name}_bounds"] = np.array(ends, np.int64)
    return _pose(header), data


def _pose(header: Any) -> Rigid3:
    """The pose of a scan. Raises ValueError when its rotation is not a unit quaternion."""
    quaternion = np.asarray(header.rotation, np.float64)
    if abs(np.linalg.norm(quaternion) - 1.0) > _NOT_UNIT:
        raise ValueError(f"the rotation of a scan is not a unit quaternion but {quaternion.tolist()}")
    return Rigid3("file", "scanner", rotation_from_quaternion(quaternion), header.translation)


def _colour(header: Any, rgb: Array) -> Array:
    """Colours (n, 3) scaled from their declared limits to 0..255; without limits they are taken as 8-bit."""
    top = 255.0
    if header.node.isDefined("colorLimits"):
        limits = header["colorLimits"]
        top = max(float(limits[f"{c}Maximum"].value()) for c in _COLOURS) or 255.0
    return (rgb * (255.0 / top)).round().clip(0, 255).astype(np.uint8)


def _coordinates(a: dict[str, Array], n: int) -> tuple[Float, Array]:
    """The points (n, 3), and which of them have coordinates (n,)."""
    if set(_CARTESIAN) <= a.keys():
        xyz = np.column_stack([a[c] for c in _CARTESIAN])
        state = a.get("cartesianInvalidState")
    elif set(_SPHERICAL) <= a.keys():
        r, azimuth, elevation = (a[c] for c in _SPHERICAL)
        flat = r * np.cos(elevation)
        xyz = np.column_stack([flat * np.cos(azimuth), flat * np.sin(azimuth), r * np.sin(elevation)])
        state = a.get("sphericalInvalidState")
    else:
        raise ValueError("a scan has neither cartesian nor spherical coordinates")
    valid = np.ones(n, bool) if state is None else state == 0
    return xyz, valid & (xyz != 0).any(axis=1)  # some writers store a lost beam at the scanner's position


def _scan(
    path: Path,
    number: int,
    pose: Rigid3,
    d: dict[str, Array],
    intensity: Array | None,
    *,
    place: Placement,
    sigmas: tuple[float, ...] | None,
    notes: list[str],
) -> Scan:
    local = place.pose_of(pose)
    c = PointColumns(
        f"{path.name}:{number + 1}",
        place.points_of(pose, d["xyz"]),
        intensity,
        d.get("rgb"),
        d.get("time"),
        origins=local.t[None],
        origin_index=np.zeros(len(d["xyz"]), np.int32),
        keep=d["valid"],
        pose=given_pose(local, sigmas),
        notes=list(notes),
    )
    c.grid = _grid(d, c)
    require_fine_steps(path, d["xyz"][d["valid"]], lambda p: place.points_of(pose, p), c.notes)
    if states_no_position(pose, c.grid is not None or "spherical" in d):
        forget_scanner(c, sigmas is not None)
    return to_scan(path, c, place)


def _grid(d: dict[str, Array], c: PointColumns) -> Array | None:
    """The scan grid (h, w) of the first returns; None, with a note, where the indices do not form a grid."""
    if "row" not in d or "column" not in d:
        return None
    first = np.flatnonzero(d["return"] == 0) if "return" in d else np.arange(len(d["row"]))
    row, column = d["row"][first].astype(np.int64), d["column"][first].astype(np.int64)
    if not len(first):
        return None
    row, h = _span(row, d.get("row_bounds"))
    column, w = _span(column, d.get("column_bounds"))
    cell = row * w + column
    taken = len(cell) - len(np.unique(cell))
    if min(h, w) < 2 or taken > _MOST_SHARED * len(cell) or h * w > _MOST_CELLS * len(cell):
        c.notes.append(f"{c.name}: its row and column indices do not form a scan grid and were left out")
        return None
    grid = np.full(h * w, -1, np.int64)
    grid[cell[::-1]] = first[::-1]  # where two share a cell, the first stays
    return grid.reshape(h, w)


def _span(index: Array, declared: Array | None) -> tuple[Array, int]:
    """Indices that start at 0, and their number; declared bounds count where all indices lie within them."""
    low, high = int(index.min()), int(index.max())
    if declared is not None and declared[0] <= low and declared[1] >= high:
        low, high = int(declared[0]), int(declared[1])
    return index - low, high - low + 1
