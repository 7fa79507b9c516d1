"""Walls behind a larger front: what is seen through it is a room, over, beside or under it a wall."""

import numpy as np
import pytest
import shapely

from frontage.facades import find_facades
from frontage.model import Building, Scan, WorldRef
from frontage.simulate.scene import Part
from scanned_streets import terrace

WORLD = WorldRef(np.array([0, 0, 0]))
EYES = np.array([[-9.0, -14.0, 1.7], [5.0, -12.0, 1.7]])
WIDTH, HEIGHT = 15.0, 12.0


def grid(rng, x0, x1, z0, z1, y, spacing=0.08):
    """Points of an upright wall facing the street."""
    x, z = np.meshgrid(np.arange(x0, x1, spacing), np.arange(z0, z1, spacing))
    return np.column_stack([x.ravel(), np.full(x.size, y), z.ravel()]) + rng.normal(0, 0.004, (x.size, 3))


def windows(x, z):
    """Windows of 1.2 x 1.5 m every 3 m, above the ground floor."""
    return (np.abs(x % 3 - 1.5) < 0.6) & (z % 3 > 0.9) & (z % 3 < 2.4) & (z > 3.5)


def seen(rear, opaque):
    """Points of walls behind y = 0 that each station sees past what is `opaque` (x, z), and its number."""
    points, stations = [], []
    for k, eye in enumerate(EYES):
        at = eye + (rear - eye) * (-eye[1] / (rear[:, 1] - eye[1]))[:, None]
        free = rear[~opaque(at[:, 0], at[:, 2])]
        points.append(free)
        stations.append(np.full(len(free), k, np.int32))
    return np.vstack(points), np.concatenate(stations)


def facades(opaque, rear, rays, seed=0, through=True):
    """What is found of a front that is `opaque` (x, z) in y = 0 and the walls (n, 3) that show behind it.

    Only what is seen `through` the front shows, or all of them.
    """
    rng = np.random.default_rng(seed)
    front = grid(rng, -WIDTH / 2, WIDTH / 2, 0.0, HEIGHT, 0.0)
    front = front[opaque(front[:, 0], front[:, 2])]
    ground = np.column_stack(
        [rng.uniform(-12, 12, 9000), rng.uniform(-10, 0, 9000), rng.normal(0, 0.01, 9000)]
    )
    back, station = seen(rear, opaque) if through else (rear, np.zeros(len(rear), np.int32))
    own = np.vstack([front, back])
    xyz = np.vstack([own, ground])
    index = np.concatenate([rng.integers(0, 2, len(front)), station, np.ones(len(ground))]).astype(np.int32)
    scan = Scan("front", xyz, WORLD, EYES if rays else None, index if rays else None)
    return find_facades(scan, Building("B01", np.arange(len(own)), 0.0))


def depths(found):
    """How deep the facades that look to the street lie, m."""
    return sorted(round(float(f.frame.t[1]), 1) for f in found if f.frame.R[1, 1] > 0.9)


def on_wall(x, z):
    return (np.abs(x) < WIDTH / 2) & (z > 0) & (z < HEIGHT)


def shop(x, z):
    """A shop window from pier to pier, with a few posts."""
    post = np.abs(x % 2.5) < 0.06
    return on_wall(x, z) & ~windows(x, z) & ~((np.abs(x) < 7.0) & (z < 3.2) & ~post)


def arcade(x, z):
    """Openings of 6.6 m between three piers, nothing in them."""
    return on_wall(x, z) & ~windows(x, z) & ~((np.abs(np.abs(x) - 3.6) < 3.3) & (z < 3.5))


def gate(x, z):
    """One opening of 9 m, not in the middle."""
    return on_wall(x, z) & ~windows(x, z) & ~((x > -3.0) & (x < 6.0) & (z < 3.5))


@pytest.mark.parametrize("rays", [True, False])
@pytest.mark.parametrize(("front", "deep"), [(shop, 1.3), (shop, 2.5), (arcade, 2.0), (gate, 3.0)])
def test_wall_seen_through_a_front_is_no_facade(front, deep, rays):
    rear = grid(np.random.default_rng(1), -7.2, 7.2, 0.0, 3.6, deep, 0.05)
    assert depths(facades(front, rear, rays)) == [0.0]


def test_sides_and_end_of_a_passage_are_no_facades():
    rng = np.random.default_rng(1)
    end = grid(rng, -3.0, 6.0, 0.0, 3.5, 10.0, 0.05)
    left = grid(rng, 0.3, 10.0, 0.0, 3.5, -3.0, 0.05)[:, [1, 0, 2]]
    right = left + np.array([9.0, 0.0, 0.0])
    found = facades(gate, np.vstack([end, left, right]), True)
    assert len(found) == 1


def galleries(x, z):
    """Solid parapets of three galleries one above another, on posts before the whole wall."""
    parapet = (z % 3 > 2.8) | (z % 3 < 1.0)
    return on_wall(x, z) & ((parapet & (z > 2.8)) | (np.abs((x + 7.5) % 3.7) < 0.2))


@pytest.mark.parametrize("rays", [True, False])
def test_wall_behind_galleries_is_the_facade_and_their_fronts_are_none(rays):
    rear = grid(np.random.default_rng(1), -7.4, 7.4, 0.0, 8.7, 1.4, 0.05)  # the top storey is hidden
    assert depths(facades(galleries, rear, rays)) == [1.4]


def low(x, z):
    return on_wall(x, z) & ~windows(x, z) & (z < 8.0)


def wings(x, z):
    """Two wings joined by a garden wall; the court between them is open to the sky."""
    return on_wall(x, z) & ~windows(x, z) & ((np.abs(x) > 3.5) | (z < 1.0))


def shaft(x, z):
    """A light shaft of 3 m, closed by a garden wall, open to the sky."""
    return on_wall(x, z) & ~windows(x, z) & ((np.abs(x) > 1.5) | (z < 1.0))


def overhang(x, z):
    """Upper storeys that jut out over the whole ground floor."""
    return on_wall(x, z) & ~windows(x, z) & (z > 3.5)


@pytest.mark.parametrize("rays", [True, False])
@pytest.mark.parametrize(
    ("front", "wall"),
    [
        (low, (-7.5, 7.5, 6.0, 12.0, 2.0)),  # an attic
        (shaft, (-1.5, 1.5, 0.0, 12.0, 3.0)),
        (wings, (-3.5, 3.5, 0.0, 12.0, 3.0)),
        (overhang, (-7.5, 7.5, 0.0, 3.5, 1.6)),
    ],
)
def test_wall_set_back_above_beside_or_below_a_front_stays(front, wall, rays):
    rear = grid(np.random.default_rng(1), *wall, 0.05)
    assert depths(facades(front, rear, rays)) == [0.0, wall[-1]]


@pytest.mark.parametrize(("gap", "number"), [(0.0, 2), (0.3, 1)])
def test_the_side_of_a_house_stays_that_goes_round_a_sharp_corner(gap, number):
    """What stands before the foot of the side hides the ground there; its inner face is that of a room."""
    side = grid(np.random.default_rng(1), 0.0, 10.0, 4.0, 10.0, 0.0, 0.05)
    turn = np.radians(68.0)  # between the front and the side
    way = np.array([[np.cos(turn), np.sin(turn), 0.0], [-np.sin(turn), np.cos(turn), 0.0], [0.0, 0.0, 1.0]])
    corner = np.array([-WIDTH / 2 + gap / np.sin(turn), 0.0, 0.0])
    found = facades(lambda x, z: on_wall(x, z) & ~windows(x, z), side @ way + corner, False, through=False)
    assert len(found) == number


@pytest.mark.parametrize("past", [0.35, 1.5])
def test_side_of_a_room_is_no_facade_though_ground_was_measured_beyond_the_end_of_the_front(past):
    rng = np.random.default_rng(1)
    side = grid(rng, 0.3, 6.0, 0.0, 3.3, WIDTH / 2 - past, 0.05)[:, [1, 0, 2]]
    beside = np.column_stack([rng.uniform(7.5, 17, 9000), rng.uniform(0, 8, 9000), rng.normal(0, 0.01, 9000)])
    found = facades(shop, np.vstack([side, beside]), False, through=False)
    assert depths(found) == [0.0] and len(found) == 1


@pytest.mark.parametrize("seed", [20, 24])
def test_rooms_of_a_cloud_cut_out_without_ground_and_rays_are_no_facades(seed):
    scene = terrace(seed, houses=3)
    for house in range(3):
        own = np.flatnonzero(scene.house == house)
        scan = Scan("cut", scene.scan.xyz[own], scene.scan.world)
        found = find_facades(scan, Building("B01", np.arange(len(own)), float(scan.xyz[:, 2].min())))
        assert all(np.mean(scene.part[own][f.inliers] == Part.ROOM) < 0.2 for f in found)
    shares = [np.mean(scene.part[scene.house == house] == Part.ROOM) for house in range(3)]
    assert max(shares) > 0.1  # there are rooms that could be taken for facades


def test_what_panes_mirror_is_no_facade_though_it_is_larger_than_the_wall_of_windows():
    """A ground floor of windows between narrow piers, and behind the panes the mirror image of a wall."""

    def glazed(x, z):
        pane = (np.abs((x + 1.25) % 2.5 - 1.25) > 0.15) & (z > 0.4) & (z < 4.1)
        return (np.abs(x) < WIDTH / 2) & (z > 0) & (z < 4.5) & ~pane

    mirrored = grid(np.random.default_rng(1), -6.6, 6.6, 0.6, 3.9, 1.7, 0.05)
    assert depths(facades(glazed, mirrored, True)) == [0.0]


@pytest.mark.parametrize("rays", [True, False])
@pytest.mark.parametrize("seed", [0, 3])
def test_the_wall_of_an_arcade_stays_and_the_front_ends_at_its_ceiling(seed, rays):
    rng = np.random.default_rng(seed)
    rear = grid(rng, -7.2, 7.2, 0.0, 3.6, 2.0, 0.05)
    floor = rng.uniform((-7.2, 0.1, 0.0), (7.2, 2.0, 0.02), (4000, 3))
    found = facades(arcade, np.vstack([rear, floor]), rays, seed)
    assert depths(found) == [0.0, 2.0]
    front = max(found, key=lambda f: f.extent[3] - f.extent[1])
    outline = shapely.Polygon(front.outline)

    def inside(*places):
        """Tells which places (x, z) on the plane of the front its outline holds."""
        on_plane = np.array([(x, 0.0, z) for x, z in places])
        return shapely.contains_xy(outline, front.frame.inverse.apply(on_plane)[:, [0, 2]])

    assert not inside((-5.0, 0.5), (-2.0, 2.5), (2.0, 0.5), (5.0, 2.5)).any()
    assert inside((-7.2, 0.5), (0.0, 0.5), (7.2, 0.5), (3.6, 4.5)).all()


@pytest.mark.parametrize("seed", [0, 3])
def test_columns_behind_the_plane_do_not_close_an_arcade(seed):
    rng = np.random.default_rng(seed)
    columns = [grid(rng, x - 0.2, x + 0.2, 0.0, 3.5, 0.2, 0.05) for x in np.arange(-7.0, 7.1, 3.5)]
    rear = grid(rng, -7.2, 7.2, 0.0, 3.6, 2.0, 0.05)
    floor = rng.uniform((-7.2, 0.3, 0.0), (7.2, 2.0, 0.02), (4000, 3))
    assert depths(facades(overhang, np.vstack([*columns, rear, floor]), True, seed)) == [0.0, 2.0]


def podium(x, z):
    """A wall of three storeys over columns on a podium 0.9 m high."""
    pier = np.abs(x % 2.4) < 0.25
    return on_wall(x, z) & ~((np.abs(x) < 6.0) & (z > 0.9) & (z < 5.0) & ~pier)


@pytest.mark.parametrize("floor", [True, False])
def test_the_wall_of_a_portico_on_a_podium_stays_if_its_floor_shows(floor):
    rng = np.random.default_rng(0)
    back = [grid(rng, -6.5, 6.5, 0.9, 5.2, 2.5, 0.05)]
    back += [rng.uniform((-6.5, 0.1, 0.89), (6.5, 2.5, 0.91), (6000, 3))] if floor else []
    assert depths(facades(podium, np.vstack(back), True)) == ([0.0, 2.5] if floor else [0.0])


def test_a_front_over_an_arcade_ends_at_an_entablature_before_its_plane():
    rng = np.random.default_rng(0)
    rear = grid(rng, -7.2, 7.2, 0.0, 2.6, 2.0, 0.05)
    floor = rng.uniform((-7.2, 0.1, 0.0), (7.2, 2.0, 0.02), (4000, 3))
    entablature = grid(rng, -WIDTH / 2, WIDTH / 2, 3.5, 4.5, -0.2)
    back = np.vstack([seen(np.vstack([rear, floor]), arcade)[0], entablature])
    found = facades(lambda x, z: arcade(x, z) & ~((z > 3.5) & (z < 4.5)), back, True)
    assert depths(found) == [0.0, 2.0]
    front = max(found, key=lambda f: f.extent[3] - f.extent[1])
    outline = shapely.Polygon(front.outline)
    z = front.frame.inverse.apply(np.array([[3.6, 0.0, 3.2], [3.6, 0.0, 4.0]]))
    assert shapely.contains_xy(outline, z[:, [0, 2]]).tolist() == [False, True]


def colonnade(x, z):
    """Columns under an entablature: less wall than there is behind them."""
    column = np.abs((x + 7.5) % 3.75) < 0.5
    return on_wall(x, z) & (z < 7.8) & (column | (z > 6.4))


def test_a_colonnade_is_open_though_the_wall_behind_it_is_larger():
    rng = np.random.default_rng(0)
    rear = grid(rng, -7.2, 7.2, 0.0, 6.5, 2.4, 0.05)
    floor = rng.uniform((-7.2, 0.1, 0.0), (7.2, 2.4, 0.02), (4000, 3))
    found = facades(colonnade, np.vstack([rear, floor]), True)
    assert depths(found) == [0.0, 2.4]
    front = min(found, key=lambda f: f.frame.t[1])
    outline = shapely.Polygon(front.outline)
    at = front.frame.inverse.apply(
        np.array([[x, 0.0, z] for x in (-4.9, -1.2, 2.6) for z in (1.0, 5.5, 7.2)])
    )
    assert shapely.contains_xy(outline, at[:, [0, 2]]).tolist() == [False, False, True] * 3
