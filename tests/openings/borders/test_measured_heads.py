"""Curved heads of openings that few beams show."""

from dataclasses import replace

import numpy as np
import pytest
import shapely

from frontage.geometry.ring import ring_contains
from frontage.openings import find_openings
from frontage.openings.borders.measure import measure
from frontage.openings.borders.shapes import ring_of
from frontage.openings.wall.crossings import CrossingBeams
from fronts import box_of, scan_wall

EYE = np.array([0.5, -8.0, 1.7])
FRAME = 0.15  # m behind the wall
ARCH = (1.0, 2.0, 2.2, 4.0)


def measured(shape, place, rise, *, begins=0.0, ends=9.0, spacing=0.03, seed=0):
    """The outline of one opening in a wall; what lies below `begins` and above `ends` m is hidden."""
    rng, ring = np.random.default_rng(seed), ring_of(shape, place, rise)[0]
    x, z = np.meshgrid(np.arange(0.2, 3.0, spacing), np.arange(place[1] - 0.8, place[3] + 0.8, spacing))
    p = np.column_stack([x.ravel(), z.ravel()]) + rng.uniform(-spacing / 2, spacing / 2, (x.size, 2))
    slope = (p - EYE[[0, 2]]) / -EYE[1]
    there = ring_contains(ring, p + slope * FRAME)
    depth = np.where(ring_contains(ring, p) & there, FRAME, 0.0)  # else on the reveal, or the wall
    depth = np.where((p[:, 1] < begins) | (p[:, 1] > ends), -1.0, depth) + rng.normal(0.0, 0.003, len(p))
    order = np.argsort(p[:, 0], kind="stable")
    ranges = np.hypot(1.0, np.hypot(*slope[order].T)) * -EYE[1]
    sight = CrossingBeams(p[order].T, slope[order].T, np.zeros(len(p)), depth[order], ranges, 0.015)
    x0, z0, x1, z1 = place
    return measure(sight, [(x0, max(z0, begins), x1, min(z1, ends))], 2.0 * spacing, spacing)[0]


@pytest.mark.parametrize("seed", range(4))
def test_a_head_springs_above_the_foot_or_is_straight(seed):
    found = measured("round", ARCH, 0.6, begins=3.42, seed=seed, spacing=0.05)  # it springs 2 cm lower
    assert found.rise == 0.0 or found.place[3] - found.rise > found.place[1]
    assert shapely.Polygon(found.ring[0]).is_valid


def test_a_head_whose_end_is_hidden_has_the_sigma_of_the_hidden_border():
    seen, hidden = measured("round", ARCH, 0.6), measured("round", ARCH, 0.6, ends=3.75)
    assert seen.shape == "round" and np.sqrt(seen.covariance[3, 3]) < 0.01
    assert hidden.rise > 0.0 and hidden.borders[3].gain == 0.0
    assert np.sqrt(hidden.covariance[3, 3]) >= hidden.borders[3].sigma > 0.1


@pytest.mark.parametrize("rough", [3.9, 4.2])
def test_a_hood_mould_above_an_arch_does_not_draw_its_head_up(rough):
    rng, ring = np.random.default_rng(0), ring_of("round", ARCH, 0.6)[0]
    x, z = np.meshgrid(np.arange(0.2, 3.0, 0.02), np.arange(1.2, 5.6, 0.02))
    p = np.column_stack([x.ravel(), z.ravel()]) + rng.uniform(-0.01, 0.01, (x.size, 2))
    off = np.hypot(p[:, 0] - 1.6, p[:, 1] - 3.4)
    hood = (off > 0.62) & (off < 0.75) & (p[:, 1] > 3.4)  # stands out further than the frame lies back
    depth = np.select([hood, ring_contains(ring, p)], [-0.1, 0.06], 0.0) + rng.normal(0.0, 0.003, len(p))
    shadow = (off > 0.75) & (off < 0.85) & (p[:, 1] > 3.4)
    p, depth = p[~shadow], depth[~shadow]
    order, none = np.argsort(p[:, 0], kind="stable"), np.zeros(len(p))
    sight = CrossingBeams(p[order].T, np.zeros((2, len(p))), none, depth[order], none, 0.015)
    found = measure(sight, [(1.0, 2.0, 2.2, rough)], 0.04, 0.02)[0]
    assert found.shape == "round" and found.place[3] == pytest.approx(4.0, abs=0.02)


@pytest.mark.parametrize("seed", range(4))
def test_casings_level_with_the_wall_beside_an_empty_upper_sash_are_no_pointed_head(seed):
    place, sash, count = np.array([2.0, 1.0, 3.0, 3.4]), 2.3, 40
    facade, scan = scan_wall([tuple(place)], spacing=0.04, depth=0.09, rays=False, seed=seed)
    x, _, z = scan.xyz.T
    empty = (x > place[0]) & (x < place[2]) & (z > sash) & (z < place[3])
    rng = np.random.default_rng(seed)
    left = rng.random(count) < 0.5
    x = np.where(left, rng.uniform(2.02, 2.12, count), rng.uniform(2.88, 2.98, count))
    casings = np.column_stack([x, rng.normal(0.0, 0.003, count), rng.uniform(sash, place[3], count)])
    points = np.vstack([scan.xyz[~empty], casings])
    scan = replace(scan, xyz=points, origin_index=np.full(len(points), -1, np.int32))
    index = np.arange(len(points))
    (found,) = find_openings(replace(facade, support=index, inliers=index), scan).openings
    assert found.shape == "rectangle"
    assert np.abs(box_of(found) - place).max() < 0.05


@pytest.mark.parametrize("seed", range(3))
def test_a_ceiling_seen_aslant_through_a_square_window_makes_no_circle_of_it(seed):
    """Without lines of sight, its points seem to lie behind the wall above the window."""
    hole, rng = (1.0, 2.0, 2.3, 3.3), np.random.default_rng(seed)
    x, z = np.meshgrid(np.arange(0.2, 3.1, 0.022), np.arange(1.2, 4.3, 0.022))
    p = np.column_stack([x.ravel(), z.ravel()]) + rng.uniform(-0.003, 0.003, (x.size, 2))
    wall = p[~((p > hole[:2]) & (p < hole[2:])).all(1)]
    frame, ceiling = (
        rng.uniform((1.1, 2.0), (2.2, 2.2), (20, 2)),
        rng.uniform((1.0, 3.28), (2.3, 3.6), (1200, 2)),
    )
    places = np.concatenate([wall, frame, ceiling])
    depth = np.concatenate([np.zeros(len(wall)), np.full(20, 0.19), rng.uniform(0.3, 0.9, 1200)])
    depth += rng.normal(0.0, 0.004, len(depth))
    k = np.argsort(places[:, 0], kind="stable")
    none = np.zeros((2, len(k)))
    sight = CrossingBeams(places[k].T, none, none[0], depth[k], none[0], 0.015)
    (found,) = measure(sight, [hole], 0.044, 0.022)
    assert found.shape == "rectangle"
    assert np.abs(np.subtract(found.place, hole)).max() < 0.03
