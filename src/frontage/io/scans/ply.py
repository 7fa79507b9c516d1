"""PLY: the vertices of ascii and binary files of both byte orders, and a binary writer."""

from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

import numpy as np

from frontage.errors import FileError
from frontage.geometry.arrays import Array
from frontage.io.columns import PointColumns, to_scan
from frontage.io.files import reading, require_file, require_length, whole_file
from frontage.io.scans.precision import require_fine_steps
from frontage.io.scans.request import ScanRequest
from frontage.model import Scan

_TYPES = {
    "char": "i1",
    "uchar": "u1",
    "short": "i2",
    "ushort": "u2",
    "int": "i4",
    "uint": "u4",
    "float": "f4",
    "double": "f8",
    "int8": "i1",
    "uint8": "u1",
    "int16": "i2",
    "uint16": "u2",
    "int32": "i4",
    "uint32": "u4",
    "float32": "f4",
    "float64": "f8",
}
_ORDERS = {"ascii": "=", "binary_little_endian": "<", "binary_big_endian": ">"}
_NAMES = {
    "intensity": ("intensity", "scalar_intensity", "reflectance", "scalar_reflectance", "remission"),
    "time": ("gps_time", "gpstime", "scalar_gpstime", "scalar_gps_time", "time", "timestamp"),
}
_FEW_POINTS = 10_000  # enough to decide where a file lies
_HEAD_BYTES = 1_000_000  # of a header; a longer one is damaged
_COLOURS = (("red", "green", "blue"), ("r", "g", "b"), ("diffuse_red", "diffuse_green", "diffuse_blue"))
_SENSORS = (("x_origin", "y_origin", "z_origin"), ("sensor_x", "sensor_y", "sensor_z"))


@dataclass
class _Header:
    """Byte order ("=" for ascii), number and record of the vertices, and what stands in front of them.

    `before` counts bytes in a binary file and lines in an ascii file.
    """

    order: str
    count: int
    vertex: np.dtype[np.void]
    before: int


def read_ply(path: str | Path, request: ScanRequest) -> list[Scan]:
    """Read the vertices of a PLY file as one scan: x y z, and colour, intensity, time and sensor where named.

    Raises FileError (missing, truncated, corrupt, no vertices), CrsError.
    """
    p = require_file(path)
    with reading(p, "PLY"), open(p, "rb") as f:
        header = _header(f, p)
        v = _ascii(f, header) if header.order == "=" else _binary(f, header)
        if len(v) < header.count:
            raise FileError(
                p, f"truncated: {len(v)} of {header.count} vertices", "copy it again", code="I103"
            )
    if not len(v):
        raise FileError(p, "holds no points", "export it again", code="I105")
    names = {n.lower(): n for n in v.dtype.names or ()}
    xyz = _pick(v, names, ("x", "y", "z"))
    place = request.placement.place(None, xyz[:: max(1, len(xyz) // _FEW_POINTS)])
    c = PointColumns(p.name, place.to_local(xyz))
    single = any(v.dtype[names[axis]] == np.float32 for axis in "xyz")
    require_fine_steps(p, xyz, place.to_local, c.notes, single=single)
    for field, known in _NAMES.items():
        found = next((names[k] for k in known if k in names), None)
        setattr(c, field, None if found is None else np.ascontiguousarray(v[found]))
    rgb = next((k for k in _COLOURS if set(k) <= set(names)), None)
    c.rgb = None if rgb is None else np.column_stack([v[names[k]] for k in rgb])
    sensor = next((k for k in _SENSORS if set(k) <= set(names)), None)
    if sensor is not None:
        seen, index = np.unique(_pick(v, names, sensor), axis=0, return_inverse=True)
        c.origins, c.origin_index = place.to_local(seen), index.reshape(-1).astype(np.int32)
    return [to_scan(p, c, place)]


def _pick(v: Array, names: dict[str, str], wanted: tuple[str, ...]) -> Array:
    return np.column_stack([v[names[k]].astype(np.float64) for k in wanted])


@dataclass
class _Element:
    """An element of the header: its name, its number, and its properties with their types."""

    name: str
    count: int
    properties: list[tuple[str, str]]

    def least(self, order: str) -> int:
        """The least number of bytes that its rows need: a text value has a digit and a separator."""
        sizes = [
            2 if order == "=" else 1 if t == "list" else np.dtype(t).itemsize for _, t in self.properties
        ]
        return self.count * max(sum(sizes), 1 if order == "=" else 0)


def _header(f: BinaryIO, path: Path) -> _Header:
    """Parse the header and compare its counts with the size of the file.

    Raises ValueError when it is not that of a PLY file with vertices x, y, z, FileError when a count does not
    fit.
    """
    if f.readline(_HEAD_BYTES).strip() != b"ply":
        raise ValueError("it does not begin with 'ply'")
    order, elements = _elements(f)
    at = next((k for k, e in enumerate(elements) if e.name == "vertex"), None)
    if at is None:
        raise ValueError("it has no vertices")
    has = path.stat().st_size - f.tell() + 1  # the last line may lack its end
    need = 0
    for e in elements:
        need += e.least(order)
        require_length(path, f"{e.count} elements '{e.name}'", min(e.count, need), has)
    before = sum(
        e.count if order == "=" else e.count * _dtype(e.properties, order).itemsize for e in elements[:at]
    )
    vertex = _dtype(elements[at].properties, order)
    if not {"x", "y", "z"} <= {n.lower() for n in vertex.names or ()}:
        raise ValueError("its vertices have no x, y, z")
    return _Header(order, elements[at].count, vertex, before)


def _elements(f: BinaryIO) -> tuple[str, list[_Element]]:
    """The byte order and the elements. Raises ValueError for a header that has no end or no format."""
    order = ""
    elements: list[_Element] = []
    while (line := f.readline(_HEAD_BYTES)).strip() != b"end_header":
        if not line or f.tell() > _HEAD_BYTES:
            raise ValueError("its header has no end")
        words = line.decode("ascii", "replace").split()
        if words[:1] == ["format"]:
            order = _ORDERS[words[1]]
        elif words[:1] == ["element"]:
            elements.append(_Element(words[1], int(words[2]), []))
        elif words[:1] == ["property"]:
            kind = "list" if words[1] == "list" else _TYPES[words[1]]
            elements[-1].properties.append((words[-1], kind))
    if not order:
        raise ValueError("its header states no format")
    return order, elements


def _dtype(properties: list[tuple[str, str]], order: str) -> "np.dtype[np.void]":
    if any(t == "list" for _, t in properties):
        raise ValueError("lists in or before the vertices are not supported; save it with the vertices first")
    return np.dtype([(name, order + t) for name, t in properties])


def _ascii(f: BinaryIO, h: _Header) -> Array:
    for _ in range(h.before):
        f.readline()
    if h.count == 0:
        return np.empty(0, h.vertex)
    columns = len(h.vertex.names or ())
    body: Array = np.loadtxt(f, np.float64, max_rows=h.count, ndmin=2, usecols=range(columns))
    out = np.empty(len(body), h.vertex)
    for k, name in enumerate(h.vertex.names or ()):
        out[name] = body[:, k]
    return out


def _binary(f: BinaryIO, h: _Header) -> Array:
    f.seek(h.before, 1)
    return np.fromfile(f, h.vertex, h.count)


def write_ply(path: str | Path, scan: Scan) -> Path:
    """Write a scan as binary little-endian PLY: x y z in world metres (double), colour, intensity, time.

    Raises FileError when the file cannot be written.
    """
    fields: list[tuple[str, str, Array]] = []
    world = scan.world.to_world(scan.xyz)
    fields += [(axis, "double", world[:, k]) for k, axis in enumerate("xyz")]
    if scan.rgb is not None:
        fields += [(name, "uchar", scan.rgb[:, k]) for k, name in enumerate(("red", "green", "blue"))]
    if scan.intensity is not None:
        fields.append(("intensity", "float", scan.intensity))
    if scan.time is not None:
        fields.append(("gps_time", "double", scan.time))
    rows = np.empty(len(scan), np.dtype([(n, "<" + _TYPES[t]) for n, t, _ in fields]))
    for name, _, values in fields:
        rows[name] = values
    properties = "".join(f"property {t} {n}\n" for n, t, _ in fields)
    head = f"ply\nformat binary_little_endian 1.0\nelement vertex {len(scan)}\n{properties}end_header\n"
    with whole_file(path) as temporary, open(temporary, "wb") as f:
        f.write(head.encode("ascii"))
        rows.tofile(f)
    return Path(path)
