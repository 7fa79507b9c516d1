"""Picture files alone: cameras and approximate poses from what the camera noted."""

from pathlib import Path

import numpy as np
import pytest
from pyproj import Transformer

from frontage.errors import FrontageError
from frontage.io.photos.exif import Exif, write_jpeg
from frontage.io.photos.photoset import PhotoSet
from frontage.io.photos.read import PhotoSource, read_photos
from frontage.model import WorldRef

ORIGIN = np.array([500000, 5400000, 400])  # on the central meridian, where grid north is true north
WORLD = WorldRef(ORIGIN, "EPSG:25832")
WIDTH, HEIGHT = 64, 48
UPRIGHT, TURNED = (b"\x12\x01\x03\x00\x01\x00\x00\x00" + bytes([n, 0]) for n in (1, 6))


def gps(east: float = 12.5, north: float = -7.25, up: float = 3.0) -> tuple[float, float, float]:
    """Latitude, longitude and height of a local position."""
    x, y = ORIGIN[0] + east, ORIGIN[1] + north
    longitude, latitude = Transformer.from_crs("EPSG:25832", "EPSG:4326", always_xy=True).transform(x, y)
    return float(latitude), float(longitude), float(ORIGIN[2] + up)


def shot(
    folder: Path, name: str = "a.jpg", *, orientation: int = 1, focal: int = 24, **known: object
) -> Path:
    """A JPEG with a bright corner to the upper left of its stored pixels."""
    pixels = np.full((HEIGHT, WIDTH, 3), 60, np.uint8)
    pixels[:16, :16] = 240
    path = write_jpeg(folder / name, pixels, Exif("maker", "phone", 4.2, focal, **known))  # type: ignore[arg-type]
    if orientation == 6:
        data = path.read_bytes()
        assert data.count(UPRIGHT) == 1
        path.write_bytes(data.replace(UPRIGHT, TURNED))
    return path


def read(folder: Path, pose: str = "approximate", world: WorldRef = WORLD, **more: object) -> PhotoSet:
    return read_photos(PhotoSource(path=str(folder), pose=pose, **more), world)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("heading", "ahead"),
    [(0.0, (0, 1, 0)), (90.0, (1, 0, 0)), (200.0, (-np.sin(np.pi / 9), -np.cos(np.pi / 9), 0))],
)
def test_gps_and_compass_give_the_pose(tmp_path: Path, heading: float, ahead: tuple[float, ...]) -> None:
    shot(tmp_path, position=gps(), heading=heading, position_error=3.0)
    (photo,) = read(tmp_path, sigma_position=8.0, sigma_angle=6.0).photos
    assert photo.id == "a.jpg"
    assert photo.pose.t == pytest.approx((12.5, -7.25, 3.0), abs=2e-3)
    assert photo.pose.R[:, 2] == pytest.approx(ahead, abs=1e-5)
    assert photo.pose.R[:, 1] == pytest.approx((0, 0, -1), abs=1e-5)
    assert photo.local_from_camera is not None
    sigma = photo.local_from_camera.sigma
    assert sigma[:2] == pytest.approx(3.0)  # what the file states counts before what the project says
    assert sigma[2] >= 10.0 and np.degrees(sigma[5]) == pytest.approx(6.0)
    assert (np.degrees(sigma[3:5]) > 10.0).all()


def test_the_compass_counts_from_true_north(tmp_path: Path) -> None:
    latitude, longitude = 48.7, 11.0  # two degrees east of the central meridian
    shot(tmp_path, position=(latitude, longitude, 400.0), heading=0.0)
    world = WorldRef(np.array([647000, 5396000, 400]), "EPSG:25832")
    (photo,) = read(tmp_path, world=world).photos
    ahead = photo.pose.R[:, 2]
    convergence = 2.0 * np.sin(np.radians(latitude))
    assert np.degrees(np.arctan2(ahead[0], ahead[1])) == pytest.approx(-convergence, abs=0.01)


def test_without_a_compass_the_heading_is_open(tmp_path: Path) -> None:
    shot(tmp_path, position=gps())
    (photo,) = read(tmp_path, sigma_position=4.0).photos
    assert photo.local_from_camera is not None
    sigma = photo.local_from_camera.sigma
    assert sigma[5] >= 3.0 and sigma[:2] == pytest.approx(4.0)


def test_without_gps_there_is_no_pose(tmp_path: Path) -> None:
    shot(tmp_path, heading=30.0)
    found = read(tmp_path)
    (photo,) = found.photos
    assert photo.local_from_camera is None
    assert found.camera_sigmas["a.jpg"][0] > 0


def test_poses_that_are_not_wanted_are_left_out(tmp_path: Path) -> None:
    shot(tmp_path, position=gps(), heading=30.0)
    assert read(tmp_path, pose="none").photos[0].local_from_camera is None


def test_the_focal_length_is_that_of_the_film(tmp_path: Path) -> None:
    shot(tmp_path, "stated.jpg", focal=27)
    shot(tmp_path, "unknown.jpg", focal=0)
    found = read(tmp_path)
    stated, unknown = (p.camera for p in found.photos)
    assert (stated.model, stated.width, stated.height) == ("OPENCV", WIDTH, HEIGHT)
    assert stated.params[:4] == pytest.approx((27 / 36 * WIDTH,) * 2 + (WIDTH / 2, HEIGHT / 2))
    assert not stated.params[4:].any()
    assert 0.5 * WIDTH < unknown.params[0] < 1.5 * WIDTH
    sure, unsure = (found.camera_sigmas[name][0] for name in ("stated.jpg", "unknown.jpg"))
    assert 0 < sure < 0.1 * WIDTH and unsure > 5 * sure
    assert all((s > 0).all() and s.shape == (8,) for s in found.camera_sigmas.values())


def test_a_picture_on_its_side_is_turned_upright(tmp_path: Path) -> None:
    shot(tmp_path, orientation=6, position=gps(), heading=0.0)
    found = read(tmp_path)
    (photo,) = found.photos
    assert (photo.camera.width, photo.camera.height) == (HEIGHT, WIDTH)
    assert photo.camera.params[:4] == pytest.approx((24 / 36 * WIDTH,) * 2 + (HEIGHT / 2, WIDTH / 2))
    image = found.image("a.jpg")
    assert image.shape == (WIDTH, HEIGHT, 3)
    assert image[:12, -12:].mean() > 200 and image[:12, :12].mean() < 100  # turned to the right by a quarter
    assert photo.pose.R[:, 1] == pytest.approx((0, 0, -1), abs=1e-5)


def test_equal_names_in_two_folders_are_told_apart(tmp_path: Path) -> None:
    for folder in ("left", "right"):
        (tmp_path / folder).mkdir()
        shot(tmp_path / folder)
    assert [p.id for p in read(tmp_path).photos] == ["left/a.jpg", "right/a.jpg"]


def test_trusted_poses_need_cameras(tmp_path: Path) -> None:
    shot(tmp_path, position=gps(), heading=0.0)
    with pytest.raises(FrontageError) as caught:
        read(tmp_path, pose="trusted")
    assert caught.value.code == "I111"
    assert "cameras" in str(caught.value)


def test_gps_needs_a_crs(tmp_path: Path) -> None:
    shot(tmp_path, position=gps(), heading=0.0)
    with pytest.raises(FrontageError, match="CRS"):
        read(tmp_path, world=WorldRef(ORIGIN))
    assert len(read(tmp_path, pose="none", world=WorldRef(ORIGIN)).photos) == 1
