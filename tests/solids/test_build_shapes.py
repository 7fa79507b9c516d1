"""Polygonised curves, sloping ground and leaning walls."""

import numpy as np
import pytest

from frontage.geometry.ring import rectangle, ring_area
from frontage.model import Face, Solid
from frontage.solids.brep import GRID_PER_M, newell_normal, unmatched_edges, volume6
from frontage.solids.cells.build import build_solid
from frontage.solids.curves import arch_ring, chord_count, circle_ring
from frontage.solids.relief import Built, FacadeReliefs, Relief
from frontage.validation import validate
from solids.facades import WORLD, block, frame


@pytest.mark.parametrize("error", [0.02, 0.005, 0.0005])
@pytest.mark.parametrize("rise", [0.15, 0.6, 1.1])
def test_chords_stay_within_their_error(rise, error):
    """For segmental, round and pointed arches, no chord is further from the arc than the error."""
    ring = arch_ring(0, 1.2, 0, spring=2, rise=rise, chord_error=error)
    assert ring_area(ring) > 0
    assert np.array_equal(ring, ring * [1, 1]) and ring[:, 1].max() == pytest.approx(2 + rise)
    right = ring[(ring[:, 0] >= 0.6 - 1e-9) & (ring[:, 1] >= 2)]
    radius = (0.36 + rise**2) / (2 * min(0.6, rise))
    centre = np.array([0.6, 2 + rise - radius]) if rise <= 0.6 else np.array([1.2 - radius, 2.0])
    assert np.linalg.norm(right - centre, axis=1) == pytest.approx(radius)
    middles = (right[1:] + right[:-1]) / 2
    sagitta = radius - np.linalg.norm(middles - centre, axis=1)
    assert (sagitta <= error + 1e-12).all()
    assert len(right) == 2 or sagitta.max() > error / 5, "not finer than asked for"
    assert np.allclose(sorted(ring[:, 0].tolist()), sorted((1.2 - ring[:, 0]).tolist())), "symmetric"


def test_circle_and_bad_curves():
    ring = circle_ring(1, 2, 0.5, 0.001)
    assert np.linalg.norm(ring - [1, 2], axis=1) == pytest.approx(0.5)
    assert len(ring) == chord_count(0.5, 2 * np.pi, 0.001)
    for x1, z0, rise in ((0, 0, 1), (1, 0, 0), (1, 2, 1)):
        with pytest.raises(ValueError, match="arch"):
            arch_ring(0, x1, z0, spring=1, rise=rise, chord_error=0.01)
    with pytest.raises(ValueError, match="positive"):
        circle_ring(0, 0, 1, 0)


def skewed(solid: Solid, along: float, into: float) -> Solid:
    """Returns the block on ground that slopes `along` the street and `into` the building (rise over run)."""
    v = solid.vertices.copy()
    low = v[:, 2] == v[:, 2].min()
    v[low, 2] += np.rint((v[low, 0] - v[:, 0].min()) * along + (v[low, 1] - v[:, 1].min()) * into).astype(int)
    return Solid(solid.building, v, solid.origin, solid.faces, "2")


@pytest.mark.parametrize(("along", "into"), [(0.08, 0.0), (0.0, 0.05), (-0.05, -0.03)])
def test_door_on_sloping_ground(along, into):
    place = frame(np.pi / 2)
    host = skewed(block(place, rectangle(0, 0, 10, 6)), along, into)
    assert not validate(host)
    foot = [along * x - (0.3 if along < 0 else 0) for x in (4.0, 5.0)]
    door = Relief("D", np.array([[4, foot[0]], [5, foot[1]], [5, 2.5], [4, 2.5]]), 0.4, "Door")
    oriel = Relief("P", rectangle(6, -0.45, 8, 2), -0.6, "WallSurface")
    result = build_solid(host, [FacadeReliefs("F", place, rectangle(0, 0, 10, 6), (door, oriel))])
    assert isinstance(result, Built) and not result.failed
    assert not validate(result.solid)
    (ground,) = (f for f in result.solid.faces if f.semantics == "GroundSurface")
    assert len(ground.ring) == 12
    n = newell_normal(result.solid.vertices[list(ground.ring)] / GRID_PER_M)
    at = result.solid.vertices[list(ground.ring)] / GRID_PER_M
    assert np.abs((at - at[0]) @ n).max() < 2e-4, "the notch lies in the ground's plane"


@pytest.mark.parametrize("lean", [-0.06, 0.06])
def test_leaning_wall(lean):
    """On a wall 3.4 degrees off the vertical, recesses follow the wall's normal."""
    place = frame(np.pi / 2)
    host = block(place, rectangle(0, 0, 10, 6))
    v = host.vertices.copy()
    front_top = (v[:, 1] == v[:, 1].min()) & (v[:, 2] == v[:, 2].max())
    v[front_top, 1] -= round(lean * 60_000)
    host = Solid("B", v, host.origin, host.faces, "2")
    reliefs = (Relief("W", rectangle(2, 2, 3, 4), 0.2), Relief("D", rectangle(5, 0, 6, 2), 0.3, "Door"))
    result = build_solid(host, [FacadeReliefs("F", place, rectangle(0, 0, 10, 6), reliefs)])
    assert isinstance(result, Built) and not result.failed and not validate(result.solid)
    lost = (volume6(host) - volume6(result.solid)) / 6e12
    assert lost == pytest.approx(0.2 * 2 + 0.3 * 2, rel=0.02)


def test_recess_under_a_roof_slope_stays_below_it():
    """Where the roof falls towards the back, a deep recess near its edge would pierce it."""
    base = block(frame(np.pi / 2), rectangle(0, 0, 10, 6))
    v = base.vertices.copy()
    v[(v[:, 1] == v[:, 1].max()) & (v[:, 2] == v[:, 2].max()), 2] -= 50_000
    host = Solid("B", v, base.origin, base.faces, "2")
    window = Relief("W", rectangle(2, 4.5, 3, 5.7), 1.0)
    result = build_solid(host, [FacadeReliefs("F", frame(np.pi / 2), rectangle(0, 0, 10, 6), (window,))])
    assert isinstance(result, Built) and "no more is free" in result.notes[0]
    assert not validate(result.solid)


def test_a_corner_just_under_a_gable_leaves_no_flat_triangle():
    """A corner that reaches by millimetres into the gap along a gable would be cut by an edge as short."""
    outline = np.array([[0.0, 0.0], [10.0, 0.0], [10.0, 6.0], [5.0, 9.3], [0.0, 6.0]])
    for azimuth in np.linspace(0.1, 3.0, 12):
        place = frame(float(azimuth))
        host = block(place, outline)
        for reach in (0.001, 0.003, 0.006, 0.012):
            x, gap = 6.97, 0.02
            top = 6.0 + (10.0 - x) * 0.66 - gap * np.hypot(1.0, 0.66) + reach
            window = Relief("W", rectangle(x - 0.76, top - 0.94, x, top), 0.1)
            built = build_solid(host, [FacadeReliefs("F", place, outline, (window,))])
            assert isinstance(built, Built) and not built.failed and not validate(built.solid)
            (face,) = [f for f in built.solid.faces if f.opening]
            sides = np.diff(built.solid.vertices[[*face.ring, face.ring[0]]], axis=0) / GRID_PER_M
            assert np.linalg.norm(sides, axis=1).min() > 2 * gap


def test_building_in_front_stops_a_protrusion():
    """In an L-shaped house, an oriel beside the inner corner cannot reach into the other wing."""
    plan = np.array([[0, 0], [10, 0], [10, 4], [4, 4], [4, 10], [0, 10.0]]) * GRID_PER_M
    low = np.column_stack([plan, np.zeros(6)])
    v = np.rint(np.concatenate([low, low + np.array([0, 0, 6 * GRID_PER_M])])).astype(np.int64)
    faces = [Face((5, 4, 3, 2, 1, 0), "GroundSurface"), Face(tuple(range(6, 12)), "RoofSurface")]
    faces += [Face((a, (a + 1) % 6, (a + 1) % 6 + 6, a + 6), "WallSurface") for a in range(6)]
    host = Solid("L", v, WORLD.origin, tuple(faces), "2")
    assert not unmatched_edges(host.faces)
    place = frame(-np.pi / 2, at=(10.0, 4.0, 0.0))  # the wall y = 4, seen from the yard
    oriels = (
        Relief("near", rectangle(5.2, 2, 5.97, 4), -1.0, "WallSurface"),
        Relief("far", rectangle(2, 2, 4, 4), -1.0, "WallSurface"),
    )
    result = build_solid(host, [FacadeReliefs("F", place, rectangle(0, 0, 6, 6), oriels)])
    assert isinstance(result, Built) and not validate(result.solid)
    assert not result.failed
    assert volume6(result.solid) - volume6(host) == 6 * GRID_PER_M**3 * 4 + 6 * 7_700 * 20_000 * 10_000


def test_touching_recesses_that_are_limited_keep_no_sliver_step():
    host = block(frame(np.pi / 2), rectangle(0, 0, 10, 6), 0.5)
    reliefs = (Relief("A", rectangle(2, 2, 3, 4), 0.47), Relief("B", rectangle(3, 2, 4, 4), 0.9))
    result = build_solid(host, [FacadeReliefs("F", frame(np.pi / 2), rectangle(0, 0, 10, 6), reliefs)])
    assert isinstance(result, Built) and not validate(result.solid)
    panes = [f for f in result.solid.faces if f.semantics == "Window"]
    assert len({int(result.solid.vertices[f.ring[0], 1]) for f in panes}) == 1
