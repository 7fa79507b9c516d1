"""Poses written in every format come back: to 1e-9 m and 1e-9 rad, with cameras that project alike."""

import json
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from frontage.errors import FileError, InputError
from frontage.geometry.rigid import Rigid3, rotation_angle
from frontage.io.colmap import read_colmap
from frontage.io.colmapwrite import Tracks, write_colmap
from frontage.io.photos.photoset import PhotoSet
from frontage.io.photos.read import PhotoSource, read_photos
from frontage.io.photos.write import WRITERS, write_poses
from frontage.io.scans.read import read_scans
from frontage.model import Camera, Estimate, Photo, WorldRef
from frontage.pipeline.project import found_offset
from pose_files import HEIGHT, WIDTH, pictures

LOCAL = WorldRef(np.zeros(3, np.int64), None)
UTM = WorldRef(np.array([676000, 5403000, 400]), "EPSG:25832")
FILES = {
    "colmap": "model",
    "metashape": "c.xml",
    "opensfm": "r.json",
    "opk": "t.csv",
    "realityscan": "rs.csv",
}
MODELS = {
    "SIMPLE_PINHOLE": [50, 31, 19.5],
    "PINHOLE": [51, 50, 31, 19.5],
    "SIMPLE_RADIAL": [50, 31, 19.5, -0.1],
    "RADIAL": [50, 31, 19.5, -0.1, 0.03],
    "OPENCV": [51, 50, 31, 19.5, -0.1, 0.03, 2e-3, -3e-3],
    "FULL_OPENCV": [50, 50, 31, 19.5, -0.1, 0.03, 2e-3, -3e-3, -0.01, 0, 0, 0],
    "SIMPLE_FISHEYE": [40, 31, 19.5],
    "FISHEYE": [41, 40, 31, 19.5],
    "SIMPLE_RADIAL_FISHEYE": [40, 31, 19.5, -0.02],
    "RADIAL_FISHEYE": [40, 31, 19.5, -0.02, 0.003],
    "OPENCV_FISHEYE": [41, 40, 31, 19.5, -0.02, 0.003, 1e-3, -1e-4],
    "THIN_PRISM_FISHEYE": [41, 40, 31, 19.5, -0.02, 0.003, 2e-3, -3e-3, 1e-3, -1e-4, 0, 0],
}
FRAMES = ("SIMPLE_PINHOLE", "SIMPLE_RADIAL", "RADIAL", "FULL_OPENCV")  # those with one focal length above
REFUSED = {
    "FULL_OPENCV": [50, 50, 31, 19.5, -0.1, 0.03, 0, 0, 0, 0.01, 0, 0],
    "THIN_PRISM_FISHEYE": [41, 40, 31, 19.5, 0, 0, 0, 0, 0, 0, 1e-3, 0],
    "FOV": [51, 50, 31, 19.5, 0.9],
    "DIVISION": [51, 50, 31, 19.5, -0.1],
    "EQUIRECTANGULAR": [70, 35],
}


def camera(model: str, params: list[float]) -> Camera:
    return Camera(model, WIDTH, HEIGHT, np.array(params, np.float64))


def rotations() -> list[np.ndarray]:
    """Rotations of all kinds, with the directions in which angles are degenerate."""
    level = [[1, 0, 0], [0, 0, 1], [0, -1, 0]]  # looks north: columns right, down, forward
    exact = [Rotation.from_euler("z", a, degrees=True).as_matrix() @ level for a in (0, 90, 180, -90, 45)]
    near = [Rotation.from_rotvec([0, 1e-9 * k, 3e-9]).as_matrix() @ exact[1] for k in (1, 2)]
    down = [np.diag([1.0, -1, -1]), np.diag([-1.0, 1, -1]), np.eye(3)]
    return [*exact, *near, *down, *Rotation.random(6, random_state=3).as_matrix()]


def photos(cameras: list[Camera]) -> list[Photo]:
    rng = np.random.default_rng(5)
    return [
        Photo(
            f"street {k % 2}/IMG {k}, b.jpg",
            cameras[k % len(cameras)],
            Estimate(Rigid3("local", "camera", R, rng.uniform(-80, 80, 3)), np.zeros((6, 6)), 0.0),
        )
        for k, R in enumerate(rotations())
    ]


def back(tmp_path: Path, format: str, given: list[Photo], world: WorldRef) -> PhotoSet:
    """The photos written in a format and read again."""
    pictures(tmp_path / "pictures", [photo.id for photo in given])
    path = write_poses(tmp_path / FILES[format], given, world, format)
    table = found_offset({"path": str(tmp_path / "pictures"), "cameras": str(path)})
    return read_photos(PhotoSource.model_validate(table), world)


def same(given: list[Photo], found: PhotoSet, metres: float = 1e-9, radians: float = 1e-9) -> None:
    assert [photo.id for photo in found.photos] == [photo.id for photo in given]
    rays = np.array([[0.1, 0.2, 1], [-0.5, 0.3, 1], [0.4, -0.3, 1.2]])
    for a, b in zip(given, found.photos, strict=True):
        assert np.abs(a.pose.t - b.pose.t).max() <= metres
        assert rotation_angle(a.pose.R @ b.pose.R.T) <= radians
        seen = a.camera.project(rays)
        assert np.isfinite(seen).all() and np.abs(seen - b.camera.project(rays)).max() < 1e-9


@pytest.mark.parametrize("format", WRITERS)
def test_local_poses_come_back(tmp_path: Path, format: str) -> None:
    kinds = [m for m in MODELS if format != "realityscan" or m in FRAMES]
    given = photos([camera(m, MODELS[m]) for m in kinds])
    same(given, back(tmp_path, format, given, LOCAL))


@pytest.mark.parametrize("format", WRITERS)
def test_poses_in_a_projected_world_come_back(tmp_path: Path, format: str) -> None:
    given = photos([camera("SIMPLE_RADIAL", MODELS["SIMPLE_RADIAL"])])
    world = UTM if format != "opensfm" else WorldRef(UTM.origin, "EPSG:32632")
    # Coordinates of millions of metres have steps of 1e-9 m, and PROJ's own rounding is of that size.
    same(given, back(tmp_path, format, given, world), metres=2e-8, radians=1e-9)


def test_a_panorama_is_written_where_it_can_be(tmp_path: Path) -> None:
    sphere = Camera("EQUIRECTANGULAR", 80, 40, np.array([80.0, 40.0]))
    given = photos([sphere])[:1]
    for format in ("metashape", "opensfm"):
        path = write_poses(tmp_path / FILES[format], given, LOCAL, format)
        text = path.read_text()
        assert "spherical" in text
    with pytest.raises(InputError, match="frame camera with one focal length"):
        write_poses(tmp_path / "p.csv", given, LOCAL, "realityscan")


@pytest.mark.parametrize("format", ["metashape", "opensfm", "realityscan"])
@pytest.mark.parametrize("model", REFUSED)
def test_a_camera_that_a_format_cannot_express_is_refused(tmp_path: Path, format: str, model: str) -> None:
    given = photos([camera(model, REFUSED[model])])
    with pytest.raises(InputError, match="write a COLMAP model") as e:
        write_poses(tmp_path / FILES[format], given, LOCAL, format)
    assert "\n" not in str(e.value) and not list(tmp_path.iterdir())


def test_two_focal_lengths_and_fisheyes_are_refused_for_realityscan(tmp_path: Path) -> None:
    for model in ("PINHOLE", "OPENCV_FISHEYE"):
        with pytest.raises(InputError, match="one focal length"):
            write_poses(tmp_path / "x.csv", photos([camera(model, MODELS[model])]), LOCAL, "realityscan")


def test_what_cannot_be_written_is_told(tmp_path: Path) -> None:
    given = photos([camera("PINHOLE", MODELS["PINHOLE"])])
    for wrong, message in (
        ([], "no photos"),
        ([Photo("a.jpg", given[0].camera)], "no pose"),
        ([given[0], given[0]], "twice"),
        ([Photo("a\n.jpg", given[0].camera, given[0].local_from_camera)], "no name that can be written"),
    ):
        with pytest.raises(InputError, match=message):
            write_poses(tmp_path / "x.xml", wrong, LOCAL, "metashape")
    with pytest.raises(InputError, match="use one of colmap, metashape"):
        write_poses(tmp_path / "x", given, LOCAL, "bundler")
    with pytest.raises(FileError, match="name the table otherwise"):
        write_poses(tmp_path / "cameras.txt", given, LOCAL, "opk")
    (tmp_path / "file").write_text("x")
    for format in WRITERS:
        with pytest.raises(FileError, match="cannot be written"):
            write_poses(tmp_path / "file" / FILES[format], given[:1], LOCAL, format) if (
                format != "realityscan"
            ) else write_poses(
                tmp_path / "file" / "x.csv", photos([camera("RADIAL", MODELS["RADIAL"])]), LOCAL, format
            )


def test_the_same_photos_give_the_same_bytes(tmp_path: Path) -> None:
    given = photos([camera("RADIAL", MODELS["RADIAL"])])
    for format, name in FILES.items():
        first, second = (write_poses(tmp_path / folder / name, given, LOCAL, format) for folder in ("a", "b"))
        if first.is_file():
            assert first.read_bytes() == second.read_bytes()


def test_opensfm_keeps_the_names_and_axes_that_others_read(tmp_path: Path) -> None:
    given = photos([camera("OPENCV", MODELS["OPENCV"])])[:1]
    (part,) = json.loads(write_poses(tmp_path / "r.json", given, LOCAL, "opensfm").read_text())
    (name, shot), (key, lens) = *part["shots"].items(), *part["cameras"].items()
    assert name == given[0].id and shot["camera"] == key and lens["projection_type"] == "brown"
    assert shot["rotation"] == pytest.approx([np.pi / 2, 0, 0])  # x right stays, y down becomes -z
    assert lens["c_x"] == pytest.approx(1 / 60) and lens["c_y"] == pytest.approx(-0.5 / 60)


def test_points_and_tracks_of_a_colmap_model_come_back(tmp_path: Path) -> None:
    given = photos([camera("PINHOLE", MODELS["PINHOLE"])])[:3]
    points = np.array([[1.5, 2.25, 3.125], [4, 5, 6], [7, 8, 1 / 3]])
    tracks = Tracks(
        np.array([0, 2, 0, 1, 2]),
        np.array([1, 0, 0, 0, 2]),
        np.array([[1.5, 2.5], [3, 4], [5, 6], [7, 8], [9, 1 / 7]]),
    )
    folder = write_colmap(tmp_path / "m", given, np.zeros(3), points, tracks)
    images = (folder / "images.txt").read_text().splitlines()
    assert images[1] == "3.0 4.0 3 5.0 6.0 1 7.0 8.0 2" and images[3] == "1.5 2.5 1"
    rows = [line.split() for line in (folder / "points3D.txt").read_text().splitlines()]
    assert [float(v) for row in rows for v in row[1:4]] == points.ravel().tolist()
    assert [row[4:8] for row in rows] == [["0", "0", "0", "-1.0"]] * 3
    assert rows[0][8:] == ["2", "0", "1", "1"]
    assert rows[1][8:] == ["1", "2"] and rows[2][8:] == ["1", "0", "3", "0"]
    for row in rows:  # every track names the observation that names the point
        for photo, k in zip(row[8::2], row[9::2], strict=True):
            assert images[2 * int(photo) - 1].split()[3 * int(k) + 2] == row[0]
    assert len(read_colmap(folder).images) == 3
    (scan,) = read_scans(folder)
    assert np.abs(scan.world.to_world(scan.xyz) - points).max() < 1e-12
    for wrong in (Tracks([3], [0], [[1.0, 1]]), Tracks([0], [3], [[1.0, 1]]), Tracks([-1], [0], [[1.0, 1]])):  # type: ignore[arg-type]
        with pytest.raises(ValueError, match="not there"):
            write_colmap(tmp_path / "n", given, np.zeros(3), points, wrong)
