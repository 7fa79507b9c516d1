"""Small valid files of every format that Frontage reads, which the mutations start from.

They are made by the project's own writers, or are a few lines of text. Nothing comes from third parties.
"""

import json
import sqlite3
import struct
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
import shapely

import copc_files
import io_files
import shape_files
from city_files import house, write
from frontage.io.citymodels.citygml.write import write_citygml
from frontage.io.citymodels.cityjson.write import write_cityjson
from frontage.io.scans.laswrite import write_las
from frontage.io.scans.npz import save_scan
from frontage.io.scans.ply import write_ply

Make = Callable[[Path], Path]
"""Writes the files of a seed into a folder and returns the one that the mutations change."""

TRACK = "gps_time,x,y,z\n" + "".join(
    f"{t},{678_000 + t},{5_403_000 + 2 * t},{401.5 + 0.1 * t}\n" for t in range(0, 70, 5)
)
PROJECT = """[project]
crs = "EPSG:25832"
seed = 3

[[scans]]
path = "scan.las"
crs = "EPSG:25832"
units = "m"
offset = [1.0, 2.0, -3.5]
sigma_range = 0.004

[photos]
path = "*.jpg"
cameras = "."
offset = [678000.0, 5403000.0, 400.0]

[model]
path = "model.city.json"

[facades]
[ortho]
gsd = 0.02

[openings]
[solids]

[[addresses]]
building = "B01"
address = "12 Lime Street"
"""


@dataclass(frozen=True)
class Seed:
    """A small valid file.

    name    of the format, as the table of results shows it
    reader  which function of `readers` reads it
    kinds   the families of mutations that know its structure (see `mutations`)
    make    writes it
    """

    name: str
    reader: str
    kinds: tuple[str, ...]
    make: Make


def _scan(suffix: str, writer: Callable[[Path, object], object], n: int = 60) -> Make:
    def make(folder: Path) -> Path:
        path = folder / f"scan{suffix}"
        writer(path, io_files.cloud(n))
        return path

    return make


def _text(name: str, text: str | Callable[[], str]) -> Make:
    return lambda folder: write(folder / name, text if isinstance(text, str) else text())


def _copc(folder: Path) -> Path:
    r = np.random.default_rng(0)
    nodes = {key: np.round(r.uniform(0, 32, (40, 3)), 3) + copc_files.ORIGIN
             for key in ((0, 0, 0, 0), (1, 0, 0, 0))}  # fmt: skip
    return copc_files.write_copc(folder / "scan.copc.laz", nodes)


def _ascii_ply(folder: Path) -> Path:
    xyz = io_files.cloud(20).xyz
    head = ["ply", "format ascii 1.0", f"element vertex {len(xyz)}"]
    head += [f"property double {axis}" for axis in "xyz"] + ["property uchar red", "end_header"]
    rows = [f"{x:.3f} {y:.3f} {z:.3f} {k}" for k, (x, y, z) in enumerate(xyz)]
    return write(folder / "scan.ply", "\n".join([*head, *rows, ""]))


def _table(name: str, head: str, comma: str) -> Make:
    rows = [comma.join(f"{v:.3f}" for v in (678_000 + x, 5_403_000 + y, 400 + z, 0.5))
            for x, y, z in io_files.cloud(20).xyz]  # fmt: skip
    return _text(name, "\n".join([*([head] if head else []), *rows, ""]))


def _colmap(kind: str, part: str, photos: bool = False) -> Make:
    def make(folder: Path) -> Path:
        maker = io_files.write_colmap_binary if kind == "bin" else io_files.write_colmap_text
        maker(folder)
        if photos:
            io_files.write_photos(folder)
        return folder / f"{part}.{kind}"

    return make


def _trajectory(name: str, data: bytes) -> Make:
    def make(folder: Path) -> Path:
        write_las(folder / "scan.las", io_files.cloud(60))
        (folder / name).write_bytes(data)
        return folder / name

    return make


def _sbet() -> bytes:
    rows = np.zeros((14, 17))
    rows[:, 0] = np.arange(0, 70, 5)
    rows[:, 1], rows[:, 2], rows[:, 3] = np.radians(48.76) + rows[:, 0] * 1e-7, np.radians(11.42), 400.0
    return rows.astype("<f8").tobytes()


def _stations(folder: Path) -> Path:
    write_las(folder / "scan.las", io_files.cloud(60))
    return folder / "scan.las.stations.json"


def _picture(suffix: str) -> Make:
    def make(folder: Path) -> Path:
        image = np.random.default_rng(1).integers(0, 256, (24, 32, 3)).astype(np.uint8)
        path = folder / f"photo{suffix}"
        path.write_bytes(cv2.imencode(suffix, image)[1].tobytes())
        return path

    return make


def _exif(folder: Path) -> Path:
    path = folder / "photo.jpg"
    path.write_bytes(io_files.picture(orientation=6))
    return path


def _cityjson(folder: Path) -> Path:
    return write_cityjson(folder / "model.city.json", [house("A", 0), house("B", 20)], io_files.UTM, "two")


def _citygml(version: str) -> Make:
    def make(folder: Path) -> Path:
        path, houses = folder / "model.gml", [house("A", 0), house("B", 20)]
        if version != "1.0":
            return write_citygml(path, houses, io_files.UTM, "two", version)  # type: ignore[arg-type]
        write_citygml(path, houses, io_files.UTM, "two", "2.0")
        text = path.read_text("utf-8").replace("citygml/2.0", "citygml/1.0")
        return write(path, text.replace("citygml/building/2.0", "citygml/building/1.0"))

    return make


def _geojson(folder: Path) -> Path:
    rings = [[[11.0, 48.0], [11.001, 48.0], [11.001, 48.001], [11.0, 48.001], [11.0, 48.0]]]
    features = [
        {"type": "Feature", "id": k, "properties": {"height": 9.5, "name": f"B{k}"},
         "geometry": {"type": kind, "coordinates": rings if kind == "Polygon" else [rings]}}
        for k, kind in enumerate(("Polygon", "MultiPolygon"))
    ]  # fmt: skip
    return write(folder / "model.geojson", {"type": "FeatureCollection", "features": features})


def _geopackage(folder: Path) -> Path:
    path = folder / "model.gpkg"
    wkb = shapely.to_wkb(shapely.box(678_000, 5_403_000, 678_010, 5_403_008))
    blob = b"GP\x00\x03" + struct.pack("<i4d", 25832, 678_000, 678_010, 5_403_000, 5_403_008) + wkb
    with sqlite3.connect(path) as db:
        db.execute("CREATE TABLE gpkg_spatial_ref_sys "
                   "(srs_name, srs_id, organization, organization_coordsys_id, definition)")  # fmt: skip
        db.execute("CREATE TABLE gpkg_geometry_columns "
                   "(table_name, column_name, geometry_type_name, srs_id, z, m)")  # fmt: skip
        db.execute("INSERT INTO gpkg_spatial_ref_sys VALUES ('x', 25832, 'EPSG', 25832, '')")
        db.execute("INSERT INTO gpkg_geometry_columns VALUES ('prints', 'geom', 'POLYGON', 25832, 0, 0)")
        db.execute("CREATE TABLE prints (fid INTEGER PRIMARY KEY, geom BLOB, street, height)")
        db.execute("INSERT INTO prints VALUES (7, ?, 'Lime Street', 12.5)", (blob,))
    db.close()
    return path


def _indoor() -> str:
    names = 'xmlns="http://www.opengis.net/indoorgml/1.0/core" xmlns:gml="http://www.opengis.net/gml/3.2" '
    names += 'xmlns:xlink="http://www.w3.org/1999/xlink"'
    faces = shape_files.members(*(shape_files.polygon(face) for face in shape_files.FACES))
    shell = f"<gml:exterior><gml:Shell>{faces}</gml:Shell></gml:exterior>"
    return (
        f'<IndoorFeatures {names} gml:id="I"><primalSpaceFeatures><PrimalSpaceFeatures><cellSpaceMember>'
        f'<CellSpace gml:id="C1"><cellSpaceGeometry><Geometry3D><gml:Solid gml:id="S">{shell}</gml:Solid>'
        '</Geometry3D></cellSpaceGeometry><duality xlink:href="#R1"/></CellSpace></cellSpaceMember>'
        "</PrimalSpaceFeatures></primalSpaceFeatures><multiLayeredGraph><MultiLayeredGraph><spaceLayers>"
        '<spaceLayerMember><SpaceLayer><nodes><stateMember><State gml:id="R1"><duality xlink:href="#C1"/>'
        "<geometry><gml:Point><gml:pos>0.5 0.5 0.5</gml:pos></gml:Point></geometry></State></stateMember>"
        "</nodes></SpaceLayer></spaceLayerMember></spaceLayers></MultiLayeredGraph></multiLayeredGraph>"
        "</IndoorFeatures>"
    )


def _project(folder: Path) -> Path:
    write_las(folder / "scan.las", io_files.cloud(60))
    io_files.write_photos(io_files.write_colmap_text(folder))
    _cityjson(folder)
    return write(folder / "project.toml", PROJECT)


SEEDS = (
    Seed("LAS", "scan", ("las",), _scan(".las", write_las)),
    Seed("LAZ", "scan", ("las",), _scan(".laz", write_las)),
    Seed("COPC", "copc", ("las",), _copc),
    Seed("E57", "scan", ("e57",), lambda folder: io_files.write_e57(folder / "scan.e57", 1)),
    Seed("E57 photo", "e57photo", ("e57",),
         lambda folder: io_files.write_e57(folder / "scan.e57", 1, io_files.picture())),
    Seed("PTX", "scan", ("text",), _text("scan.ptx", lambda: io_files.ptx_text(colour=True, scans=2))),
    Seed("PLY ascii", "scan", ("text",), _ascii_ply),
    Seed("PLY binary", "scan", ("head",), _scan(".ply", write_ply)),
    Seed("PCD", "scan", ("head",),
         lambda folder: io_files.write_pcd(folder / "scan.pcd", io_files.cloud(60).xyz)),
    Seed("XYZ", "scan", ("text",), _table("scan.xyz", "", " ")),
    Seed("CSV", "scan", ("text",), _table("scan.csv", "x,y,z,intensity", ",")),
    Seed("npz", "scan", ("npz",), _scan(".npz", save_scan)),
    Seed("points3D.txt", "scan", ("text",), _colmap("txt", "points3D")),
    Seed("points3D.bin", "scan", ("numbers",), _colmap("bin", "points3D")),
    Seed("images.txt", "photos", ("text",), _colmap("txt", "images", photos=True)),
    Seed("images.bin", "photos", ("numbers",), _colmap("bin", "images", photos=True)),
    Seed("cameras.txt", "photos", ("text",), _colmap("txt", "cameras", photos=True)),
    Seed("cameras.bin", "photos", ("numbers",), _colmap("bin", "cameras", photos=True)),
    Seed("trajectory CSV", "trajectory", ("text",), _trajectory("track.csv", TRACK.encode())),
    Seed("trajectory SBET", "trajectory", ("numbers",), _trajectory("track.sbet", _sbet())),
    Seed("stations", "stations", ("json",), _stations),
    Seed("JPEG", "photo", ("jpeg",), _picture(".jpg")),
    Seed("JPEG with EXIF", "photo", ("jpeg",), _exif),
    Seed("PNG", "photo", ("png",), _picture(".png")),
    Seed("TIFF", "photo", ("numbers",), _picture(".tiff")),
    Seed("CityJSON 2.0", "city", ("json",), _cityjson),
    Seed("CityJSON 1.1", "city", ("json",),
         _text("model.city.json", lambda: json.dumps(shape_files.cityjson("1.1")))),
    Seed("CityJSONSeq", "city", ("json",), _text("model.city.jsonl", shape_files.sequence)),
    Seed("CityGML 1.0", "city", ("xml",), _citygml("1.0")),
    Seed("CityGML 2.0", "city", ("xml",), _citygml("2.0")),
    Seed("CityGML 3.0", "city", ("xml",), _citygml("3.0")),
    Seed("GeoJSON", "city", ("json",), _geojson),
    Seed("GeoPackage", "city", ("gpkg",), _geopackage),
    Seed("OBJ (validate)", "validate", ("text",), _text("cube.obj", shape_files.obj)),
    Seed("OFF (validate)", "validate", ("text",), _text("cube.off", shape_files.off)),
    Seed("POLY (validate)", "validate", ("text",), _text("cube.poly", shape_files.poly)),
    Seed("CityJSON (validate)", "validate", ("json",),
         _text("cube.city.json", lambda: json.dumps(shape_files.cityjson()))),
    Seed("JSON-FG (validate)", "validate", ("json",), _text("cube.fg.json", shape_files.jsonfg)),
    Seed("GML (validate)", "validate", ("xml",), _text("cube.gml", shape_files.gml)),
    Seed("IndoorGML (validate)", "validate", ("xml",), _text("cell.gml", _indoor)),
    Seed("project.toml", "project", ("text", "toml"), _project),
)  # fmt: skip
"""Every format that is read from outside a run folder."""
