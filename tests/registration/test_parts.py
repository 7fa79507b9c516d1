"""The parts of registration: model walls, surfels, coarse search, adjustment, selection, strips."""

import numpy as np
import pytest

from frontage.errors import InputError
from frontage.geometry.rigid import Rigid3
from frontage.model import Scan
from frontage.registration import PosePrior, RegistrationOptions
from frontage.registration.adjust import adjust
from frontage.registration.coarse import Plan, plan_of_walls, search_motions
from frontage.registration.correspond import match_surfels
from frontage.registration.equations import NormalEquations, apply_step, linearise, rotation_vector
from frontage.registration.icp import plain_icp
from frontage.registration.observability import about_frame
from frontage.registration.problem import Problem
from frontage.registration.select import select_walls
from frontage.registration.strips import correct_strips
from frontage.registration.walls import model_walls
from frontage.solve.surfels import make_surfels
from registration.boxes import ALONE, STREET, WORLD, BoxHouse, misplaced, model_of, scan_of

PLACE = np.array([0.0, 0.0, 1.7])
IDENTITY = Rigid3.identity("local", "given")


def test_wall_normals_point_outwards_even_for_reversed_rings() -> None:
    model = model_of(ALONE)
    (building,) = model.buildings
    (shell,) = building.shells
    wrong = [type(s)(s.ring[::-1], s.semantics, s.source_id) for s in shell.surfaces]
    turned = type(model)((type(building)("B0", (type(shell)("1.2", tuple(wrong)),)),), WORLD)
    for m in (model, turned):
        front = next(p for p in model_walls(m).patches if p.source == "B0-0")
        assert front.normal == pytest.approx([0, -1, 0], abs=1e-9)


def test_party_walls_are_hidden_up_to_the_lower_roof() -> None:
    low, high = BoxHouse(-4.5, 5, height=6), BoxHouse(4.5, 5, height=9)
    walls = {p.source: p for p in model_walls(model_of((low, high))).patches}
    assert "B0-1" not in walls
    assert walls["B1-3"].area == pytest.approx(10 * 3, rel=0.05)
    assert walls["B1-0"].area == pytest.approx(9 * 9, rel=1e-6)


def test_surfel_areas_do_not_depend_on_the_density() -> None:
    rng = np.random.default_rng(1)
    dense = np.column_stack(
        [rng.uniform(0, 4, 40_000), rng.normal(0.1, 0.002, 40_000), rng.uniform(0, 3, 40_000)]
    )
    for part in (dense, dense[:4000]):
        scan = Scan("wall", part, WORLD, np.array([[2.0, -5, 1]]), np.zeros(len(part), np.int32))
        s = make_surfels(scan, 0.2, np.zeros(3), 50.0)
        assert s.area.sum() == pytest.approx(12.0, rel=0.12)
        assert (s.normal[:, 1] < -0.9).mean() > 0.99


def test_coarse_search_finds_turn_and_shift() -> None:
    walls = plan_of_walls(model_walls(model_of(STREET)))
    turn, shift = np.radians(-12.0), np.array([4.0, -3.0])
    c, s = np.cos(turn), np.sin(turn)
    R = np.array([[c, -s], [s, c]])
    source = Plan((walls.xy - shift) @ R, walls.theta - turn, walls.weight)
    best = search_motions(source, walls, np.zeros(2), (2.5, np.radians(6.0)))[0]
    assert best.turn == pytest.approx(turn, abs=np.radians(0.8))
    assert best.shift == pytest.approx(tuple(shift), abs=0.6)


def test_walls_facing_away_do_not_correlate() -> None:
    walls = plan_of_walls(model_walls(model_of(STREET)))
    back = Plan(walls.xy, walls.theta + np.pi, walls.weight)
    sigma = (1.0, np.radians(1.0))
    right = search_motions(walls, walls, np.zeros(2), sigma)[0].score
    wrong = search_motions(back, walls, np.zeros(2), sigma)
    assert not wrong or wrong[0].score < 0.5 * right


def test_surfels_facing_away_do_not_match_a_front() -> None:
    scan = scan_of(ALONE, PLACE)
    pieces = make_surfels(scan, 0.2, PLACE, 60)
    walls = model_walls(model_of(ALONE))
    assert len(match_surfels(pieces, walls, 0.3)) > 0.9 * pieces.upright.sum()
    turned = type(pieces)(pieces.xyz, -pieces.normal, pieces.oriented, pieces.area, pieces.thickness)
    assert len(match_surfels(turned, walls, 0.3)) == 0


def problem_of(scan: Scan) -> Problem:
    prior = PosePrior(PLACE, np.array([2.0, 2.0, 1.0]), 0.1, 0.002)
    return Problem(
        [make_surfels(scan, 0.3, PLACE, 60)], model_walls(model_of(STREET)), [prior], RegistrationOptions()
    )


def test_the_gradient_of_the_adjustment_equals_finite_differences() -> None:
    problem = problem_of(scan_of(STREET, PLACE, step=0.15))
    pose = apply_step(IDENTITY, PLACE, np.array([0.05, -0.04, 0.0, 0.0, 0.0, 0.01]))
    matches = [match_surfels(problem.pieces[0].moved(pose), problem.walls, 0.5)]
    model_errors = np.zeros((len(problem.walls.names) + len(problem.walls.patches), 3))
    wide = 1e4  # a loss without an edge: plain least squares

    def linearised(at: Rigid3) -> NormalEquations:
        return linearise(problem, [at], model_errors, matches, None, scale=wide, free_levels=True)

    state = linearised(pose)
    area = problem.pieces[0].area[matches[0].piece]
    for k in range(6):
        step = np.zeros(6)
        step[k] = 1e-5
        cost = []
        for sign in (1, -1):
            there = linearised(apply_step(pose, PLACE, sign * step))
            cost.append(0.5 * float(area @ there.r[0] ** 2))
        slope = (cost[0] - cost[1]) / 2e-5
        rows = state.r[0]
        y = pose.apply(problem.pieces[0].xyz[matches[0].piece])
        n = problem.walls.normals[matches[0].patch]
        jacobian = np.column_stack([n, np.cross(y - pose.apply(PLACE[None]), n)])[:, k]
        assert slope == pytest.approx(float(area @ (rows * jacobian)), rel=1e-4, abs=1e-6)


def test_rotating_the_world_rotates_the_result() -> None:
    turn = 0.7
    boxes = tuple(
        BoxHouse(
            np.cos(turn) * b.x - np.sin(turn) * b.y,
            np.sin(turn) * b.x + np.cos(turn) * b.y,
            b.width,
            b.depth,
            b.height,
            b.turn + turn,
        )
        for b in STREET
    )
    sigma = []
    for world in (STREET, boxes):
        scan = scan_of(world, PLACE, step=0.12)
        prior = PosePrior(PLACE, np.array([2.0, 2.0, 1.0]), 0.1, 0.002)
        problem = Problem(
            [make_surfels(scan, 0.2, PLACE, 60)], model_walls(model_of(world)), [prior], RegistrationOptions()
        )
        sigma.append(np.linalg.eigvalsh(adjust(problem, [IDENTITY]).covariance[:2, :2]))
    assert sigma[0] == pytest.approx(sigma[1], rel=0.1)


def test_covariance_moves_with_the_pivot() -> None:
    """The sigma of a motion's translation is that of the point to which it moves the given origin."""
    rng = np.random.default_rng(0)
    A = rng.normal(size=(6, 6))
    C = A @ A.T
    pose = apply_step(IDENTITY, np.array([3.0, 1.0, 0.0]), np.array([1.0, 2.0, 0.5, 0.1, -0.2, 0.3]))
    position = pose.apply(np.array([[30.0, -20.0, 1.0]]))[0]
    got = about_frame(C, pose, position)
    step = rng.normal(0, 1e-6, 6)
    far = apply_step(pose, np.array([30.0, -20.0, 1.0]), step)
    tangent = np.concatenate([far.t - pose.t, rotation_vector(far.R @ pose.R.T)])
    J = np.eye(6)
    J[:3, 3:] = np.column_stack([np.cross(e, pose.t - position) for e in np.eye(3)])
    assert tangent == pytest.approx(J @ step, abs=1e-10)
    assert got == pytest.approx(J @ C @ J.T)


def test_icp_converges_from_a_good_start() -> None:
    scan = scan_of(ALONE, PLACE, step=0.2)
    walls = scan.xyz[scan.xyz[:, 2] > 0.3]
    off = np.array([0.0, 0.15, 0.0])
    for method in ("point", "plane"):
        pose = plain_icp(walls + off, model_of(ALONE), method)  # type: ignore[arg-type]
        assert pose.apply(walls + off)[:, 1].mean() == pytest.approx(8.0, abs=0.02)


def test_selection_measures_offset_turn_and_lean() -> None:
    scan = scan_of(STREET, PLACE)
    shift = np.zeros((len(STREET), 3))
    shift[0] = [0.0, 0.10, 0.0]
    found = select_walls(scan, model_of(STREET, shift))
    by_id = {w.surface: w for w in found.walls}
    first, second = by_id["B0-0"], by_id["B1-0"]
    assert first.offset == pytest.approx(0.10, abs=0.005)
    assert first.significance[0] > 5
    assert abs(second.offset) < 0.003
    assert np.abs([second.turn, second.lean]).max() < 0.002
    assert np.nanmax(np.abs(second.relief[:-1, 1:-1])) < 0.02  # but for the ground at its foot
    assert second.coverage > 0.8
    assert second.local_from_facade.R[:, 1] == pytest.approx([0, 1, 0], abs=0.01)
    assert np.abs(scan.xyz[second.index, 1] - 6.4).max() < 1.0


def test_buildings_that_only_the_model_or_only_the_scan_has_are_listed() -> None:
    scan = scan_of(STREET, PLACE)
    extra = BoxHouse(0, 30, width=12, height=25)
    only_scan = select_walls(scan, model_of(STREET[:4] + STREET[5:]))
    assert any(np.hypot(c[0] - 5, c[1] + 7.5) < 3 for c, _ in only_scan.unknown)
    assert select_walls(scan, model_of(STREET)).unknown == ()
    ghost = BoxHouse(3.0, 3.0, width=3.0, depth=1.0)
    found = select_walls(scan, model_of((*STREET, ghost, extra)))
    assert found.absent == ("B6",)
    assert found.unseen == ("B7",)


def drive(drift: float) -> tuple[Scan, Scan]:
    """Returns a drive along the street twice: true, and with an error across that grows along the way."""
    parts, times = [], []
    way = np.linspace(-12, 12, 9)
    for k, x in enumerate(way):
        s = scan_of(STREET, np.array([x, 0.0, 2.0]), k, step=0.25)
        rows = np.abs(s.xyz[:, 0] - x) < 15
        parts.append(s.xyz[rows])
        times.append(np.full(int(rows.sum()), float(k)))
    xyz, time = np.concatenate(parts), np.concatenate(times)
    origins = np.column_stack([way, np.zeros(9), np.full(9, 2.0)])
    index = time.astype(np.int32)
    true = Scan("drive", xyz, WORLD, origins, index, time=time)
    error = np.column_stack([np.zeros(len(time)), 0.2 + drift * time, np.zeros(len(time))])
    moved_origins = origins + np.column_stack([np.zeros(9), 0.2 + drift * np.arange(9), np.zeros(9)])
    return true, Scan("drive", xyz + error, WORLD, moved_origins, index, time=time)


def test_strips_remove_the_drift_of_a_trajectory() -> None:
    true, given = drive(0.02)
    prior = PosePrior(PLACE, np.array([0.5, 0.5, 0.3]), 0.01, 0.002)
    options = RegistrationOptions(sigma_model=0.005, sigma_height=0.01, sigma_lean=0.01)
    result = correct_strips(
        given, model_of(STREET), prior, length=8.0, drift=0.1, drift_angle=0.002, options=options
    )
    assert len(result.strips) == 3
    off = np.abs(result.scan.xyz - true.xyz)[:, 1]
    assert np.median(off) < 0.03
    assert np.median(np.abs(given.xyz - true.xyz)[:, 1]) > 0.2
    assert np.abs(result.scan.origins - true.origins)[:, 1].max() < 0.12


def test_strips_need_times_and_a_trajectory() -> None:
    scan = misplaced(scan_of(ALONE, PLACE, step=0.3), np.zeros(3), 0.0).scan
    with pytest.raises(InputError, match="gps_time and a trajectory"):
        correct_strips(scan, model_of(ALONE), PosePrior(PLACE, np.ones(3), 0.1, 0.1))
