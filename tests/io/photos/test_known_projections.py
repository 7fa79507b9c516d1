"""Axes, angles, pixels and distortion of every pose format, against projections worked out by hand."""

import json
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import pytest
from pyproj import CRS, Proj, Transformer

from frontage.errors import CrsError
from frontage.geometry.arrays import Float
from frontage.io.photos.interchange import opk
from frontage.io.photos.interchange import realityscan as rs
from frontage.io.photos.photoset import PhotoSet
from frontage.io.photos.read import photo_inputs, read_photos
from frontage.model import WorldRef
from pose_files import (
    CAMERAS,
    POINTS,
    Known,
    metashape,
    opensfm,
    opensfm_shots,
    pictures,
    pix4d,
    pixels,
    realityscan,
    source,
)

LOCAL = WorldRef(np.array([-2, 3, 1]), None)
FILES: dict[str, tuple[Callable[[Path], Path], float, int]] = {
    # a function that writes the file, the horizontal focal length in it, the number of files read
    "metashape": (lambda folder: metashape(folder / "cameras.xml"), 51.0, 1),
    "opensfm": (lambda folder: opensfm(folder / "reconstruction.json"), 51.0, 1),
    "odm folder": (lambda folder: opensfm(folder / "opensfm" / "reconstruction.json").parents[1], 51.0, 1),
    "pix4d": (lambda folder: pix4d(folder), 51.0, 2),
    "pix4d cam": (lambda folder: pix4d(folder, "cam"), 50.0, 2),
    "pix4d colmap": (lambda folder: pix4d(folder, "colmap"), 51.0, 2),
    "realityscan": (lambda folder: realityscan(folder / "cameras.csv"), 50.0, 1),
}


def check(found: PhotoSet, fx: float, world: WorldRef = LOCAL) -> None:
    """Every point lies in every photo where the definition puts it."""
    photos = {photo.id.removesuffix(".jpg"): photo for photo in found.photos}
    assert set(photos) == {known.name.removesuffix(".jpg") for known in CAMERAS}
    for known in CAMERAS:
        seen = photos[known.name.removesuffix(".jpg")].project(world.to_local(POINTS))
        expected = pixels(known, (fx, 50.0), (31.5, 19.5), POINTS)
        assert np.abs(seen - expected).max() < 1e-9
        assert np.ptp(expected, axis=0).min() > 1.0, "the points are spread over the picture"


@pytest.mark.parametrize("kind", FILES)
def test_points_fall_where_the_definition_of_the_format_puts_them(tmp_path: Path, kind: str) -> None:
    write, fx, files = FILES[kind]
    (tmp_path / "poses").mkdir()
    pictures(tmp_path / "pictures")
    where = source(tmp_path, write(tmp_path / "poses"))
    found = read_photos(where, LOCAL)
    check(found, fx)
    assert found.notes == () and found.image(found.photos[0].id).shape == (40, 60, 3)
    assert len(photo_inputs(where)) == len(CAMERAS) + files


def test_a_camera_that_looks_north_sees_east_on_the_right_and_up_above(tmp_path: Path) -> None:
    for kind, (write, _, _) in FILES.items():
        folder = tmp_path / kind
        (folder / "poses").mkdir(parents=True)
        pictures(folder / "pictures")
        north = read_photos(source(folder, write(folder / "poses")), WorldRef(np.zeros(3))).photos[0]
        ahead, east, up = north.project(np.array([[4.0, 1, 2], [4.2, 1, 2], [4.0, 1, 2.2]]))
        assert ahead.tolist() == pytest.approx([31.5, 19.5])
        assert east[0] > ahead[0] + 0.5 and up[1] < ahead[1] - 0.5


def test_the_angles_of_realityscan_are_those_of_its_own_rotation_matrix() -> None:
    # Both were written by the program itself for one photo (Unreal Engine forum, topic 710449).
    angles = np.radians([163.736597399311, 83.4154313461628, 174.386496244756])
    camera_from_world = [
        [0.982594073038806, 0.185426733553445, -0.0112166890261935],
        [-0.032113633044729, 0.11008102707942, -0.993403685341366],
        [-0.18296885582437, 0.976472781986697, 0.114],
    ]
    assert np.abs(rs.rotation_of(*angles).T - camera_from_world).max() < 2e-4  # the last number was cut
    assert np.abs(rs.rotation_of(*angles).T[:2] - camera_from_world[:2]).max() < 1e-8


def test_omega_phi_kappa_are_three_turns_in_this_order() -> None:
    o, p, k = 0.3, -0.7, 2.1
    Rx = [[1, 0, 0], [0, np.cos(o), -np.sin(o)], [0, np.sin(o), np.cos(o)]]
    Ry = [[np.cos(p), 0, np.sin(p)], [0, 1, 0], [-np.sin(p), 0, np.cos(p)]]
    Rz = [[np.cos(k), -np.sin(k), 0], [np.sin(k), np.cos(k), 0], [0, 0, 1]]
    expected = np.array(Rx) @ Ry @ Rz @ np.diag([1, -1, -1])
    assert np.abs(opk.rotation_of(o, p, k) - expected).max() < 1e-15


@pytest.mark.parametrize(
    ("head", "factor"),
    [
        ("imageName;X;Y;Z;Omega[gon];Phi[gon];Kappa[gon]", 400 / 360),
        ("name,easting,northing,height,omega_rad,phi_rad,kappa_rad", np.pi / 180),
        ("# angles: gon\nname\tx\ty\tz\tomega\tphi\tkappa", 400 / 360),
        ("# Cameras (3)\n# PhotoID, X, Y, Z, Omega, Phi, Kappa", 1.0),
    ],
)
def test_units_and_dividers_of_tables(tmp_path: Path, head: str, factor: float) -> None:
    pictures(tmp_path / "pictures")
    table = pix4d(tmp_path, "colmap")
    divider = next((d for d in ";\t" if d in head), "," if "_rad" in head else "\t")
    rows = [divider.join(map(repr, (*c.centre, *np.multiply(c.opk, factor).tolist()))) for c in CAMERAS]
    names = [c.name.removesuffix(".jpg") for c in CAMERAS]
    table.write_text("\n".join([head, *(n + divider + row for n, row in zip(names, rows, strict=True))]))
    check(read_photos(source(tmp_path, table), LOCAL), 51.0)


def test_the_transform_of_the_chunk_turns_shifts_and_scales(tmp_path: Path) -> None:
    pictures(tmp_path / "pictures")
    turned = "".join(  # the chunk is half as large, and turned by a quarter about z
        f'<camera id="{k}" sensor_id="3" component_id="0" label="{c.name}"><transform>'
        + " ".join(map(repr, _in_chunk(c).ravel().tolist()))
        + "</transform></camera>"
        for k, c in enumerate(CAMERAS)
    )
    part = (
        "<transform><rotation>0 -1 0 1 0 0 0 0 1</rotation><translation>10 20 30</translation>"
        "<scale>2</scale></transform>"
    )
    whole = "<transform><scale>7</scale></transform>"
    for chunk in (part, f'{whole}<components><component id="0">{part}</component></components>'):
        file = metashape(tmp_path / "c.xml", 'LOCAL_CS["Local (m)"]', chunk, turned.replace("> ", ">"))
        check(read_photos(source(tmp_path, file), LOCAL), 51.0)


def _in_chunk(known: Known) -> Float:
    """The matrix of a camera in a chunk from which x = 2 R c + (10, 20, 30), R a quarter turn about z."""
    R = np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]])
    matrix = np.eye(4)
    matrix[:3, :3] = R.T @ known.axes.T
    matrix[:3, 3] = R.T @ (np.array(known.centre) - [10, 20, 30]) / 2
    return matrix


UTM = WorldRef(np.array([676000, 5403000, 400]), "EPSG:25832")
EAST_NORTH_UP = (676100.25, 5403200.5, 420.0)  # 0.04 % east of the line where lengths in plan are true


def geocentric(east: Float, code: int = 4936) -> Float:
    """UTM coordinates with ellipsoidal heights (n, 3) as geocentric ones, by PROJ alone."""
    to = Transformer.from_crs(CRS(25832).to_3d(), code, always_xy=True)
    return np.column_stack(to.transform(*np.atleast_2d(east).T))


def north_at(place: Float) -> Float:
    """Axes east, north, up (rows) in geocentric coordinates, from three neighbouring points on the globe."""
    lon, lat, h = Transformer.from_crs(4936, 4937, always_xy=True).transform(*place)
    to = Transformer.from_crs(4937, 4936, always_xy=True)
    steps = [(lon + 1e-6, lat, h), (lon, lat + 1e-6, h), (lon, lat, h + 1.0)]
    rows = np.array([to.transform(*step) for step in steps]) - place
    return rows / np.linalg.norm(rows, axis=1, keepdims=True)


@pytest.mark.parametrize("reference", ["EPSG:25832", "EPSG:4258"])
def test_a_georeferenced_chunk_comes_into_the_grid_of_the_run(tmp_path: Path, reference: str) -> None:
    pictures(tmp_path / "pictures")
    place = geocentric(np.array(EAST_NORTH_UP))[0]
    enu = north_at(place)
    R = " ".join(map(repr, enu.T.ravel().tolist()))  # the chunk has the axes east, north, up
    chunk = (
        f"<transform><rotation>{R}</rotation><translation>{' '.join(map(repr, place.tolist()))}</translation>"
        "<scale>1</scale></transform>"
    )
    wkt = CRS(reference).to_wkt("WKT1_GDAL").replace("&", "&amp;")
    found = read_photos(source(tmp_path, metashape(tmp_path / "c.xml", wkt, chunk)), UTM)
    assert any("above the ellipsoid" in note for note in found.notes)
    lon, lat, _ = Transformer.from_crs(25832, 4258, always_xy=True).transform(*EAST_NORTH_UP)
    convergence = np.radians(Proj("EPSG:25832").get_factors(lon, lat).meridian_convergence)
    assert np.degrees(convergence) > 1.5, "grid north is far from true north here"
    for known, photo in zip(CAMERAS, found.photos, strict=True):
        # True north lies counter-clockwise of grid north by the convergence, and so does the camera.
        c, s = np.cos(convergence), np.sin(convergence)
        grid_from_true = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
        assert np.abs(photo.pose.R - grid_from_true @ known.axes.T).max() < 3e-5  # over 10 m of the Earth
        # Points of the grid, projected through geocentric coordinates, fall where the photo puts them.
        local = photo.pose.t + 15 * known.axes[2] @ grid_from_true.T + POINTS - POINTS.mean(0)
        chunk_xyz = (geocentric(UTM.to_world(local)) - place) @ enu.T
        expected = pixels(known, (51.0, 50.0), (31.5, 19.5), chunk_xyz)
        assert np.abs(photo.project(local) - expected).max() < 2e-3


def test_a_real_metashape_chunk_looks_down_from_its_place(tmp_path: Path) -> None:
    # One camera of a drone flight: the numbers of a test file of geograypher, and the position of its GPS.
    pictures(tmp_path / "pictures")
    camera = (
        '<group id="0"><camera id="0" sensor_id="3" component_id="0" label="north"><transform>'
        "-0.99988146 -0.00872749 0.01268391 7.04224697 -0.00842932 0.99969124 0.02337453 7.05403071 "
        "-0.01288400 0.02326485 -0.99964631 0.43561421 0 0 0 1</transform></camera></group>"
    )
    chunk = (
        '<components><component id="0"><transform><rotation>0.8710699454 0.3070967021 -0.3833128821 '
        "-0.4909742007 0.5658364395 -0.6623997719 0.0134716110 0.7651932691 0.6436596744</rotation>"
        "<translation>-2499366.429888 -4256836.520906 4029217.965003</translation>"
        "<scale>12.354192447331316</scale></transform></component></components>"
    )
    file = metashape(tmp_path / "c.xml", CRS(4326).to_wkt("WKT1_GDAL"), chunk, camera)
    found = read_photos(source(tmp_path, file), WorldRef(np.zeros(3), "EPSG:32610"))
    (photo,) = found.photos
    gps = Transformer.from_crs(4326, 32610, always_xy=True).transform(-120.417985477, 39.41191747)
    assert np.abs(photo.pose.t - [*gps, 2420.109]).max() < 15.0
    right, down, forward = photo.pose.R.T
    assert forward[2] < -0.999, "the camera looks straight down"
    assert down[1] > 0.99, "with a yaw of 179.9 degrees the top of the picture is to the south"
    assert right[0] < -0.99


def test_local_scans_take_the_grid_of_the_cameras_or_say_what_is_missing(tmp_path: Path) -> None:
    pictures(tmp_path / "pictures")
    place = " ".join(map(repr, geocentric(np.array(EAST_NORTH_UP))[0].tolist()))
    chunk = f"<transform><translation>{place}</translation></transform>"
    world = WorldRef(UTM.origin, None)
    file = metashape(tmp_path / "c.xml", CRS(25832).to_wkt("WKT1_GDAL"), chunk)
    found = read_photos(source(tmp_path, file), world)
    assert np.abs(UTM.to_world(found.photos[0].pose.t) - EAST_NORTH_UP).max() < 20
    assert any("the scans have no CRS" in note for note in found.notes)
    file = metashape(tmp_path / "c.xml", CRS(4258).to_wkt("WKT1_GDAL"), chunk)
    with pytest.raises(CrsError, match="state crs for the scans"):
        read_photos(source(tmp_path, file), world)


def test_a_reference_puts_opensfm_into_the_grid_of_the_run(tmp_path: Path) -> None:
    pictures(tmp_path / "pictures")
    world = WorldRef(np.array([676000, 5403000, 400]), "EPSG:32632")
    lon, lat = Transformer.from_crs(32632, 4326, always_xy=True).transform(*EAST_NORTH_UP[:2])
    reference = {"latitude": lat, "longitude": lon, "altitude": EAST_NORTH_UP[2]}
    file = opensfm(tmp_path / "r" / "reconstruction.json", reference_lla=reference)
    found = read_photos(source(tmp_path, file), world)
    place = geocentric(np.array(EAST_NORTH_UP), 4978)[0]
    enu = north_at(place)
    to = Transformer.from_crs(CRS(32632).to_3d(), 4978, always_xy=True)
    for known, photo in zip(CAMERAS, found.photos, strict=True):
        local = photo.pose.t + photo.pose.rotate(np.array([[0.0, 0, 15]])) + POINTS - POINTS.mean(0)
        true = (np.column_stack(to.transform(*world.to_world(local).T)) - place) @ enu.T
        expected = pixels(known, (51.0, 50.0), (31.5, 19.5), true)
        assert np.abs(photo.project(local) - expected).max() < 2e-3
    beside = opensfm(tmp_path / "r" / "reconstruction.json").with_name("reference_lla.json")
    beside.write_text(json.dumps(reference))
    again = read_photos(source(tmp_path, file), world)
    assert [p.pose.t.tolist() for p in again.photos] == [p.pose.t.tolist() for p in found.photos]
    assert beside in photo_inputs(source(tmp_path, file))
    local = read_photos(source(tmp_path, file), LOCAL)
    check(local, 51.0)
    assert any("stay in metres east, north and up" in note for note in local.notes)


def test_the_shots_of_a_rig_have_the_poses_of_their_cameras(tmp_path: Path) -> None:
    pictures(tmp_path / "pictures")
    shots = opensfm_shots()
    poses = {name: (s.pop("rotation"), s.pop("translation")) for name, s in shots.items()}  # type: ignore[attr-defined]
    turn = {"rotation": [0.0, 0.0, np.pi / 2], "translation": [0.5, 0.25, -1.0]}  # from the world to the rig
    R = np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]])
    rig_cameras = {}
    for name, (rotation, translation) in poses.items():
        from_rig = cv2.Rodrigues(np.array(rotation))[0] @ R.T
        rig_cameras[name] = {
            "rotation": cv2.Rodrigues(from_rig)[0].ravel().tolist(),
            "translation": (translation - from_rig @ turn["translation"]).tolist(),
        }
    instance = {**turn, "rig_camera_ids": {name: name for name in poses}}
    file = opensfm(tmp_path / "r.json", shots=shots, rig_cameras=rig_cameras, rig_instances={"7": instance})
    check(read_photos(source(tmp_path, file), LOCAL), 51.0)


def test_the_largest_of_several_reconstructions_is_taken(tmp_path: Path) -> None:
    pictures(tmp_path / "pictures")
    file = opensfm(tmp_path / "r.json")
    parts = json.loads(file.read_text())
    small = {**parts[0], "shots": {"x.jpg": parts[0]["shots"]["north.jpg"]}}
    file.write_text(json.dumps([small, *parts]))
    found = read_photos(source(tmp_path, file), LOCAL)
    check(found, 51.0)
    assert found.notes == ("r.json: 1 smaller reconstructions with 1 shots were left out",)


def test_fisheyes_and_plain_cameras_follow_their_definitions(tmp_path: Path) -> None:
    pictures(tmp_path / "pictures")
    k1, k2, k3, k4, p1, p2 = -0.03, 0.004, 1e-3, -2e-4, 2e-3, -3e-3
    fisheye = {"projection_type": "fisheye_opencv", "focal_x": 0.7, "focal_y": 0.6, "c_x": 0.02, "c_y": -0.01,
               "k1": k1, "k2": k2, "k3": k3, "k4": k4}  # fmt: skip
    plain = {"projection_type": "perspective", "focal": 0.7, "k1": k1, "k2": k2}
    inner = (
        f"<f>36</f><cx>1.2</cx><cy>-0.6</cy><b1>6</b1><k1>{k1}</k1><k2>{k2}</k2><k3>{k3}</k3><k4>{k4}</k4>"
        f"<p1>{p1}</p1><p2>{p2}</p2>"
    )
    xml = metashape(tmp_path / "c.xml", calibration=inner)
    xml.write_text(xml.read_text().replace('"frame" class="adj', '"equidistant_fisheye" class="adj'))
    files = [xml]
    for name, camera in (("f.json", fisheye), ("p.json", plain)):
        cameras = {"v2 some camera": {**camera, "width": 60, "height": 40}}
        files.append(opensfm(tmp_path / name, cameras=cameras))
    X, Y, Z = CAMERAS[0].axes @ (POINTS - CAMERAS[0].centre).T
    angle, from_axis = np.arctan2(np.hypot(X, Y), Z), np.hypot(X, Y)
    x, y, q = X / from_axis * angle, Y / from_axis * angle, angle**2
    bent = 1 + k1 * q + k2 * q**2 + k3 * q**3 + k4 * q**4
    u = x * bent + p1 * (q + 2 * x * x) + 2 * p2 * x * y  # Metashape's order of p1 and p2
    v = y * bent + p2 * (q + 2 * y * y) + 2 * p1 * x * y
    flat = (X**2 + Y**2) / Z**2
    expected = [
        np.column_stack([42 * u + 31.2, 36 * v + 19.4]),
        np.column_stack([42 * x * bent + 31.2, 36 * y * bent + 19.4]),
        np.column_stack([X / Z, Y / Z]) * (42 * (1 + k1 * flat + k2 * flat**2))[:, None] + [30, 20],
    ]
    for file, wanted in zip(files, expected, strict=True):
        north = read_photos(source(tmp_path, file), LOCAL).photos[0]
        assert np.abs(north.project(LOCAL.to_local(POINTS)) - wanted).max() < 1e-9


def test_a_table_that_states_its_grid_comes_into_that_of_the_run(tmp_path: Path) -> None:
    pictures(tmp_path / "pictures")
    table = pix4d(tmp_path, "colmap")
    rows = [
        "\t".join([c.name, *map(repr, (np.array(EAST_NORTH_UP) + c.centre).tolist()), *map(repr, c.opk)])
        for c in CAMERAS
    ]
    wkt = CRS(25832).to_wkt("WKT1_GDAL", pretty=False)
    head = [f"# CoordinateSystem: {wkt}", "# PhotoID, X, Y, Z, Omega, Phi, Kappa"]
    table.write_text("\n".join([*head, *rows]))
    zone33 = WorldRef(np.array([236000, 5411000, 400]), "EPSG:25833")
    found = read_photos(source(tmp_path, table), zone33)
    to = Transformer.from_crs(25832, 25833, always_xy=True)
    lon, lat, _ = Transformer.from_crs(25832, 4258, always_xy=True).transform(*EAST_NORTH_UP)
    convergences = [
        Proj(f"EPSG:{code}").get_factors(lon, lat).meridian_convergence for code in (25832, 25833)
    ]
    turn = np.radians(convergences[1] - convergences[0])
    assert np.degrees(turn) < -4
    for known, photo in zip(CAMERAS, found.photos, strict=True):
        x, y, z = np.array(EAST_NORTH_UP) + known.centre
        assert np.abs(zone33.to_world(photo.pose.t) - [*to.transform(x, y), z]).max() < 1e-6
        c, s = np.cos(turn), np.sin(turn)
        expected = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]) @ known.axes.T
        assert np.abs(photo.pose.R - expected).max() < 2e-3  # the scales of the two grids differ by 0.2 %
        level = photo.pose.R[:2, 2] / np.hypot(*photo.pose.R[:2, 2])
        wanted = expected[:2, 2] / np.hypot(*expected[:2, 2])
        assert np.abs(level - wanted).max() < 1e-5, "a horizontal direction turns by the convergences alone"
    assert any("lengths in plan differ from heights by" in note for note in found.notes)
