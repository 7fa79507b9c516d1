"""Point tables (XYZ, CSV, TXT): columns are found by their header row, or else by their number and values."""

from pathlib import Path

import numpy as np

from frontage.errors import FileError
from frontage.geometry.arrays import Array, Float
from frontage.io.columns import PointColumns, to_scan
from frontage.io.scans.precision import require_fine_steps
from frontage.io.scans.request import ScanRequest
from frontage.io.scans.table import Table, read_table
from frontage.model import Scan

_AXES = (
    ("x", "easting", "east", "e", "rechtswert"),
    ("y", "northing", "north", "n", "hochwert"),
    ("z", "height", "elevation", "h", "altitude", "hoehe"),
)
_INTENSITY = ("intensity", "i", "reflectance", "scalar_intensity")
_COLOURS = (("red", "green", "blue"), ("r", "g", "b"))
_FEW_POINTS = 10_000  # enough to decide where a file lies
_TIME = ("gps_time", "gpstime", "time", "timestamp")


def read_xyz(path: str | Path, request: ScanRequest) -> list[Scan]:
    """Read a text table of points as one scan.

    With a header row, columns are found by name. Without one, 3 columns are x y z, 4 are x y z intensity, 6
    are x y z r g b (normals are ignored), and 7 are x y z with intensity r g b or with r g b intensity.

    Raises FileError (missing, binary, no numbers, ragged rows), CrsError.
    """
    table = read_table(path, "point table")
    p = table.path
    xyz, intensity, rgb, time = _named(table) if table.names else _unnamed(table.values, p)
    place = request.placement.place(None, xyz[:: max(1, len(xyz) // _FEW_POINTS)])
    c = PointColumns(p.name, place.to_local(xyz), intensity, rgb, time)
    require_fine_steps(p, xyz, place.to_local, c.notes)
    return [to_scan(p, c, place)]


def _named(t: Table) -> tuple[Float, Array | None, Array | None, Array | None]:
    axes = [t.column(*names) for names in _AXES]
    if any(a is None for a in axes):
        if len(t.names) in (3, 4, 6, 7):
            return _unnamed(t.values, t.path)
        raise FileError(
            t.path,
            f"its header ({', '.join(t.names[:8])}) does not name x, y, z",
            "rename the columns",
            code="I106",
        )
    rgb = next((c for c in _COLOURS if all(n in t.names for n in c)), None)
    colour = None if rgb is None else np.column_stack([t.column(n) for n in rgb])  # type: ignore[misc]
    return np.column_stack(axes), t.column(*_INTENSITY), colour, t.column(*_TIME)  # type: ignore[arg-type]


def _unnamed(v: Float, path: Path) -> tuple[Float, Array | None, Array | None, Array | None]:
    k = v.shape[1]
    if k < 3:
        raise FileError(path, f"its rows have {k} values, too few for points", "give x y z", code="I106")
    intensity = rgb = None
    if k == 4:
        intensity = v[:, 3]
    elif k == 6 and _colours(v[:, 3:6]):
        rgb = v[:, 3:6]
    elif k >= 7 and _colours(v[:, 4:7]):
        intensity, rgb = v[:, 3], v[:, 4:7]
    elif k >= 7 and _colours(v[:, 3:6]):
        intensity, rgb = v[:, 6], v[:, 3:6]
    return v[:, :3], intensity, None if rgb is None else rgb.astype(np.uint16), None


def _colours(v: Float) -> bool:
    """Whether columns (n, 3) hold colours: whole numbers 0..65535 that are not unit normals."""
    return bool(((v >= 0) & (v <= 65535) & (v == np.round(v))).all() and v.max() > 1)
