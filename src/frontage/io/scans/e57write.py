"""Writing E57: structured scans with their pose, grid and the beams that did not return (extra `e57`).

Equal scans give equal bytes: identifiers are counted, and no date is written.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from frontage.errors import InputError, MissingExtra
from frontage.geometry.arrays import Array
from frontage.geometry.rigid import Rigid3, quaternion_from_rotation
from frontage.io.crs import parse_crs
from frontage.io.files import whole_file
from frontage.model import Scan

_BYTE = {"Minimum": 0, "Maximum": 255}
_REAL = ("cartesianX", "cartesianY", "cartesianZ", "intensity")
_NO_COORDINATES = 2  # cartesianInvalidState of a beam that did not return
_GUID = "{00000000-0000-4000-8000-%012d}"


def write_e57(path: str | Path, scans: Sequence[Scan]) -> Path:
    """Write scans that each have one pose (`local_from_scanner`); points are float32 in the scanner's frame.

    A scan with a `grid` keeps its rows and columns; beams that did not return become invalid points.
    Intensity stays 0..1. Poses are in world coordinates, and coordinateMetadata holds the CRS.

    Raises MissingExtra without pye57, InputError for a scan without a pose, and FileError when the file
    cannot be written.
    """
    try:
        from pye57 import libe57
    except ImportError as problem:
        raise MissingExtra("writing E57", "e57") from problem
    p = Path(path)
    poses = [_pose(scan) for scan in scans]
    with whole_file(p) as temporary:
        file = libe57.ImageFile(str(temporary), "w")
        try:
            clouds = _header(file, scans[0].world.crs, str(p))
            for number, (scan, pose) in enumerate(zip(scans, poses, strict=True), 1):
                _write(file, clouds, scan, pose, number)
        finally:
            file.close()
    return p


def _pose(scan: Scan) -> Rigid3:
    if scan.local_from_scanner is None:
        raise InputError(f"{scan.name}: an E57 scan needs the pose of its scanner; write this scan as LAZ")
    return scan.local_from_scanner.value


def _header(file: Any, crs: str | None, name: str) -> Any:
    """Write the root's entries; returns the list that scans are appended to."""
    from pye57 import libe57

    file.extensionsAdd("", libe57.E57_V1_0_URI)
    root = file.root()
    _set(file, root, formatName="ASTM E57 3D Imaging Data File", guid=_GUID % 0)
    _set(file, root, versionMajor=libe57.E57_FORMAT_MAJOR, versionMinor=libe57.E57_FORMAT_MINOR)
    _set(file, root, e57LibraryVersion=libe57.E57_LIBRARY_ID)
    _set(file, root, coordinateMetadata=parse_crs(crs, name).to_wkt() if crs else "")
    root.set("creationDateTime", _node(file, dateTimeValue=0.0, isAtomicClockReferenced=0))
    clouds = libe57.VectorNode(file, True)
    root.set("data3D", clouds)
    root.set("images2D", libe57.VectorNode(file, True))
    return clouds


def _node(file: Any, **values: Any) -> Any:
    from pye57 import libe57

    node = libe57.StructureNode(file)
    _set(file, node, **values)
    return node


def _set(file: Any, node: Any, **values: Any) -> None:
    """Set entries of a structure by the type of their values; nodes are set as they are."""
    from pye57 import libe57

    kinds = {str: libe57.StringNode, int: libe57.IntegerNode, float: libe57.FloatNode}
    for name, value in values.items():
        kind = kinds.get(type(value))
        node.set(name, value if kind is None else kind(file, value))


def _write(file: Any, clouds: Any, scan: Scan, pose: Rigid3, number: int) -> None:
    """Write one scan: its header, then its points in one block."""
    from pye57 import libe57

    columns = _columns(scan, pose)
    node = _node(file, guid=_GUID % number, name=scan.name)
    w, x, y, z = (float(v) for v in quaternion_from_rotation(pose.R))
    tx, ty, tz = (float(v) for v in scan.world.to_world(pose.t))
    at = _node(file, x=tx, y=ty, z=tz)
    node.set("pose", _node(file, rotation=_node(file, w=w, x=x, y=y, z=z), translation=at))
    if scan.grid is not None:
        rows, width = scan.grid.index.shape
        bounds = {"rowMinimum": 0, "rowMaximum": rows - 1, "columnMinimum": 0, "columnMaximum": width - 1}
        node.set("indexBounds", _node(file, **bounds, returnMinimum=0, returnMaximum=0))
    if scan.intensity is not None:
        node.set("intensityLimits", _node(file, intensityMinimum=0.0, intensityMaximum=1.0))
    if scan.rgb is not None:
        limits = {f"color{c}{e}": v for c in ("Red", "Green", "Blue") for e, v in _BYTE.items()}
        node.set("colorLimits", _node(file, **limits))
    prototype = libe57.StructureNode(file)
    buffers = libe57.VectorSourceDestBuffer()
    for name, values in columns.items():
        prototype.set(name, _element(file, name, values))
        buffers.append(libe57.SourceDestBuffer(file, name, values, len(values), True, True))
    points = libe57.CompressedVectorNode(file, prototype, libe57.VectorNode(file, True))
    node.set("points", points)
    clouds.append(node)
    writer = points.writer(buffers)
    writer.write(len(columns["cartesianX"]))
    writer.close()


def _element(file: Any, name: str, values: Array) -> Any:
    """The prototype of a column: integers with their range, other numbers in single precision."""
    from pye57 import libe57

    low, high = values.min(initial=0), values.max(initial=0)
    if not name.startswith(_REAL):
        return libe57.IntegerNode(file, 0, int(low), int(high))
    return libe57.FloatNode(file, 0.0, libe57.E57_SINGLE, float(low), float(high))


def _columns(scan: Scan, pose: Rigid3) -> dict[str, Array]:
    """The file's columns, with one row per beam of the grid, column by column, or else one row per point.

    All are doubles that libe57 converts on writing, because pye57 0.4.19 misreads other integer buffers.
    """
    out: dict[str, Array] = {}
    index = np.arange(len(scan), dtype=np.int64)
    if scan.grid is not None:
        index = scan.grid.index.T.ravel()
        rows, columns = scan.grid.index.shape
        out["columnIndex"], out["rowIndex"] = (a.ravel() for a in np.mgrid[0:columns, 0:rows])
    lost = index < 0
    xyz = np.where(lost[:, None], 0.0, pose.inverse.apply(scan.xyz)[index])
    for k, axis in enumerate("XYZ"):
        out[f"cartesian{axis}"] = xyz[:, k].astype(np.float32)
    out["cartesianInvalidState"] = np.where(lost, _NO_COORDINATES, 0)
    if scan.intensity is not None:
        out["intensity"] = np.where(lost, 0.0, scan.intensity[index]).astype(np.float32)
    if scan.rgb is not None:
        for k, name in enumerate(("Red", "Green", "Blue")):
            out[f"color{name}"] = np.where(lost, 0, scan.rgb[index, k])
    return {name: np.ascontiguousarray(values, np.float64) for name, values in out.items()}
