"""Every format that the simulator writes is read back, is repeatable byte for byte, and fits its schema."""

import json
import struct
import warnings
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest
from lxml import etree

from frontage.errors import InputError, UnsupportedFormat
from frontage.geometry.rigid import Rigid3, rotation_from_quaternion
from frontage.io.citymodels.address import split_address
from frontage.io.citymodels.citygml.write import write_citygml
from frontage.io.citymodels.cityjson.write import write_cityjson
from frontage.io.citymodels.footprints import read_footprints
from frontage.io.citymodels.formats import FORMATS as CITY_MODELS
from frontage.io.colmap import read_colmap
from frontage.io.colmapwrite import write_colmap
from frontage.io.meshes.formats import FORMATS as MESHES
from frontage.io.meshes.formats import write_meshes
from frontage.io.meshes.textured import TexturedMesh, glb_bytes
from frontage.io.photos.decoder import decode
from frontage.io.photos.exif import Exif, read_exif, write_jpeg
from frontage.io.photos.formats import FORMATS as POSES
from frontage.io.photos.imagefile import image_header
from frontage.io.scans.e57write import write_e57
from frontage.io.scans.formats import FORMATS as SCANS
from frontage.io.scans.ptx import write_ptx
from frontage.io.scans.read import ScanSource, read_scans
from frontage.io.scans.trajectory import read_trajectory, write_trajectory
from frontage.io.shapes.formats import FACE_FORMATS as FACES
from frontage.io.shapes.formats import SOLID_FORMATS as SOLIDS
from frontage.model import Camera, Estimate, Grid, Photo, Scan, Surface, WorldRef
from frontage.model.citymodel import CityBuilding, Shell
from io_files import UTM
from realdata import data_path


def structured(seed: int = 0, rows: int = 21, columns: int = 34) -> Scan:
    """A scan from a turned and tilted scanner; a fifth of its beams are lost."""
    rng = np.random.default_rng(seed)
    index = np.full(rows * columns, -1)
    back = rng.random(rows * columns) < 0.8
    n = int(back.sum())
    index[back] = rng.permutation(n)
    R = rotation_from_quaternion(np.array([0.8, 0.02, -0.01, 0.6]))
    pose = Rigid3("local", "scanner", R, np.array([3.0, -4.0, 1.625]))
    return Scan(
        "station 1", pose.apply(rng.uniform(-40, 40, (n, 3))), UTM, pose.t[None], np.zeros(n),
        rng.random(n), rng.integers(0, 256, (n, 3)), grid=Grid(index.reshape(rows, columns)),
        local_from_scanner=Estimate(pose, np.zeros((6, 6)), 0.0),
    )  # fmt: skip


def by_beam(scan: Scan, values: np.ndarray) -> np.ndarray:
    """Per-point values in the order of the raster, which is what a file must keep."""
    index = scan.grid.index.ravel()
    return values[index[index >= 0]]


@pytest.mark.parametrize("kind", ["e57", "ptx"])
def test_structured_scans_come_back(tmp_path: Path, kind: str) -> None:
    scans = [structured(0), structured(1)]
    write = {"e57": write_e57, "ptx": write_ptx}[kind]
    path = write(tmp_path / f"two.{kind}", scans)
    crs = UTM.crs if kind == "ptx" else None
    found = read_scans(ScanSource(path=str(path), crs=crs), UTM)
    assert len(found) == 2
    for wrote, read in zip(scans, found, strict=True):
        assert ((read.grid.index >= 0) == (wrote.grid.index >= 0)).all()
        assert np.abs(by_beam(read, read.xyz) - by_beam(wrote, wrote.xyz)).max() < 2e-5
        assert (by_beam(read, read.rgb) == by_beam(wrote, wrote.rgb)).all()
        assert np.abs(by_beam(read, read.intensity) - by_beam(wrote, wrote.intensity)).max() < 2e-4
        assert np.abs(read.origins[0] - wrote.origins[0]).max() < 1e-8
        assert np.abs(read.local_from_scanner.value.R - wrote.local_from_scanner.value.R).max() < 1e-9
    if kind == "e57":
        assert found[0].world.crs == "EPSG:25832"


@pytest.mark.parametrize("write", [write_e57, write_ptx])
def test_the_same_scans_give_the_same_bytes_and_poses_are_needed(tmp_path: Path, write) -> None:
    a, b = write(tmp_path / "a", [structured()]), write(tmp_path / "b", [structured()])
    assert a.read_bytes() == b.read_bytes()
    scan = structured()
    with pytest.raises(InputError, match="needs the pose"):
        write(tmp_path / "c", [Scan("bare", scan.xyz, UTM)])
    assert not (tmp_path / "c").exists()


def test_a_trajectory_comes_back(tmp_path: Path) -> None:
    k = np.arange(50.0)
    samples = np.column_stack([1000 + k / 10, k, 0.1 * k, 1.5 + 0 * k, 0 * k, 0 * k, np.radians(k)])
    found = read_trajectory(write_trajectory(tmp_path / "t.csv", samples, UTM))
    assert np.abs(found.time - samples[:, 0]).max() < 1e-6
    assert np.abs(UTM.to_local(found.xyz) - samples[:, 1:4]).max() < 6e-5
    assert (tmp_path / "t.csv").read_text().splitlines()[0] == "gps_time,x,y,z,roll,pitch,heading"


def test_a_colmap_model_comes_back_with_its_offset(tmp_path: Path) -> None:
    rng = np.random.default_rng(3)
    camera = Camera("OPENCV", 60, 40, np.array([50.0, 51, 30, 20, -0.06, 0.02, 4e-4, -3e-4]))
    photos = []
    for k in range(3):
        pose = Rigid3("local", "camera", rotation_from_quaternion(rng.normal(size=4)), rng.normal(size=3))
        photos.append(Photo(f"sub folder/IMG {k}.jpg", camera, Estimate(pose, np.zeros((6, 6)), 0.0)))
    model = read_colmap(write_colmap(tmp_path / "colmap", photos, UTM.origin))
    assert len(model.cameras) == 1 and (model.cameras[1].params == camera.params).all()
    for photo, image in zip(photos, model.images, strict=True):
        back = image.camera_from_world.inverse
        assert image.name == photo.id
        assert np.abs(back.matrix - photo.pose.matrix).max() < 1e-12
    assert (tmp_path / "colmap" / "offset.txt").read_text().split() == ["678000.0", "5403000.0", "400.0"]


def exif_of(data: bytes) -> dict[int, dict[int, tuple[int, bytes]]]:
    """An independent reading of the EXIF block: directory (0, 0x8769, 0x8825) -> tag -> (type, bytes)."""
    at = data.index(b"Exif\0\0") + 6
    tiff = data[at:]
    assert tiff[:4] == b"II*\0"
    sizes = {1: 1, 2: 1, 3: 2, 4: 4, 5: 8, 7: 1}

    def directory(start: int) -> dict[int, tuple[int, bytes]]:
        (n,) = struct.unpack_from("<H", tiff, start)
        out = {}
        for k in range(n):
            tag, kind, count = struct.unpack_from("<HHI", tiff, start + 2 + 12 * k)
            length = sizes[kind] * count
            place = start + 10 + 12 * k
            if length > 4:
                (place,) = struct.unpack_from("<I", tiff, place)
            out[tag] = kind, tiff[place : place + length]
        assert list(out) == sorted(out)
        return out

    main = directory(struct.unpack_from("<I", tiff, 4)[0])
    return {0: main} | {t: directory(*struct.unpack("<I", main[t][1])) for t in (0x8769, 0x8825) if t in main}


def degrees(value: bytes) -> float:
    d, m, s = (a / b for a, b in np.frombuffer(value, "<u4").reshape(3, 2))
    return d + m / 60 + s / 3600


def test_a_jpeg_carries_focal_length_place_and_direction(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    rgb = np.kron(rng.integers(0, 256, (4, 6, 3)), np.ones((10, 10, 1))).astype(np.uint8)
    place = (48.7651234, -11.4212345, 373.25)
    about = Exif("Simulated", "One", 4.25, 26, place, -88.5, 2.0)
    path = write_jpeg(tmp_path / "a.jpg", rgb, about, quality=95)
    assert (image_header(path).width, image_header(path).height) == (60, 40)
    assert np.abs(decode(path.read_bytes(), path).astype(int) - rgb).mean() < 8
    tags = exif_of(path.read_bytes())
    assert tags[0][0x010F][1] == b"Simulated\0"
    gps, shot = tags[0x8825], tags[0x8769]
    assert np.divide(*np.frombuffer(shot[0x920A][1], "<u4")) == pytest.approx(4.25)
    assert (gps[1][1], gps[3][1]) == (b"N\0", b"W\0")
    assert degrees(gps[2][1]) == pytest.approx(48.7651234, abs=1e-8)
    assert degrees(gps[4][1]) == pytest.approx(11.4212345, abs=1e-8)
    assert np.divide(*np.frombuffer(gps[0x11][1], "<u4")) == pytest.approx(271.5)
    back = read_exif(path)
    assert (back.make, back.model, back.focal_length, back.focal_length_35mm) == (
        "Simulated",
        "One",
        4.25,
        26,
    )
    assert back.position == pytest.approx(place, abs=1e-8)
    assert (back.heading, back.position_error) == (271.5, 2.0)
    bare = write_jpeg(tmp_path / "b.jpg", rgb, Exif("S", "One", 4.25, 26))
    assert 0x8825 not in exif_of(bare.read_bytes())
    assert read_exif(bare) == Exif("S", "One", 4.25, 26)


def house(name: str, x: float, address: str | None = None) -> CityBuilding:
    """A closed box of 8 x 6 x 5 m with a hole-free shell; one wall carries attributes."""
    low = np.array([[x, 0, 0.12341], [x + 8, 0, 0.12341], [x + 8, 6, 0.12341], [x, 6, 0.12341]])
    top = low + np.array([0, 0, 5.0])
    faces = [("GroundSurface", low[::-1]), ("RoofSurface", top)]
    for k in range(4):
        m = (k + 1) % 4
        faces.append(("WallSurface", np.array([low[k], low[m], top[m], top[k]])))
    surfaces = tuple(Surface(ring, kind, f"{name}/s{k}") for k, (kind, ring) in enumerate(faces))
    shell = Shell("2.2", surfaces, {f"{name}/s2": {"sigma": 0.004}})
    return CityBuilding(name, (shell,), address, {"measuredHeight": 5.0})


HOUSES = [house("B01", 0.0, "12 Lime Street"), house("B/02", 8.0, "Am Markt 3a"), house("B03", 16.0)]


def test_cityjson_is_valid_and_its_footprints_come_back(tmp_path: Path) -> None:
    import jsonschema

    path = write_cityjson(tmp_path / "m.city.json", HOUSES, UTM, "a street")
    model = json.loads(path.read_text())
    solid = model["CityObjects"]["B01"]["geometry"][0]
    assert solid["semantics"]["surfaces"][2] == {"type": "WallSurface", "id": "B01/s2", "sigma": 0.004}
    assert len(model["vertices"]) == 16  # neighbours share their corners
    assert model["metadata"]["referenceSystem"].endswith("EPSG/0/25832")
    found = read_footprints(path, UTM)
    assert [(f.id, f.address) for f in found] == [
        ("B01", "12 Lime Street"), ("B/02", "Am Markt 3a"), ("B03", None)]  # fmt: skip
    assert np.abs(np.sort(found[0].ring, 0) - [[0, 0], [0, 0], [8, 6], [8, 6]]).max() < 1e-4
    schema = json.loads(data_path("schemas/cityjson/cityjson.min.schema.json").read_text())
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        jsonschema.validate(model, schema)
        model["CityObjects"]["B01"]["geometry"][0]["type"] = "Sphere"
        with pytest.raises(jsonschema.ValidationError):
            jsonschema.validate(model, schema)


def test_every_edge_of_a_written_solid_is_used_once_each_way(tmp_path: Path) -> None:
    model = json.loads(write_cityjson(tmp_path / "m.city.json", HOUSES, UTM, "t").read_text())
    edges: list[tuple[int, int]] = []
    for surface in model["CityObjects"]["B03"]["geometry"][0]["boundaries"][0]:
        for ring in surface:
            edges += list(zip(ring, ring[1:] + ring[:1], strict=True))
    assert len(edges) == 24 == len(set(edges))
    assert {(b, a) for a, b in edges} == set(edges)


def test_citygml_is_valid_and_its_footprints_come_back(tmp_path: Path) -> None:
    path = write_citygml(tmp_path / "m.gml", HOUSES, UTM, "a street")
    found = read_footprints(path, UTM)
    assert [(f.id, f.address) for f in found] == [
        ("B01", "12 Lime Street"), ("B_02", "3a Am Markt"), ("B03", None)]  # fmt: skip
    assert np.abs(np.sort(found[2].ring, 0) - [[16, 0], [16, 0], [24, 6], [24, 6]]).max() < 1e-4
    folder = data_path("schemas/citygml/citygml/2.0/building.xsd")
    schema = etree.XMLSchema(etree.parse(str(folder)))
    tree = etree.parse(str(path))
    assert schema.validate(tree), schema.error_log.last_error
    solid = next(tree.iter("{http://www.opengis.net/citygml/building/2.0}lod2Solid"))
    solid.getparent().append(solid)  # out of its place in the sequence
    assert not schema.validate(tree)


def test_a_model_without_the_level_asked_for_is_refused(tmp_path: Path) -> None:
    bare = CityBuilding("B9", (Shell("1", HOUSES[0].shells[0].surfaces),))
    with pytest.raises(ValueError, match="B9 has no shell"):
        write_citygml(tmp_path / "m.gml", [bare], UTM, "t")
    assert not (tmp_path / "m.gml").exists()


@pytest.mark.parametrize(
    ("address", "parts"),
    [
        ("13 rue Soufflot", ("13", "rue Soufflot")),
        ("Am Markt 3a", ("3a", "Am Markt")),
        ("Court", ("", "Court")),
    ],
)
def test_addresses_are_split(address: str, parts: tuple[str, str]) -> None:
    assert split_address(address) == parts


def test_a_world_without_crs_is_written_without_one(tmp_path: Path) -> None:
    bare = WorldRef(UTM.origin, None)
    model = json.loads(write_cityjson(tmp_path / "m.city.json", HOUSES, bare, "t").read_text())
    assert "referenceSystem" not in model["metadata"]


def test_textured_meshes_are_written_by_their_suffix(tmp_path: Path) -> None:
    xyz = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    mesh = TexturedMesh("B01/F1", xyz, xyz[:, [0, 2]], np.array([[0, 1, 2]]), np.eye(4), b"jpeg", {})
    for suffix in (".glb", ".obj"):
        write_meshes(tmp_path / f"a{suffix}", [mesh], UTM)
    assert (tmp_path / "a.glb").read_bytes() == glb_bytes([mesh], UTM)
    assert (tmp_path / "textures" / "B01_F1.jpg").read_bytes() == b"jpeg"
    with pytest.raises(UnsupportedFormat, match=r"use one of \.glb, \.obj"):
        write_meshes(tmp_path / "a.fbx", [mesh], UTM)


def test_every_reader_of_the_registries_exists() -> None:
    listed = [f.reader for f in (*SCANS, *POSES, *CITY_MODELS, *FACES, *SOLIDS)] + [f.writer for f in MESHES]
    for name in listed:
        module, function = name.split(":")
        assert callable(getattr(import_module(module), function)), name
