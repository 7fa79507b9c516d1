"""Damaged and unusual files with poses: one sentence each, and never another exception."""

import json
import os
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from frontage.errors import FileError, InputError, UnsupportedFormat
from frontage.io.photos.interchange.calibration import VISIBLE_PX, Calibration
from frontage.io.photos.read import read_photos
from frontage.model import WorldRef
from io_files import picture
from pose_files import CAMERAS, metashape, opensfm, pictures, pix4d, realityscan, source

LOCAL = WorldRef(np.zeros(3, np.int64), None)
FILES: dict[str, Callable[[Path], Path]] = {
    "metashape": lambda folder: metashape(folder / "cameras.xml"),
    "opensfm": lambda folder: opensfm(folder / "reconstruction.json"),
    "pix4d": lambda folder: pix4d(folder),
    "pix4d cam": lambda folder: pix4d(folder, "cam"),
    "pix4d colmap": lambda folder: pix4d(folder, "colmap"),
    "realityscan": lambda folder: realityscan(folder / "cameras.csv"),
}
PER_PHOTO = "street_calibrated_camera_parameters.txt"
CAM = "street_pix4d_calibrated_internal_camera_parameters.cam"


def refused(tmp_path: Path, file: Path, message: str, kind: type[InputError] = FileError) -> None:
    with pytest.raises(kind) as e:
        read_photos(source(tmp_path, file), LOCAL)
    text = str(e.value)
    assert message in text, text
    assert "\n" not in text and "Traceback" not in text and 20 < len(text) < 600


# kind of file -> what is wrong -> (text, what stands there instead, words of the message)
CHANGES: dict[str, list[tuple[str, str, str]]] = {
    "metashape": [
        ("<document", "<project", "cameras.xml: not a readable Metashape camera file"),
        ("document>", "document", "not a readable Metashape camera file"),
        ("<document", '<!DOCTYPE d [<!ENTITY x SYSTEM "file:///etc/hostname">]><document', "document type"),
        ("<document", '<!DOCTYPE d [<!ENTITY a "b"><!ENTITY c "&a;&a;">]><document', "document type"),
        ('<sensor id="3"', '<sensor id="4"', "no sensor"),
        ('label="north"', "", "no label"),
        ("<f>50</f>", "", "focal length f"),
        ("<f>50</f>", "<f>nan</f>", "not finite"),
        ("<f>50</f>", "<f>-50</f>", "not positive"),
        ("<f>50</f>", "<f>1e12</f>", "beyond"),
        ("<f>50</f>", "<f>fifty</f>", "no number"),
        ("</f><cx>", "</f><k4>9e9</k4><cx>", "beyond"),
        ("</f><cx>", "</f><k4>0.5</k4><k3>9</k3><cx>", "k4"),
        ("</f><cx>", "</f><b2>0.2</b2><cx>", "b2 moves a corner of the picture by 0."),
        ("</f><cx>", "</f><p3>30</p3><cx>", "p3 and p4"),
        ('type="frame" class="adjusted"', 'type="rpc" class="adjusted"', "'rpc'"),
        ('type="frame" class="adjusted"', 'type="spherical" class="adjusted"', "panorama"),
        ('<resolution width="60"', '<resolution width="-60"', "size of a picture"),
        ('<resolution width="60"', '<resolution width="1e300"', "beyond"),
        ('<resolution width="60" height="40"/><calibration', "<calibration", "resolution"),
        ('width="60" height="40"/><f>50', 'width="61" height="40"/><f>50', "differ in size"),
        ("<transform>1.0 0.0", "<transform>1.0 0.5", "not a rotation"),
        ("<transform>1.0 0.0", "<transform>nan 0.0", "not finite"),
        ("<transform>1.0 0.0", "<transform>0.0", "16 numbers"),
        ("</chunk>", "<transform><scale>0</scale></transform></chunk>", "not positive"),
        ("</chunk>", "<transform><translation>1 2</translation></transform></chunk>", "3 numbers"),
        ("</chunk>", "<transform><scale>9e8</scale></transform></chunk>", "beyond"),
        ("</chunk>", "</chunk><chunk/>", "2 chunks"),
        ('label="east"', 'label="north"', "twice: north"),
        ('label="east"', 'label="west"', "not there: west"),
        ('label="east"', 'label="north.jpg"', "twice"),
    ],
    "opensfm": [
        ("[{", "{", "not a readable OpenSfM reconstruction"),
        ('"rotation": [', '"rotation": [NaN, ', "3 numbers"),
        ('"translation": [', '"translation": [1e400, 1, 1], "t": [', "not finite"),
        ('"translation": [', '"translation": [1e10, 1, 1], "t": [', "beyond"),
        ('"translation": [', '"translation": [true, 1, 1], "t": [', "no number"),
        ('"translation": [', '"translation": "nothing", "t": [', "3 numbers"),
        ('"projection_type": "brown"', '"projection_type": "dual"', "'dual'"),
        ('"projection_type": "brown"', '"projection_type": ["brown"]', "reconstruction.json"),
        ('"projection_type": "brown"', '"projection_type": "fisheye62", "k5": 0.1', "k5"),
        ('"projection_type": "brown"', '"projection_type": "spherical"', "panorama"),
        ('"focal_x": ', '"focal_q": ', "focal"),
        ('"focal_x": ', '"focal_x": -', "not positive"),
        ('"width": 60', '"width": 0', "size of a picture"),
        ('"width": 60', '"width": 60.5', "size of a picture"),
        ('"camera": "v2 some camera"', '"camera": "other"', "'other'"),
        ('"camera": "v2 some camera"', '"camera": {}', "reconstruction.json"),
        ('"shots": {', '"shots": [{', "reconstruction.json"),
        ('"points": {}', '"points": {}, "rig_cameras": {"a": {"rotation": []}}', "3 numbers"),
    ],
    "pix4d": [
        ("Omega Phi Kappa", "Phi Omega Kappa", "order phi, omega, kappa"),
        ("Omega", "Roll", "street_calibrated"),
        ("Omega Phi Kappa", "Omega[gon] Phi[rad] Kappa", "no common unit"),
        ("4.0 -9.0", "4.0 nan", "not finite"),
        ("4.0 -9.0", "4.0 1e10", "beyond"),
        ("4.0 -9.0", "4.0 4,5", "values instead of 7"),
        ("4.0 -9.0", "4.0", "values instead of 7"),
        (" 90 0 0", " 390 0 0", "beyond a full turn"),
        ("east.jpg", "west.jpg", "not there: west.jpg"),
    ],
    "realityscan": [
        (",heading", ",angle", "no row names"),
        (",30,", ",-30,", "not positive"),
        (",30,", ",nan,", "not finite"),
        (",30,", ",30,1,", "values instead of 16"),
        ("north.jpg,4.0", "north.jpg,4e10", "beyond"),
        (",0,0.0021", ",-9,0.0021", "folds the picture"),
        ("east.jpg", "west.jpg", "not there: west.jpg"),
        ("\nnorth.jpg", "\n", "no name"),
    ],
}  # fmt: skip


@pytest.mark.parametrize(("kind", "k"), [(kind, k) for kind in CHANGES for k in range(len(CHANGES[kind]))])
def test_a_damaged_file_is_refused_in_one_sentence(tmp_path: Path, kind: str, k: int) -> None:
    pictures(tmp_path / "pictures")
    file = FILES[kind](tmp_path)
    old, new, message = CHANGES[kind][k]
    text = file.read_text()
    assert old in text
    file.write_text(text.replace(old, new) if kind == "pix4d" or len(old) > 40 else text.replace(old, new, 1))
    if kind == "metashape" and old.startswith("<resolution width"):
        file.write_text(text.replace(old, new))
    refused(tmp_path, file, message)


def test_files_that_are_missing_empty_or_no_text(tmp_path: Path) -> None:
    pictures(tmp_path / "pictures")
    for name in ("none.xml", "none.json", "none.csv", "none.opk", "none"):
        refused(tmp_path, tmp_path / name, "no" if name != "none" else "holds no COLMAP model")
        (tmp_path / name).write_bytes(b"")
        refused(tmp_path, tmp_path / name, "empty" if name != "none" else "holds no COLMAP model")
        (tmp_path / name).write_bytes(b"\xff\xfe\x00\x01" * 50)
        refused(tmp_path, tmp_path / name, name)
        (tmp_path / name).unlink()
        (tmp_path / name).mkdir()
        refused(tmp_path, tmp_path / name, name)
    os.mkfifo(tmp_path / "pipe.csv")
    refused(tmp_path, tmp_path / "pipe.csv", "is a pipe")
    (tmp_path / "deep.json").write_text("[" * 100000)
    refused(tmp_path, tmp_path / "deep.json", "deep.json")
    (tmp_path / "open.json").write_text("[]")
    refused(tmp_path, tmp_path / "open.json", "no reconstructions")
    (tmp_path / "open.json").write_text('[{"cameras": {}, "shots": {}}]')
    refused(tmp_path, tmp_path / "open.json", "holds no shots")


def test_tables_without_cameras_say_what_to_add(tmp_path: Path) -> None:
    pictures(tmp_path / "pictures")
    table = pix4d(tmp_path, "none")
    refused(tmp_path, table, "states no cameras; put Pix4D's")
    for name in ("a", "b"):
        (tmp_path / f"{name}_calibrated_camera_parameters.txt").write_text("x")
    refused(tmp_path, table.rename(tmp_path / "t.csv"), "several files")


@pytest.mark.parametrize(
    ("kind", "name", "old", "new", "message"),
    [
        ("pix4d", PER_PHOTO, "camera model", "model", "no header"),
        ("pix4d", PER_PHOTO, "51 0 31.5\n", "", "10 lines"),
        ("pix4d", PER_PHOTO, "51 0 31.5", "51 2 31.5", "skew"),
        ("pix4d", PER_PHOTO, "51 0 31.5", "inf 0 31.5", "not finite"),
        ("pix4d", PER_PHOTO, "north.jpg 60", "south.jpg 60", "no camera for photo"),
        ("pix4d", PER_PHOTO, "60 40", "60", "no number"),
        ("pix4d cam", CAM, "12.0x8.0mm", "mm", "sensor width"),
        ("pix4d cam", CAM, "12.0x8.0mm", "0x8.0mm", "positive"),
        ("pix4d cam", CAM, "12.0x8.0mm", "8.0x12.0mm", "shape"),
        ("pix4d cam", CAM, "F 10.0", "F 10.0\nF 9", "one camera"),
        ("pix4d cam", CAM, "T2", "T3", "T2"),
        ("pix4d cam", CAM, "Px 6.3", "Px nan", "not finite"),
        ("pix4d colmap", "cameras.txt", "FULL_OPENCV", "NEW_MODEL", "NEW_MODEL"),
        ("pix4d colmap", "cameras.txt", "51 50", "51", "parameters"),
        ("pix4d colmap", "cameras.txt", "1 FULL", "# FULL", "no cameras"),
        ("pix4d colmap", "cameras.txt", "60 40", "6 4", "60 x 40 px but its camera is 6 x 4"),
    ],
)  # fmt: skip
def test_damaged_cameras_beside_a_table(
    tmp_path: Path, kind: str, name: str, old: str, new: str, message: str
) -> None:
    pictures(tmp_path / "pictures")
    table, file = FILES[kind](tmp_path), tmp_path / name
    text = file.read_text()
    assert old in text
    file.write_text(text.replace(old, new))
    refused(tmp_path, table, message)


def test_several_cameras_of_one_size_need_a_column(tmp_path: Path) -> None:
    pictures(tmp_path / "pictures")
    table = pix4d(tmp_path, "colmap")
    with (tmp_path / "cameras.txt").open("a") as file:
        file.write("2 PINHOLE 60 40 44 44 30 20\n")
    refused(tmp_path, table, "2 cameras of the size of photo north.jpg")
    rows = table.read_text().splitlines()
    table.write_text(
        "\n".join([rows[0] + " camera", *(f"{row} {1 + k % 2}" for k, row in enumerate(rows[1:]))])
    )
    found = read_photos(source(tmp_path, table), LOCAL)
    assert [p.camera.model for p in found.photos] == ["FULL_OPENCV", "PINHOLE", "FULL_OPENCV"]
    table.write_text(table.read_text().replace("90 0 0 1", "90 0 0 5"))
    refused(tmp_path, table, "camera 5")


def test_a_quarter_turn_is_refused_where_the_file_states_no_size(tmp_path: Path) -> None:
    pictures(tmp_path / "pictures")
    (tmp_path / "pictures" / "east.jpg").write_bytes(picture(60, 40, 6))
    refused(tmp_path, realityscan(tmp_path / "c.csv"), "EXIF orientation that turns it")
    refused(tmp_path, pix4d(tmp_path / "t"), "EXIF orientation that turns it")
    assert len(read_photos(source(tmp_path, metashape(tmp_path / "c.xml")), LOCAL).photos) == 3


def test_a_real_distortion_with_k4_stays_within_a_twentieth_of_a_pixel() -> None:
    # A drone camera (a test file of geograypher), whose polynomial folds close beyond the corners.
    k, f, size = (-0.0919367147, -0.0762807468, 0.1162639394, -0.0761413904), 3705.4728792737214, (5280, 3956)
    drone = Calibration("frame", *size, (f, f), (size[0] / 2, size[1] / 2), k)
    camera, (note,) = drone.camera()
    assert camera.model == "FULL_OPENCV" and "k4" in note
    r = np.linspace(0, 1.05, 500)[:, None] * [0.8, 0.6]
    q = (r**2).sum(1)
    expected = f * r * (1 + k[0] * q + k[1] * q**2 + k[2] * q**3 + k[3] * q**4)[:, None] + np.array(size) / 2
    inside = (expected <= size).all(1)
    assert inside.sum() > 450
    seen = camera.project(np.column_stack([r, np.ones(len(r))]))
    assert 0.001 < np.abs(seen - expected)[inside].max() < VISIBLE_PX


def test_cameras_that_are_not_used_are_counted(tmp_path: Path) -> None:
    pictures(tmp_path / "pictures")
    file = metashape(tmp_path / "c.xml")
    more = (
        '<camera id="7" sensor_id="3" label="x"/><camera id="8" sensor_id="3" label="y" enabled="false">'
        '<transform/></camera><camera id="9" sensor_id="3" label="z" master_id="7"/></cameras>'
    )
    file.write_text(file.read_text().replace("</cameras>", more))
    found = read_photos(source(tmp_path, file), LOCAL)
    assert len(found.photos) == 3
    assert found.notes == (
        "c.xml: 1 cameras are not aligned and were left out",
        "c.xml: 1 cameras are disabled and were left out",
        "c.xml: 1 cameras belong to a rig without poses of their own and were left out",
    )
    file.write_text(file.read_text().replace('sensor_id="3"', 'sensor_id="3" enabled="0"', 3))
    refused(tmp_path, file, "holds no aligned cameras")


def test_what_no_model_has_is_ignored_only_where_it_cannot_be_seen(tmp_path: Path) -> None:
    pictures(tmp_path / "pictures")
    small = "<f>50</f><k1>-0.1</k1><k2>0.02</k2><k4>-0.002</k4><b2>0.05</b2>"
    found = read_photos(source(tmp_path, metashape(tmp_path / "c.xml", calibration=small)), LOCAL)
    (note,) = found.notes
    assert "the distortion term k4 was replaced by a quotient that is within" in note
    camera = found.photos[0].camera
    xy = np.stack(np.meshgrid(np.linspace(-0.55, 0.55, 23), np.linspace(-0.36, 0.36, 15)), -1).reshape(-1, 2)
    q = (xy**2).sum(1)[:, None]
    expected = 50 * xy * (1 - 0.1 * q + 0.02 * q**2 - 0.002 * q**4) + [30, 20]
    seen = camera.project(np.column_stack([xy, np.ones(len(xy))]))
    assert 0 < np.abs(seen - expected).max() < 0.05
    large = small.replace("0.05", "0.2")
    refused(tmp_path, metashape(tmp_path / "d.xml", calibration=large), "b2 moves", UnsupportedFormat)


@pytest.mark.parametrize("kind", FILES)
def test_a_file_cut_anywhere_is_refused_or_read(tmp_path: Path, kind: str) -> None:
    pictures(tmp_path / "pictures")
    table = FILES[kind](tmp_path)
    outcomes = set()
    for file in sorted(p for p in tmp_path.iterdir() if p.is_file()):
        whole = file.read_bytes()
        for keep in range(0, len(whole), max(1, len(whole) // 150)):
            file.write_bytes(whole[:keep])
            outcomes.add(_outcome(tmp_path, table))
        file.write_bytes(whole)
    assert "refused" in outcomes
    assert _outcome(tmp_path, table) == "read"


@pytest.mark.parametrize("kind", FILES)
def test_a_file_with_other_bytes_is_refused_or_read(tmp_path: Path, kind: str) -> None:
    pictures(tmp_path / "pictures")
    table = FILES[kind](tmp_path)
    rng = np.random.default_rng(11)
    for file in sorted(p for p in tmp_path.iterdir() if p.is_file()):
        whole = file.read_bytes()
        for _ in range(150):
            damaged = bytearray(whole)
            for at in rng.integers(0, len(whole), rng.integers(1, 4)):
                damaged[at] = rng.choice(list(b'0919e-. ,\n\t<>"[]{}#/\x00\xff'))
            file.write_bytes(damaged)
            _outcome(tmp_path, table)
        file.write_bytes(whole)


def _outcome(tmp_path: Path, table: Path) -> str:
    """Whether reading is "refused", in one line, or gives usable photos; another exception fails the test."""
    try:
        found = read_photos(source(tmp_path, table), LOCAL)
    except InputError as problem:
        assert "\n" not in str(problem) and len(str(problem)) < 700
        return "refused"
    assert 0 < len(found.photos) <= len(CAMERAS)
    for photo in found.photos:
        assert np.isfinite(photo.pose.matrix).all() and np.isfinite(photo.camera.params).all()
    return "read"


def test_a_colmap_model_in_the_folder_wins(tmp_path: Path) -> None:
    pictures(tmp_path / "pictures", ["a.jpg"])
    opensfm(tmp_path / "both" / "reconstruction.json")
    (tmp_path / "both" / "cameras.txt").write_text("1 PINHOLE 60 40 50 50 30 20\n")
    (tmp_path / "both" / "images.txt").write_text("1 1 0 0 0 0 0 0 1 a.jpg\n\n")
    assert read_photos(source(tmp_path, tmp_path / "both"), LOCAL).photos[0].id == "a.jpg"


def test_projected_coordinates_of_opensfm_are_taken_as_they_are(tmp_path: Path) -> None:
    pictures(tmp_path / "pictures")
    file = opensfm(tmp_path / "reconstruction.geocoords.json")
    parts = json.loads(file.read_text())
    parts[0]["reference_lla"] = {"latitude": 48.0, "longitude": 11.0, "altitude": 400.0}
    file.write_text(json.dumps(parts))
    found = read_photos(source(tmp_path, file), WorldRef(np.zeros(3), "EPSG:25832"))
    assert np.abs(found.photos[0].pose.t - CAMERAS[0].centre).max() < 1e-12
    assert any("projected already" in note for note in found.notes)
