"""Real and simulated recordings beside the checkout: poses compared with truth, sensors, extents."""

import json
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import shapely
from scipy.spatial import cKDTree

from frontage.io.citymodels.footprints import read_footprints
from frontage.io.photos.read import PhotoSource, read_photos
from frontage.io.scans.info import scan_info
from frontage.io.scans.origins import with_possible_origins
from frontage.io.scans.read import ScanSource, read_scans
from frontage.model import Scan, WorldRef
from realdata import data_path

SCENE = "ingolstadt_scene/"
UTM = WorldRef(np.array([678_057, 5_403_871, 415]), "EPSG:25832")


def truth(kind: str) -> list[dict[str, Any]]:
    found: list[dict[str, Any]] = json.loads(data_path(SCENE + "truth/truth.json").read_text())[kind]
    return found


def scans(relative: str, **more: Any) -> list[Scan]:
    return read_scans(ScanSource(path=str(data_path(SCENE + "input/" + relative)), **more), UTM)


@pytest.mark.parametrize("name", ["registered/scan_2cm.e57", "coarse/scan_4cm.ptx"])
def test_stations_have_their_poses_rasters_and_points(name: str) -> None:
    found = scans(name, crs="EPSG:25832")
    stations = [s for s in truth("stations") if s["file"] == name]
    assert len(found) == len(stations) == 3
    for scan, station in zip(found, stations, strict=True):
        pose = scan.local_from_scanner.value
        assert np.abs(UTM.to_world(pose.t) - station["given_position"]).max() < 1e-4
        assert np.abs(pose.R - station["given_R"]).max() < 1e-8
        assert len(scan) == station["points"]
        columns, rows = station["raster"]
        assert scan.grid is not None and scan.grid.index.shape == (rows, columns)
        assert (scan.grid.index >= 0).sum() == len(scan)


@pytest.mark.parametrize(
    "name", ["registered/scan_2cm.e57", "coarse/scan_4cm.ptx", "registered/scan_4cm.laz", "mobile/mobile.laz"]
)
def test_true_origins_pass_and_others_do_not(name: str) -> None:
    track = {"trajectory": str(data_path(SCENE + "input/mobile/trajectory.csv"))} if "mobile" in name else {}
    for scan in scans(name, crs="EPSG:25832", **track):
        assert scan.has_origins and not any("cannot be right" in n or "steps" in n for n in scan.notes)
        far = with_possible_origins(replace(scan, origins=scan.origins + np.array([691_000.0, 0, 0])))
        assert not far.has_origins and "691 km" in far.notes[-1]


def test_a_station_below_the_ground_is_told() -> None:
    (scan,) = scans("registered/scan_4cm.laz")
    below = with_possible_origins(replace(scan, origins=scan.origins - np.array([0.0, 0, 5])))
    assert not below.has_origins and "two surfaces" in below.notes[-1]


def test_rasters_follow_the_beams() -> None:
    """Azimuth steps evenly along columns, elevation along rows, in the scanner's frame."""
    scan = scans("coarse/scan_4cm.ptx", crs="EPSG:25832")[0]
    row, column = np.nonzero(scan.grid.index >= 0)
    xyz = scan.local_from_scanner.value.inverse.apply(scan.xyz[scan.grid.index[row, column]])
    azimuth = np.unwrap(np.arctan2(xyz[:, 1], xyz[:, 0]))
    elevation = np.arctan2(xyz[:, 2], np.hypot(xyz[:, 0], xyz[:, 1]))
    assert abs(np.corrcoef(azimuth, column)[0, 1]) > 0.999
    assert np.corrcoef(elevation, row)[0, 1] > 0.999


def test_e57_and_laz_are_the_same_walls() -> None:
    e57 = np.vstack([s.xyz for s in scans("registered/scan_2cm.e57", crs="EPSG:25832")])
    laz = scans("registered/scan_4cm.laz")[0]
    distance, _ = cKDTree(laz.xyz, balanced_tree=False).query(e57[::200])
    assert np.median(distance) < 0.03  # LAZ points lie 4 cm apart
    positions = {s["station"]: s["position"] for s in truth("stations") if "scan_4cm.laz" in s["file"]}
    given = [positions[k] for k in sorted(positions)]
    assert np.abs(UTM.to_world(laz.origins) - given).max() < 0.02
    assert (laz.origin_index >= 0).all()


def test_mobile_points_have_the_vehicle_s_position() -> None:
    track = str(data_path(SCENE + "input/mobile/trajectory.csv"))
    scan = scans("mobile/mobile.laz", trajectory=track)[0]
    assert (scan.origin_index >= 0).all()
    table = np.loadtxt(track, delimiter=",", skiprows=1)
    some = np.arange(0, len(scan), 997)
    expected = np.column_stack([np.interp(scan.time[some], table[:, 0], table[:, k]) for k in (1, 2, 3)])
    assert np.abs(UTM.to_world(scan.sensor_of(some)) - expected).max() < 0.03
    reach = np.linalg.norm(scan.xyz[some] - scan.sensor_of(some), axis=1)
    assert 2 < np.median(reach) < 30


def test_photo_poses_equal_the_truth() -> None:
    folder = data_path(SCENE + "input")
    source = PhotoSource(path=str(folder / "photos" / "*.jpg"), cameras=str(folder / "registered" / "colmap"),
                         offset=tuple(UTM.origin.tolist()))  # fmt: skip
    photos = read_photos(source, UTM)
    assert len(photos.photos) == 6
    for photo, true in zip(photos.photos, truth("photos"), strict=True):
        assert photo.id == true["name"]
        assert np.abs(UTM.to_world(photo.pose.t) - true["C"]).max() < 1e-4
        assert np.abs(photo.pose.R.T - true["R"]).max() < 1e-8
    assert photos.image("IMG_0006.jpg").shape == (4032, 3024, 3)


def test_castle_points_fall_on_their_photos() -> None:
    castle = data_path("castle_photos")
    cloud = read_scans(castle / "colmap")[0]
    photos = read_photos(
        PhotoSource(path=str(castle / "images"), cameras=str(castle / "colmap")), cloud.world
    )
    assert len(cloud) == 13_572 and len(photos.photos) == 19 and (cloud.origin_index >= 0).all()
    lines = (castle / "colmap" / "images.txt").read_text().splitlines()
    at = next(k for k, line in enumerate(lines) if line.endswith(" 0018.jpg"))
    seen = np.array(lines[at + 1].split(), float).reshape(-1, 3)
    seen = seen[seen[:, 2] >= 0]
    ids = [int(line.split(maxsplit=1)[0]) for line in
           (castle / "colmap" / "points3D.txt").read_text().splitlines() if line[0] != "#"]  # fmt: skip
    row = {number: k for k, number in enumerate(ids)}
    xyz = cloud.xyz[[row[int(k)] for k in seen[:, 2]]]
    photo = next(p for p in photos.photos if p.id == "0018.jpg")
    error = np.linalg.norm(photo.project(xyz) - seen[:, :2], axis=1)
    assert np.median(error) < 1.0  # px: axes, rotation and pixel centres are right


def test_the_clock_tower_is_recognised_as_geocentric() -> None:
    (scan,) = read_scans(data_path("clocktower/clocktower_ecef.laz"))
    assert scan.world.crs == "EPSG:32644" and len(scan) == 3_230_067 and scan.rgb is None
    assert any("geocentric" in n for n in scan.notes) and any("no colour" in n for n in scan.notes)
    size = np.ptp(scan.xyz, axis=0)
    assert size[2] > 25 and (size[:2] < 9).all()  # upright: a tower


@pytest.mark.parametrize(
    ("name", "points", "fields"),
    [
        ("brooklyn_row/street_front.laz", 1_279_233, ["rgb"]),
        ("lille_mobile/Lille_street_small.ply", 170_610, []),
    ],
)
def test_info_of_real_scans(name: str, points: int, fields: list[str]) -> None:
    info = scan_info(data_path(name))
    assert info["points"] == points and info["crs"] is None and info["scans"][0]["fields"] == fields
    assert 0.001 < info["scans"][0]["spacing"] < 0.1


@pytest.mark.parametrize("name", ["lod2.city.json", "lod2.gml"])
def test_footprints_of_the_city_model(name: str) -> None:
    found = read_footprints(data_path(SCENE + "input/lod2/" + name), UTM)
    assert [f.id for f in found][2] == "DEBY_LOD2_4018150a" and len(found) == 6
    assert shapely.Polygon(found[2].ring).area == pytest.approx(188.15, abs=0.1)


@pytest.mark.parametrize("path", ["munich_lod2/DEBY_LOD2_4959322.gml", "lod_examples/CityGMLv3/Building_LOD0-EPSG25832.gml",  # noqa: E501
                                  "lod_examples/CityGMLv2/Building_LOD1-EPSG25832.gml",
                                  "ingolstadt_lod3/4018115.xml"])  # fmt: skip
def test_footprints_of_every_citygml(path: str) -> None:
    (found,) = read_footprints(data_path("citymodels/" + path), UTM)
    assert shapely.Polygon(found.ring).area > 45
