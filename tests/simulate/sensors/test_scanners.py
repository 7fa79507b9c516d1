"""Stations and the vehicle: geometry, rasters, poses, occlusion, limits, repeatability."""

from dataclasses import fields

import numpy as np
import pytest

from frontage.errors import OptionError
from frontage.simulate.scene import Part, Scene
from frontage.simulate.sensors.instrument import DriveSpec, ScannerSpec, draw_instrument
from frontage.simulate.sensors.mobile import drive
from frontage.simulate.sensors.recording import Echo, Station
from frontage.simulate.sensors.terrestrial import scan_stations
from laser_scenes import PENCIL, QUIET, Sheet, ground, scene_of, wall

COARSE = {"spacing": 0.3, "positions": ((10.0, 0.0),)}


def yard(**more: object) -> Scene:
    """Ground, a wall 8 m away, and a post in front of it."""
    post = Sheet((10.5, 6.0, 0.0), (0.3, 0, 0), (0, 0, 4.0), Part.LAMP)
    return scene_of(ground(), wall(8.0, **more), post)  # type: ignore[arg-type]


def depth(station: Station, surface: int, axis: int) -> np.ndarray:
    return station.scan.xyz[station.surface == surface, axis]


def test_points_without_noise_lie_on_their_surfaces() -> None:
    (s,) = scan_stations(yard(), ScannerSpec(**PENCIL, **COARSE), 1)
    assert np.abs(depth(s, 1, 1) - 8.0).max() < 1e-9 < np.ptp(depth(s, 1, 0))
    assert np.abs(depth(s, 0, 2)).max() < 1e-9
    assert np.abs(depth(s, 2, 1) - 6.0).max() < 1e-9
    ranges = np.linalg.norm(s.scan.xyz - s.true.t, axis=1)
    np.testing.assert_allclose(ranges, s.true_range, atol=1e-9)


def test_footprints_do_not_shift_walls() -> None:
    (s,) = scan_stations(yard(), ScannerSpec(**QUIET, **COARSE, exit_beam=0.005, divergence=0.3), 1)
    d = s.scan.xyz - s.true.t
    steep = np.abs(d[:, 1]) / np.linalg.norm(d, axis=1) > 0.5
    plain = (s.surface == 1) & (s.echo == Echo.PLAIN) & steep
    assert plain.sum() > 500
    off = np.abs(s.scan.xyz[plain, 1] - 8.0)
    assert np.quantile(off, 0.99) < 1e-5 and off.max() < 1e-3  # more only where the post takes half the beam


def test_raster_keeps_every_beam_in_order() -> None:
    (s,) = scan_stations(yard(), ScannerSpec(**PENCIL, **COARSE, lowest=-40, highest=50), 1)
    index = s.scan.grid.index  # type: ignore[union-attr]
    h, w = index.shape
    assert w == np.ceil(2 * np.pi / 0.03) and h == int(np.radians(90) / 0.03) + 1
    assert sorted(index[index >= 0]) == list(range(len(s.scan)))
    assert (index[0] < 0).any() and (index < 0).mean() < 0.7  # sky is kept as beams without return
    local = s.true.inverse.apply(s.scan.xyz)
    row, column = np.nonzero(index >= 0)
    at = local[index[row, column]]
    elevation = np.arctan2(at[:, 2], np.hypot(at[:, 0], at[:, 1]))
    np.testing.assert_allclose(elevation, np.radians(50) - 0.03 * row, atol=1e-9)
    azimuth = np.unwrap(np.arctan2(at[:, 1], at[:, 0])[np.lexsort((row, column))])
    assert (np.diff(azimuth) < 1e-9).all()  # columns to the right, as the picture of the scan is seen


def test_a_raster_of_several_echoes_points_at_the_first() -> None:
    fence = [Sheet((x, 3.0, 0.0), (0.02, 0, 0), (0, 0, 8.0), Part.RAILING) for x in np.arange(5, 15, 0.2)]
    scene, wide = scene_of(ground(), wall(8.0), *fence), {"exit_beam": 0.03, "ranging": "pulsed"}
    (s,) = scan_stations(scene, ScannerSpec(**QUIET, **wide, **COARSE, echoes="all"), 1)
    number, count = s.scan.return_number, s.scan.return_count
    assert number is not None and count is not None and (count == 2).sum() > 10
    index = s.scan.grid.index  # type: ignore[union-attr]
    assert (number[index[index >= 0]] == 1).all() and (index >= 0).sum() == (number == 1).sum()


def test_neighbouring_beams_are_as_far_apart_as_asked() -> None:
    spec = ScannerSpec(**PENCIL, spacing=0.04, positions=((10.0, -2.0),), field=20.0, lowest=-5, highest=5)
    (s,) = scan_stations(scene_of(ground(), wall(8.0)), spec, 1)
    x = np.sort(s.scan.xyz[s.scan.grid.index[5], 0])  # type: ignore[union-attr]
    middle = np.abs(x - 10) < 0.5
    assert np.diff(x[middle]).mean() == pytest.approx(0.04, rel=0.02)


def test_objects_hide_what_lies_behind_them_from_the_scanner() -> None:
    (s,) = scan_stations(yard(), ScannerSpec(**PENCIL, **COARSE), 1)
    ray = (np.array([10.65, 6.0]) - s.true.t[:2]) * 8 / 6
    shadow = s.true.t[0] + ray[0]
    low = s.scan.xyz[(s.surface == 1) & (s.scan.xyz[:, 2] < 3.5), 0]
    assert (np.abs(low - shadow) < 0.15).sum() == 0 < (np.abs(low - shadow - 1) < 0.15).sum()


def test_true_and_approximate_poses() -> None:
    spec = ScannerSpec(**PENCIL, **COARSE, sigma_position=1.5, sigma_heading=3.0)
    (exact,) = scan_stations(yard(), spec, 1)
    (coarse,) = scan_stations(yard(), spec.model_copy(update={"pose": "approximate"}), 1)
    assert exact.given is exact.true
    np.testing.assert_array_equal(coarse.true.matrix, exact.true.matrix)
    assert 0.05 < np.linalg.norm(coarse.given.t - coarse.true.t) < 8
    turn = np.degrees(np.arccos((np.trace(coarse.given.R @ coarse.true.R.T) - 1) / 2))
    assert 0.05 < turn < 12
    assert np.degrees(np.arccos((coarse.given.R @ coarse.true.R.T)[2, 2])) < 0.6  # the level is good
    moved = (coarse.given @ exact.true.inverse).apply(exact.scan.xyz)
    np.testing.assert_allclose(coarse.scan.xyz, moved, atol=1e-9)
    pose = coarse.scan.local_from_scanner
    assert pose is not None and pose.sigma[0] == 1.5 and pose.value is coarse.given
    np.testing.assert_array_equal(coarse.scan.origins, coarse.given.t[None])


def test_level_errors_do_not_depend_on_the_heading() -> None:
    (s,) = scan_stations(yard(), ScannerSpec(**PENCIL, **COARSE), 7)
    tilt = np.degrees(np.arccos(s.true.R[2, 2]))
    assert 0 < tilt < 1.5


def test_same_seed_same_bytes() -> None:
    spec = ScannerSpec(**COARSE, colour=False)
    first, again, other = (scan_stations(yard(), spec, seed)[0] for seed in (1, 1, 2))
    for f in fields(first.scan):
        a, b = getattr(first.scan, f.name), getattr(again.scan, f.name)
        if isinstance(a, np.ndarray):
            assert a.tobytes() == b.tobytes(), f.name
    assert first.echo.tobytes() == again.echo.tobytes()
    assert len(other.scan) != len(first.scan) or (other.scan.xyz != first.scan.xyz).any()


def test_stations_do_not_depend_on_one_another() -> None:
    spec = ScannerSpec(spacing=0.4, positions=((5.0, 0.0), (14.0, -1.0)), colour=False)
    both = scan_stations(yard(), spec, 3)
    (second,) = scan_stations(yard(), spec, 3, only=[1])
    assert second.scan.xyz.tobytes() == both[1].scan.xyz.tobytes()
    assert not np.array_equal(both[0].true.R, both[1].true.R)


def test_noise_and_strays_are_as_stated() -> None:
    spec = ScannerSpec(
        **{**PENCIL, "sigma_range": 0.004, "strays": 0.01, "spacing": 0.1}, positions=((10.0, 0.0),)
    )
    scene = scene_of(ground(), wall(8.0, laser=0.9))
    (s,) = scan_stations(scene, spec, 5)
    near = (s.surface == 1) & (np.abs(s.scan.xyz[:, 0] - 10) < 3) & (s.scan.xyz[:, 2] < 4)
    residual = np.linalg.norm(s.scan.xyz[near] - s.true.t, axis=1) - s.true_range[near]
    assert 0.6 * 0.004 < residual.std() < 1.1 * 0.004
    stray = s.echo == Echo.STRAY
    beams = s.scan.grid.index.size  # type: ignore[union-attr]
    assert stray.sum() == pytest.approx(0.01 * beams, rel=0.2)
    assert (s.surface[stray] == -1).all() and np.ptp(s.true_range[stray]) > 20


def test_stations_without_positions_stand_along_the_street_where_there_is_room() -> None:
    car = Sheet((4.7, 0.5, 0.0), (0.6, 0, 0), (0, 0, 1.8), Part.CAR)
    scene = scene_of(ground(), wall(8.0), car)
    stations = scan_stations(scene, ScannerSpec(**PENCIL, spacing=0.5, stations=2, height=1.6), 1)
    at = np.array([s.true.t for s in stations])
    assert at[1, 0] == pytest.approx(15.0) and at[0, 0] != 5.0 and abs(at[0, 0] - 5) < 3
    np.testing.assert_allclose(at[:, 2], 1.6)
    with pytest.raises(OptionError, match=r"\[5, 0.5\] is not free ground"):
        scan_stations(scene, ScannerSpec(positions=((5.0, 0.5),)), 1)
    with pytest.raises(OptionError, match="not free ground"):
        scan_stations(scene, ScannerSpec(positions=((5.0, 900.0),)), 1)


@pytest.mark.parametrize(
    "bad",
    [
        {"spacing": -0.01},
        {"sigma_range": -1},
        {"subrays": 5},
        {"lowest": 20, "highest": 10},
        {"range_min": 200},
        {"colour_depth": 3},
        {"positions": ()},
    ],
)
def test_bad_scanners_are_refused(bad: dict[str, object]) -> None:
    with pytest.raises(ValueError, match=next(iter(bad))):
        ScannerSpec(**bad)  # type: ignore[arg-type]


def test_stating_one_property_changes_no_other() -> None:
    free = draw_instrument(ScannerSpec(ranging="pulsed"), np.random.default_rng(3))
    stated = draw_instrument(
        ScannerSpec(ranging="pulsed", divergence=1.0, sigma_range=0.01, echoes="last"),
        np.random.default_rng(3),
    )
    differing = {f.name for f in fields(free) if getattr(free, f.name) != getattr(stated, f.name)}
    assert differing == {"divergence", "sigma_range", "echoes"}
    drawn = {draw_instrument(ScannerSpec(), np.random.default_rng(k)).ranging for k in range(20)}
    assert drawn == {"pulsed", "phase"}


STILL = {"offset": 0.0, "drift": 0.0, "drift_angle": 0.0, "boresight": 0.0}
DRIVE = {"speed": 10.0, "beams": 200, "profile_rate": 50.0, "overrun": 5.0, "lane": 0.0}


def street() -> Scene:
    return scene_of(ground(), wall(8.0, z=(0, 12)), wall(14.0, z=(0, 30)))


def test_a_vehicle_without_errors_measures_exactly() -> None:
    d = drive(street(), DriveSpec(**PENCIL, **DRIVE, **STILL), 1)
    for surface, axis, value in ((0, 2, 0.0), (1, 1, 8.0), (2, 1, 14.0)):
        own = d.scan.xyz[d.surface == surface, axis]
        assert len(own) > 100 and np.abs(own - value).max() < 1e-8
    assert set(d.scanner) == {1, 2}
    np.testing.assert_array_equal(d.trajectory, d.true_trajectory)


def test_gps_time_orders_the_points_and_finds_the_sensor() -> None:
    d = drive(street(), DriveSpec(**PENCIL, **DRIVE), 1)
    time = d.scan.time
    assert time is not None and (np.diff(time) >= 0).all()
    assert time[0] >= 302_400 and time[-1] <= d.trajectory[-1, 0]
    track = np.column_stack([np.interp(time, d.trajectory[:, 0], d.trajectory[:, k]) for k in (1, 2, 3)])
    sensor = d.scan.sensor_of(np.arange(len(time)))
    # scanners sit 0.25 m before and behind the reference point
    np.testing.assert_allclose(np.linalg.norm(sensor - track, axis=1), 0.25, atol=0.03)
    ranges = np.linalg.norm(d.scan.xyz - sensor, axis=1)
    assert np.abs(ranges - d.true_range)[d.echo == Echo.PLAIN].max() < 0.03


def test_profiles_are_slanted_and_as_dense_as_the_speed_makes_them() -> None:
    d = drive(street(), DriveSpec(**PENCIL, **{**DRIVE, "beams": 2000}, **STILL), 1)
    front = (d.surface == 1) & (d.scanner == 1) & (np.abs(d.scan.xyz[:, 2] - 5) < 0.02)
    x = np.sort(d.scan.xyz[front, 0])
    steps = np.diff(x)
    assert np.median(steps[steps > 0.05]) == pytest.approx(10.0 / 50.0, rel=0.1)
    one = (d.surface == 1) & (d.scanner == 1) & (np.abs(d.scan.time - d.scan.time.mean()) < 0.01)
    slope = np.polyfit(d.scan.xyz[one, 2], d.scan.xyz[one, 0], 1)[0]
    assert abs(slope) > 0.2  # no profile runs along the jambs


def test_drift_moves_points_with_the_trajectory() -> None:
    wrong = {"offset": 0.05, "drift": 0.2, "drift_angle": 0.0, "boresight": 0.0}
    d = drive(street(), DriveSpec(**PENCIL, **DRIVE, **wrong), 3)
    shift = d.trajectory[:, 1:4] - d.true_trajectory[:, 1:4]
    assert 0.01 < np.abs(shift).max() < 0.5 and np.ptp(shift, axis=0).max() > 0.02
    front = d.surface == 1
    at = np.interp(d.scan.time[front], d.trajectory[:, 0], shift[:, 1])
    np.testing.assert_allclose(d.scan.xyz[front, 1] - 8.0, at, atol=1e-6)


def test_random_walk_grows_with_the_distance() -> None:
    from frontage.simulate.sensors.track import drive_along, navigation_solution

    spec = DriveSpec(offset=0.0, drift=0.03, drift_angle=0.0)
    gained = []
    for seed in range(60):
        rng = np.random.default_rng(seed)
        true = drive_along(street(), (0.0, 100.0), 0.0, spec, rng)
        error = navigation_solution(true, spec, rng).xyz - true.xyz
        gained.append(error[-1] - error[0])
    assert np.std(gained) == pytest.approx(0.03, rel=0.2)


def test_pulses_through_a_grille_return_several_echoes() -> None:
    bars = [Sheet((x, 5.0, 0.0), (0.01, 0, 0), (0, 0, 8.0), Part.RAILING) for x in np.arange(0, 20, 0.1)]
    scene = scene_of(ground(), wall(8.0), *bars)
    d = drive(scene, DriveSpec(**{**QUIET, "exit_beam": 0.02}, **DRIVE, **STILL), 1)
    two = d.scan.return_count > 1
    assert two.sum() > 20
    assert (d.scan.return_number[two] <= d.scan.return_count[two]).all()
    second = np.flatnonzero(d.scan.return_number == 2)
    assert (d.scan.time[second] == d.scan.time[second - 1]).all()
    assert (d.true_range[second] > d.true_range[second - 1]).all()


def test_drive_is_repeatable() -> None:
    spec = DriveSpec(**DRIVE, colour=False)
    a, b = (drive(street(), spec, 4) for _ in range(2))
    assert a.scan.xyz.tobytes() == b.scan.xyz.tobytes() and a.trajectory.tobytes() == b.trajectory.tobytes()
    assert drive(street(), spec, 5).trajectory.tobytes() != a.trajectory.tobytes()
