"""Stated positions of the sensor: merged clouds have none, and a position must see what it measured."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from frontage.geometry.arrays import Float
from frontage.io.scans.origins import with_possible_origins
from frontage.io.scans.read import ScanSource, read_scans
from frontage.model import Scan, WorldRef
from io_files import e57_columns, ptx_text, write_json, write_laspy

LOCAL = WorldRef(np.zeros(3), None)


def street(sensor: Float, beams: int = 60_000, seed: int = 0) -> Float:
    """What a scanner at `sensor` sees of a street: the ground, two rows of houses, cars in front of them."""
    r = np.random.default_rng(seed)
    ray = r.normal(size=(beams, 3))
    ray /= np.linalg.norm(ray, axis=1)[:, None]
    planes = [(2, 0.0, None), (1, 8.0, (0.0, 12.0)), (1, -8.0, (0.0, 12.0)), (1, 5.0, (0.0, 1.5)), (1, -5.0, (0.0, 1.5))]  # fmt: skip  # noqa: E501
    best = np.full(beams, np.inf)
    for axis, at, height in planes:
        with np.errstate(divide="ignore", invalid="ignore"):
            t = (at - sensor[axis]) / ray[:, axis]
        hit = sensor + ray * np.where(np.isfinite(t), t, 1e9)[:, None]
        ok = (t > 0.5) & (t < 60)
        if height is not None:
            ok &= (hit[:, 2] >= height[0]) & (hit[:, 2] <= height[1])
            if height[1] < 2:
                ok &= np.floor(hit[:, 0] / 4) % 2 == 0  # parked cars with gaps
        best = np.where(ok & (t < best), t, best)
    seen = np.isfinite(best)
    return sensor + ray[seen] * best[seen, None]


SENSORS = np.array([[0.0, 0, 1.7], [15, 2, 1.7], [-12, -2, 1.8]])


def scan(origins: Float = SENSORS, stated: Float | None = None) -> Scan:
    clouds = [street(o, seed=k) for k, o in enumerate(origins)]
    index = np.repeat(np.arange(len(origins)), [len(c) for c in clouds])
    return Scan("street", np.vstack(clouds), LOCAL, origins if stated is None else stated, index)


def test_true_positions_stay() -> None:
    true = scan()
    assert with_possible_origins(true) is true
    alone = Scan("a", true.xyz, LOCAL)
    assert with_possible_origins(alone) is alone


@pytest.mark.parametrize(
    ("shift", "why"),
    [((0, 0, -6), "two surfaces"), ((0, 0, -9), "two surfaces"), ((9000, 0, 0), "9 km"), ((691_000, 0, 0), "691 km")],  # noqa: E501
)  # fmt: skip
def test_wrong_positions_are_told_and_not_used(shift: tuple[float, float, float], why: str) -> None:
    tested = with_possible_origins(scan(stated=SENSORS + np.array(shift, float)))
    assert not tested.has_origins and not len(tested.origins)
    (note,) = tested.notes
    assert why in note and "3 of the 3 stated positions" in note and "unknown" in note


def test_only_the_wrong_position_is_dropped() -> None:
    stated = SENSORS.copy()
    stated[1, 2] -= 6
    tested = with_possible_origins(scan(stated=stated))
    assert set(tested.origin_index) == {-1, 0, 2} and len(tested.origins) == 3
    assert "1 of the 3 stated positions" in tested.notes[0]


def test_merged_stations_do_not_belong_to_one_position() -> None:
    true = scan(SENSORS[:1])
    streets = np.vstack([true.xyz + np.array([0.0, y, 0]) for y in (0, 25, 50, 75)])
    merged = Scan("m", streets, LOCAL, np.array([[10.0, 30, 1.7]]), np.zeros(len(streets), int))
    assert not with_possible_origins(merged).has_origins
    wall = np.random.default_rng(0).uniform(0, 20, (40_000, 3)) * [1, 0, 1]
    amid = replace(merged, xyz=np.vstack([wall[:, :3] * 0.005, wall]), origin_index=np.zeros(80_000, int), origins=np.zeros((1, 3)))  # fmt: skip  # noqa: E501
    assert "within 0.2 m" in with_possible_origins(amid).notes[0]


def test_second_returns_lie_behind_the_first() -> None:
    true = scan(SENSORS[:1])
    behind = SENSORS[0] + 1.5 * (true.xyz - SENSORS[0])
    both = Scan(
        "r", np.vstack([true.xyz, behind]), LOCAL, SENSORS[:1], np.zeros(2 * len(true), int),
        return_number=np.repeat([1, 2], len(true)), return_count=np.full(2 * len(true), 2),
    )  # fmt: skip
    assert with_possible_origins(both) is both
    assert not with_possible_origins(replace(both, return_number=None, return_count=None)).has_origins


def e57(path: Path, translation: Float, turned: bool = False, **columns: Float) -> Path:
    import pye57

    rotation = np.array([np.cos(0.2), 0, 0, np.sin(0.2)]) if turned else np.array([1.0, 0, 0, 0])
    with pye57.E57(str(path), mode="w") as file:
        file.write_scan_raw(columns, rotation=rotation, translation=translation)
    return path


def bare() -> dict[str, Float]:
    return {k: v for k, v in e57_columns().items() if k not in ("rowIndex", "columnIndex")}


@pytest.mark.parametrize("translation", [np.zeros(3), np.array([678_000.0, 5_403_000, 0])])
def test_a_merged_e57_has_no_origin(tmp_path: Path, translation: Float) -> None:
    path = e57(tmp_path / "m.e57", translation, **bare())
    (merged,) = read_scans(path)
    assert not merged.has_origins and not len(merged.origins) and merged.local_from_scanner is None
    assert any("placeholder" in n and "m.e57" in n for n in merged.notes)
    (approximate,) = read_scans(ScanSource(path=str(path), pose="approximate"))
    assert not approximate.has_origins and approximate.local_from_scanner is not None


def test_an_e57_with_a_raster_or_a_true_pose_keeps_its_origin(tmp_path: Path) -> None:
    for name, translation, turned, columns in (
        ("raster", np.zeros(3), False, e57_columns()),
        ("place", np.array([3.25, 4.5, 1.7]), False, bare()),
        ("turned", np.zeros(3), True, bare()),
    ):
        (one,) = read_scans(e57(tmp_path / f"{name}.e57", translation, turned, **columns))
        assert one.has_origins and one.local_from_scanner is not None, name


def test_a_ptx_without_raster_and_position_has_no_origin(tmp_path: Path) -> None:
    head = "1\n{}\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n"
    rows = "".join(f"{k % 7 + 1} {k % 5} {k % 3} 0.5\n" for k in range(50))
    (tmp_path / "m.ptx").write_text(head.format(50) + rows)
    assert not read_scans(tmp_path / "m.ptx")[0].has_origins
    (tmp_path / "a.ptx").write_text(ptx_text(20, 20))
    assert read_scans(tmp_path / "a.ptx")[0].has_origins


def test_positions_in_files_are_tested(tmp_path: Path) -> None:
    true = scan(SENSORS[:1])
    ids = np.ones(len(true), np.uint16)
    path = write_laspy(tmp_path / "s.las", true.xyz, 6, point_source_id=ids, gps_time=np.linspace(0, 9, len(ids)))  # fmt: skip  # noqa: E501
    for position, good in ((SENSORS[0], True), (SENSORS[0] - [0, 0, 6], False), (SENSORS[0] + 1e5, False)):
        write_json(tmp_path / "s.las.stations.json", [{"station": 1, "position": position.tolist()}])
        (found,) = read_scans(path)
        assert found.has_origins == good and good != any("cannot be right" in n for n in found.notes)
    track = tmp_path / "t.csv"
    track.write_text("gps_time,x,y,z\n0,691000,0,2\n9,691009,0,2\n")
    (found,) = read_scans(ScanSource(path=str(path), trajectory=str(track)))
    assert not found.has_origins and any("positions" in n and "691 km" in n for n in found.notes)


def test_a_file_that_is_stated_but_not_used_is_told(tmp_path: Path) -> None:
    (tmp_path / "a.ptx").write_text(ptx_text())
    (scan,) = read_scans(ScanSource(path=str(tmp_path / "a.ptx"), trajectory="t.csv"))
    assert any("trajectory, t.csv, is not used" in n for n in scan.notes)
