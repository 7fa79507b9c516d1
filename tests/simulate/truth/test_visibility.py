"""Visible shares of openings, on a wall whose shadows can be computed by hand."""

import numpy as np
import pytest

from frontage.geometry.rigid import Rigid3
from frontage.geometry.ring import rectangle
from frontage.model import Camera, Estimate, Photo, WorldRef
from frontage.simulate.optics.rays import Tracer
from frontage.simulate.scene import FacadePlan, House, OpeningPlan, Part, Scene, SceneMesh, SceneSurface
from frontage.simulate.truth.visibility import ScannerView, Shares, visibility


def opening(name: str, x: float) -> OpeningPlan:
    ring = rectangle(x, 1.0, x + 1.0, 2.0)
    return OpeningPlan(name, "window", "rectangle", ring, 0.0, 0.15, (), "none", True, 0.2, 0.07)


def quad(x0: float, x1: float, y: float, z0: float, z1: float) -> np.ndarray:
    return np.array([[x0, y, z0], [x1, y, z0], [x1, y, z1], [x0, y, z1]])


def wall(*before: tuple[np.ndarray, tuple[int, int, int]]) -> Scene:
    """A wall of 20 x 4 m at y = 0 with windows at x = 2 and 12, and quadrilaterals in front of it."""
    facade = FacadePlan(
        "B01/F1", Rigid3("local", "facade", np.eye(3), np.zeros(3)), rectangle(0, 0, 20, 4),
        (opening("B01/F1/W0-1", 2.0), opening("B01/F1/W0-2", 12.0)),
    )  # fmt: skip
    house = House("B01", "1 Long Street", 0, rectangle(0, 0, 20, 8), 0.0, 4.0, 6.0, (facade,))
    quads = [(quad(0, 20, 0.0, 0, 4), (0, 0, -1)), *before]
    corners = [np.array([[0, 1, 2], [0, 2, 3]]) + 4 * k for k in range(len(quads))]
    mesh = SceneMesh(
        np.concatenate([q for q, _ in quads]), np.concatenate(corners), np.repeat(np.arange(len(quads)), 2)
    )
    surfaces = tuple(SceneSurface(f"s{k}", Part.WALL, 0, *owner) for k, (_, owner) in enumerate(quads))
    frame = Rigid3.identity("local", "street")
    road = np.array([[0.0, -8, 0], [20, -8, 0]])
    return Scene("wall", 0, WorldRef(np.zeros(3), None), frame, mesh, surfaces, (), (house,), road)


def eye(x: float, y: float, field: float = 360.0) -> ScannerView:
    return ScannerView(np.array([x, y, 1.5]), np.array([0.0, 1, 0]), np.radians(field), -1.5, 1.5)


def shares(scene: Scene, stations: list[ScannerView], photos: tuple[Photo, ...] = ()) -> list[Shares]:
    seen = visibility(scene, Tracer(scene.mesh), stations, np.empty((0, 3)), photos)
    return [seen.openings[0, 0, k] for k in range(2)]


def test_an_unobstructed_wall_is_visible_to_each_sensor() -> None:
    first, second = shares(wall(), [eye(7.0, -8.0)])
    assert first == second == {"stations": 1.0, "any": 1.0}


def test_a_board_hides_what_lies_in_its_shadow() -> None:
    board = (quad(1.5, 2.5, -4.0, 0, 4), (-1, -1, -1))  # half way: its shadow is twice as wide
    first, second = shares(wall(board), [eye(2.5, -8.0)])
    assert first["stations"] == pytest.approx(0.5, abs=0.07)  # x = 0.5..2.5 is dark
    assert second["stations"] == 1.0
    both, _ = shares(wall(board), [eye(2.5, -8.0), eye(8.0, -8.0)])
    assert both["stations"] == 1.0


def test_an_opening_is_hidden_by_a_neighbours_shutter_but_not_by_its_own() -> None:
    leaf = quad(1.9, 3.1, -0.05, 0.9, 2.1)
    assert shares(wall((leaf, (0, 0, 0))), [eye(2.5, -8.0)])[0]["stations"] == 1.0
    assert shares(wall((leaf, (0, 0, 1))), [eye(2.5, -8.0)])[0]["stations"] == 0.0


def test_grazing_far_and_outside_the_field_is_not_seen() -> None:
    assert shares(wall(), [eye(14.0, -0.5)])[0]["stations"] == 0.0  # 88 degrees off the normal
    assert shares(wall(), [eye(2.5, -70.0)])[0]["stations"] == 0.0
    assert shares(wall(), [eye(7.5, 3.0)])[0]["stations"] == 0.0  # from behind
    first, second = shares(wall(), [eye(2.5, -4.0, field=40.0)])
    assert (first["stations"], second["stations"]) == (1.0, 0.0)


def test_a_photo_sees_what_lies_in_its_picture() -> None:
    camera = Camera("PINHOLE", 400, 400, np.array([400.0, 400, 200, 200]))
    R = np.column_stack([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]])  # looking along +y
    pose = Rigid3("local", "camera", R, np.array([2.0, -4.0, 1.5]))
    photo = Photo("a.jpg", camera, Estimate(pose, np.zeros((6, 6)), 0.0))
    first, second = shares(wall(), [], (photo,))
    assert first["photos"] == 1.0  # x = 0..4
    assert second == {"photos": 0.0, "any": 0.0}


def test_a_track_is_sampled_every_metre() -> None:
    board = (quad(1.5, 3.5, -4.0, 0, 4), (-1, -1, -1))
    scene = wall(board)
    track = np.column_stack([np.linspace(2.0, 12.0, 500), np.full(500, -8.0), np.full(500, 2.0)])
    seen = visibility(scene, Tracer(scene.mesh), [], track, ())
    assert seen.openings[0, 0, 0]["drive"] == seen.openings[0, 0, 1]["drive"] == 1.0
    assert seen.facades[0, 0]["drive"] > 0.95
