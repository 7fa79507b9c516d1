"""LAS, PLY and run-folder scans round-trip: every LAS point format, and fields of other programs."""

import filecmp
from dataclasses import replace
from datetime import date, datetime
from pathlib import Path

import laspy
import numpy as np
import pytest

from frontage.geometry.rigid import Rigid3
from frontage.io.placement import PlacementRequest
from frontage.io.poses import given_pose
from frontage.io.scans.info import scan_info
from frontage.io.scans.las import read_las
from frontage.io.scans.laswrite import BUILDING_CLASS, write_las
from frontage.io.scans.npz import load_scan, save_scan
from frontage.io.scans.ply import read_ply, write_ply
from frontage.io.scans.read import ScanSource, read_scans
from frontage.io.scans.request import ScanRequest
from frontage.model import Grid, Scan
from io_files import UTM, cloud, write_json, write_laspy


@pytest.mark.parametrize("suffix", [".las", ".laz"])
def test_las_keeps_points_attributes_and_rays(tmp_path: Path, suffix: str) -> None:
    scan = cloud(5000)
    back = read_las(write_las(tmp_path / f"a{suffix}", scan), ScanRequest(PlacementRequest("a")))[0]
    assert np.abs(back.world.to_world(back.xyz) - scan.world.to_world(scan.xyz)).max() < 0.51e-4
    assert back.world.crs == "EPSG:25832"
    np.testing.assert_array_equal(back.rgb, scan.rgb)
    np.testing.assert_allclose(back.time, scan.time)
    np.testing.assert_allclose(back.intensity, scan.intensity, atol=1e-5)
    np.testing.assert_array_equal(back.return_number, scan.return_number)
    known = scan.origin_index >= 0
    np.testing.assert_array_equal(back.origin_index >= 0, known)
    rays = back.world.to_world(back.sensor_of(known)) - scan.world.to_world(scan.sensor_of(known))
    assert np.abs(rays).max() < 1e-5


@pytest.mark.parametrize("suffix", [".las", ".laz"])
def test_las_tells_the_class_and_the_day_of_its_points(tmp_path: Path, suffix: str) -> None:
    scan, day = cloud(500), date(2026, 3, 14)
    since_epoch = (datetime(2026, 3, 14, 12) - datetime(1980, 1, 6)).total_seconds()
    for times, told in ((since_epoch - 1e9, day), (400_000.0, None), (None, None)):
        values = None if times is None else np.linspace(times - 60, times, 500)
        path = write_las(tmp_path / f"b{suffix}", replace(scan, time=values), BUILDING_CLASS)
        with laspy.open(path) as file:
            assert file.header.creation_date == told
            assert file.header.global_encoding.gps_time_type == int(told is not None)
            points = file.read()
        assert (np.asarray(points.classification) == BUILDING_CLASS).all() and len(points) == 500
        back = read_las(path, ScanRequest(PlacementRequest("b", UTM)))[0]
        assert values is None or np.array_equal(back.time, values)


def test_las_with_more_origins_than_source_ids(tmp_path: Path) -> None:
    base = cloud(70_000)
    r = np.random.default_rng(1)
    scan = Scan("m", base.xyz, UTM, r.uniform(-30, 30, (70_000, 3)), np.arange(70_000))
    back = read_las(write_las(tmp_path / "m.laz", scan), ScanRequest(PlacementRequest("m", UTM)))[0]
    assert np.abs(back.sensor_of(np.arange(70_000)) - scan.origins).max() < 1e-5


def test_the_same_scan_gives_the_same_bytes(tmp_path: Path) -> None:
    for write, name in ((write_las, "laz"), (write_ply, "ply"), (save_scan, "npz")):
        write(tmp_path / f"1.{name}", cloud())
        write(tmp_path / f"2.{name}", cloud())
        assert filecmp.cmp(tmp_path / f"1.{name}", tmp_path / f"2.{name}", shallow=False), name


def test_writing_again_without_rays_removes_the_old_stations(tmp_path: Path) -> None:
    scan = cloud()
    write_las(tmp_path / "a.laz", scan)
    write_las(tmp_path / "a.laz", Scan("b", scan.xyz, scan.world))
    assert not read_las(tmp_path / "a.laz", ScanRequest(PlacementRequest("a")))[0].has_origins


@pytest.mark.parametrize("point_format", range(11))
def test_every_las_point_format(tmp_path: Path, point_format: int) -> None:
    r = np.random.default_rng(point_format)
    xyz = np.round(r.uniform(0, 50, (300, 3)) + np.array([500_000, 5_400_000, 100]), 3)
    extra = r.uniform(0, 1, 300).astype(np.float32)
    path = write_laspy(tmp_path / "f.las", xyz, point_format, intensity=np.arange(300), my_extra=extra)
    back = read_las(path, ScanRequest(PlacementRequest("f")))[0]
    assert np.abs(back.world.to_world(back.xyz) - xyz).max() < 1e-6
    assert back.intensity is not None and back.intensity[-1] == 1.0 and back.intensity[0] == 0.0
    with laspy.open(path) as file:
        assert file.header.point_count == 300 and "my_extra" in file.header.point_format.dimension_names


def test_las_read_in_chunks_equals_las_read_at_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = write_las(tmp_path / "c.laz", cloud(3000))
    whole = read_las(path, ScanRequest(PlacementRequest("c", UTM)))[0]
    seen: list[float] = []
    monkeypatch.setattr("frontage.io.scans.las.CHUNK_POINTS", 700)
    parts = read_las(path, ScanRequest(PlacementRequest("c", UTM), progress=seen.append))[0]
    np.testing.assert_array_equal(whole.xyz, parts.xyz)
    np.testing.assert_array_equal(whole.rgb, parts.rgb)
    assert len(seen) == 5 and seen[-1] == 1.0


@pytest.mark.parametrize("factor", [1, 256, 257])
def test_colour_of_8_bits_in_fields_of_16(tmp_path: Path, factor: int) -> None:
    rgb = np.random.default_rng(3).integers(0, 256, (400, 3))
    rgb[0] = 255
    xyz = np.random.default_rng(4).uniform(0, 9, (400, 3))
    fields = {n: (rgb[:, k] * factor).astype(np.uint16) for k, n in enumerate(("red", "green", "blue"))}
    np.testing.assert_array_equal(
        read_las(write_laspy(tmp_path / "c.las", xyz, 2, **fields), ScanRequest(PlacementRequest("c")))[
            0
        ].rgb,
        rgb,
    )


def test_colour_fields_that_hold_no_colour_are_dropped_with_a_note(tmp_path: Path) -> None:
    r = np.random.default_rng(3)
    other = r.integers(0, 65536, 2000)
    path = write_laspy(
        tmp_path / "c.las", r.uniform(0, 9, (2000, 3)), 2, red=np.full(2000, 777), green=other, blue=other
    )
    scan = read_las(path, ScanRequest(PlacementRequest("c")))[0]
    assert scan.rgb is None and any("colour" in n for n in scan.notes)


def test_withheld_points_are_dropped_with_a_note(tmp_path: Path) -> None:
    xyz = np.random.default_rng(5).uniform(0, 9, (100, 3))
    path = write_laspy(tmp_path / "w.las", xyz, 6, withheld=np.arange(100) < 10)
    scan = read_las(path, ScanRequest(PlacementRequest("w")))[0]
    assert len(scan) == 90 and any("withheld" in n for n in scan.notes)


def test_stations_by_option_and_unknown_sources(tmp_path: Path) -> None:
    xyz = np.random.default_rng(5).uniform(0, 9, (100, 3))
    path = write_laspy(tmp_path / "s.las", xyz, 6, point_source_id=np.repeat([4, 9], 50))
    stations = write_json(tmp_path / "my.json", [{"station": 9, "position": [1, 2, 3]}])
    scan = read_scans(ScanSource(path=str(path), stations=str(stations)))[0]
    assert (scan.origin_index[:50] == -1).all() and (scan.origin_index[50:] == 0).all()
    np.testing.assert_allclose(scan.origins, [[1, 2, 3]])
    assert any("without a station" in n for n in scan.notes)


def test_ply_round_trip(tmp_path: Path) -> None:
    scan = cloud()
    back = read_ply(
        write_ply(tmp_path / "a.ply", scan), ScanRequest(PlacementRequest("a", crs="EPSG:25832", world=UTM))
    )[0]
    assert np.abs(back.xyz - scan.xyz).max() < 2e-9
    np.testing.assert_array_equal(back.rgb, scan.rgb)
    np.testing.assert_array_equal(back.intensity, scan.intensity)


def test_scans_of_a_run_folder_round_trip_exactly(tmp_path: Path) -> None:
    scan = cloud(24)
    pose = given_pose(Rigid3("local", "scanner", np.eye(3), np.ones(3)), (1, 1, 1, 0.1, 0.1, 0.1))
    full = Scan(scan.name, scan.xyz, scan.world, scan.origins, scan.origin_index, scan.intensity, scan.rgb, scan.time,  # noqa: E501
                grid=Grid(np.arange(24).reshape(4, 6)), sigma_range=0.002, local_from_scanner=pose,
                notes=("a", "b"))  # fmt: skip
    back = load_scan(save_scan(tmp_path / "s.npz", full))
    for name in ("xyz", "origins", "origin_index", "intensity", "rgb", "time"):
        np.testing.assert_array_equal(getattr(back, name), getattr(full, name))
    np.testing.assert_array_equal(back.grid.index, full.grid.index)
    np.testing.assert_array_equal(back.local_from_scanner.covariance, pose.covariance)
    assert (back.notes, back.sigma_range, back.world.crs, back.name) == (
        full.notes,
        0.002,
        "EPSG:25832",
        "cloud",
    )
    assert back.return_number is None


def test_bounds_and_resolution(tmp_path: Path) -> None:
    path = write_las(tmp_path / "b.laz", cloud(4000))
    scan = read_scans(path, UTM, bounds=(678_000, 5_403_000, 678_010, 5_403_010))[0]
    inside = ((cloud(4000).xyz[:, :2] >= 0) & (cloud(4000).xyz[:, :2] <= 10)).all(1)
    assert len(scan) == inside.sum() > 100
    thin = read_scans(path, UTM, resolution=5.0)[0]
    cells = np.floor((thin.xyz - cloud(4000).xyz.min(0)) / 5.0 + 1e-6)
    assert 200 < len(thin) <= 1000 and len(np.unique(cells, axis=0)) > 0.95 * len(thin)


def test_info_of_a_scan(tmp_path: Path) -> None:
    info = scan_info(write_las(tmp_path / "i.laz", cloud(800)))
    assert info["points"] == 800 and info["crs"] == "EPSG:25832"
    assert info["scans"][0]["fields"] == ["intensity", "rgb", "time", "return_number"]
    assert 0.5 < info["scans"][0]["spacing"] < 4.0  # 800 points in a cube of 40 m
    assert info["minimum"][0] == pytest.approx(677_980, abs=1)


def test_intensity_is_linear_up_to_its_quantile(tmp_path: Path) -> None:
    values = np.r_[np.linspace(0, 1000, 9_999), 65535].astype(np.uint16)
    path = write_laspy(
        tmp_path / "i.las", np.random.default_rng(0).uniform(0, 9, (10_000, 3)), 1, intensity=values
    )
    got = read_las(path, ScanRequest(PlacementRequest("i")))[0].intensity
    assert got is not None and got.max() == 1.0 and got[5000] == pytest.approx(0.5, abs=0.01)


def test_only_laspy_reads_our_extra_dimension_as_a_number(tmp_path: Path) -> None:
    scan = Scan("m", np.zeros((66_000, 3)) + np.arange(66_000)[:, None] * 1e-3, UTM, np.zeros((66_000, 3)),
                np.arange(66_000))  # fmt: skip
    las = laspy.read(write_las(tmp_path / "x.laz", scan))
    np.testing.assert_array_equal(las["origin_index"], np.arange(66_000))
