"""Valid geometry is never reported: random extrusions, walls with windows, integer solids."""

import time

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from frontage.model import Face, Feature, Polygons, Shape, Solid
from frontage.validation import Tolerances, validate, validate_feature, validate_shape
from validation.models import Model, box, ell, extrude, windows
from validation.test_defects import PLACES, rotation


@st.composite
def plans(draw: st.DrawFn) -> shapely.Polygon:
    """Draws a star-shaped plan of 3 to 14 corners, 4 to 20 m, with up to six holes on a grid inside it."""
    n = draw(st.integers(3, 14))
    radii = draw(st.lists(st.floats(4, 20), min_size=n, max_size=n))
    angles = (np.arange(n) + draw(st.lists(st.floats(-0.3, 0.3), min_size=n, max_size=n))) * 2 * np.pi / n
    plan = shapely.Polygon(np.column_stack([np.cos(angles), np.sin(angles)]) * np.array(radii)[:, None])
    for k in draw(st.sets(st.integers(0, 15), max_size=6)):
        x, y = (k % 4 - 1.5) * 3, (k // 4 - 1.5) * 3
        hole = shapely.Point(x, y).buffer(draw(st.floats(0.2, 1.4)), quad_segs=draw(st.integers(1, 3)))
        plan = plan.difference(hole) if plan.buffer(-0.3).contains(hole) else plan
    return plan


@settings(max_examples=60, deadline=None)
@given(
    plans(),
    st.floats(0.5, 60),
    st.tuples(st.floats(-3, 3), st.floats(-1, 1), st.floats(-1, 1)),
    st.tuples(st.floats(-1e6, 1e6), st.floats(-6e6, 6e6), st.floats(-100, 3000)),
)
def test_random_extrusions_with_holes(
    plan: shapely.Polygon,
    height: float,
    angles: tuple[float, float, float],
    shift: tuple[float, float, float],
) -> None:
    model = extrude(plan, 0.0, height).placed(rotation(*angles), shift)
    assert validate_shape(model.shape()) == ()
    rounded = Model(np.round(model.xyz, 3), model.faces)  # as in most files
    assert validate_shape(rounded.shape(), Tolerances(planarity_normals=90)) == ()


@settings(max_examples=25, deadline=None)
@given(plans(), st.integers(0, 40), st.floats(0.02, 0.5))
def test_one_defect_in_a_random_extrusion_is_found(plan: shapely.Polygon, which: int, step: float) -> None:
    model = extrude(plan, 0.0, 5.0)
    wall = 2 + which % (len(model.faces) - 2)
    assert {f.code for f in validate_shape(model.without(wall).shape())} == {302}
    turned = model.changed(wall, model.faces[wall][0][::-1])
    assert {(f.code, f.where.split("|")[-1]) for f in validate_shape(turned.shape())} == {
        (307, f"face={wall}")
    }
    assert {f.code for f in validate_shape(model.turned().shape())} == {405}


def test_faces_whose_holes_touch_in_points() -> None:
    """In a checkered floor, holes touch each other and the border at corners; the interior is connected."""
    r = np.random.default_rng(5)
    polygons = []
    while len(polygons) < 400:
        k = int(r.integers(3, 10))
        dark = np.argwhere(r.random((k, k)) < r.uniform(0.3, 0.8))
        cells = shapely.union_all(shapely.box(dark[:, 0], dark[:, 1], dark[:, 0] + 1, dark[:, 1] + 1))
        rest = shapely.box(-1, -1, k + 1, k + 1).difference(cells)
        polygons += [p for p in (*shapely.get_parts(cells), *shapely.get_parts(rest)) if p.interiors]
    flat = [[np.asarray(x.coords)[:-1] for x in (p.exterior, *p.interiors)] for p in map(_oriented, polygons)]
    turn, shift = PLACES["tilted in UTM"]
    rings = [[np.column_stack([x, np.zeros(len(x))]) @ turn.T + shift for x in face] for face in flat]
    assert validate_shape(Shape("MultiSurface", ((Polygons.of(rings),),))) == ()


def _oriented(polygon: shapely.Polygon) -> shapely.Polygon:
    return shapely.orient_polygons(polygon)


@pytest.mark.parametrize("place", PLACES)
def test_a_wall_with_windows(place: str) -> None:
    assert validate_shape(windows(4, 3).placed(*PLACES[place]).shape()) == ()


@pytest.mark.parametrize("place", ["as it is", "turned in UTM"])
def test_three_hundred_windows_in_half_a_second(place: str) -> None:
    shape = windows(20, 15).placed(*PLACES[place]).shape()
    assert len(shape.solids[0][0]) == 1506
    seconds = []
    for _ in range(2):
        start = time.process_time()
        assert validate_shape(shape) == ()
        seconds.append(time.process_time() - start)
    assert min(seconds) < 0.5


def solid(model: Model, origin: tuple[int, int, int] = (691_000, 5_334_000, 520)) -> Solid:
    faces = tuple(Face(f[0], "WallSurface", f[1:]) for f in model.faces)
    return Solid("B7", np.rint(model.xyz * 1e4).astype(np.int64), np.array(origin), faces, "3")


@pytest.mark.parametrize("model", [box(), ell(), windows(3, 2)])
def test_an_integer_solid(model: Model) -> None:
    assert validate(solid(model)) == ()
    broken = validate(solid(model.without(1)))
    assert {f.code for f in broken} == {302}
    assert broken[0].feature == "B7"
    assert broken[0].location is not None and broken[0].location[1] > 5_333_999


def test_a_touch_on_the_integer_grid_is_exact() -> None:
    """A tip exactly on a slanted face is found; a tenth of a millimetre above the face it is free."""
    roof = box((0, 0, 0), (3, 3, 3)).moved(6, (0, 0, -1)).moved(7, (0, 0, -1))  # falls by 1 in 3 along y
    lower = Model(roof.xyz * (1, 1, 1), roof.faces)
    assert validate(solid(lower)) == ()
    for rise, expected in ((0.0, {306}), (1e-4, set())):
        tip = (1.5, 1.5, 1.0 + rise)
        pit = lower.also(tip)
        sides = tuple(((a, b, 8),) for a, b in ((4, 5), (5, 6), (6, 7), (7, 4)))
        base = pit.changed(0, (0, 3, 2, 1))
        slanted = base.moved(0, (0, 0, 1.5)).moved(1, (0, 0, 1.5)).moved(2, (0, 0, 0.5)).moved(3, (0, 0, 0.5))
        model = Model(slanted.xyz, (slanted.faces[0], *slanted.faces[2:], *sides))
        assert {f.code for f in validate(solid(model))} == expected


def test_the_same_input_gives_the_same_findings() -> None:
    model = windows(3, 3).moved(8, (0.3, 0.0, 0.1)).placed(*PLACES["tilted in UTM"])
    feature = Feature("B", "Building", (model.shape(),))
    first = validate_feature(feature)
    assert first and first == validate_feature(feature)
