"""Writers of small point files for the tests of `frontage.io`: every format, whole or damaged."""

import json
import struct
from pathlib import Path

import cv2
import laspy
import numpy as np
import pye57
from pye57 import libe57

from frontage.geometry.arrays import Array, Float
from frontage.io.scans.laswrite import write_las
from frontage.io.scans.ply import write_ply
from frontage.model import Scan, WorldRef

UTM = WorldRef(np.array([678_000, 5_403_000, 400]), "EPSG:25832")


def cloud(n: int = 500, seed: int = 0, world: WorldRef = UTM) -> Scan:
    """A scan with every attribute and two stations."""
    r = np.random.default_rng(seed)
    return Scan(
        "cloud", r.uniform(-20, 20, (n, 3)), world, np.array([[0.0, -30, 1.5], [10, -30, 1.6]]),
        r.integers(-1, 2, n), r.uniform(0, 1, n), r.integers(0, 256, (n, 3)), np.sort(r.uniform(0, 60, n)),
        r.integers(1, 3, n), np.full(n, 2),
    )  # fmt: skip


def write_laspy(
    path: Path, xyz: Float, point_format: int = 3, crs: str | None = None, **fields: Array
) -> Path:
    """A LAS or LAZ file as another program would write it; extra fields become columns."""
    header = laspy.LasHeader(point_format=point_format, version="1.4" if point_format > 5 else "1.3")
    header.scales, header.offsets = np.full(3, 0.001), np.floor(xyz.min(0))
    if crs is not None:
        from pyproj import CRS

        header.add_crs(CRS.from_user_input(crs))
    for name in [n for n in fields if n not in header.point_format.dimension_names]:
        header.add_extra_dim(laspy.ExtraBytesParams(name, fields[name].dtype))
    las = laspy.LasData(header)
    las.x, las.y, las.z = xyz.T
    for name, values in fields.items():
        las[name] = values
    las.write(path)
    return path


def e57_columns(rows: int = 12, columns: int = 20) -> dict[str, Array]:
    """A small raster of a wall 5 m away; every seventh beam has no return."""
    row, column = (a.ravel() for a in np.mgrid[0:rows, 0:columns])
    xyz = np.column_stack([(column - 10) * 0.1, np.full(len(row), 5.0), (row - 5) * 0.1])
    lost = np.arange(len(row)) % 7 == 3
    xyz[lost] = 0.0
    return {
        "cartesianX": xyz[:, 0], "cartesianY": xyz[:, 1], "cartesianZ": xyz[:, 2],
        "intensity": np.linspace(0.1, 0.9, len(row)), "rowIndex": row, "columnIndex": column,
        "colorRed": row * 20, "colorGreen": column * 12, "colorBlue": np.arange(len(row)) % 256,
        "cartesianInvalidState": np.where(lost, 2, 0),
    }  # fmt: skip


QUATERNION = np.array([np.cos(0.3), 0.0, 0.0, np.sin(0.3)])
POSITION = np.array([678_010.25, 5_403_020.5, 401.75])


def write_e57(path: Path, scans: int = 2, photo: bytes | None = None, **changed: Array) -> Path:
    """An E57 file with pose and raster, as pye57 writes it, and one embedded pinhole photo when given."""
    e57 = pye57.E57(str(path), mode="w")
    for k in range(scans):
        e57.write_scan_raw(
            e57_columns() | changed, rotation=QUATERNION, translation=POSITION + np.array([k, 0, 0])
        )
    if photo is not None:
        _embed(e57, photo)
    e57.close()
    return path


def _embed(e57: pye57.E57, photo: bytes) -> None:
    """One pinhole photo, 60 x 40 px, looking along the file's +y axis (E57: along the camera's -z)."""
    imf = e57.image_file
    image, view, pose = (libe57.StructureNode(imf) for _ in range(3))
    half = np.sqrt(0.5)
    for name, values in (
        ("rotation", {"w": half, "x": half, "y": 0.0, "z": 0.0}),
        ("translation", {"x": 1.0, "y": 2.0, "z": 3.0}),
    ):
        node = libe57.StructureNode(imf)
        for axis, value in values.items():
            node.set(axis, libe57.FloatNode(imf, value))
        pose.set(name, node)
    image.set("guid", libe57.StringNode(imf, "{1}"))
    image.set("name", libe57.StringNode(imf, "north"))
    image.set("pose", pose)
    e57.root["images2D"].append(image)
    blob = libe57.BlobNode(imf, len(photo))
    view.set("jpegImage", blob)
    for name, value in (("imageWidth", 60), ("imageHeight", 40)):
        view.set(name, libe57.IntegerNode(imf, value))
    for name, number in (("focalLength", 0.05), ("pixelWidth", 0.001), ("pixelHeight", 0.001),
                         ("principalPointX", 30.0), ("principalPointY", 20.0)):  # fmt: skip
        view.set(name, libe57.FloatNode(imf, number))
    image.set("pinholeRepresentation", view)
    blob.write(np.frombuffer(photo, np.uint8).copy(), 0, len(photo))


def ptx_text(
    rows: int = 3, columns: int = 4, t: Float = POSITION, colour: bool = False, scans: int = 1
) -> str:
    """PTX scans turned by 30 degrees about z; the beam of row 1 in column 2 has no return."""
    c, s = np.cos(np.pi / 6), np.sin(np.pi / 6)
    matrix = np.array([[c, s, 0, 0], [-s, c, 0, 0], [0, 0, 1, 0], [*t, 1]])
    lines = []
    for _ in range(scans):
        lines += [str(columns), str(rows), *(" ".join(f"{v:.6f}" for v in r) for r in
                                             (t, *matrix[:3, :3], *matrix))]  # fmt: skip
        for k in range(columns):
            for j in range(rows):
                gone = (j, k) == (1, 2)
                xyz = "0 0 0 0.5" if gone else f"{k + 1} {j + 2} {j * k + 0.5} {0.1 * j:.3f}"
                lines.append(xyz + (" 10 20 30" if colour else ""))
    return "\n".join(lines) + "\n"


def write_colmap_binary(folder: Path) -> Path:
    """The model of `write_colmap_text` in binary."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "cameras.bin").write_bytes(struct.pack("<QiiQQ4d", 1, 7, 1, 60, 40, 50.0, 50.0, 30.0, 20.0))
    images = struct.pack("<Q", 2)
    for number, name, x in ((3, b"a.jpg", 1.0), (5, b"sub/b.jpg", 2.0)):
        images += struct.pack("<I7dI", number, 1.0, 0.0, 0.0, 0.0, -x, 0.0, 0.0, 7) + name + b"\0"
        images += struct.pack("<QddQ", 1, 5.0, 6.0, 11)
    (folder / "images.bin").write_bytes(images)
    points = struct.pack("<Q", 2)
    points += struct.pack("<Q3d3BdQII", 11, 1.0, 2.0, 3.0, 9, 8, 7, 0.5, 1, 5, 0)
    points += struct.pack("<Q3d3BdQIIII", 12, 4.0, 5.0, 6.0, 1, 2, 3, 0.5, 2, 3, 0, 5, 1)
    (folder / "points3D.bin").write_bytes(points)
    return folder


def write_colmap_text(folder: Path) -> Path:
    """Two photos 60 x 40 px at x = 1 and 2, turned by nothing, and two points."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "cameras.txt").write_text("# comment\n7 PINHOLE 60 40 50 50 30 20\n")
    (folder / "images.txt").write_text(
        "# comment\n5 1 0 0 0 -2 0 0 7 sub/b.jpg\n\n3 1 0 0 0 -1 0 0 7 a.jpg\n5 6 11\n"
    )
    (folder / "points3D.txt").write_text("# c\n11 1 2 3 9 8 7 0.5 5 0\n12 4 5 6 1 2 3 0.5 3 0 5 1\n")
    return folder


def picture(width: int = 60, height: int = 40, orientation: int | None = None) -> bytes:
    """JPEG bytes, red in the upper left quarter, with an EXIF orientation when asked."""
    image = np.full((height, width, 3), 90, np.uint8)
    image[: height // 2, : width // 2] = (0, 0, 255)
    data: bytes = cv2.imencode(".jpg", image)[1].tobytes()
    if orientation is None:
        return data
    tiff = b"II*\0\x08\0\0\0" + struct.pack("<HHHIHHI", 1, 0x0112, 3, 1, orientation, 0, 0)
    body = b"Exif\0\0" + tiff
    return data[:2] + b"\xff\xe1" + struct.pack(">H", len(body) + 2) + body + data[2:]


def write_photos(folder: Path) -> Path:
    """The pictures that the COLMAP models above name."""
    (folder / "sub").mkdir(parents=True, exist_ok=True)
    (folder / "a.jpg").write_bytes(picture())
    (folder / "sub" / "b.jpg").write_bytes(picture())
    return folder


def write_pcd(path: Path, xyz: np.ndarray) -> Path:
    """A binary PCD file of points (n, 3) in double precision."""
    head = (
        "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z\nSIZE 8 8 8\nTYPE F F F\nCOUNT 1 1 1\n"
        f"WIDTH {len(xyz)}\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS {len(xyz)}\nDATA binary\n"
    )
    path.write_bytes(head.encode() + np.ascontiguousarray(xyz, "<f8").tobytes())
    return path


def whole_files(folder: Path) -> dict[str, Path]:
    """One good file of every scan format, by suffix."""
    folder.mkdir(parents=True, exist_ok=True)
    scan = cloud(2000)
    kinds = (".laz", ".las", ".ply", ".pcd", ".e57", ".ptx", ".xyz", ".csv")
    files = {k: folder / f"good{k}" for k in kinds}
    write_las(files[".laz"], scan)
    write_las(files[".las"], scan)
    write_ply(files[".ply"], scan)
    write_e57(files[".e57"])
    files[".ptx"].write_text(ptx_text(30, 40))
    world = scan.world.to_world(scan.xyz)
    write_pcd(files[".pcd"], world)
    np.savetxt(files[".xyz"], world, fmt="%.4f")
    np.savetxt(files[".csv"], world, fmt="%.4f", delimiter=",", header="x,y,z", comments="")
    files["points3D.bin"] = write_colmap_binary(folder / "binary") / "points3D.bin"
    files["points3D.txt"] = write_colmap_text(folder / "text") / "points3D.txt"
    return files


def write_json(path: Path, value: object) -> Path:
    """A JSON file."""
    path.write_text(json.dumps(value))
    return path
