"""Photos on the page: cameras where they stand and look, residuals to scale, numbers with their units."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from facade_fakes import WORLD, facade
from frontage.geometry.arrays import Float
from frontage.pipeline.reportdata import report_data
from frontage.pipeline.store.manifest import Manifest, StageRecord
from frontage.pipeline.store.results import StageResult
from frontage.pipeline.store.store import Store
from frontage.report import BuildingView, FacadeView, OrientationView, ReportData, render_report
from frontage.report.cameramap import CameraMap, CameraMark, camera_map
from frontage.report.figures import facade_ends
from frontage.report.orientation import lengths, orientation_facts, orientation_section
from frontage.report.plans import half_axes, magnification
from frontage.report.residuals import residual_plots
from report.test_page import EVIL, Tags

ORIGIN = WORLD.origin.astype(np.float64)
WIDTH, HEIGHT, FOCAL = 6000, 4000, 5200.0
VERDICTS = ["confirmed", "confirmed", "confirmed", "confirmed", "tied", "plain"]


def camera_from_world(centre: Float, look: Float, upright: bool = False) -> Float:
    """A level camera at `centre` that looks along `look`; upright: turned by a quarter about its axis."""
    z = look / np.linalg.norm(look)
    x = np.cross(z, [0, 0, 1.0])
    x /= np.linalg.norm(x)
    R = np.array([x, np.cross(z, x), z])
    if upright:
        R = np.array([-R[1], R[0], R[2]])
    return np.column_stack([R, -R @ centre])


def photo(k: int, points: int = 150) -> dict[str, Any]:
    """A made-up entry of report.json: photo `k` in a row before the facade of the fakes."""
    rng = np.random.default_rng(k)
    wall = facade().frame
    at = wall.apply(np.array([[-8.0 + 3.1 * k, -11.0 - k % 2, -1.5]]))[0]
    look = wall.apply(np.array([[-4.0 + 1.8 * k, 0.0, 0.5]]))[0] - at
    sigma = np.array([0.008, 0.005, 0.004, 2e-4, 3e-4, 2e-4]) * (1 + k)
    C = np.diag(sigma**2)
    C[0, 1] = C[1, 0] = 0.6 * sigma[0] * sigma[1]
    n = points if VERDICTS[k % 6] == "confirmed" else 0
    place = rng.uniform(0, 1, (n, 2)) * (WIDTH, HEIGHT)
    residuals = np.column_stack([place, rng.normal(0, 0.6, (n, 2))])
    moved = [2.1, -1.4, 0.9] if k != 2 else [-3.0, 0.5, 1.0]
    return {
        "photo": f"IMG_{k:04d}.jpg",
        "camera_from_world": camera_from_world(ORIGIN + at, look, upright=k == 3).tolist(),
        "center": (ORIGIN + at).tolist(),
        "given": None if k == 1 else (ORIGIN + at + moved).tolist(),
        "sigma_center": sigma[:3].tolist(), "sigma_angles": np.degrees(sigma[3:]).tolist(),
        "covariance": C.tolist(),
        "camera": {"model": "OPENCV", "width": WIDTH, "height": HEIGHT, "sigma": [1.0] * 8,
                   "params": [FOCAL, FOCAL, WIDTH / 2, HEIGHT / 2, -0.02, 0.01, 0.0, 0.0]},
        "control_points": 7 * n, "control_rms": 0.6 if n else None,
        "tie_points": 1234 if k % 6 != 5 else 3, "tie_rms": 0.41,
        "check_rmse": 0.0123 if k % 2 == 0 and n else None,
        "redundancy": 0.93 if n else None, "detectable": 3.21 if n else None,
        "verdict": VERDICTS[k % 6], "rival": 0.62 if n else None,
        "rig": "roof" if k < 2 else None, "exposure": "0017" if k < 2 else None,
        "residuals": residuals.round(3).tolist(),
    }  # fmt: skip


def rig(estimated: bool = True) -> dict[str, Any]:
    """Two cameras of one exposure, the second 0.4 m beside the first."""
    sigma = [0.002, 0.003, 0.001] if estimated else [0.0] * 3
    front = {
        "camera": "front",
        "body_from_camera": np.eye(4)[:3].tolist(),
        "estimated": False,
        "sigma_position": [0.0] * 3,
        "sigma_angles": [0.0] * 3,
    }
    beside = np.column_stack([np.eye(3), [0.4, 0.0, 0.0]]).tolist()
    left = {
        "camera": "left",
        "body_from_camera": beside,
        "estimated": estimated,
        "sigma_position": sigma,
        "sigma_angles": sigma,
    }
    taken = [{"exposure": "0017", "photos": {"front": photo(0)["photo"], "left": photo(1)["photo"]}}]
    return {"rig": "roof", "cameras": [front, left], "exposures": taken}  # fmt: skip


def record(count: int = 6) -> dict[str, Any]:
    reason = "too few points in common with other photos"
    return {
        "photos": [photo(k) for k in range(count)],
        "unoriented": [{"photo": EVIL, "code": "O102", "reason": reason}],
        "source": "intensity", "points": 12345, "sigma_points": [0.004, 0.0052, 0.003],
        "factors": {"tie points": 1.049, "control": 0.93, "surfaces": 1.2}, "sigma0": 1.0012,
        "redundancy": 45678, "rejected": 321, "rigs": [rig()] if count > 1 else [], "notes": [],
    }  # fmt: skip


def data(about: dict[str, Any], street: Float | None = None) -> ReportData:
    """A page with one building, whose wall, floor and house opposite make the street's points."""
    view = FacadeView(facade(), None, "facades/B01_F1", ())
    if street is None:
        rng, frame = np.random.default_rng(1), view.facade.frame
        wall = rng.uniform([-9, -0.1, 0], [9, 0.1, 0], (6000, 3))
        opposite = rng.uniform([-12, -18.2, 0], [12, -18, 0], (4000, 3))
        street = frame.apply(np.vstack([wall, opposite]))[:, :2]
    record = {"id": "B01", "address": "", "points": 10, "ground_z": None, "cuts": [], "notes": []}
    manifest = {
        "frontage": "0.1.0", "seed": 0, "versions": {}, "warnings": [], "notes": [], "inputs": {},
        "world": {"crs": "EPSG:25832", "origin": ORIGIN.tolist()}, "stages": {},
    }  # fmt: skip
    building = BuildingView(record, street, (view,))
    oriented = OrientationView(about, ORIGIN)
    group = np.zeros(len(street), np.int64)
    return ReportData(manifest, (building,), street, group, orientation=oriented)


def mapped(about: dict[str, Any], **kwargs: Any) -> CameraMap:
    found = camera_map(data(about, **kwargs))
    assert found is not None
    return found


def corners(mark: CameraMark) -> Float:
    return np.array([[float(v) for v in pair.split(",")] for pair in mark.view.split()])


def test_cameras_stand_and_look_where_their_poses_say() -> None:
    about = record()
    figure = mapped(about)
    places = np.array([[m.x, m.y] for m in figure.cameras])
    true = np.array([p["center"] for p in about["photos"]])[:, :2]
    scale = np.linalg.norm(places[5] - places[0]) / np.linalg.norm(true[5] - true[0])
    assert (places - places[0]) * (1, -1) / scale == pytest.approx(true - true[0], abs=1e-6)
    for mark, entry in zip(figure.cameras, about["photos"], strict=True):
        apex, left, right = corners(mark)
        along = ((left + right) / 2 - apex) * (1, -1)
        axis = np.array(entry["camera_from_world"])[2, :2]
        cosine = along @ axis / np.linalg.norm(along) / np.linalg.norm(axis)
        assert cosine == pytest.approx(1.0, abs=1e-3)


def test_the_field_of_view_is_that_of_the_level_side_of_the_photo() -> None:
    about = record()
    for entry in about["photos"]:
        entry["camera"] |= {"model": "PINHOLE", "params": [FOCAL, FOCAL, WIDTH / 2, HEIGHT / 2]}
    angles = []
    for mark in mapped(about).cameras:
        apex, left, right = corners(mark)
        a, b = left - apex, right - apex
        angles.append(np.arccos(a @ b / np.linalg.norm(a) / np.linalg.norm(b)))
        assert a[0] * b[1] - a[1] * b[0] > 0  # y runs down: left, then right, turns with the clock
    wide, tall = 2 * np.arctan(WIDTH / 2 / FOCAL), 2 * np.arctan(HEIGHT / 2 / FOCAL)
    assert angles == pytest.approx([wide, wide, wide, tall, wide, wide], abs=0.01)


def test_a_fisheye_and_a_spherical_camera_are_drawn_too() -> None:
    about = record()
    fisheye = {"model": "OPENCV_FISHEYE", "params": [1500.0, 1500, 3000, 2000, 0, 0, 0, 0]}
    about["photos"][0]["camera"] |= fisheye
    about["photos"][1]["camera"] |= {"model": "EQUIRECTANGULAR", "params": [WIDTH, HEIGHT]}
    for mark in mapped(about).cameras:
        assert np.isfinite(corners(mark)).all()


def test_ellipses_grow_by_the_stated_factor_and_point_along_the_largest_error() -> None:
    about = record()
    figure = mapped(about)
    places = np.array([[m.x, m.y] for m in figure.cameras])
    true = np.array([p["center"] for p in about["photos"]])[:, :2]
    scale = np.linalg.norm(places[5] - places[0]) / np.linalg.norm(true[5] - true[0])
    error, C = figure.cameras[0].error, np.array(about["photos"][0]["covariance"])[:2, :2]
    assert error is not None
    axis = np.array([np.cos(np.radians(error.angle)), -np.sin(np.radians(error.angle))])
    assert error.major == pytest.approx(2.448 * np.sqrt(axis @ C @ axis) * scale * figure.magnified)
    assert error.minor < error.major
    longest = [m.error.major for m in figure.cameras if m.error]
    assert 4.0 < np.median(longest) <= 16.0 and max(longest) <= 60.0
    about["photos"][0]["covariance"] = np.full((6, 6), np.inf).tolist()
    assert mapped(about).cameras[0].error is None


def test_lines_start_at_approximate_positions_which_do_not_stretch_the_map() -> None:
    about = record()
    figure = mapped(about)
    scale = 1 / np.hypot(*(np.array(about["photos"][0]["given"]) - about["photos"][0]["center"])[:2])
    first, second = figure.cameras[0], figure.cameras[1]
    assert first.given is not None and second.given is None
    scale *= np.hypot(first.given[0] - first.x, first.given[1] - first.y)
    assert first.given[0] - first.x == pytest.approx(2.1 * scale, abs=1e-3)
    assert first.given[1] - first.y == pytest.approx(1.4 * scale, abs=1e-3)  # 1.4 m to the south is down
    about["photos"][0]["given"] = (np.array(about["photos"][0]["center"]) + 5000.0).tolist()
    assert mapped(about).width == pytest.approx(figure.width, rel=0.1)


def test_walls_and_a_lonely_camera() -> None:
    figure = mapped(record())
    (wall,) = figure.walls
    bar = float(figure.bar_label.removesuffix(" m"))
    length = np.linalg.norm(np.diff(facade_ends(data(record()).buildings[0].facades[0]), axis=0))
    assert np.hypot(wall[2] - wall[0], wall[3] - wall[1]) * bar / figure.bar == pytest.approx(length)
    lonely = mapped({**record(), "photos": [photo(0)]}, street=np.empty((0, 2)))
    assert lonely.href == "" and lonely.width > 0 and lonely.height > 0


def test_labels_do_not_cover_one_another() -> None:
    about = record()
    about["photos"] = [{**photo(0), "photo": f"left/IMG_{k}.jpg"} for k in range(3)]
    assert [m.label for m in mapped(about).cameras] == ["IMG_0", "", ""]


def test_residuals_keep_their_place_direction_and_common_scale() -> None:
    (one, other) = photo(0, 2), photo(1, 1)
    one["residuals"] = [[3000, 1000, 0.5, 0], [1500, 4000, 0, -1]]
    other["residuals"] = [[0, 0, 2.0, 2.0]]
    other["camera"] = {**other["camera"], "width": HEIGHT, "height": WIDTH}
    shown = residual_plots([one, other])
    first, second = shown.plots
    px = first.width / WIDTH
    assert first.points == f"M{3000 * px:.1f} {1000 * px:.1f}h0M{1500 * px:.1f} {4000 * px:.1f}h0"
    longer = shown.magnified * px
    assert f"l{0.5 * longer:.1f} 0.0" in first.vectors and f"l0.0 {-longer:.1f}" in first.vectors
    assert second.width < second.height and f"l{2 * longer:.1f} {2 * longer:.1f}" in second.vectors
    assert first.caption == "rms 0.60 px, 14 points, 2 of them drawn"


def test_plots_stop_at_sixty_and_say_so() -> None:
    shown = residual_plots([photo(k, 3) for k in range(64)])
    assert len(shown.plots) == 60 and shown.left_out == 4
    assert shown.plots[4].caption == "no control points" and shown.plots[4].vectors == ""
    text = render_report(data(record(64)))
    assert "4 more photos are not shown" in text and text.count('aria-label="Residuals of') == 60


def test_rows_and_facts_say_what_was_found() -> None:
    section = orientation_section(data(record()))
    assert section is not None
    first, fifth, last = section.rows[0], section.rows[4], section.rows[5]
    assert first.sigma_position == "8.0, 5.0, 4.0 mm" and first.sigma_angles == "0.0115, 0.0172, 0.0115°"
    assert first.control == "1,050 (0.60 px)" and first.ties == "1,234 (0.41 px)"
    assert first.check == "12 mm" and section.rows[1].check == "–"
    assert first.verdict == "confirmed by the scan" and "62%" in first.rival
    assert fifth.verdict == "held by other photos only" and fifth.control == "0" and fifth.rival == ""
    assert last.verdict.startswith("not confirmed")
    facts = {f.name: f for f in section.facts}
    assert facts["Oriented"].value == "6 of 7 photos" and "4 confirmed" in facts["Oriented"].error
    assert facts["Tie points"].value == "12,345" and "4.0, 5.2, 3.0 mm" in facts["Tie points"].error
    assert facts["Variance factors"].value == "tie points 1.05, control 0.93, surfaces 1.20"
    assert facts["Redundancy"].value == "45,678" and facts["Rejected"].value == "321"
    assert "intensity" in facts["Compared with"].value


def test_unknown_numbers_are_said_not_invented() -> None:
    about = {**record(1), "sigma_points": None, "sigma0": None, "factors": {}}
    about["photos"][0] |= {"sigma_center": [0.1, None, 0.1], "sigma_angles": [float("inf")] * 3}
    section = orientation_section(data(about))
    assert section is not None
    assert section.rows[0].sigma_position == section.rows[0].sigma_angles == "not known"
    facts = {f.name: f for f in orientation_facts(about)}
    assert facts["σ0"].value == "not known" and facts["Tie points"].error == ""


@pytest.mark.parametrize(
    ("metres", "text"),
    [([0.0004], "0.4 mm"), ([0.012, 0.004], "12, 4 mm"), ([0.25, 0.01], "25.0, 1.0 cm"), ([12.0], "12.00 m")],
)
def test_lengths_choose_their_unit(metres: list[float], text: str) -> None:
    assert lengths(metres) == text


def test_magnification_is_a_round_number() -> None:
    found = [magnification(v, 14.0) for v in (0.0, 0.001, 0.06, 0.07, 1.0, 14.0, 20.0)]
    assert found == [1, 10_000, 200, 200, 10, 1, 1]
    major, minor, angle = half_axes(np.diag([1.0, 4.0]))
    assert (major, minor, abs(angle)) == pytest.approx((2 * 2.448, 2.448, 90.0))


def test_the_page_shows_the_section_escaped_and_well_formed() -> None:
    about = record()
    about["photos"][0]["photo"] = EVIL
    text = render_report(data(about))
    assert "Photos</h2>" in text and "<script" not in text and text.count("&lt;script&gt;") >= 4
    tags = Tags()
    tags.VOID = Tags.VOID | {"ellipse", "circle", "br"}
    tags.feed(text)
    assert tags.open == []
    assert "NaN" not in text and ">nan" not in text and '"nan' not in text
    assert render_report(data(about)) == text


def test_without_poses_only_the_reasons_are_shown() -> None:
    about = {**record(0), "points": 0, "sigma_points": None, "factors": {}}
    text = render_report(data(about))
    assert "0 of 1 photos" in text and "Photos without a pose" in text
    assert "The photos from above" not in text and "Photos with a pose" not in text
    assert "Photos</h2>" not in render_report(data({**about, "unoriented": []}))
    assert "Photos</h2>" not in render_report(replace(data(about), orientation=None))


def test_the_run_folder_gives_the_record_where_photos_were_oriented(tmp_path: Path) -> None:
    store = Store.create(tmp_path)
    world = {"crs": "EPSG:25832", "origin": ORIGIN.tolist()}
    scans = StageRecord("k", 0.0, {"items": 1, "warnings": [], "notes": [], "world": world})
    before = Manifest(stages={"scans": scans})
    assert report_data(store, before).orientation is None
    (tmp_path / "orientation").mkdir()
    (tmp_path / "orientation" / "report.json").write_text(json.dumps(record()))
    stages = {"scans": scans, "orient": StageRecord.of("k", 0.0, StageResult(items=6))}
    gathered = report_data(store, Manifest(stages=stages))
    assert gathered.orientation is not None
    assert gathered.orientation.record == record() and (gathered.orientation.origin == ORIGIN).all()
    assert "6 of 7 photos" in render_report(gathered)


def test_the_rig_of_photos_is_named_with_its_relative_poses():
    about = record()
    section = orientation_section(data(about))
    assert section is not None
    assert section.rows[0].photo.endswith("(roof, 0017)") and "roof" not in section.rows[2].photo
    (fact,) = (f for f in section.facts if f.name == "Rig: roof")
    assert fact.value == "1 exposure of up to 2 photos by 2 cameras"
    assert fact.error == "left at 40.0, 0.0, 0.0 cm (σ 2.0, 3.0, 1.0 mm; 0.0020, 0.0030, 0.0010°)"
    about["rigs"] = [rig(estimated=False)]
    (fact,) = (f for f in orientation_facts(about) if f.name == "Rig: roof")
    assert fact.error == "relative poses held fixed"
    about["photos"][2]["verdict"] = "carried"
    held = orientation_section(data(about))
    assert held is not None and ("carried", "held by the other cameras of their rig") in held.verdicts
