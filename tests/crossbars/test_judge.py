"""Bars in their places: the adjustment of edges, standard errors, provenance, and how sure a layout is."""

import numpy as np
import pytest

from crossbars.painted import DEPTH, EYES, HOLE, bar, view, window
from frontage.crossbars.adjust import Adjusted, Known, Shown, adjust
from frontage.crossbars.division import Line
from frontage.crossbars.evidence import bars_by_evidence
from frontage.crossbars.observe import look
from frontage.crossbars.options import CrossbarOptions
from frontage.crossbars.place import pose_sigmas
from frontage.crossbars.readings import Readings
from frontage.geometry.arrays import Float
from frontage.geometry.rigid import Rigid3
from frontage.model import Glazing

X0, Z0, X1, Z1 = HOLE
TILT = np.array([[-0.5, 0.3], [-0.1, 0.32], [0.2, 0.31], [0.6, 0.35]])
TRUE = ((0, 0.1, 0.06), (0, 0.5, 0.05), (1, 2.4, 0.05))  # axis, position, width


def adjusted(rng: np.random.Generator, side: float = 0.0, wrong: bool = False) -> Adjusted:
    """Adjusts edges of three bars, 1 cm behind the plane that they are read on, in four displaced views."""
    shift = rng.normal(0, 0.003, (4, 2))
    rows = []
    for k, (axis, at, width) in enumerate(TRUE):
        for v in range(4):
            for s in (-1, 1):
                tilt = TILT[v, axis]
                faced = side * (tilt * s < 0)
                edge = at + s * width / 2 - tilt * (0.01 + faced) + shift[v, axis]
                rows.append((k, v, s, edge + rng.normal(0, 0.0018)))
    if wrong:
        rows[3] = (*rows[3][:3], rows[3][3] + 0.02)
    table = np.array(rows)
    k, v, s = table[:, :3].astype(np.int64).T
    lines = [Line(axis, at + 0.004, (0.0, 1.0), width, 20.0) for axis, at, width in TRUE]
    views = Shown(TILT, np.full((4, 2), 0.005), np.full((4, 2), 0.003))
    return adjust(lines, Readings(k, v, s, table[:, 3]), views, DEPTH, Known(DEPTH, 0.02))


def test_an_adjustment_recovers_places_and_depth_within_its_standard_errors() -> None:
    found = [adjusted(np.random.default_rng(k), side=0.01) for k in range(60)]
    errors = np.array([[line.position - t[1] for line, t in zip(f.lines, TRUE, strict=True)] for f in found])
    sigma = np.array([f.sigma for f in found])
    assert np.sqrt((errors**2).mean()) < 0.004
    assert 0.2 < ((errors / sigma) ** 2).mean() < 1.3
    depth = np.array([f.depth.value - DEPTH - 0.01 for f in found])
    assert np.sqrt((depth**2).mean()) < 0.008
    assert 0.2 < ((depth / np.array([f.depth.sigma[0] for f in found])) ** 2).mean() < 1.5


def test_side_faces_do_not_widen_bars() -> None:
    plain, thick = (
        np.mean(
            [[line.width for line in adjusted(np.random.default_rng(k), side=s).lines] for k in range(30)], 0
        )
        for s in (0.0, 0.02)
    )
    assert np.abs(thick - plain).max() < 0.004


def test_one_wrong_edge_does_little() -> None:
    right = adjusted(np.random.default_rng(3))
    wrong = adjusted(np.random.default_rng(3), wrong=True)
    moved = [a.position - b.position for a, b in zip(right.lines, wrong.lines, strict=True)]
    assert np.abs(moved).max() < 0.002


def find(eyes: tuple[tuple[float, float, float], ...], sigma_pose: float) -> Glazing:
    mullion = bar("vertical", 0.02, Z0, Z1)
    views = [view(eye, [mullion], sigma_pose=sigma_pose) for eye in eyes]
    return bars_by_evidence([window(views)], CrossbarOptions())[0].glazing


def test_standard_errors_grow_with_those_of_poses_and_shrink_with_views() -> None:
    (good,), (bad,), (few,) = (find(EYES, 0.001).bars, find(EYES, 0.01).bars, find(EYES[:1], 0.01).bars)
    assert 0.001 < good.sigma < 0.5 * bad.sigma
    assert bad.sigma < few.sigma < 0.02


def test_the_depth_is_that_of_the_bars() -> None:
    depth = find(EYES, 0.001).depth
    assert depth is not None
    assert abs(depth.value - DEPTH) < 0.01
    assert 0.0005 < float(depth.sigma[0]) < 0.02


def test_displacements_of_views_follow_from_the_covariance_of_poses() -> None:
    sight = look(window([view(EYES[0], sigma_pose=0.004)]))
    sigma = pose_sigmas(sight)[0]
    rng = np.random.default_rng(0)
    photo = sight.window.views[0].photo
    middle = np.array([*sight.window.ring.mean(0)])
    ray = photo.camera.ray(photo.project(np.array([[middle[0], 0.0, middle[1]]])))
    off = rng.normal(0, 0.004, (2000, 3))
    moved = [_met(Rigid3("local", "camera", photo.pose.R, photo.pose.t + by), ray) for by in off]
    assert np.std(np.array(moved) - middle, axis=0) == pytest.approx(sigma, rel=0.1)


def _met(pose: Rigid3, ray: Float) -> Float:
    """Returns where a ray of a camera meets the wall, (x, z) m."""
    way = pose.rotate(ray)[0]
    return np.asarray((pose.t - way * pose.t[1] / way[1])[[0, 2]])


def test_the_depth_of_a_window_without_bars_is_that_of_its_frame() -> None:
    sight = window([view(eye) for eye in EYES], depth=DEPTH + 0.02)
    found = bars_by_evidence([sight], CrossbarOptions())[0].glazing
    assert found.resolved and not found.bars and found.depth is not None
    assert abs(found.depth.value - DEPTH) < 0.01
    assert 0.001 < float(found.depth.sigma[0]) < 0.02
