"""One point through every frame of docs/conventions.md, with numbers worked out by hand.

The street runs north (azimuth 90 degrees), the house stands to the west of it, so the facade looks east.
"""

import numpy as np
import pytest

from frontage.geometry.plane import facade_axes
from frontage.geometry.rigid import Rigid3
from frontage.model import Camera, Estimate, Facade, OrthoImage, Photo, WorldRef

WORLD = WorldRef(np.array([691_000, 5_334_000, 520]), "EPSG:25832")
POINT = np.array(
    [691_000.25, 5_334_002.0, 523.0]
)  # 2 m to the right of the origin, 3 m up, 25 cm before the wall
LOCAL = np.array([0.25, 2.0, 3.0])
FACADE = np.array([2.0, -0.25, 3.0])

# Who stands in the east and looks west has north on the right hand: X = north, Y = west, Z = up.
LOCAL_FROM_FACADE = Rigid3(
    "local", "facade", np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]), np.zeros(3)
)


@pytest.fixture
def facade() -> Facade:
    outline = np.array([[-1.0, -1.0], [4.0, -1.0], [4.0, 5.0], [-1.0, 5.0]])
    return Facade(
        "B01/F1", "B01", Estimate(LOCAL_FROM_FACADE, np.eye(6) * 1e-6, 10.0), WORLD, outline, (),
        np.zeros(0, int), np.zeros(0, int), 0.005, 0.02, 1.0, "rays",
    )  # fmt: skip


@pytest.fixture
def photo() -> Photo:
    """10 m east of the wall at the point's height, facing it: x right = north, y down, z west."""
    R = np.column_stack([[0, 1.0, 0], [0, 0, -1.0], [-1.0, 0, 0]])
    pose = Rigid3("local", "camera", R, np.array([10.25, 0.0, 3.0]))
    return Photo(
        "a.jpg",
        Camera("PINHOLE", 1000, 800, np.array([1000.0, 1000, 500, 400])),
        Estimate(pose, np.eye(6), 1.0),
    )


def test_world_and_local_differ_by_whole_metres() -> None:
    np.testing.assert_array_equal(WORLD.to_local(POINT), LOCAL)
    np.testing.assert_array_equal(WORLD.to_world(LOCAL), POINT)


def test_facade_frame_is_right_handed_x_right_y_inward_z_up(facade: Facade) -> None:
    np.testing.assert_allclose(facade.frame.inverse.apply(LOCAL[None])[0], FACADE, atol=1e-12)
    X, Y, Z = facade.frame.R.T
    np.testing.assert_allclose(np.cross(X, Y), Z, atol=1e-12)
    looking = -np.array([1.0, 0, 0])  # from the street (east) to the wall
    np.testing.assert_allclose(np.cross(looking, [0, 0, 1.0]), X, atol=1e-12)  # right hand of who looks at it
    assert Y @ looking > 0  # y grows into the building


def test_facade_axes_of_the_street_are_those_worked_out_by_hand() -> None:
    """The wall leans back by 3-4-5: its inward normal points west and down, its upward axis up and west."""
    np.testing.assert_allclose(facade_axes(np.array([-2.0, 0, 0])), LOCAL_FROM_FACADE.R, atol=1e-12)
    leaning = [[0, -0.8, -0.6], [1, 0, 0], [0, -0.6, 0.8]]
    np.testing.assert_allclose(facade_axes(np.array([-0.8, 0, -0.6])), leaning, atol=1e-12)


@pytest.mark.parametrize("azimuth_deg", [0, 37, 90, 180, 251, 359])
@pytest.mark.parametrize("zenith_deg", [90, 75, 100])
def test_facade_axes_follow_paper_a_from_azimuth_and_zenith(azimuth_deg: int, zenith_deg: int) -> None:
    """Paper A eq. 2-4: the axes from the azimuth phi and the zenith angle psi of the inward normal."""
    phi, psi = np.radians([azimuth_deg, zenith_deg])
    X = (np.sin(phi), -np.cos(phi), 0)
    Y = (np.cos(phi) * np.sin(psi), np.sin(phi) * np.sin(psi), np.cos(psi))
    Z = (-np.cos(phi) * np.cos(psi), -np.sin(phi) * np.cos(psi), np.sin(psi))
    np.testing.assert_allclose(facade_axes(2.5 * np.array(Y)), np.column_stack([X, Y, Z]), atol=1e-12)


@pytest.mark.parametrize("normal", [[0.0, 0.0, 1.0], [0.0, 0.0, 0.0], [np.nan, 0.0, 0.0]])
def test_facade_axes_refuse_a_plane_without_a_direction_to_the_right(normal: list[float]) -> None:
    with pytest.raises(ValueError, match="horizontal"):
        facade_axes(np.array(normal))


def test_scanner_frame_is_a_rigid_motion_away() -> None:
    local_from_scanner = Rigid3("local", "scanner", np.eye(3), np.array([8.0, 1.0, 1.7]))
    np.testing.assert_allclose(
        local_from_scanner.inverse.apply(LOCAL[None])[0], [-7.75, 1.0, 1.3], atol=1e-12
    )


def test_camera_looks_along_z_with_x_right_and_y_down(photo: Photo) -> None:
    np.testing.assert_allclose(photo.pose.inverse.apply(LOCAL[None])[0], [2.0, 0.0, 10.0], atol=1e-12)
    np.testing.assert_allclose(
        photo.project(LOCAL[None])[0], [700.0, 400.0], atol=1e-9
    )  # 500 + 1000 * 2 / 10
    higher = photo.project(LOCAL[None] + [0, 0, 1.0])[0]
    assert higher[1] < 400  # rows count downwards
    origin, ray = photo.ray(np.array([[700.0, 400.0]]))
    np.testing.assert_allclose(origin + ray[0] * np.linalg.norm(LOCAL - origin), LOCAL, atol=1e-9)


def test_frames_that_do_not_meet_are_refused(photo: Photo, facade: Facade) -> None:
    camera_from_facade = photo.pose.inverse @ facade.frame
    assert (camera_from_facade.to, camera_from_facade.frm) == ("camera", "facade")
    with pytest.raises(ValueError, match="do not meet"):
        facade.frame @ photo.pose


def test_ortho_columns_run_right_and_rows_run_down(facade: Facade) -> None:
    gsd, shape = 0.01, (600, 500)
    depth = np.full(shape, np.nan, np.float32)
    depth[200, 300] = -0.25  # the pixel that holds the point
    ortho = OrthoImage(
        np.zeros((*shape, 4), np.uint8), gsd, (-1.0, 5.0), facade, depth, np.zeros(shape, np.uint16), (),
        np.full(shape, np.nan, np.float32),
    )  # fmt: skip
    pixel, y = ortho.pixel_from_local(LOCAL[None])
    np.testing.assert_allclose(pixel[0], [300.0, 200.0], atol=1e-9)  # (2 - -1) / gsd, (5 - 3) / gsd
    assert y[0] == pytest.approx(-0.25)
    centre, used = ortho.local_from_pixel(np.array([[300.5, 200.5]]))
    np.testing.assert_allclose(WORLD.to_world(centre[0]), POINT + np.array([0, 0.005, -0.005]), atol=1e-7)
    assert used[0]
    plane, used = ortho.local_from_pixel(np.array([[300.5, 200.5]]), relief=False)
    assert plane[0, 0] == 0.0 and not used[0]
