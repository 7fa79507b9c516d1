"""find_facades against simulated truth:
accuracy, frames, sides, what must not win, what must fail clearly.
"""

import numpy as np
import pytest
from scipy import ndimage
from shapely.geometry import Polygon

from frontage.facades import FacadeOptions, find_facades
from frontage.geometry.ring import ring_area
from frontage.model import Building, Facade, Failed, Scan, WorldRef
from frontage.simulate.scene import Part

WORLD = WorldRef(np.array([0, 0, 0]))


def turned(azimuth):
    c, s = np.cos(azimuth), np.sin(azimuth)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def panel(rng, width, height, noise=0.005, spacing=0.04, windows=True):
    """Points of a wall in its own frame, x from -width/2, z from 0, y = noise, windows every 3 m."""
    x, z = np.meshgrid(np.arange(-width / 2, width / 2, spacing), np.arange(0, height, spacing))
    x, z = x.ravel() + rng.uniform(-0.01, 0.01, x.size), z.ravel() + rng.uniform(-0.01, 0.01, x.size)
    hole = (np.abs((x + 300) % 3 - 1.5) < 0.6) & (z % 3 > 0.9) & (z % 3 < 2.4) & windows
    wall = np.column_stack([x, rng.normal(0, noise, x.size), z])
    return wall[~hole], wall[hole]


def scene(seed=0, azimuth=0.6, shift=(30.0, -12.0, 3.0), rays=True, clutter=True, lean=0.0):
    """A 20 x 12 m wall with 60 % clutter, a station in the street; truth: R columns X, Y, Z and a point."""
    rng = np.random.default_rng(seed)
    wall, hole = panel(rng, 20, 12)
    wall[:, 1] -= np.tan(lean) * wall[:, 2]
    parts = [wall]
    if clutter:
        n = len(wall) // 5
        frames = hole[: n // 2] + np.array([0, 0.12, 0])
        eye = np.array([2.0, -12.0, 1.7])
        depth = rng.uniform(0.5, 5, n)[:, None]
        seen = hole[rng.permutation(len(hole))[:n]]
        rooms = seen + (seen - eye) / 12.0 * depth[: len(seen)]  # along the line of sight: behind the windows
        balcony = np.column_stack([rng.uniform(-6, 6, n), rng.normal(-1.0, 0.005, n), rng.uniform(3, 4, n)])
        bushes = rng.normal([-5, -3, 1.5], 0.8, (2 * n, 3))
        ground = np.column_stack(
            [rng.uniform(-12, 12, 2 * n), rng.uniform(-10, 0, 2 * n), rng.normal(0, 0.01, 2 * n)]
        )
        parts += [frames, rooms, balcony, bushes, ground]
    xyz = np.vstack(parts)
    R = turned(azimuth)
    t = np.asarray(shift)
    origins = (R @ np.array([2.0, -12.0, 1.7]) + t)[None] if rays else None
    index = np.zeros(len(xyz), np.int32) if rays else None
    return Scan("wall", xyz @ R.T + t, WORLD, origins, index), R, t


def only(result):
    assert all(isinstance(f, Facade) for f in result), result
    return result[0]


def whole(scan, ground_z=3.0):
    return Building("B01", np.arange(len(scan)), ground_z)


@pytest.mark.parametrize("rays", [True, False])
@pytest.mark.parametrize("seed", range(3))
def test_plane_of_a_cluttered_wall_is_found_to_a_millimetre(seed, rays):
    scan, R, t = scene(seed, azimuth=0.6 + 2 * seed, rays=rays)
    f = only(find_facades(scan, whole(scan)))
    offset = (f.frame.t - t) @ R[:, 1]
    angle = np.degrees(np.linalg.norm(np.cross(f.frame.R[:, 1], R[:, 1])))
    assert abs(offset) < 0.001 and angle < 0.005
    # n_eff counts points of white noise, not fewer, not infinity
    assert 0.00005 / 10 < f.sigma_plane < 0.0005
    assert 0.0045 < f.roughness < 0.0055
    assert f.frame.R[:, 1] @ R[:, 1] > 0.999  # into the building
    assert f.oriented_by == ("rays" if rays else "evidence")
    x0, z0, x1, z1 = f.extent
    assert 19.5 < x1 - x0 < 20.6 and 11.5 < z1 - z0 < 12.6


@pytest.mark.parametrize("seed", range(3))
def test_frames_tell_the_street_side_of_a_court_that_was_cut_out(seed):
    # no ground, no roof, and the only things far from the wall are the next walls of the court, before it
    rng = np.random.default_rng(seed)
    wall, hole = panel(rng, 12.6, 12, spacing=0.02)
    left = np.abs((hole[:, 0] + 300) % 3 - 1.0) < 0.1
    frames = hole[left] + np.array([0.0, 0.2, 0.0])
    beside, _ = panel(rng, 6, 12, spacing=0.02, windows=False)
    corners = [np.column_stack([x + beside[:, 1], beside[:, 0] - 3.0, beside[:, 2]]) for x in (-6.1, 6.1)]
    scan = Scan("court", np.vstack([wall, frames, *corners]) @ turned(0.3).T, WORLD)
    found = [f for f in find_facades(scan, whole(scan, 0.0)) if isinstance(f, Facade)]
    f = max(found, key=lambda f: f.extent[2] - f.extent[0])
    assert f.frame.R[:, 1] @ turned(0.3)[:, 1] > 0.999


@pytest.mark.parametrize("seed", range(3))
def test_windows_round_the_corners_tell_the_street_side_of_a_blank_wall(seed):
    # the walls that stand before it would be taken for the building behind it
    rng = np.random.default_rng(seed)
    blank, _ = panel(rng, 12.6, 12, spacing=0.03, windows=False)
    beside, hole = panel(rng, 6, 12, spacing=0.03)
    left = np.abs((hole[:, 0] + 300) % 3 - 1.0) < 0.1
    beside = np.vstack([beside, hole[left] + np.array([0.0, 0.2, 0.0])])
    corners = [np.column_stack([s * (6.2 + beside[:, 1]), beside[:, 0] - 3.2, beside[:, 2]]) for s in (-1, 1)]
    scan = Scan("court", np.vstack([blank, *corners]) @ turned(0.3).T, WORLD)
    found = [f for f in find_facades(scan, whole(scan, 0.0)) if isinstance(f, Facade)]
    assert len(found) == 3
    middle = turned(0.3) @ np.array([0.0, -3.0, 0.0])
    assert all((middle - f.frame.t)[:2] @ f.frame.R[:2, 1] < 0.0 for f in found)


def sheet(rng, width, low, high, depth, spacing=0.03):
    """Points of a blank wall from -width/2, between two heights, at a depth m behind the plane."""
    wall, _ = panel(rng, width, high - low, spacing=spacing, windows=False)
    return wall + np.array([0.0, depth, low])


def crowns(rng, low, high, count=6000):
    """Points on the outsides of crowns 4 m wide in a row 5 m before a wall."""
    towards = rng.normal(size=(count, 3))
    towards /= np.linalg.norm(towards, axis=1)[:, None]
    middle = np.column_stack([rng.choice([-6.0, -2.0, 2.0, 6.0], count), np.full((count, 2), (-5.0, 0.0))])
    middle[:, 2] = rng.uniform(low, high, count)
    return middle + 2.0 * towards * [1.0, 1.0, 0.3]


def street(rng, width, near, far, spacing=0.2):
    """Points of level ground between two distances from a wall."""
    x, y = np.meshgrid(np.arange(-width / 2, width / 2, spacing), np.arange(near, far, spacing))
    return np.column_stack([x.ravel(), y.ravel(), rng.normal(0, 0.01, x.size)])


def base(rng, width):
    """A storey 0.4 m before the plane of the next one, with windows of 4 x 2 m and panes in that plane."""
    lower = sheet(rng, width, 0.0, 3.2, -0.4)
    window = (np.abs((lower[:, 0] + 300) % 6 - 3.0) < 2.0) & (np.abs(lower[:, 2] - 1.6) < 1.0)
    return lower[~window], lower[window] + np.array([0.0, 0.4, 0.0])


def facades_of(*parts):
    scan = Scan("parts", np.vstack(parts) @ turned(0.3).T, WORLD)
    return [f for f in find_facades(scan, whole(scan, 0.0)) if isinstance(f, Facade)]


@pytest.mark.parametrize("seed", range(3))
def test_a_storey_that_stands_out_behind_trees_does_not_turn_the_upper_one_round(seed):
    # the lower wall is no pane in the windows of the upper one, and trees are no building
    rng = np.random.default_rng(seed)
    lower, panes = base(rng, 18)
    ground = street(rng, 18, -8, -1)
    shade = np.abs(ground[:, 1] + 5) < 2
    trees = crowns(rng, 5, 7)
    found = facades_of(sheet(rng, 18, 3.4, 7.0, 0.0), lower, panes, trees, ground[~shade])
    assert found
    assert all(f.frame.R[:, 1] @ turned(0.3)[:, 1] > 0.9 for f in found)


@pytest.mark.parametrize("seed", range(3))
def test_ground_behind_a_tower_is_not_before_its_front(seed):
    # the street was cut off; the square on the other side shows beyond the rear wall
    rng = np.random.default_rng(seed)
    found = facades_of(sheet(rng, 4, 0, 20, 0), sheet(rng, 4, 0, 20, 4, 0.06), street(rng, 4, 4.2, 10))
    fronts = [f for f in found if abs((turned(0.3).T @ f.frame.t)[1]) < 0.5]
    assert len(fronts) == 1
    assert fronts[0].frame.R[:, 1] @ turned(0.3)[:, 1] > 0.9


def test_frame_is_right_handed_upright_and_not_mirrored():
    scan, R, t = scene(1)
    frame = only(find_facades(scan, whole(scan))).frame
    X, Y, Z = frame.R.T
    assert np.allclose(np.cross(X, Y), Z) and X[2] == 0.0 and Z[2] > 0.99
    # a mark at the right as seen from the street has a positive x: the truth's own x axis says so
    right = R @ np.array([8.0, 0.0, 6.0]) + t
    assert frame.inverse.apply(right[None])[0, 0] > frame.inverse.apply(t[None])[0, 0] + 7.9


def test_origin_is_the_barycentre_of_the_inliers():
    scan, *_ = scene(2)
    f = only(find_facades(scan, whole(scan)))
    q = f.frame.inverse.apply(scan.xyz[f.inliers])
    assert np.abs(q.mean(0)).max() < 1e-3
    assert np.abs(q[:, 1]).max() < 0.1


def test_rotating_the_world_changes_nothing():
    sizes = []
    for azimuth, shift in ((0.0, (0, 0, 0)), (2.1, (500.0, -300.0, 40.0))):
        scan, R, t = scene(3, azimuth=azimuth, shift=shift)
        f = only(find_facades(scan, whole(scan, shift[2])))
        sizes.append([*(R.T @ (f.frame.t - t)), f.roughness, f.coverage])
    assert np.abs(np.subtract(*sizes))[1] < 0.001
    assert np.abs(np.subtract(*sizes)).max() < 0.15


@pytest.mark.parametrize("axes", [np.eye(3), turned(0.9), np.diag([-1.0, 1.0, 1.0])])
@pytest.mark.parametrize("rays", [True, False])
def test_neither_order_nor_direction_nor_handedness_changes_a_facade(axes, rays):
    scan, *_ = scene(2, rays=rays)
    order = np.random.default_rng(9).permutation(len(scan))
    origins = scan.origins @ axes.T if rays else None
    moved = Scan("moved", scan.xyz[order] @ axes.T, WORLD, origins, scan.origin_index[order])
    a, b = only(find_facades(scan, whole(scan))), only(find_facades(moved, whole(moved)))
    side = np.array([np.linalg.det(axes), 1.0, 1.0])  # x runs the other way where left and right are swapped
    assert np.abs(axes @ a.frame.t - b.frame.t).max() < 1e-5
    assert np.abs(axes @ a.frame.R * side - b.frame.R).max() < 1e-6
    signs = np.concatenate([side, side * side[0]])
    expected = a.local_from_facade.covariance * np.outer(signs, signs)
    assert np.allclose(expected, b.local_from_facade.covariance, rtol=1e-3, atol=1e-14)
    assert len(np.setxor1d(a.support, order[b.support])) < 1e-3 * len(a.support)
    ours = a.outline * side[[0, 2]]
    assert np.abs(np.sort(ours, axis=0) - np.sort(b.outline, axis=0)).max() < 1e-4
    assert ring_area(b.outline) * ring_area(a.outline) > 0.0


def test_errors_are_what_the_covariance_says():
    score = []
    for seed in range(12):
        scan, R, t = scene(seed, azimuth=0.3 * seed)
        f = only(find_facades(scan, whole(scan), seed=seed))
        turn = f.frame.R.T @ R  # small: true axes in the facade's
        error = np.array([(t - f.frame.t) @ f.frame.R[:, 1], turn[2, 1], -turn[0, 1]])
        cov = f.local_from_facade.covariance[np.ix_([1, 3, 5], [1, 3, 5])]
        score.append(error @ np.linalg.solve(cov, error) / 3)
    assert 0.5 < np.mean(score) < 2.0


def test_same_seed_same_bytes():
    scan, *_ = scene(4, rays=False)
    a, b = (only(find_facades(scan, whole(scan), seed=7)) for _ in range(2))
    assert a.frame.matrix.tobytes() == b.frame.matrix.tobytes()
    assert a.outline.tobytes() == b.outline.tobytes() and a.support.tobytes() == b.support.tobytes()


def test_support_holds_balcony_and_frames_but_no_room():
    scan, _R, _t = scene(5)
    f = only(find_facades(scan, whole(scan)))
    y = f.frame.inverse.apply(scan.xyz[f.support])[:, 1]
    assert y.min() < -0.95 and 0.9 < y.max() <= 1.0
    assert np.isin(f.inliers, f.support).mean() > 0.99
    assert [round(layer.y, 1) for layer in f.layers] == [-1.0, 0.0, 0.1]


@pytest.mark.parametrize("rays", [True, False])
def test_corner_building_has_two_facades(rays):
    rng = np.random.default_rng(0)
    street, _ = panel(rng, 12, 9)
    side, _ = panel(rng, 8, 9)
    corner = side @ turned(np.pi / 2).T + [6.0, 4.0, 0.0]
    ground = np.column_stack([rng.uniform(-6, 14, 8000), rng.uniform(-8, 8, 8000), rng.normal(0, 0.01, 8000)])
    ground = ground[(ground[:, 1] < 0) | (ground[:, 0] > 6)]
    xyz = np.vstack([street, corner, ground])
    origins = np.array([[0.0, -9, 1.7], [14.0, 4, 1.7]]) if rays else None
    index = (
        np.r_[np.zeros(len(street)), np.ones(len(corner)), np.zeros(len(ground))].astype(np.int32)
        if rays
        else None
    )
    scan = Scan("corner", xyz, WORLD, origins, index)
    found = find_facades(scan, Building("B02", np.arange(len(street) + len(corner)), 0.0))
    assert [f.id for f in found] == ["B02/F1", "B02/F2"]
    assert found[0].frame.R[:, 1] @ [0, 1, 0] > 0.999
    assert found[1].frame.R[:, 1] @ [-1, 0, 0] > 0.999


def test_tower_has_six_facades_that_look_outwards_without_rays():
    rng = np.random.default_rng(1)
    faces = []
    for k in range(6):
        face, _ = panel(rng, 4, 15, windows=False)
        faces.append((face + np.array([0, -3.46, 0])) @ turned(k * np.pi / 3).T)
    scan = Scan("tower", np.vstack(faces), WORLD)
    found = find_facades(scan, whole(scan, 0.0))
    assert len(found) == 6
    for f in found:
        assert f.frame.t[:2] @ f.frame.R[:2, 1] < -3.4  # from outside towards the axis


@pytest.mark.parametrize("rays", [True, False])
def test_wall_of_a_room_seen_through_windows_is_no_facade(rays):
    rng = np.random.default_rng(2)
    wall, hole = panel(rng, 20, 12)
    eye = np.array([0.0, -10.0, 1.7])
    through = hole[rng.permutation(len(hole))]
    # a wall 6 m behind, denser than the front
    back = eye + (through - eye) * (16.0 / (through[:, 1] - eye[1]))[:, None]
    back = np.vstack([back + rng.normal(0, 0.003, back.shape) for _ in range(4)])
    xyz = np.vstack([wall, back])
    scan = Scan(
        "room", xyz, WORLD, eye[None] if rays else None, np.zeros(len(xyz), np.int32) if rays else None
    )
    found = find_facades(scan, whole(scan, 0.0))
    assert len(found) == 1
    assert abs(found[0].frame.t[1]) < 0.001


def test_a_shop_beside_the_pier_of_a_neighbour_is_no_facade():
    rng = np.random.default_rng(6)
    wall, _ = panel(rng, 20, 9)
    shop = (wall[:, 0] < -3) & (wall[:, 2] < 3)
    eye = np.array([-6.0, -10.0, 1.7])
    pier = np.column_stack(
        [rng.uniform(-10.6, -10, 4000), rng.normal(0, 0.005, 4000), rng.uniform(0, 9, 4000)]
    )
    # the back of the shop, 1.3 m behind its window, which reaches up to the neighbour's pier
    back = eye + (wall[shop] - eye) * 1.13
    back[:, 1] = rng.normal(1.3, 0.005, len(back))
    xyz = np.vstack([wall[~shop], back, back + rng.normal(0, 0.005, back.shape), pier])
    scan = Scan("shop", xyz, WORLD, eye[None], np.zeros(len(xyz), np.int32))
    found = find_facades(scan, Building("B01", np.arange(len(xyz) - len(pier)), 0.0))
    assert len(found) == 1 and abs(only(found).frame.t[1]) < 0.001


def test_opposite_side_of_the_street_never_wins():
    rng = np.random.default_rng(3)
    wall, _ = panel(rng, 8, 6)
    opposite, _ = panel(rng, 40, 20)
    opposite += [0, -18.0, 0]
    scan = Scan("street", np.vstack([opposite, wall]), WORLD)
    found = find_facades(scan, Building("B03", np.arange(len(opposite), len(opposite) + len(wall)), 0.0))
    assert len(found) == 1 and abs(found[0].frame.t[1]) < 0.001
    assert found[0].support.min() >= len(opposite)


def test_dense_front_does_not_win_against_more_wall():
    rng = np.random.default_rng(4)
    wall, _ = panel(rng, 20, 12, spacing=0.05)
    cladding = np.column_stack(
        [rng.uniform(-10, 10, 200_000), rng.normal(-0.3, 0.002, 200_000), rng.uniform(0, 3, 200_000)]
    )
    xyz = np.vstack([wall[wall[:, 2] > 3], cladding])
    scan = Scan("shop", xyz, WORLD, np.array([[0, -10.0, 1.7]]), np.zeros(len(xyz), np.int32))
    f = only(find_facades(scan, whole(scan, 0.0)))
    assert abs(f.frame.t[1]) < 0.001  # 200 k points of cladding on 60 m2 against 70 k points on 140 m2
    assert any(abs(layer.y + 0.3) < 0.005 for layer in f.layers)


def test_curved_wall_says_so():
    rng = np.random.default_rng(5)
    wall, _ = panel(rng, 20, 8)
    wall[:, 1] += 0.2 * (wall[:, 0] / 10) ** 2
    scan = Scan("bent", wall, WORLD, np.array([[0, -10.0, 1.7]]), np.zeros(len(wall), np.int32))
    f = only(find_facades(scan, whole(scan, 0.0)))
    assert -0.24 < f.curvature[0] < -0.16 and any("bent" in note for note in f.notes)


@pytest.mark.parametrize(("degrees", "pieces"), [(1.0, 1), (3.5, 2), (8.0, 2)])
def test_no_end_of_a_wall_that_bends_is_lost(degrees, pieces):
    rng = np.random.default_rng(7)
    left, _ = panel(rng, 10, 9)
    right, _ = panel(rng, 10, 9)
    bend = np.array([5.0, 0.0, 0.0])
    right = (right + bend) @ turned(np.radians(degrees)).T + bend
    wall = np.vstack([left, right])
    scan = Scan("bend", wall, WORLD, np.array([[5, -12.0, 1.7]]), np.zeros(len(wall), np.int32))
    found = find_facades(scan, whole(scan, 0.0))
    assert len(found) == pieces
    held = np.zeros(len(wall), int)
    for f in found:
        held[f.support] += 1
    assert np.mean(held == 0) < 0.01 and np.mean(held > 1) < 0.05


def test_flat_wall_is_not_called_bent():
    scan, *_ = scene(6)
    f = only(find_facades(scan, whole(scan)))
    assert abs(f.curvature[0]) < 0.003 and not any("bent" in note for note in f.notes)


def test_leaning_wall_is_not_forced_upright():
    scan, _R, _t = scene(7, lean=np.radians(1.0))
    f = only(find_facades(scan, whole(scan)))
    assert np.degrees(np.arcsin(f.frame.R[2, 1])) == pytest.approx(1.0, abs=0.005)
    assert any("leans towards the street" in note for note in f.notes)


def test_cloud_that_is_not_levelled():
    scan, _R, _t = scene(8, lean=np.radians(6.0))
    f = only(find_facades(scan, whole(scan), FacadeOptions(levelled=False)))
    assert np.degrees(np.arcsin(f.frame.R[2, 1])) == pytest.approx(6.0, abs=0.01)


def test_thirty_points_fail_with_a_clear_sentence():
    scan, *_ = scene(0)
    (failed,) = find_facades(scan, Building("B09", np.arange(30), 0.0))
    assert isinstance(failed, Failed) and not failed
    assert failed.code == "F101" and "30 points" in failed.message and failed.hint


def monument(rng, trees=True):
    """A front of 30 x 16 m whose panels lie at six depths, none of them on a third of it; x, y, z in m.

    Trees stand in the street, and the ground is seen under them; the windows show what lies behind.
    """
    parts = []
    for i, j in np.ndindex(10, 8):
        x, z = np.meshgrid(np.arange(0, 3, 0.05), np.arange(0, 2, 0.05))
        x, z = x.ravel(), z.ravel()
        wall = (np.abs(x - 1.5) > 0.75) | (np.abs(z - 1.0) > 0.7)
        depth = np.where(wall, (0.0, 0.12, 0.25, 0.38, 0.5, 0.62)[rng.integers(6)], 0.9)
        seen = wall | (rng.random(len(x)) < 0.3)
        parts.append(np.column_stack([x + 3 * i, depth, z + 2 * j])[seen])
    n = 60_000
    ground = np.column_stack([rng.uniform(0, 30, n), rng.uniform(-8, 0, n), np.zeros(n)])
    crown = np.column_stack([rng.uniform(2, 28, n), rng.uniform(-6, -2, n), rng.uniform(4, 11, n)])
    xyz = np.vstack([*parts, ground, *([crown] if trees else [])])
    return xyz + rng.normal(0, 0.004, xyz.shape)


@pytest.mark.parametrize("share", [1.0, 0.125])
def test_a_monumental_front_in_many_planes_has_a_facade_that_looks_to_the_street(share):
    rng = np.random.default_rng(4)
    xyz = monument(rng)
    xyz = xyz[rng.random(len(xyz)) < share]
    scan = Scan("museum", xyz, WORLD)
    f = only(find_facades(scan, whole(scan, 0.0)))
    x0, z0, x1, z1 = f.extent
    assert x1 - x0 > 28 and z1 - z0 > 14
    assert f.coverage < 0.35
    assert f.frame.R[1, 1] > 0.999  # into the building, though nothing is higher than the trees


def test_walls_side_by_side_share_no_area():
    rng = np.random.default_rng(8)
    left, _ = panel(rng, 12, 9)
    right, _ = panel(rng, 8, 6)
    right[:, 0] += 10.0
    # a lower wing 0.45 m further forward, whose frieze is near the planes of both walls
    right[:, 1] -= np.where(right[:, 2] > 5.0, 0.3, 0.45)
    xyz = np.vstack([left, right])
    eye = np.array([[4.0, -12.0, 1.7]])
    scan = Scan("wings", xyz, WORLD, eye, np.zeros(len(xyz), np.int32))
    a, b = (
        Polygon([(f.frame.t[0] + f.frame.R[0, 0] * x, f.frame.t[2] + z) for x, z in f.outline])
        for f in find_facades(scan, whole(scan, 0.0))
    )
    assert a.intersection(b).area < 0.5
    assert abs(a.area - 12 * 9) < 3.0 and abs(b.area - 8 * 6) < 3.0


def test_a_bush_is_no_facade():
    rng = np.random.default_rng(0)
    scan = Scan("bush", rng.normal(0, 2.0, (40_000, 3)), WORLD)
    (failed,) = find_facades(scan, whole(scan, -5.0))
    assert isinstance(failed, Failed) and failed.code == "F102"


def test_points_that_are_not_numbers_are_refused_before_any_search():
    scan, *_ = scene(1)
    xyz = scan.xyz.copy()
    xyz[::50] = np.nan
    with pytest.raises(ValueError, match="not finite; leave these rows out"):
        Scan("nan", xyz, WORLD, scan.origins, scan.origin_index)


def test_paper_method_finds_the_same_wall_less_exactly():
    scan, R, _t = scene(2)
    paper = only(find_facades(scan, whole(scan), FacadeOptions(method="paper", paper_iterations=200)))
    angle = np.degrees(np.linalg.norm(np.cross(paper.frame.R[:, 1], R[:, 1])))
    assert 0.005 < angle < 2.0


def rough(rng, x, z, sigma=0.003, length=0.3, cell=0.05):
    """A Gaussian random field at (x, z), correlated over `length`."""
    shape = (int(np.ptp(z) / cell) + 3, int(np.ptp(x) / cell) + 3)
    field = ndimage.gaussian_filter(rng.normal(0, 1, (shape[0] + 40, shape[1] + 40)), length / 2 / cell)
    field = field[20:-20, 20:-20]
    at = [(z - z.min()) / cell, (x - x.min()) / cell]
    return sigma / field.std() * ndimage.map_coordinates(field, at, order=1, mode="nearest")


@pytest.mark.parametrize("roughness", [0.0, 0.003])
def test_errors_match_the_covariance_on_smooth_and_on_rough_walls(roughness):
    score = []
    for seed in range(20):
        rng = np.random.default_rng(seed)
        wall, _ = panel(rng, 10, 7, spacing=0.06)
        if roughness:
            wall[:, 1] += rough(rng, wall[:, 0], wall[:, 2], roughness)
        ground = np.column_stack(
            [rng.uniform(-6, 6, 3000), rng.uniform(-4, 0, 3000), rng.normal(0, 0.01, 3000)]
        )
        xyz = np.vstack([wall, ground])
        scan = Scan("rough", xyz, WORLD, np.array([[0, -10.0, 1.7]]), np.zeros(len(xyz), np.int32))
        f = only(find_facades(scan, whole(scan, 0.0), seed=seed))
        # errors of (c, lean, azimuth) at the facade's own origin
        error = np.array([-f.frame.t[1], f.frame.R[1, 2], -f.frame.R[1, 0]])
        cov = f.local_from_facade.covariance[np.ix_([1, 3, 5], [1, 3, 5])]
        score.append(error @ np.linalg.solve(cov, error) / 3)
    assert 0.55 < np.mean(score) < 1.6  # 99.8 % of chi-square with 60 degrees of freedom


@pytest.mark.parametrize("rays", [True, False])
def test_no_facade_of_a_street_is_made_of_rooms(street, rays):
    scan = street.scan if rays else Scan("street", street.scan.xyz, street.scan.world)
    for i, house in enumerate(street.houses):
        own = np.flatnonzero(street.house == i)
        found = find_facades(scan, Building(f"B{i}", own, float(scan.xyz[own, 2].min())))
        true = house.facades[0].local_from_facade
        assert abs((found[0].frame.t - true.t) @ true.R[:, 1]) < 0.002
        for f in found:
            assert np.mean(street.part[f.inliers] == Part.ROOM) < 0.2
    assert np.mean(street.part[street.house == 0] == Part.ROOM) > 0.05  # rooms are seen


@pytest.mark.parametrize(("radius", "faces"), [(1.0, 2), (1.5, 2), (3.0, 3)])
def test_rounded_corner_is_no_fan_of_slivers(radius, faces):
    rng = np.random.default_rng(0)
    a, _ = panel(rng, 8, 9)
    b, _ = panel(rng, 8, 9)
    turn = rng.uniform(0, np.pi / 2, int(radius * np.pi / 2 * 9 / 0.04**2))
    arc = np.column_stack(
        [radius * (np.sin(turn) - 1), radius * (1 - np.cos(turn)), rng.uniform(0, 9, len(turn))]
    )
    arc += rng.normal(0, 0.005, arc.shape)
    xyz = np.vstack([a - [4 + radius, 0, 0], arc, b @ turned(np.pi / 2).T + [0, 4 + radius, 0]])
    scan = Scan("corner", xyz, WORLD, np.array([[8.0, -8, 1.7]]), np.zeros(len(xyz), np.int32))
    found = find_facades(scan, whole(scan, 0.0))
    assert len(found) == faces
    flat = sorted(found, key=lambda f: -f.coverage)[:2]
    assert all(f.sigma_plane < 0.0003 for f in flat)
    for f in found[2:]:  # the corner of three metres is a wall of its own, and bent
        assert any("bent" in note for note in f.notes)


def test_relief_does_not_tilt_the_plane_across_its_layers():
    rng = np.random.default_rng(0)
    wall, _ = panel(rng, 4, 20, noise=0.003, windows=False)
    strip = np.floor((wall[:, 0] + 2) / 0.5).astype(int)
    # pilasters, fluted panels, all of it set back in the upper storeys
    depth = np.array([0, 0.2, 0.14, 0.2, 0.2, 0.26, 0.2, 0])[strip % 8] + 0.08 * (wall[:, 2] > 15)
    wall[:, 1] += depth
    scan = Scan("relief", wall, WORLD, np.array([[0, -10.0, 1.7]]), np.zeros(len(wall), np.int32))
    f = only(find_facades(scan, whole(scan, 0.0)))
    assert np.degrees(np.hypot(f.frame.R[1, 0], f.frame.R[1, 2])) < 0.05
    assert f.roughness < 0.005 and not any("bent" in note for note in f.notes)


def test_reveals_are_no_layers():
    rng = np.random.default_rng(0)
    wall, _ = panel(rng, 12, 9)
    x, y, z = np.meshgrid(np.arange(-4.5, 5, 3.0), np.arange(0.03, 0.4, 0.03), np.arange(1, 8, 0.03))
    reveal = np.column_stack([x.ravel(), y.ravel(), z.ravel()]) + rng.normal(0, 0.002, (x.size, 3))
    xyz = np.vstack([wall, reveal, reveal + np.array([1.2, 0, 0])])
    scan = Scan("reveals", xyz, WORLD, np.array([[0, -10.0, 1.7]]), np.zeros(len(xyz), np.int32))
    f = only(find_facades(scan, whole(scan, 0.0)))
    assert [layer.y for layer in f.layers] == [0.0]


def test_plinth_and_mouldings_do_not_pull_the_wall():
    """Layers 2 and 4.5 cm proud of it, on a third of the area, are not the wall's roughness."""
    rng = np.random.default_rng(12)
    wall, _ = panel(rng, 11, 6.5, noise=0.004, spacing=0.03)
    plinth, moulding = wall[:, 2] < 0.9, (wall[:, 2] % 3 > 2.5) | (np.abs(wall[:, 0]) > 5.2)
    wall[moulding, 1] -= 0.021
    wall[plinth, 1] -= 0.045 - 0.021 * moulding[plinth]
    scan = Scan("trim", wall, WORLD, np.array([[0, -9.0, 1.7]]), np.zeros(len(wall), np.int32))
    f = only(find_facades(scan, whole(scan, 0.0)))
    assert abs(f.frame.t[1]) < 0.002
    assert f.roughness < 0.008
