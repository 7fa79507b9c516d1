"""Coordinates of every kind become local metres of one projected world; assumptions become notes."""

from pathlib import Path

import numpy as np
import pytest
from pyproj import CRS, Transformer

from frontage.errors import CrsError
from frontage.geometry.rigid import Rigid3
from frontage.io.crs import crs_text, looks_geocentric, metric_twin, parse_crs
from frontage.io.placement import PlacementRequest
from frontage.io.scans.read import ScanSource, read_scans
from frontage.model import WorldRef
from io_files import write_laspy

PLAN = np.random.default_rng(0).uniform(0, 40, (50, 3)) + np.array([678_000, 5_403_000, 415])


@pytest.mark.parametrize(
    ("name", "code"),
    [
        ("EPSG:25832", "EPSG:25832"),
        ("EPSG:25832+7837", "EPSG:25832+7837"),
        ("urn:ogc:def:crs,crs:EPSG::25832,crs:EPSG::5783", "EPSG:25832+5783"),
        ("https://www.opengis.net/def/crs/EPSG/0/25832", "EPSG:25832"),
        ("urn:adv:crs:ETRS89_UTM32*DE_DHHN2016_NH", "EPSG:25832+7837"),
        (CRS.from_epsg(25832).to_wkt(), "EPSG:25832"),
    ],
)
def test_names_of_systems(name: str, code: str) -> None:
    assert crs_text(parse_crs(name)) == code


def test_the_file_s_own_metric_system_changes_nothing_but_the_origin(tmp_path: Path) -> None:
    scan = read_scans(write_laspy(tmp_path / "a.las", PLAN, 6, "EPSG:25832"))[0]
    assert scan.world.crs == "EPSG:25832" and scan.notes == ()
    assert np.abs(scan.xyz).max() < 50 and scan.world.origin.dtype == np.int64
    assert np.abs(scan.world.to_world(scan.xyz) - np.round(PLAN, 3)).max() < 1e-6


def test_geocentric_coordinates_without_a_crs_are_recognised_with_a_note(tmp_path: Path) -> None:
    to_ecef = Transformer.from_crs(CRS("EPSG:32632").to_3d(), "EPSG:4978", always_xy=True)
    ecef = np.column_stack(to_ecef.transform(*PLAN.T))
    scan = read_scans(write_laspy(tmp_path / "e.las", ecef))[0]
    assert scan.world.crs == "EPSG:32632"
    assert np.abs(scan.world.to_world(scan.xyz) - PLAN).max() < 2e-3  # the file's steps are 1 mm
    assert any("geocentric" in n for n in scan.notes) and any("ellipsoid" in n for n in scan.notes)


def test_projected_coordinates_with_the_earth_s_radius_are_not_geocentric() -> None:
    north = np.array([[500_000.0, 6_357_000.0, 20.0], [499_000.0, 6_358_000.0, 60.0]])
    assert 6.35e6 < np.linalg.norm(north[0]) < 6.4e6
    assert not looks_geocentric(north)
    assert not looks_geocentric(PLAN) and not looks_geocentric(np.zeros((3, 3)))


def test_a_scanner_pose_is_turned_with_its_points() -> None:
    to_ecef = Transformer.from_crs(CRS("EPSG:32632").to_3d(), "EPSG:4978", always_xy=True)
    at = np.array([678_020.0, 5_403_020.0, 415.0])
    ecef = np.column_stack(to_ecef.transform(*np.vstack([at, at + 30 * np.eye(3)]).T))
    U, _, Vt = np.linalg.svd((ecef[1:] - ecef[0]).T)
    pose = Rigid3("file", "scanner", U @ Vt, ecef[0])
    place = PlacementRequest("s").place(CRS.from_epsg(4978), ecef)
    xyz = np.random.default_rng(1).uniform(-30, 30, (20, 3))
    turned = place.pose_of(pose)
    assert np.abs(turned.apply(xyz) - place.points_of(pose, xyz)).max() < 0.03  # UTM's scale here is 0.9996
    assert np.abs(turned.R - np.eye(3)).max() < 1e-3


def test_longitude_and_latitude_go_to_utm(tmp_path: Path) -> None:
    degrees = Transformer.from_crs("EPSG:25832", "EPSG:4258", always_xy=True)
    lon, lat = degrees.transform(PLAN[:, 0], PLAN[:, 1])
    text = "".join(f"{a:.10f} {b:.10f} {c:.4f}\n" for a, b, c in zip(lon, lat, PLAN[:, 2], strict=True))
    (tmp_path / "g.xyz").write_text(text)
    scan = read_scans(ScanSource(path=str(tmp_path / "g.xyz"), crs="EPSG:4258"))[0]
    assert scan.world.crs == "EPSG:25832" and any("transformed to" in n for n in scan.notes)
    assert np.abs(scan.world.to_world(scan.xyz) - PLAN).max() < 2e-4


@pytest.mark.parametrize(("crs", "z_foot"), [("EPSG:2263", 1200 / 3937), ("EPSG:2263+6360", 1200 / 3937),
                                             ("EPSG:2263+5703", 1.0)])  # fmt: skip
def test_feet_become_metres_plan_and_height_each_by_its_own_unit(
    tmp_path: Path, crs: str, z_foot: float
) -> None:
    feet = np.random.default_rng(0).uniform(0, 300, (40, 3)) + np.array([985_000, 200_000, 0])
    np.savetxt(tmp_path / "f.xyz", feet, fmt="%.5f")
    scan = read_scans(ScanSource(path=str(tmp_path / "f.xyz"), crs=crs))[0]
    assert np.abs(scan.world.to_world(scan.xyz) - feet * [1200 / 3937, 1200 / 3937, z_foot]).max() < 1e-5
    twin = parse_crs(scan.world.crs or "")
    assert {a.unit_name for a in twin.axis_info} == {"metre"} and any(
        "not in metres" in n for n in scan.notes
    )
    again = read_scans(ScanSource(path=str(tmp_path / "f.xyz"), crs=crs), scan.world)[0]
    np.testing.assert_allclose(again.xyz, scan.xyz, atol=1e-9)


def test_the_metric_twin_is_the_same_place() -> None:
    twin = metric_twin(parse_crs("EPSG:2263"))
    assert twin is not None
    a = Transformer.from_crs("EPSG:2263", "EPSG:4269", always_xy=True).transform(985_000.0, 200_000.0)
    b = Transformer.from_crs(twin, "EPSG:4269", always_xy=True).transform(
        *np.array([985_000, 200_000]) * 1200 / 3937
    )
    np.testing.assert_allclose(a, b, atol=1e-10)


@pytest.mark.parametrize(("units", "factor"), [("ft", 0.3048), ("us-ft", 1200 / 3937), ("m", 1.0)])
def test_units_without_a_system(tmp_path: Path, units: str, factor: float) -> None:
    (tmp_path / "u.xyz").write_text("0 0 0\n10 20 30\n")
    scan = read_scans(ScanSource(path=str(tmp_path / "u.xyz"), units=units))[0]
    np.testing.assert_allclose(scan.xyz[1], np.array([10, 20, 30]) * factor)
    assert scan.world.crs is None and any("local engineering" in n for n in scan.notes)


def test_small_local_coordinates_keep_their_origin_and_large_ones_do_not(tmp_path: Path) -> None:
    np.savetxt(tmp_path / "l.xyz", PLAN - [678_000, 5_403_000, 0], fmt="%.4f")
    np.savetxt(tmp_path / "w.xyz", PLAN, fmt="%.4f")
    assert not read_scans(tmp_path / "l.xyz")[0].world.origin.any()
    assert np.abs(read_scans(tmp_path / "w.xyz")[0].xyz).max() < 50


def test_all_scans_share_the_world_of_the_first(tmp_path: Path) -> None:
    first = read_scans(write_laspy(tmp_path / "a.las", PLAN, 6, "EPSG:25832"))[0]
    to_33 = Transformer.from_crs("EPSG:25832", "EPSG:25833", always_xy=True)
    moved = np.column_stack([*to_33.transform(PLAN[:, 0], PLAN[:, 1]), PLAN[:, 2]])
    second = read_scans(write_laspy(tmp_path / "b.las", moved, 6, "EPSG:25833"), first.world)[0]
    assert second.world is first.world and np.abs(second.xyz - first.xyz).max() < 2e-3


def test_a_file_without_a_crs_is_taken_in_the_requested_one_only_where_it_fits(tmp_path: Path) -> None:
    np.savetxt(tmp_path / "w.xyz", PLAN, fmt="%.4f")
    np.savetxt(tmp_path / "l.xyz", PLAN - PLAN[0], fmt="%.4f")
    scan = read_scans(tmp_path / "w.xyz", target_crs="EPSG:25832")[0]
    assert scan.world.crs == "EPSG:25832" and any("taken to be in" in n for n in scan.notes)
    with pytest.raises(CrsError, match="has no CRS, but"):
        read_scans(tmp_path / "l.xyz", target_crs="EPSG:25832")


def test_missing_grids_are_reported_with_their_accuracy() -> None:
    gk = np.array([[4_468_000.0, 5_333_000.0, 515.0]])
    place = PlacementRequest("old.las", WorldRef(np.zeros(3, int), "EPSG:25832")).place(
        CRS.from_epsg(31468), gk
    )
    said = [n for n in place.notes if "good to" in n]
    assert said and "BETA2007" in said[0] and " m" in said[0]


def test_heights_without_a_known_transformation_are_refused() -> None:
    with pytest.raises(CrsError, match="install the grids"):
        PlacementRequest("e.las", WorldRef(np.zeros(3, int), "EPSG:25832+7837")).place(
            CRS.from_epsg(4978), np.array([[4_176_000.0, 856_000.0, 4_728_000.0]])
        )
