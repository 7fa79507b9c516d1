"""Solids with reliefs are closed, valid, and exactly as large as the host less what was cut."""

import numpy as np
import pytest
import shapely
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from frontage.geometry.plane import facade_axes
from frontage.geometry.rigid import Rigid3
from frontage.geometry.ring import rectangle, ring_area
from frontage.model import Face, Failed, Solid, Surface
from frontage.solids.brep import GRID_PER_M, rings_of, unmatched_edges, volume6
from frontage.solids.cells.build import build_solid
from frontage.solids.coarse.extrude import ground_block
from frontage.solids.coarse.host import Host
from frontage.solids.curves import arch_ring
from frontage.solids.options import BuildOptions
from frontage.solids.relief import Built, FacadeReliefs, Relief
from frontage.validation import validate
from solids.facades import WORLD, block, frame, random_facade

STRAIGHT = frame(np.pi / 2)  # X = x, Y = y, Z = z: the grid of the wall is the grid of the solid
WALL = rectangle(0, 0, 12, 9)


def built(reliefs: list[Relief], place=STRAIGHT, outline=WALL, options=None, host=None) -> Built:
    host = host or block(place, outline)
    result = build_solid(host, [FacadeReliefs("F", place, outline, tuple(reliefs))], options)
    assert isinstance(result, Built)
    return result


def removed6(reliefs: list[Relief], base: int = 0) -> int:
    """Returns six times the volume that disjoint reliefs remove, from their outlines alone."""
    total = 0
    for r in reliefs:
        deep = round((r.depth or 0.0) * GRID_PER_M)
        total += round(2 * ring_area(np.rint(r.ring * GRID_PER_M))) * 3 * deep + removed6(list(r.inside))
    return total


def column6(solid: Solid, front: int) -> int:
    """Returns six times the volume between the plane y = `front` and all faces that look to the street."""
    total = 0
    for face in solid.faces:
        at = solid.vertices[list(face.ring)]
        if len(set(at[:, 1].tolist())) == 1:
            for ring in rings_of(face):
                p = solid.vertices[list(ring)][:, [0, 2]].astype(object)
                x, z = p[:, 0] - p[0, 0], p[:, 1] - p[0, 1]
                area2 = (x * np.roll(z, -1) - np.roll(x, -1) * z).sum()
                total += 3 * int(area2) * (int(at[0, 1]) - front)
    return total


def kinds(solid: Solid, semantics: str) -> list[Face]:
    return [f for f in solid.faces if f.semantics == semantics]


def test_window_becomes_a_recess_with_its_surface_at_the_bottom():
    window = Relief("W", rectangle(2, 3, 3.5, 5), 0.25)
    host = block(STRAIGHT, WALL)
    result = built([window], host=host)
    (pane,) = kinds(result.solid, "Window")
    assert pane.opening == "W"
    y = result.solid.vertices[list(pane.ring)][:, 1]
    assert (y == host.vertices[0, 1] + 2500).all()
    assert len(result.solid.faces) == len(host.faces) + 1 + 4
    assert volume6(host) - volume6(result.solid) == removed6([window]) == 6 * 15_000 * 20_000 * 2_500
    assert not validate(result.solid) and not result.notes and not result.failed


def test_flush_opening_is_a_face_of_its_own_in_the_wall():
    result = built([Relief("W", rectangle(2, 3, 3.5, 5), None)])
    assert volume6(result.solid) == volume6(result.host)
    assert [f.opening for f in kinds(result.solid, "Window")] == ["W"]
    assert not validate(result.solid)


def test_door_at_the_ground_line_is_a_notch_of_wall_and_ground():
    door = Relief("D", rectangle(5, 0, 6, 2.1), 0.3, "Door")
    result = built([door])
    (ground,) = kinds(result.solid, "GroundSurface")
    assert len(ground.ring) == 8
    assert not [f for f in kinds(result.solid, "WallSurface") if f.holes]
    assert volume6(result.host) - volume6(result.solid) == removed6([door])
    assert not validate(result.solid)


@pytest.mark.parametrize("bottom", [-0.4, 0.012, 0.0])
def test_door_near_the_ground_line_goes_down_to_it(bottom):
    result = built([Relief("D", rectangle(5, bottom, 6, 2.1), 0.3, "Door")])
    assert volume6(result.host) - volume6(result.solid) == 6 * 10_000 * 21_000 * 3_000
    assert bool(result.notes) == (bottom != 0.0)


def test_arch_follows_its_curve():
    ring = arch_ring(2, 4, 1, spring=3, rise=1, chord_error=0.002)
    result = built([Relief("A", ring, 0.2)])
    lost = (volume6(result.host) - volume6(result.solid)) / 6e12
    true = 0.2 * (4 + np.pi / 2)
    assert true - 0.2 * 0.002 * np.pi < lost < true
    assert not validate(result.solid)


def test_protrusion_with_a_window_in_it_and_a_window_beside_it():
    pane = Relief("P1", rectangle(5.2, 3.2, 5.8, 4.4), 0.15)
    oriel = Relief("P", rectangle(5, 3, 6, 5), -0.8, "WallSurface", (pane,))
    reliefs = [oriel, Relief("W", rectangle(6, 3, 7, 5), 0.1)]
    result = built(reliefs)
    assert volume6(result.host) - volume6(result.solid) == removed6(reliefs)
    assert (
        len(kinds(result.solid, "OuterCeilingSurface")) == len(kinds(result.solid, "OuterFloorSurface")) == 1
    )
    assert not validate(result.solid)


def test_openings_that_touch_in_a_point_are_separated():
    reliefs = [Relief("A", rectangle(2, 2, 3, 3), 0.2), Relief("B", rectangle(3, 3, 4, 4), 0.2)]
    result = built(reliefs)
    assert any(n.startswith("B: 0.01 m cut off") for n in result.notes)
    assert removed6(reliefs) - (volume6(result.host) - volume6(result.solid)) == 6 * 100 * 100 * 2000
    assert not validate(result.solid)


def test_overlap_is_clipped_or_refused():
    two = [Relief("A", rectangle(2, 2, 4, 4), 0.2), Relief("B", rectangle(3.5, 2, 6, 4), 0.3)]
    clipped = built(two)
    assert volume6(clipped.host) - volume6(clipped.solid) == 6 * 20_000 * (20_000 * 2000 + 20_000 * 3000)
    assert any("overlaps A" in n for n in clipped.notes)
    refused = built(two, options=BuildOptions(overlaps="refuse"))
    assert [f.code for f in refused.failed] == ["S313"]
    assert volume6(refused.host) - volume6(refused.solid) == removed6(two[:1])


def test_narrow_pier_is_closed():
    result = built([Relief("A", rectangle(2, 2, 3, 4), 0.2), Relief("B", rectangle(3.01, 2, 4, 4), 0.2)])
    assert volume6(result.host) - volume6(result.solid) == 6 * 20_000 * 20_000 * 2000
    assert result.notes and not validate(result.solid)


def test_an_opening_over_the_whole_wall_leaves_a_frame():
    result = built([Relief("A", WALL, 0.2)])
    lost = (volume6(result.host) - volume6(result.solid)) / 6e12
    assert lost == pytest.approx(0.2 * (12 - 0.04) * (9 - 0.02), abs=1e-9)
    assert not validate(result.solid)


def test_recess_deeper_than_the_building_is_made_shallower():
    host = block(STRAIGHT, WALL, 0.5)
    result = built([Relief("A", rectangle(2, 2, 3, 3), 0.7)], host=host)
    assert "no more is free behind it" in result.notes[0]
    assert not validate(result.solid)
    assert 0.4 < (volume6(host) - volume6(result.solid)) / 6e12 < 0.48 + 1e-4


@pytest.mark.parametrize(
    ("ring", "code"),
    [
        (np.array([[2.0, 2], [3, 3], [3, 2], [2, 3]]), "S312"),
        (rectangle(20, 2, 21, 3), "S310"),
        (rectangle(11.5, 2, 14, 3), "S311"),
        (rectangle(2, 2, 2.015, 3), "S314"),
        (np.full((4, 2), np.nan), "S312"),
    ],
)
def test_what_cannot_be_placed_is_named(ring, code):
    result = built([Relief("A", ring, 0.2), Relief("B", rectangle(5, 5, 6, 6), 0.2)])
    assert [f.code for f in result.failed] == [code]
    assert "A" in result.failed[0].message
    assert [f.opening for f in kinds(result.solid, "Window")] == ["B"]


@pytest.mark.parametrize("step", [-1.6, 1.3])
@pytest.mark.parametrize("azimuth", [np.pi / 2, 1.1, 2.3])
def test_a_front_far_from_the_wall_of_the_host_stands_on_a_step_of_it(step, azimuth):
    wall = frame(azimuth)
    place = Rigid3("local", "facade", wall.R, wall.t + step * wall.R[:, 1])
    window = Relief("W", rectangle(4, 5, 5, 6.5), 0.2)
    made = build_solid(block(wall, WALL), [FacadeReliefs("F", place, rectangle(1, 3, 11, 8), (window,))])
    assert isinstance(made, Built) and not made.failed and not validate(made.solid)
    (pane,) = kinds(made.solid, "Window")
    y = wall.inverse.apply(made.solid.vertices[list(pane.ring)] / GRID_PER_M)[:, 1]
    assert np.abs(y - (step + 0.2)).max() < 5e-4
    assert any(f"a step of {step:.2f} m" in note for note in made.notes)


def test_a_front_further_off_than_an_arcade_is_deep_is_refused():
    place = Rigid3("local", "facade", STRAIGHT.R, STRAIGHT.t - 4.5 * STRAIGHT.R[:, 1])
    window = Relief("W", rectangle(4, 5, 5, 6.5), 0.2)
    made = build_solid(block(STRAIGHT, WALL), [FacadeReliefs("F", place, WALL, (window,))])
    assert isinstance(made, Built) and [f.code for f in made.failed] == ["S310"]


def test_open_host_is_refused():
    host = block(STRAIGHT, WALL)
    open_host = Solid("B", host.vertices, host.origin, host.faces[:-1], "2")
    result = build_solid(open_host, [])
    assert isinstance(result, Failed) and result.code == "S301"


def test_host_without_openings_is_the_host():
    host = block(frame(0.3), WALL)
    assert built([], frame(0.3), host=host).solid is host
    far = built([Relief("A", rectangle(50, 2, 51, 3), 0.2)], frame(0.3), host=host)
    assert far.solid is host and far.host is host


def test_model_without_depth_keeps_the_volume():
    pane = Relief("P1", rectangle(5.2, 3.2, 5.8, 4.4), 0.15)
    reliefs = [Relief("P", rectangle(5, 3, 6, 5), -0.8, "WallSurface", (pane,))]
    reliefs += [Relief("W", rectangle(8, 3, 9, 5), 0.2), Relief("D", rectangle(1, 0, 2, 2), 0.2, "Door")]
    result = built(reliefs, options=BuildOptions(depth=False))
    assert volume6(result.solid) == volume6(result.host)
    assert {f.opening for f in result.solid.faces} == {None, "P1", "W", "D"}
    assert not validate(result.solid)


def test_wall_of_several_coplanar_faces():
    """The front of the host is two polygons; an opening crosses the seam, another ends at it."""
    host = block(STRAIGHT, WALL)
    (x0, y, z0), (x1, _, z1) = host.vertices[:4].min(0).tolist(), host.vertices[:4].max(0).tolist()
    v = np.concatenate([host.vertices, [[x0 + 60_000, y, z0], [x0 + 60_000, y, z1]]])
    low, high = len(host.vertices), len(host.vertices) + 1
    by = {tuple(p): i for i, p in enumerate(host.vertices.tolist())}
    a, b, c, d = (by[p] for p in ((x0, y, z0), (x1, y, z0), (x1, y, z1), (x0, y, z1)))
    faces = [Face((a, low, high, d), "WallSurface"), Face((low, b, c, high), "WallSurface")]
    for f in host.faces[1:]:
        ring = list(f.ring)
        for p, q, new in ((b, a, low), (d, c, high)):
            pairs = list(zip(ring, ring[1:] + ring[:1], strict=True))
            if (p, q) in pairs:
                ring.insert(pairs.index((p, q)) + 1, new)
        faces.append(Face(tuple(ring), f.semantics))
    split = Solid("B", v, host.origin, tuple(faces), "2")
    assert not unmatched_edges(split.faces)
    reliefs = [Relief("A", rectangle(5, 4, 7, 6), 0.2), Relief("B", rectangle(6.005, 1, 7, 2), 0.2)]
    reliefs += [
        Relief("D", rectangle(5.5, 0, 6.5, 0.9), 0.3, "Door"),
        Relief("C", rectangle(5, 7, 7, 8), None),
    ]
    result = built(reliefs, host=split)
    assert not validate(result.solid) and not result.failed
    assert len(kinds(result.solid, "Window")) == 3 and len(kinds(result.solid, "Door")) == 1
    snapped = [reliefs[0], Relief("B", rectangle(6, 1, 7, 2), 0.2), *reliefs[2:]]
    assert volume6(split) - volume6(result.solid) == removed6(snapped)


def test_two_facades_that_meet_at_a_corner():
    host = block(STRAIGHT, WALL)
    side = frame(np.pi, at=(24.0, -7.0, 3.0))  # the right side of the block, seen from its street
    near = [Relief("A", rectangle(11.4, 3, 11.9, 5), 0.45), Relief("B", rectangle(9, 3, 10, 5), 0.2)]
    turned = [Relief("C", rectangle(0.1, 3, 0.7, 5), 0.45), Relief("D", rectangle(3, 0, 4, 2), 0.2, "Door")]
    facades = [FacadeReliefs("F1", STRAIGHT, WALL, tuple(near))]
    facades += [FacadeReliefs("F2", side, rectangle(0, 0, 9, 9), tuple(turned))]
    result = build_solid(host, facades)
    assert isinstance(result, Built) and not result.failed
    assert {f.opening for f in result.solid.faces} == {None, "A", "B", "C", "D"}
    assert any(n.startswith("C:") for n in result.notes), "the recesses would meet behind the corner"
    assert not validate(result.solid)


def test_openings_are_projected_onto_the_host_with_their_offset():
    host = block(STRAIGHT, WALL)
    place = frame(np.pi / 2 + 0.01, at=(12.0, -7.2, 3.0))
    result = built([Relief("A", rectangle(2, 2, 3, 3), 0.2)], place, host=host)
    assert result.offsets["A"] == pytest.approx(0.2 + 2.5 * 0.01 - 0.025 + 0.025, abs=0.06)
    assert set(map(tuple, host.vertices.tolist())) <= set(map(tuple, result.solid.vertices.tolist()))
    assert not validate(result.solid)


def test_reseated_walls_lie_in_the_measured_plane():
    host = block(frame(0.4), WALL)
    measured = frame(0.405, at=(12.0, -7.0, 3.0))
    shifted = type(measured)("local", "facade", measured.R, measured.t + 0.3 * measured.R[:, 1])
    result = built(
        [Relief("A", rectangle(2, 2, 3, 3), 0.2)], shifted, host=host, options=BuildOptions(reseat=True)
    )
    assert not validate(result.host) and not validate(result.solid)
    assert abs(result.offsets["A"]) < 2e-4
    assert (volume6(host) - volume6(result.host)) / 6e12 == pytest.approx(0.33 * 108, rel=0.1)


def test_many_random_facades_are_valid_and_exact():
    touching = (20702, 22062)  # three reliefs each with steps below a millimetre
    for seed in (*range(25), *touching):
        rng = np.random.default_rng(seed)
        host, facade = random_facade(rng, np.pi / 2)
        result = build_solid(host, [facade])
        assert isinstance(result, Built)
        assert not validate(result.solid), seed
        front = int(host.vertices[0, 1])
        assert volume6(host) == -column6(host, front)
        assert volume6(result.solid) == -column6(result.solid, front), seed


@settings(max_examples=40, deadline=None, suppress_health_check=list(HealthCheck), derandomize=True)
@given(st.integers(0, 2**32 - 1), st.floats(0, 6.28))
def test_any_facade_in_any_direction(seed, azimuth):
    host, facade = random_facade(np.random.default_rng(seed), azimuth)
    result = build_solid(host, [facade])
    assert isinstance(result, Built)
    assert not unmatched_edges(result.solid.faces)
    assert not validate(result.solid)
    assert "S399" not in {f.code for f in result.failed}
    assert {f.opening for f in result.solid.faces} - {None} == set(result.offsets) | {
        f.opening for f in result.solid.faces if f.opening and f.opening[-1] in "np"
    }


def test_two_facades_share_a_wall():
    """A second facade on the same wall gets the part of it that the first one has left."""
    host = block(STRAIGHT, WALL)
    first, second = Relief("A", rectangle(2, 2, 3, 3), 0.2), Relief("B", rectangle(2.5, 2, 4, 3), 0.2)
    third = Relief("C", rectangle(6, 2, 7, 3), 0.2)
    facades = [
        FacadeReliefs("F1", STRAIGHT, WALL, (first,)),
        FacadeReliefs("F2", STRAIGHT, WALL, (second, third)),
    ]
    result = build_solid(host, facades)
    assert isinstance(result, Built) and not validate(result.solid)
    assert {f.opening for f in result.solid.faces} == {None, "A", "B", "C"}
    assert any(n.startswith("B: its outline was changed") for n in result.notes)


def test_same_input_gives_the_same_solid():
    one, other = (build_solid(h, [f]) for h, f in (random_facade(np.random.default_rng(5)) for _ in range(2)))
    assert isinstance(one, Built) and isinstance(other, Built)
    assert one.solid.faces == other.solid.faces and one.notes == other.notes
    assert np.array_equal(one.solid.vertices, other.solid.vertices)


@pytest.mark.parametrize("seed", range(12))
def test_mosaic_of_touching_reliefs(seed):
    """Reliefs fill an irregular grid and touch along borders and at corners, in and out, with niches."""
    rng = np.random.default_rng(seed)
    place = STRAIGHT if seed % 2 else frame(rng.uniform(0, 6.28), rng.uniform(-0.05, 0.05))
    outline = rectangle(0, 0, 9, 7)
    xs, zs = np.sort(rng.uniform(0, 9, 6)).round(2), np.sort(rng.uniform(0, 7, 6)).round(2)
    reliefs = []
    for i, j in np.argwhere(rng.random((5, 5)) < 0.6).tolist():
        x0, x1, z0, z1 = float(xs[i]), float(xs[i + 1]), float(zs[j]), float(zs[j + 1])
        depth = rng.choice([None, 0.1, 0.105, 0.3, -0.3, float(rng.uniform(-0.6, 0.6))])
        inner: tuple[Relief, ...] = ()
        if min(x1 - x0, z1 - z0) > 0.3:
            niche = rectangle(x0 + 0.1, z0 + 0.05, x1 - 0.1, z1 - 0.05)
            inner = (Relief(f"{i}{j}n", niche, float(rng.uniform(-0.5, 0.5))),)
        reliefs.append(Relief(f"{i}{j}", rectangle(x0, z0, x1, z1), depth, "Window", inner))
    result = built(reliefs, place, outline)
    assert not validate(result.solid)
    assert not {"S399", "S316"} & {f.code for f in result.failed}
    assert len({f.opening for f in result.solid.faces}) > 5
    if place is STRAIGHT:
        assert volume6(result.solid) == -column6(result.solid, int(result.host.vertices[0, 1]))


def test_part_on_a_narrow_neck_is_left_out():
    """The rest of a clipped opening may be connected by a millimetre only."""
    later = np.array(
        [[2, 2], [4, 2], [4, 4], [3.001, 4], [3.001, 4.4], [3.6, 4.4], [3.6, 5], [3, 5], [3, 4], [2, 4.0]]
    )
    result = built([Relief("A", later, 0.2)])
    assert not validate(result.solid)
    assert volume6(result.host) - volume6(result.solid) == pytest.approx(
        6 * 20_000 * 20_000 * 2_000, rel=2e-3
    )
    assert len(result.notes) == 1


@pytest.mark.parametrize("foot", [0.0, 0.03])
def test_openings_behind_the_piers_of_an_arcade_lie_on_steps_between_them(foot):
    # the model draws the arcade as a wall; the front was measured on it, and a wall 2 m behind its gaps
    piers = shapely.union_all([shapely.box(x, foot, x + 1.0, 3.5) for x in (0.0, 5.5, 11.0)])
    ring = np.array((piers | shapely.box(0.0, 3.0, 12.0, 9.0)).exterior.coords)[:-1]
    front = FacadeReliefs("F1", STRAIGHT, ring, (Relief("F1/W", rectangle(4, 5, 5, 6.5), 0.2),))
    back = Rigid3("local", "facade", STRAIGHT.R, STRAIGHT.t + 2.0 * STRAIGHT.R[:, 1])
    rings = {"left": rectangle(2, 1, 4, 2.5), "right": rectangle(7, 0.8, 9, 2.6)}
    rings["door"] = rectangle(9.5, 0, 10.5, 2)
    shown = (
        *(Relief(n, r, 0.15) for n, r in rings.items()),
        Relief("hidden", rectangle(0.1, 1, 0.9, 2), 0.1),
    )
    behind = FacadeReliefs("F2", back, rectangle(0, 0, 12, 3), shown)
    made = build_solid(block(STRAIGHT, WALL), [front, behind])
    assert isinstance(made, Built) and not validate(made.solid)
    depth = STRAIGHT.inverse.apply(made.solid.vertices / GRID_PER_M)[:, 1]
    panes = {f.opening: depth[list(f.ring)] for f in kinds(made.solid, "Window")}
    assert set(panes) == {"F1/W", *rings}
    assert all(np.allclose(panes[n], 2.15, atol=5e-4) for n in rings)
    assert len(made.failed) == 1 and "hidden" in made.failed[0].message


def test_openings_beside_a_wall_at_their_depth_lie_on_a_step_of_the_next_wall():
    """The wall of a colonnade goes on a little beside the block behind the columns."""
    plan = np.array([[0, 0], [12, 0], [12, 2], [12.3, 2], [12.3, 10], [0, 10.0]])
    ground = Surface(np.column_stack([plan, np.zeros(6)])[::-1], "GroundSurface", "")
    host = ground_block("B", [ground], WORLD, 9.0)
    assert isinstance(host, Host)
    back = Rigid3("local", "facade", np.eye(3), np.array([0.0, 2.0, 0.0]))
    window = Relief("W", rectangle(4, 1, 5, 2.5), 0.2)
    made = build_solid(host.solid, [FacadeReliefs("F", back, rectangle(0.5, 0, 12.3, 3), (window,))])
    assert isinstance(made, Built) and not made.failed and not validate(made.solid)
    (pane,) = kinds(made.solid, "Window")
    assert made.solid.vertices[list(pane.ring), 1] / GRID_PER_M == pytest.approx(2.2, abs=5e-4)


def test_a_wall_wholly_behind_another_facade_is_refused_with_all_its_elements():
    front = FacadeReliefs("F1", STRAIGHT, WALL, (Relief("F1/W", rectangle(4, 5, 5, 6.5), 0.2),))
    back = Rigid3("local", "facade", STRAIGHT.R, STRAIGHT.t + 2.0 * STRAIGHT.R[:, 1])
    reliefs = (Relief("A", rectangle(1, 1, 2, 2), 0.1), Relief("B", rectangle(3, 1, 4, 2), 0.1))
    behind = FacadeReliefs("F2", back, rectangle(0.5, 0.5, 11, 3), reliefs)
    made = build_solid(block(STRAIGHT, WALL), [front, behind])
    assert isinstance(made, Built)
    (failed,) = made.failed
    assert failed.code == "S310" and failed.message.endswith("left out: A, B")


@pytest.mark.parametrize("step", [0.0005, 0.002, 0.004])
def test_a_host_with_a_step_of_millimetres_in_its_wall_takes_openings_on_both_sides(step):
    plan = shapely.Polygon([(0, 0), (6, 0), (6, -step), (12, -step), (12, 8), (0, 8)])
    ring = np.array(shapely.orient_polygons(plan).exterior.coords)[:-1]
    ground = Surface(np.insert(ring[::-1], 2, 0.0, axis=1), "GroundSurface")
    host = ground_block("B", [ground], WORLD, 9.0)
    assert isinstance(host, Host)
    place = Rigid3("local", "facade", facade_axes(np.array([0.0, 1.0, 0.0])), np.zeros(3))
    reliefs = (Relief("A", rectangle(2, 2, 3, 3.5), 0.2), Relief("B", rectangle(8, 2, 9, 3.5), 0.2))
    made = build_solid(host.solid, [FacadeReliefs("F", place, WALL, reliefs)])
    assert isinstance(made, Built) and not made.failed and not validate(made.solid)


def test_windows_of_a_bay_that_the_host_has_are_in_its_wall():
    """The model draws the bay; nothing is put before it a second time."""
    plan = np.array([[0, 0], [3, 0], [3, -1], [6, -1], [6, 0], [9, 0], [9, 8], [0, 8.0]])
    ground = Surface(np.column_stack([plan, np.zeros(8)])[::-1], "GroundSurface", "")
    made = ground_block("B", [ground], WORLD, 7.0)
    assert isinstance(made, Host)
    window = Relief("W", rectangle(3.8, 2.0, 5.2, 3.5), 0.1)
    bay = Relief("P", rectangle(3.0, 0.0, 6.0, 7.0), -0.95, "WallSurface", (window,))
    other = Relief("V", rectangle(1.0, 2.0, 2.0, 3.5), 0.1)
    place = Rigid3("local", "facade", np.eye(3), np.array([0.0, 0.05, 0.0]))
    facade = FacadeReliefs("F", place, rectangle(0, 0, 9, 7), (bay, other))
    whole = build_solid(made.solid, [facade])
    assert isinstance(whole, Built) and not whole.failed
    assert not validate(whole.solid)
    assert {f.opening for f in whole.solid.faces} - {None} == {"W", "V"}
    assert whole.solid.vertices[:, 1].min() == made.solid.vertices[:, 1].min()
    assert whole.offsets["W"] == pytest.approx(-0.1, abs=1e-6)
