"""Scans hold what each format states: poses, scan grids, beams without return, colours, columns."""

import pickle
import struct
from pathlib import Path

import numpy as np
import pytest

from frontage.geometry.rigid import rotation_from_quaternion
from frontage.io.citymodels.footprints import read_footprints
from frontage.io.colmap import read_colmap
from frontage.io.photos.read import PhotoSource, read_photos
from frontage.io.placement import PlacementRequest
from frontage.io.scans.e57 import read_e57
from frontage.io.scans.ptx import read_ptx
from frontage.io.scans.read import ScanSource, read_scans
from frontage.io.scans.request import ScanRequest
from frontage.io.scans.trajectory import TRACK_STEP_M
from frontage.model import WorldRef
from io_files import (
    POSITION,
    QUATERNION,
    UTM,
    e57_columns,
    picture,
    ptx_text,
    write_colmap_binary,
    write_colmap_text,
    write_e57,
    write_json,
    write_laspy,
    write_photos,
)

LOCAL = WorldRef(np.zeros(3), None)


def test_e57_pose_raster_and_lost_beams(tmp_path: Path) -> None:
    scans = read_e57(write_e57(tmp_path / "a.e57"), ScanRequest(PlacementRequest("a", crs="EPSG:25832")))
    columns = e57_columns()
    lost = columns["cartesianInvalidState"] > 0
    R = rotation_from_quaternion(QUATERNION)
    assert [s.name for s in scans] == ["a.e57:1", "a.e57:2"]
    for k, scan in enumerate(scans):
        xyz = (
            np.column_stack([columns[f"cartesian{a}"] for a in "XYZ"])[~lost] @ R.T
            + POSITION
            + np.array([k, 0, 0])
        )
        assert (
            np.abs(scan.world.to_world(scan.xyz) - xyz).max() < 1e-6
        )  # pye57 writes 32-bit sensor coordinates
        assert scan.grid is not None and scan.grid.index.shape == (12, 20)
        np.testing.assert_array_equal(scan.grid.index.ravel() < 0, lost)
        np.testing.assert_array_equal(np.sort(scan.grid.index[scan.grid.index >= 0]), np.arange(len(scan)))
        np.testing.assert_allclose(
            scan.world.to_world(scan.origins)[0], POSITION + np.array([k, 0, 0]), atol=1e-6
        )
        np.testing.assert_allclose(scan.local_from_scanner.value.R, R, atol=1e-12)
        np.testing.assert_allclose(scan.intensity, columns["intensity"][~lost], atol=1e-6)
        np.testing.assert_array_equal(scan.rgb[:, 0], columns["colorRed"][~lost])
    assert scans[0].world is scans[1].world


def test_e57_with_wrong_indices_and_without(tmp_path: Path) -> None:
    wrong = read_e57(
        write_e57(tmp_path / "w.e57", 1, rowIndex=np.zeros(240, int)), ScanRequest(PlacementRequest("w"))
    )[0]
    assert wrong.grid is None and any("indices" in n for n in wrong.notes)


def test_e57_embedded_photo_keeps_its_pose(tmp_path: Path) -> None:
    path = write_e57(tmp_path / "p.e57", 1, photo=picture())
    photos = read_photos(PhotoSource(path=str(path)), LOCAL)
    (photo,) = photos.photos
    assert photo.id == "north" and photos.image("north").shape == (40, 60, 3)
    assert tuple(photos.image("north")[5, 5] > 128) == (True, False, False)
    ahead = photo.project(np.array([[1.0, 12.0, 3.0], [2.0, 12.0, 4.0]]))  # straight ahead; 1 m right and up
    np.testing.assert_allclose(ahead, [[30, 20], [35, 15]], atol=1e-9)


def test_approximate_poses_have_the_stated_sigmas(tmp_path: Path) -> None:
    (tmp_path / "a.ptx").write_text(ptx_text())
    source = ScanSource(
        path=str(tmp_path / "a.ptx"), pose="approximate", sigma_position=3.0, sigma_heading=4.0
    )
    pose = read_scans(source)[0].local_from_scanner
    np.testing.assert_allclose(pose.sigma, [3, 3, 3, *np.radians([0.1, 0.1, 4.0])])
    source = ScanSource(path=str(tmp_path / "a.ptx"))
    assert not read_scans(source)[0].local_from_scanner.covariance.any()


@pytest.mark.parametrize("colour", [False, True])
def test_ptx_scans_pose_and_raster(tmp_path: Path, colour: bool) -> None:
    (tmp_path / "a.ptx").write_text(ptx_text(colour=colour, scans=2))
    scans = read_ptx(tmp_path / "a.ptx", ScanRequest(PlacementRequest("a")))
    assert len(scans) == 2 and all(len(s) == 11 for s in scans)
    grid = scans[0].grid.index
    assert grid.shape == (3, 4) and grid[1, 2] == -1 and (grid >= 0).sum() == 11
    sensor = np.array([4.0, 4.0, 6.5])  # column 3, row 2
    c, s = np.cos(np.pi / 6), np.sin(np.pi / 6)
    expected = POSITION + np.array([c * 4 - s * 4, s * 4 + c * 4, 6.5])
    assert np.abs(scans[0].world.to_world(scans[0].xyz[grid[2, 3]]) - expected).max() < 1e-5
    np.testing.assert_allclose(
        scans[0].local_from_scanner.value.apply(sensor[None])[0], scans[0].xyz[grid[2, 3]]
    )
    np.testing.assert_allclose(scans[0].world.to_world(scans[0].origins)[0], POSITION)
    assert (scans[0].rgb is None) == (not colour) or any("colour" in n for n in scans[0].notes)


def test_ptx_already_in_world_coordinates(tmp_path: Path) -> None:
    text = (
        "1\n2\n7 8 9\n1 0 0\n0 1 0\n0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n10 11 12 0.5\n13 14 15 0.6\n"
    )
    (tmp_path / "i.ptx").write_text(text)
    scan = read_ptx(tmp_path / "i.ptx", ScanRequest(PlacementRequest("i")))[0]
    np.testing.assert_allclose(scan.xyz, [[10, 11, 12], [13, 14, 15]])
    np.testing.assert_allclose(scan.origins, [[7, 8, 9]])


@pytest.mark.parametrize("order", ["ascii", "binary_little_endian", "binary_big_endian"])
def test_ply_orders_and_other_elements(tmp_path: Path, order: str) -> None:
    rows = [(1.5, 2.5, 3.5, 10, 0.25), (4.5, 5.5, 6.5, 200, 0.75)]
    head = (
        f"ply\nformat {order} 1.0\ncomment x\nelement camera 1\nproperty float a\nproperty uchar b\nelement vertex 2\n"  # noqa: E501
        "property double x\nproperty double y\nproperty double z\nproperty uchar red\nproperty float scalar_Intensity\n"  # noqa: E501
        "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
    )
    if order == "ascii":
        body = b"1 2\n" + "".join(" ".join(map(str, r)) + "\n" for r in rows).encode() + b"3 0 1 1\n"
    else:
        sign = "<" if "little" in order else ">"
        body = struct.pack(sign + "fB", 1, 2) + b"".join(struct.pack(sign + "dddBf", *r) for r in rows)
        body += struct.pack(sign + "B3i", 3, 0, 1, 1)
    (tmp_path / "a.ply").write_bytes(head.encode() + body)
    scan = read_scans(tmp_path / "a.ply")[0]
    np.testing.assert_allclose(scan.xyz, [[1.5, 2.5, 3.5], [4.5, 5.5, 6.5]])
    np.testing.assert_allclose(scan.intensity, [0.25, 0.75])


TABLES = {
    "plain.xyz": ("1 2 3\n4 5 6\n", False, False),
    "comma.csv": ("x,y,z,intensity\n1,2,3,0.5\n4,5,6,0.7\n", True, False),
    "order.csv": ("z;y;x\n3;2;1\n6;5;4\n", False, False),
    "decimal.csv": ("x;y;z\n1,0;2,0;3,0\n4,0;5,0;6,0\n", False, False),
    "hash.txt": ("# X Y Z R G B\n1 2 3 10 20 30\n4 5 6 11 21 31\n", False, True),
    "slash.txt": ("//X,Y,Z,R,G,B\n1,2,3,10,20,30\n4,5,6,11,21,31\n", False, True),
    "count.pts": ("2\n1 2 3 -500 10 20 30\n4 5 6 200 11 21 31\n", True, True),
    "normals.xyz": ("1 2 3 0 0 1\n4 5 6 0.6 0 0.8\n", False, False),
    "bom.csv": ("\ufeffEasting,Northing,Height\n1,2,3\n4,5,6\n", False, False),
    "unit.csv": ("x [m];y [m];z [m]\n1;2;3\n4;5;6\n", False, False),
    "tab.asc": ("1\t2\t3\t7\n4\t5\t6\t9\n", True, False),
}


@pytest.mark.parametrize("name", TABLES)
def test_text_tables(tmp_path: Path, name: str) -> None:
    text, intensity, colour = TABLES[name]
    (tmp_path / name).write_text(text, "utf-8")
    scan = read_scans(tmp_path / name)[0]
    np.testing.assert_allclose(scan.xyz, [[1, 2, 3], [4, 5, 6]])
    assert (scan.intensity is not None) == intensity and (scan.rgb is not None) == colour


def drive(tmp_path: Path, times: np.ndarray, track: str) -> ScanSource:
    xyz = np.random.default_rng(0).uniform(0, 9, (len(times), 3))
    path = write_laspy(tmp_path / "m.las", xyz, 6, gps_time=times)
    (tmp_path / "track.csv").write_text(track)
    return ScanSource(path=str(path), trajectory=str(tmp_path / "track.csv"))


def test_every_point_gets_its_sensor_position_from_the_trajectory(tmp_path: Path) -> None:
    times = np.linspace(100, 110, 400)
    track = "gps_time,x,y,z,heading\n" + "".join(f"{t},{(t - 100) * 5},2,1.8,90\n" for t in range(100, 111))
    scan = read_scans(drive(tmp_path, times, track))[0]
    sensor = scan.sensor_of(np.arange(400))
    assert np.abs(sensor[:, 0] - (times - 100) * 5).max() <= TRACK_STEP_M / 2 + 1e-9
    np.testing.assert_allclose(sensor[:, 1:], [[2, 1.8]] * 400)
    assert len(scan.origins) <= 400


def test_trajectory_with_gaps_standstill_and_another_clock(tmp_path: Path) -> None:
    track = "gps_time,x,y,z\n" + "".join(
        f"{t},{x},0,0\n" for t, x in ((0, 0), (1, 1), (2, 1), (3, 1), (10, 8), (11, 9))
    )
    scan = read_scans(drive(tmp_path, np.array([0.5, 2.5, 6.0, 10.5, 12.5]), track))[0]
    np.testing.assert_array_equal(scan.origin_index >= 0, [True, True, False, True, False])
    np.testing.assert_allclose(scan.sensor_of(np.array([0, 1, 3]))[:, 0], [0.5, 1.0, 8.5])
    assert any("origin is unknown" in n for n in scan.notes)
    week = 2200 * 604_800.0
    adjusted = np.array([0.5, 10.5]) + week - 1e9
    scan = read_scans(drive(tmp_path, adjusted, track))[0]
    np.testing.assert_allclose(scan.sensor_of(np.arange(2))[:, 0], [0.5, 8.5], atol=1e-3)


def test_sbet(tmp_path: Path) -> None:
    from pyproj import Transformer

    to_degrees = Transformer.from_crs("EPSG:25832", "EPSG:4258", always_xy=True)
    east = np.linspace(678_000, 678_050, 11)
    lon, lat = to_degrees.transform(east, np.full(11, 5_403_000.0))
    records = np.zeros((11, 17))
    records[:, 0], records[:, 1], records[:, 2], records[:, 3] = (
        np.arange(11),
        np.radians(lat),
        np.radians(lon),
        450.0,
    )
    records.astype("<f8").tofile(tmp_path / "t.sbet")
    xyz = np.random.default_rng(0).uniform(0, 9, (50, 3)) + UTM.origin
    path = write_laspy(tmp_path / "m.las", xyz, 6, crs="EPSG:25832", gps_time=np.linspace(0, 10, 50))
    scan = read_scans(ScanSource(path=str(path), trajectory=str(tmp_path / "t.sbet")))[0]
    world = scan.world.to_world(scan.sensor_of(np.arange(50)))
    assert np.abs(world[:, 0] - np.linspace(678_000, 678_050, 50)).max() < TRACK_STEP_M
    assert np.abs(world[:, 2] - 450).max() < 1e-6


def test_colmap_text_and_binary_models_agree(tmp_path: Path) -> None:
    text = read_colmap(write_colmap_text(tmp_path / "t"))
    binary = read_colmap(write_colmap_binary(tmp_path / "b" / "sparse" / "0").parents[1])
    assert [i.name for i in text.images] == [i.name for i in binary.images] == ["a.jpg", "sub/b.jpg"]
    for a, b in zip(text.images, binary.images, strict=True):
        np.testing.assert_array_equal(a.camera_from_world.matrix, b.camera_from_world.matrix)
    np.testing.assert_array_equal(text.cameras[7].params, binary.cameras[7].params)
    offset = (678_000.0, 5_403_000.0, 400.0)
    clouds = [read_scans(ScanSource(path=str(p), offset=offset))[0] for p in (tmp_path / "t", tmp_path / "b")]
    for scan in clouds:
        np.testing.assert_allclose(scan.world.to_world(scan.xyz) - offset, [[1, 2, 3], [4, 5, 6]], atol=1e-6)
        np.testing.assert_array_equal(scan.rgb, [[9, 8, 7], [1, 2, 3]])
        np.testing.assert_allclose(
            scan.world.to_world(scan.sensor_of([0, 1])) - offset, [[2, 0, 0], [1, 0, 0]]
        )


def test_photos_with_offset_orientation_and_pickle(tmp_path: Path) -> None:
    model, folder = write_colmap_text(tmp_path / "m"), write_photos(tmp_path / "p")
    (folder / "a.jpg").write_bytes(picture(40, 60, orientation=6))  # stored on its side
    (folder / "spare.jpg").write_bytes(picture())
    source = PhotoSource(path=str(folder), cameras=str(model), offset=(678_000.0, 5_403_000.0, 400.0))
    photos = pickle.loads(pickle.dumps(read_photos(source, UTM)))
    np.testing.assert_allclose([p.pose.t for p in photos.photos], [[1, 0, 0], [2, 0, 0]])
    a, b = photos.image("a.jpg"), photos.image("sub/b.jpg")
    assert a.shape == b.shape == (40, 60, 3)
    assert a[5, 50, 0] > 200 and a[5, 5, 0] < 128  # the red corner turned clockwise
    assert b[5, 5, 0] > 200
    assert len(photos.notes) == 1 and "1 pictures have no pose" in photos.notes[0]


def test_orientation_tag_on_a_picture_of_the_right_size_is_left_alone(tmp_path: Path) -> None:
    model, folder = write_colmap_text(tmp_path / "m"), write_photos(tmp_path / "p")
    (folder / "a.jpg").write_bytes(picture(60, 40, orientation=3))
    assert read_photos(PhotoSource(path=str(folder), cameras=str(model)), LOCAL).image("a.jpg")[5, 5, 0] > 200


def test_footprints_of_geojson_and_cityjson(tmp_path: Path) -> None:
    square = [[0, 0], [10, 0], [10, 8], [0, 8], [0, 0]]
    feature = {"type": "Feature", "properties": {"addr:street": "rue Soufflot", "addr:housenumber": "13", "id": "B"},  # noqa: E501
               "geometry": {"type": "Polygon", "coordinates": [[[x + 500_000, y + 5_400_000] for x, y in square]]}}  # fmt: skip  # noqa: E501
    crs = {"type": "name", "properties": {"name": "urn:ogc:def:crs:EPSG::25832"}}
    path = write_json(
        tmp_path / "a.geojson", {"type": "FeatureCollection", "crs": crs, "features": [feature]}
    )
    (f,) = read_footprints(path, WorldRef(np.array([500_000, 5_400_000, 0]), "EPSG:25832"))
    assert (f.id, f.address) == ("B", "13 rue Soufflot")
    np.testing.assert_allclose(sorted(map(tuple, f.ring)), [(0, 0), (0, 8), (10, 0), (10, 8)], atol=1e-6)
    x, y = f.ring.T
    assert 0.5 * np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y) == pytest.approx(80)  # counter-clockwise

    part = {"type": "BuildingPart", "parents": ["H"], "geometry": [
        {"type": "Solid", "lod": "2.2", "boundaries": [[[[0, 1, 2, 3]], [[4, 5, 6, 7]]]],
         "semantics": {"surfaces": [{"type": "GroundSurface"}, {"type": "RoofSurface"}], "values": [[0, 1]]}}]}  # fmt: skip  # noqa: E501
    vertices = [
        [0, 0, 0],
        [100, 0, 0],
        [100, 50, 0],
        [0, 50, 0],
        [-9, -9, 9],
        [999, -9, 9],
        [999, 999, 9],
        [-9, 999, 9],
    ]
    city = {"type": "CityJSON", "version": "2.0", "transform": {"scale": [0.1] * 3, "translate": [5, 5, 0]},
            "metadata": {}, "vertices": vertices,
            "CityObjects": {"H": {"type": "Building", "children": ["P"]}, "P": part}}  # fmt: skip
    (f,) = read_footprints(write_json(tmp_path / "h.city.json", city), LOCAL)
    assert f.id == "H"
    np.testing.assert_allclose(sorted(map(tuple, f.ring)), [(5, 5), (5, 10), (15, 5), (15, 10)])
