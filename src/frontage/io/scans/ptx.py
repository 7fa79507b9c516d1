"""PTX: several structured scans in one text file, each with its pose and its full scan grid.

Every scan has a header (columns, rows, scanner position, three axes, a 4x4 matrix for row vectors) and
columns x rows lines ``x y z intensity [r g b]``, column by column; ``0 0 0`` is a beam without return.
"""

import warnings
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TextIO

import numpy as np

from frontage.errors import FileError, InputError
from frontage.geometry.arrays import Array, Float
from frontage.geometry.rigid import Rigid3
from frontage.io.columns import PointColumns, normalised, to_scan
from frontage.io.files import reading, require_file, require_length, whole_file
from frontage.io.placement import Placement
from frontage.io.poses import given_pose, nearest_rotation
from frontage.io.scans.origins import forget_scanner, states_no_position
from frontage.io.scans.precision import require_fine_steps
from frontage.io.scans.request import ScanRequest
from frontage.model import Scan

_CHUNK_LINES = 1_000_000  # parsed at once
_LEAST_LINE = 8  # bytes of a line: four values, each with a separator
_FEW_POINTS = 2000  # of every scan, enough to decide where the file lies
_NO_INTENSITY = 0.5  # what Leica's programs write where there is no intensity


@dataclass
class _Raw:
    """One scan as stored: points (n, 3) in the scanner's frame, intensity, colour, grid (rows, columns)."""

    pose: Rigid3
    xyz: Float
    intensity: Array
    rgb: Array | None
    grid: Array


def read_ptx(path: str | Path, request: ScanRequest) -> list[Scan]:
    """Read every scan of a PTX file; the rows and columns of the scan grids stay as stored.

    Raises FileError (missing, truncated, corrupt, no returns), CrsError.
    """
    p = require_file(path)
    with reading(p, "PTX"), open(p, encoding="latin-1") as f:
        raws = list(_scans(f, p))
    kept = [(k, r) for k, r in enumerate(raws, 1) if len(r.xyz)]
    if not kept:
        raise FileError(p, "holds no points", "export it again", code="I105")
    some = [r.pose.apply(r.xyz[:: max(1, len(r.xyz) // _FEW_POINTS)]) for _, r in kept]
    place = request.placement.place(None, np.vstack(some))
    shared = normalised([r.intensity for _, r in kept])
    empty = len(raws) - len(kept)
    notes = [f"{p.name}: {empty} scans without any return were left out"] if empty else []
    return [
        _scan(p, k, r, i, place=place, sigmas=request.sigmas, notes=notes)
        for (k, r), i in zip(kept, shared, strict=True)
    ]


def _scan(
    path: Path,
    number: int,
    r: _Raw,
    intensity: Array | None,
    *,
    place: Placement,
    sigmas: tuple[float, ...] | None,
    notes: list[str],
) -> Scan:
    pose = place.pose_of(r.pose)
    c = PointColumns(
        f"{path.name}:{number}",
        place.points_of(r.pose, r.xyz),
        intensity,
        r.rgb,
        grid=r.grid,
        origins=pose.t[None],
        origin_index=np.zeros(len(r.xyz), np.int32),
        pose=given_pose(pose, sigmas),
        notes=list(notes),
    )
    require_fine_steps(path, r.xyz, lambda p: place.points_of(r.pose, p), c.notes)
    if not r.pose.t.any() and states_no_position(r.pose, min(r.grid.shape) > 1):
        forget_scanner(c, sigmas is not None)
    return to_scan(path, c, place)


def _scans(f: TextIO, path: Path) -> Iterator[_Raw]:
    """Yield scan after scan until the end of the file."""
    while (first := _next_line(f)) is not None:
        columns, rows = _count(first), _count(_next_line(f))
        grid = f"a scan grid of {columns} x {rows}"
        if min(columns, rows) <= 0:
            raise ValueError(f"its header states {grid}")
        require_length(path, grid, columns * rows * _LEAST_LINE, path.stat().st_size)
        header = np.array([_numbers(f, 3) for _ in range(4)])
        matrix = np.array([_numbers(f, 4) for _ in range(4)])
        raw = _body(f, path, columns, rows, _pose(matrix))
        yield _from_scanner_position(raw, header[0])


def _pose(matrix: Float) -> Rigid3:
    """The scanner's pose from the 4x4 matrix for row vectors."""
    if not np.isfinite(matrix).all():
        raise ValueError("its matrix holds numbers that are not finite")
    return Rigid3("file", "scanner", nearest_rotation(matrix[:3, :3].T), matrix[3, :3])


def _from_scanner_position(raw: _Raw, position: Float) -> _Raw:
    """The same points seen from the scanner's `position` (3,), if they are in world coordinates.

    Some writers store world coordinates with an identity matrix; then only the header's first line says where
    the scanner stood.
    """
    if not position.any() or raw.pose.t.any() or not np.array_equal(raw.pose.R, np.eye(3)):
        return raw
    return replace(raw, pose=Rigid3("file", "scanner", np.eye(3), position), xyz=raw.xyz - position)


def _body(f: TextIO, path: Path, columns: int, rows: int, pose: Rigid3) -> _Raw:
    """Parse the lines of one scan: its returns, and the grid of their numbers."""
    total, at = columns * rows, 0
    parts: list[Float] = []
    hit = np.zeros(total, bool)
    while at < total:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", UserWarning)  # "no data" is reported as truncated below
            block: Float = np.loadtxt(f, np.float64, max_rows=min(_CHUNK_LINES, total - at), ndmin=2)
        if not block.size:
            raise FileError(
                path, f"truncated: {at} of {total} lines of a scan", "copy or export it again", code="I103"
            )
        if block.shape[1] not in (4, 7):
            raise ValueError(f"its lines have {block.shape[1]} values instead of 4 or 7")
        returned = (block[:, :3] != 0).any(axis=1) & np.isfinite(block[:, :3]).all(axis=1)
        hit[at : at + len(block)] = returned
        parts.append(block[returned])
        at += len(block)
    data = np.concatenate(parts)
    index = np.where(hit, np.cumsum(hit) - 1, -1)
    rgb = data[:, 4:7].astype(np.uint8) if data.shape[1] == 7 else None
    return _Raw(pose, data[:, :3].copy(), data[:, 3], rgb, index.reshape(columns, rows).T)


def _next_line(f: TextIO) -> str | None:
    """The next line that is not blank, or None at the end."""
    return next((line for line in iter(f.readline, "") if line.strip()), None)


def _count(line: str | None) -> int:
    if line is None:
        raise ValueError("its header ends early")
    return int(line)


def _numbers(f: TextIO, n: int) -> list[float]:
    values = [float(v) for v in (_next_line(f) or "").split()]
    if len(values) != n:
        raise ValueError(f"a line of its header has {len(values)} values instead of {n}")
    return values


def write_ptx(path: str | Path, scans: Sequence[Scan]) -> Path:
    """Write structured scans with one pose each: 0.01 mm in the scanner's frame, intensity 0..1 to 1e-4.

    Raises InputError for a scan without a pose or a grid, and FileError when the file cannot be written.
    """
    p = Path(path)
    with whole_file(p) as temporary, temporary.open("w", encoding="ascii", newline="\n") as f:
        for scan in scans:
            _write(f, scan)
    return p


def _write(f: TextIO, scan: Scan) -> None:
    """Write one scan: its header, then every beam of the grid, column by column."""
    if scan.local_from_scanner is None or scan.grid is None:
        raise InputError(f"{scan.name}: a PTX scan needs the pose and the scan grid of its scanner")
    pose, index = scan.local_from_scanner.value, scan.grid.index.T.ravel()
    t = scan.world.to_world(pose.t)
    matrix = np.vstack([np.column_stack([pose.R.T, np.zeros(3)]), [*t, 1.0]])
    rows, columns = scan.grid.index.shape
    f.write(f"{columns}\n{rows}\n")
    for numbers in (t, *pose.R.T, *matrix):
        f.write(" ".join(f"{v:.12g}" for v in numbers) + "\n")
    lost = index < 0
    intensity = np.full(len(scan), _NO_INTENSITY) if scan.intensity is None else scan.intensity
    table = np.column_stack([pose.inverse.apply(scan.xyz), intensity])[index]
    table[lost] = 0.0, 0.0, 0.0, _NO_INTENSITY
    form = "%.5f %.5f %.5f %.4f"
    if scan.rgb is not None:
        table = np.column_stack([table, np.where(lost[:, None], 0, scan.rgb[index])])
        form += " %d %d %d"
    for start in range(0, len(table), _CHUNK_LINES):
        np.savetxt(f, table[start : start + _CHUNK_LINES], fmt=form)
