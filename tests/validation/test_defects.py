"""Defects of every code on small solids are found exactly, wherever the solid stands."""

from collections.abc import Callable

import numpy as np
import pytest
import shapely

from frontage.geometry.arrays import Float
from frontage.model import Feature, Finding, Polygons, Shape
from frontage.model.shape import CellGraph
from frontage.validation import NAMES, QIE_NAMES, Tolerances, validate_feature
from validation.models import Model, box, ell, extrude, pyramid

Defect = Callable[[], tuple[Model, ...]]
UTM = (691_000.123, 5_334_000.456, 520.789)


def rotation(yaw: float, pitch: float, roll: float) -> Float:
    def turn(k: int, angle: float) -> Float:
        i, j = [n for n in range(3) if n != k]
        r = np.eye(3)
        r[i, i] = r[j, j] = np.cos(angle)
        r[i, j], r[j, i] = -np.sin(angle), np.sin(angle)
        return r

    return turn(2, yaw) @ turn(1, pitch) @ turn(0, roll)


PLACES = {
    "as it is": (np.eye(3), (0.0, 0.0, 0.0)),
    "tilted": (rotation(0.7, 0.3, -1.1), (5.0, -3.0, 2.0)),
    "turned in UTM": (rotation(1.1, 0.0, 0.0), UTM),
    "tilted in UTM": (rotation(2.0, -0.4, 0.9), UTM),
}


def unrotated_hole(low: float, high: float, z: float = 1.0) -> list[tuple[float, float, float]]:
    return [(low, low, z), (high, low, z), (high, high, z), (low, high, z)]


def holed(*rings: list[tuple[float, float, float]], lid: bool = True) -> Model:
    """Returns a cube whose top has holes (given counter-clockwise), each filled by a face of its own."""
    model = box()
    holes = []
    for ring in rings:
        n = len(model.xyz)
        ids = tuple(range(n, n + len(ring)))
        model = model.also(*ring)
        holes.append(ids[::-1])
        if lid:
            model = model.with_face(ids)
    return model.changed(1, (4, 5, 6, 7), *holes)


INNER = pyramid(
    [(0.2, 0.2, 0.2), (0.8, 0.2, 0.2), (0.8, 0.8, 0.2), (0.2, 0.8, 0.2)], (0.5, 0.5, 0.8)
).turned()
BLOCKER = pyramid([(0, 0.5, 0.0), (0.5, 0, 0.0), (1, 0.5, 0.0), (0.5, 1, 0.0)], (0.5, 0.5, 1.0)).turned()

# One shell, or an outer one and inner ones.
SHELLS: dict[str, tuple[int, Defect]] = {
    "a face of two points": (101, lambda: (box().changed(1, (4, 5)),)),
    "a hole of one point": (101, lambda: (box().also((0.5, 0.5, 1)).changed(1, (4, 5, 6, 7), (8,)),)),
    "a point twice": (102, lambda: (box().changed(1, (4, 5, 5, 6, 7)),)),
    "two points half a millimetre apart": (
        102,
        lambda: (box().also((1, 0.0005, 1)).changed(1, (4, 5, 8, 6, 7)),),
    ),
    "a bow tie": (104, lambda: (box().changed(1, (4, 6, 5, 7)),)),
    "a ring that touches itself": (
        104,
        lambda: (box().also((0.5, 0.5, 1), (0.5, 0, 1)).changed(1, (4, 9, 5, 6, 7, 9, 8)),),
    ),
    "a spike": (104, lambda: (box().also((2, 0, 1)).changed(1, (4, 8, 5, 6, 7)),)),
    "a hole on one line": (
        104,
        lambda: (
            box().also((0.2, 0.5, 1), (0.5, 0.5, 1), (0.8, 0.5, 1)).changed(1, (4, 5, 6, 7), (8, 9, 10)),
        ),
    ),
    "a hole through the rim": (201, lambda: (holed([(0.5, 0.5, 1), (1.5, 0.5, 1), (1.0, 0.9, 1)]),)),
    "a hole along the rim": (201, lambda: (holed([(0.2, 0, 1), (0.8, 0, 1), (0.5, 0.5, 1)]),)),
    "holes across each other": (201, lambda: (holed(unrotated_hole(0.2, 0.6), unrotated_hole(0.4, 0.8)),)),
    "holes side by side": (
        201,
        lambda: (
            holed(
                [(0.2, 0.2, 1), (0.5, 0.2, 1), (0.5, 0.8, 1), (0.2, 0.8, 1)],
                [(0.5, 0.3, 1), (0.8, 0.3, 1), (0.8, 0.7, 1), (0.5, 0.7, 1)],
            ),
        ),
    ),
    "a hole twice": (202, lambda: (holed(unrotated_hole(0.3, 0.7), unrotated_hole(0.3, 0.7)),)),
    "a corner up by 5 cm": (203, lambda: (box().moved(6, (0, 0, 0.05)),)),
    "a fold of 2 mm": (
        204,
        lambda: (
            box()
            .also((1, 0.498, 1.002), (1, 0.502, 0.998), (0, 0.502, 0.998), (0, 0.498, 1.002))
            .changed(1, (4, 5, 8, 9, 6, 7, 10, 11))
            .changed(3, (1, 2, 6, 9, 8, 5))
            .changed(5, (3, 0, 4, 11, 10, 7)),
        ),
    ),
    "holes that cut the face": (
        205,
        lambda: (
            holed([(0, 0, 1), (0.6, 0.4, 1), (0.5, 0.5, 1)], [(0.5, 0.5, 1), (0.9, 0.6, 1), (1, 1, 1)]),
        ),
    ),
    "a hole from rim to rim": (
        205,
        lambda: (holed([(0.4, 0, 1), (0.6, 0.5, 1), (0.4, 1, 1), (0.3, 0.5, 1)]),),
    ),
    "a hole outside": (206, lambda: (holed(unrotated_hole(1.2, 1.8)),)),
    "a hole in a hole": (207, lambda: (holed(unrotated_hole(0.2, 0.8), unrotated_hole(0.4, 0.6)),)),
    "a hole that runs the same way": (
        208,
        lambda: (box().also(*unrotated_hole(0.3, 0.7)).changed(1, (4, 5, 6, 7), (8, 9, 10, 11)),),
    ),
    "three faces": (301, lambda: (Model(box().xyz, box().faces[:3]),)),
    "a face missing": (302, lambda: (box().without(0),)),
    "a face of an L missing": (302, lambda: (ell().without(4),)),
    "an unfilled hole": (302, lambda: (holed(unrotated_hole(0.3, 0.7), lid=False),)),
    "two faces missing at one corner": (302, lambda: (Model(box().xyz, box().faces[2:]),)),
    "a wall through the middle": (303, lambda: (box().with_face((3, 1, 5, 7)),)),
    "a face that hangs on an edge": (
        303,
        lambda: (box().also((2, 0, 2), (2, 1, 2)).with_face((5, 8, 9, 6)),),
    ),
    "a face that hangs on a corner": (303, lambda: (box().also((2, 2, 2), (2, 1, 2)).with_face((6, 9, 8)),)),
    "boxes that share a corner": (303, lambda: (box().joined(box((1, 1, 1), (2, 2, 2))),)),
    "boxes that share an edge": (303, lambda: (box().joined(box((1, 1, 0), (2, 2, 1))),)),
    "a face in the air": (305, lambda: (box().also((3, 3, 3), (4, 3, 3), (4, 4, 3)).with_face((8, 9, 10)),)),
    "two boxes apart": (305, lambda: (box().joined(box((0, 0, 3), (1, 1, 4))),)),
    "a roof through the floor": (306, lambda: (spire(-0.5),)),
    "a roof that touches the floor": (306, lambda: (spire(0.0),)),
    "a face turned": (307, lambda: (box().changed(2, (4, 5, 1, 0)),)),
    "most faces turned": (307, lambda: (Model(box().xyz, box().turned().faces[:4] + box().faces[4:]),)),
    "a turned face of an L": (307, lambda: (ell().changed(5, ell().faces[5][0][::-1]),)),
    "a void through the top": (401, lambda: (box(), INNER.moved(4, (0, 0, 0.21)))),
    "a void on the floor": (401, lambda: (box(), INNER.shifted((0, 0, -0.2)))),
    "voids that overlap": (401, lambda: (box(), INNER, INNER.shifted((0.1, 0, 0.05)))),
    "a void in a void": (
        401,
        lambda: (box(), INNER, Model(INNER.xyz * 0.5 + (0.25, 0.25, 0.2), INNER.faces)),
    ),
    "voids face to face": (
        401,
        lambda: (
            box(),
            box((0.2, 0.2, 0.2), (0.5, 0.8, 0.8)).turned(),
            box((0.5, 0.3, 0.3), (0.8, 0.7, 0.7)).turned(),
        ),
    ),
    "a void twice": (402, lambda: (box(), INNER, INNER)),
    "a void outside": (403, lambda: (box(), INNER.shifted((3, 0, 0)))),
    "a void around": (403, lambda: (box(), box((-1, -1, -1), (2, 2, 2)).turned())),
    "a void from wall to wall": (404, lambda: (box((0, 0, -0.5), (1, 1, 1)), wedge())),
    "inside out": (405, lambda: (box().turned(),)),
    "an L inside out": (405, lambda: (ell().turned(),)),
    "a void that looks outwards": (405, lambda: (box(), INNER.turned())),
}


def spire(tip: float) -> Model:
    """Returns a house whose roof comes down to a point inside it, or lower."""
    house = box().also((0.5, 0.5, tip))
    return Model(
        house.xyz,
        (house.faces[0], *house.faces[2:], *(((a, b, 8),) for a, b in ((4, 5), (5, 6), (6, 7), (7, 4)))),
    )


def wedge() -> Model:
    """Returns a flat double pyramid whose four outer edges lie on the walls of the unit cube."""
    rim = [(0.0, 0.0, 0.5), (1.0, 0.0, 0.5), (1.0, 1.0, 0.5), (0.0, 1.0, 0.5)]
    xyz = np.array([*rim, (0.5, 0.5, 0.8), (0.5, 0.5, 0.2)])
    sides = ((0, 1), (1, 2), (2, 3), (3, 0))
    faces = [((a, b, 4),) for a, b in sides] + [((b, a, 5),) for a, b in sides]
    return Model(xyz, tuple(faces)).turned()


def placed(models: tuple[Model, ...], place: str) -> list[Polygons]:
    return [m.placed(*PLACES[place]).surfaces() for m in models]


def codes(findings: tuple[Finding, ...]) -> list[int]:
    return sorted({f.code for f in findings})


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize("name", SHELLS)
def test_a_defect_of_a_solid_is_found_and_nothing_else(name: str, place: str) -> None:
    code, make = SHELLS[name]
    feature = Feature("B1", "Building", (Shape("Solid", (tuple(placed(make(), place)),)),))
    findings = validate_feature(feature)
    assert codes(findings) == [code], findings
    low = np.min([s.points.min(0) for s in feature.shapes[0].solids[0]], axis=0) - 1e-6
    high = np.max([s.points.max(0) for s in feature.shapes[0].solids[0]], axis=0) + 1e-6
    for finding in findings:
        assert finding.feature == "B1" and finding.where.startswith("geometry=0")
        assert finding.location is not None
        assert (low <= finding.location).all() and (finding.location <= high).all()


A = box()
COMPOSITES: dict[str, tuple[list[int], list[tuple[Model, ...]]]] = {
    "side by side": ([], [(A,), (box((1, 0, 0), (2, 1, 1)),)]),
    "side by side, in part": ([], [(A,), (box((1, 0.2, 0.3), (2, 3, 1)),)]),
    "a void filled": ([], [(A, INNER), (INNER.turned(),)]),
    "overlap of 1 cm": ([501], [(A,), (box((0.99, 0, 0), (2, 1, 1)),)]),
    "overlap crosswise": ([501], [(A,), (box((0.4, -1, 0.4), (0.6, 2, 0.6)),)]),
    "one in the other": ([501], [(A,), (box((0.2, 0.2, 0.2), (0.8, 0.8, 0.8)),)]),
    "one in the other, sharing a face": ([501], [(A,), (box((0.2, 0.2, 0), (0.8, 0.8, 0.8)),)]),
    "the same twice": ([502], [(A,), (A,)]),
    "apart": ([503], [(A,), (box((3, 0, 0), (4, 1, 1)),)]),
    "on an edge": ([503], [(A,), (box((1, 1, 0), (2, 2, 1)),)]),
}


@pytest.mark.parametrize("place", ["as it is", "turned in UTM", "tilted"])
@pytest.mark.parametrize("name", COMPOSITES)
def test_solids_of_a_composite(name: str, place: str) -> None:
    expected, models = COMPOSITES[name]
    solids = tuple(tuple(placed(m, place)) for m in models)
    assert codes(validate_feature(Feature("C", "Thing", (Shape("CompositeSolid", solids),)))) == expected
    assert codes(validate_feature(Feature("C", "Thing", (Shape("MultiSolid", solids),)))) == []


@pytest.mark.parametrize("place", ["as it is", "turned in UTM"])
@pytest.mark.parametrize("name", COMPOSITES)
def test_parts_of_a_building(name: str, place: str) -> None:
    expected, models = COMPOSITES[name]
    parts = tuple(
        Feature(f"P{k}", "BuildingPart", (Shape("Solid", (tuple(placed(m, place)),), "2"),))
        for k, m in enumerate(models)
    )
    findings = validate_feature(Feature("B", "Building", (), parts))
    assert codes(findings) == ([601] if expected in ([501], [502]) else [])
    assert all("P0" in f.where and "P1" in f.where and f.feature == "B" for f in findings)


def test_levels_of_detail_are_not_compared() -> None:
    shapes = tuple(Shape("Solid", ((box().surfaces(),),), lod) for lod in ("1", "2"))
    assert validate_feature(Feature("B", "Building", shapes)) == ()


def test_an_overlap_within_tolerance_is_accepted() -> None:
    solids = tuple((m.surfaces(),) for m in (A, box((0.99, 0, 0), (2, 1, 1))))
    feature = Feature("C", "Thing", (Shape("CompositeSolid", solids),))
    assert codes(validate_feature(feature, Tolerances(overlap=0.01))) == []
    assert codes(validate_feature(feature, Tolerances(overlap=0.009))) == [501]


def test_a_gap_within_tolerance_is_accepted() -> None:
    solids = tuple((m.surfaces(),) for m in (A, box((1.02, 0, 0), (2, 1, 1))))
    feature = Feature("C", "Thing", (Shape("CompositeSolid", solids),))
    assert codes(validate_feature(feature, Tolerances(overlap=0.03))) == []
    assert codes(validate_feature(feature, Tolerances(overlap=0.01))) == [503]


def test_an_open_ring_where_rings_must_be_closed() -> None:
    good = box().surfaces(closed=True)
    assert validate_feature(Feature("B", "", (Shape("Solid", ((good,),)),))) == ()
    polygons = [[good.points[a:b]] for a, b in zip(good.rings[:-1], good.rings[1:], strict=True)]
    polygons[3] = [polygons[3][0][:-1]]
    open_ring = Polygons.of(polygons, explicit=True)
    findings = validate_feature(Feature("B", "", (Shape("Solid", ((open_ring,),)),)))
    assert codes(findings) == [103] and "face=3" in findings[0].where


@pytest.mark.parametrize("kind", ["Solid", "MultiSurface", "CompositeSurface"])
def test_an_empty_geometry_is_reported(kind: str) -> None:
    empty = Shape(kind, ((Polygons.of([]),),))  # type: ignore[arg-type]
    assert codes(validate_feature(Feature("B", "", (empty,)))) == [902]
    assert codes(validate_feature(Feature("B", "", (Shape("MultiSolid", ()),)))) == [902]


def test_a_multi_surface_is_only_checked_face_by_face() -> None:
    loose = box().without(0).with_face((3, 1, 5, 7))
    assert validate_feature(Feature("B", "", (loose.shape(kind="MultiSurface"),))) == ()
    assert codes(validate_feature(Feature("B", "", (loose.shape(kind="CompositeSurface"),)))) == [303]


def test_a_composite_surface_may_have_a_border_but_no_loose_corner() -> None:
    sheet = box().without(0)
    assert validate_feature(Feature("B", "", (sheet.shape(kind="CompositeSurface"),))) == ()
    kite = Model(
        np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (-1, 0, 0), (0, -1, 0.0)]), (((0, 1, 2),), ((0, 3, 4),))
    )
    assert codes(validate_feature(Feature("B", "", (kite.shape(kind="CompositeSurface"),)))) == [303]


def test_a_vertex_that_one_of_two_neighbours_lacks() -> None:
    """val3dity calls it a hole (302), the QIE list a non-manifold edge (304); both are reported."""
    model = box().also((0.5, 0, 1)).changed(1, (4, 8, 5, 6, 7))
    findings = validate_feature(Feature("B", "", (model.shape(),)))
    assert codes(findings) == [302, 303]
    assert [f.qie for f in findings if f.code == 303] == [304]
    assert [f.location for f in findings if f.code == 303] == [(0.5, 0.0, 1.0)]


def test_the_findings_name_the_face() -> None:
    model = box().moved(6, (0, 0, 0.05)).changed(0, (0, 2, 1, 3))
    findings = validate_feature(Feature("B", "", (model.shape(),)))
    assert {(f.code, f.where) for f in findings} == {
        (203, "geometry=0|shell=0|face=1"),
        (104, "geometry=0|shell=0|face=0|ring=0"),
    }
    assert all(f.code in NAMES and (f.qie is None or f.qie in QIE_NAMES) for f in findings)


@pytest.mark.parametrize(("move", "expected"), [(0.0009, []), (0.0011, [302])])
def test_vertices_are_one_within_the_snap_tolerance(move: float, expected: list[int]) -> None:
    loose = box().also((1, 1 + move, 1)).changed(1, (4, 5, 8, 7))
    assert codes(validate_feature(Feature("B", "", (loose.shape(),)))) == expected


@pytest.mark.parametrize(("rise", "expected"), [(0.018, []), (0.022, [203])])
def test_faces_are_flat_within_the_distance_tolerance(rise: float, expected: list[int]) -> None:
    """If a corner of a square is raised by h, it is h / 4 off the fitted plane."""
    model = extrude(shapely.Polygon([(0, 0), (10, 0), (10, 10), (0, 10)]), 0, 5).moved(6, (0, 0, 2 * rise))
    assert codes(validate_feature(Feature("B", "", (model.shape(),)))) == expected


def test_tolerances_are_checked() -> None:
    for wrong in (
        {"snap": -1},
        {"planarity_distance": 0},
        {"planarity_normals": 200},
        {"snap": float("nan")},
        {"x": 1},
    ):
        with pytest.raises(ValueError):
            Tolerances(**wrong)  # type: ignore[arg-type]


ROOMS = {"R1": "S1", "R2": "S2"}
STATES = {"S1": "R1", "S2": "R2"}
SPOTS = {"S1": (0.5, 0.5, 0.5), "S2": (1.5, 0.5, 0.5)}
INDOOR: dict[str, tuple[list[int], float, CellGraph]] = {
    "two rooms and a door": ([], 0.0, CellGraph(ROOMS, STATES, SPOTS, {"T": ("S1", "S2")})),
    "without states": ([], 0.0, CellGraph({"R1": "", "R2": ""}, {}, {}, {})),
    "rooms that overlap": ([701], -0.2, CellGraph(ROOMS, STATES, SPOTS, {"T": ("S1", "S2")})),
    "a state outside": ([702], 0.0, CellGraph(ROOMS, STATES, {**SPOTS, "S2": (2.5, 0.5, 0.5)}, {})),
    "states that are swapped": ([703], 0.0, CellGraph(ROOMS, {"S1": "R2", "S2": "R1"}, SPOTS, {})),
    "a state that is not there": ([703], 0.0, CellGraph(ROOMS, {"S1": "R1"}, {}, {})),
    "a door to nowhere": ([703], 0.0, CellGraph(ROOMS, STATES, SPOTS, {"T": ("S1", "S9")})),
    "a door with one side": ([703], 0.0, CellGraph(ROOMS, STATES, SPOTS, {"T": ("S1",)})),
    "a door between rooms apart": ([704], 0.1, CellGraph(ROOMS, STATES, SPOTS, {"T": ("S1", "S2")})),
}


@pytest.mark.parametrize("name", INDOOR)
def test_rooms_and_their_graph(name: str) -> None:
    expected, gap, graph = INDOOR[name]
    rooms = (box(), box((1 + gap, 0, 0), (2, 1, 1)))
    cells = tuple(Feature(f"R{k}", "CellSpace", (room.shape(),)) for k, room in enumerate(rooms, 1))
    assert codes(validate_feature(Feature("I", "IndoorFeatures", (), cells, graph))) == expected
