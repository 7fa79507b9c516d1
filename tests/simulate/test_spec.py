"""Specifications: what they ask for is built, and one sentence names what cannot be built."""

import re
from pathlib import Path

import numpy as np
import pytest

from frontage.errors import OptionError
from frontage.geometry.ring import ring_area
from frontage.simulate.houses.housespec import HouseSpec, OpeningSpec
from frontage.simulate.spec import SceneSpec, parse_spec
from frontage.simulate.street.build import build_street
from frontage.simulate.survey import ModelSpec

OPENING = "x = 1.0\nz = 1.2\nwidth = 1.1\nheight = 1.6\n"
BARE = "trees = 0\ncars = 0\nlamps = 0\npeople = 0\n"
HOUSE = f"houses = 1\nopposite = false\nslope = 0\n{BARE}[[house]]\nwidth = 8\n"


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("houses = -1", "houses = -1 is not usable: input should be greater than or equal to 0"),
        ("hauses = 3", "unknown key hauses; known there: "),
        ("[[house]]\nwidth = -8", "house 1, width = -8 is not usable: input should be greater than 2.5"),
        ("[[house]]\n[[house]]\nlane = 1", "unknown key house 2, lane; known there: "),
        (
            "[[house]]\n[[house.opening]]\n" + OPENING.replace("1.1", "-1.1"),
            "house 1, opening 1, width = -1.1",
        ),
        ("[[house]]\n[[house.opening]]\nx = 1", "house 1, opening 1, z is missing"),
        ("[[house]]\n[[house.opening]]\nheigth = 2", "unknown key house 1, opening 1, heigth"),
        (
            "[[house]]\n[[house.opening]]\nshape = 'round'\n" + OPENING.replace("1.6", "0.5"),
            "too low for a round",
        ),
        ("[[house]]\n[[house.opening]]\nshape = 'circle'\n" + OPENING, "a circle has one size"),
        ("[[house]]\n[[house.opening]]\nframe = 0.2\n" + OPENING.replace("1.1", "0.4"), "fills an opening"),
        (f"[[house]]\n[[house.opening]]\nshutters = 'closed'\ndepth = 0.03\n{OPENING}", "need a reveal of"),
        ("[house]\nwidth = 8", "house must be a list of tables; write [[house]] in two brackets"),
        ("[[house]]\n[house.opening]\nx = 1", "write [[house.opening]] in two brackets"),
        ("model = 3", "model must be a table, not 3"),
        ("[[house]]\ntwin = true", "house 1 is a twin of the house before it, but there is none"),
        (
            "[[house]]\n[[house]]\ntwin = true\nwidth = 7",
            "house 2: a twin is built like the house before it; leave out",
        ),
        ("[[scanners]]\nspacing = 0", "scanners 1, spacing = 0 is not usable"),
        ("[drive]\nspeed = -3", "drive, speed = -3 is not usable"),
        ("[model]\ncorner = -0.1", "model, corner = -0.1 is not usable"),
        ("seed = ", "not TOML"),
    ],
)
def test_an_error_in_a_specification_is_named_in_one_sentence(text: str, sentence: str) -> None:
    with pytest.raises(OptionError) as caught:
        parse_spec(text, "street.toml")
    message = str(caught.value)
    assert message.startswith("street.toml: ") and sentence in message and "\n" not in message


@pytest.mark.parametrize(
    ("openings", "sentence"),
    [
        (
            [OPENING, OPENING.replace("x = 1.0", "x = 1.9")],
            "house B01: opening 2 overlaps or touches opening 1",
        ),
        (
            [OPENING.replace("x = 1.0", "x = 7.5")],
            "house B01: opening 1 reaches beyond the wall (x 0.00 to 8.00 m",
        ),
        ([OPENING.replace("z = 1.2", "z = -0.5")], "house B01: opening 1 reaches beyond the wall"),
    ],
)
def test_openings_that_do_not_fit_are_named_in_one_sentence(openings: list[str], sentence: str) -> None:
    spec = parse_spec(HOUSE + "".join(f"[[house.opening]]\n{o}" for o in openings))
    with pytest.raises(OptionError, match=re.escape(sentence)):
        build_street(spec)


def test_openings_are_built_as_they_were_specified() -> None:
    wanted = "kind = 'door'\nshape = 'segmental'\nx = 5.0\nz = 0.1\nwidth = 1.2\nheight = 2.4\ndepth = 0.3\n"
    bars = "vertical = 2\nhorizontal = 1\ndepth = 0.22\nframe = 0.06\n"
    text = HOUSE + f"floors = 2\n[[house.opening]]\n{OPENING}{bars}[[house.opening]]\n{wanted}"
    (house,) = build_street(parse_spec(text)).houses
    window, door = sorted(house.facades[0].openings, key=lambda o: o.kind, reverse=True)
    np.testing.assert_allclose([window.ring.min(0), window.ring.max(0)], [[1.0, 1.2], [2.1, 2.8]], atol=1e-12)
    assert (window.depth, window.frame_width, window.floor) == (0.22, 0.06, 0)
    assert [b.axis for b in window.bars] == ["vertical", "vertical", "horizontal"]
    assert (door.kind, door.shape, door.depth, door.glazed) == ("door", "segmental", 0.3, False)
    assert door.ring[:, 1].max() == pytest.approx(2.5, abs=0.001) and ring_area(door.ring) < 1.2 * 2.4
    assert {window.id, door.id} == {"B01/F1/W0-1", "B01/F1/D0-2"}


def test_the_specified_properties_of_a_house_are_built() -> None:
    text = HOUSE + (
        "floors = 3\nfloor_height = 3.2\nground_floor_height = 4.0\nroof = 'flat'\nlean = 0.4\n"
        "shape = 'round'\n"
        "columns = 3\nreveal = 0.2\nshop = false\noriel = false\nbalconies = false\nshutters = false\n"
        "roughness = 0.004\nwall = 'brick'\nsetback = 1.5\n"
    )
    scene = build_street(parse_spec(text))
    (house,) = scene.houses
    facade = house.facades[0]
    assert np.ptp(facade.outline[:, 0]) == pytest.approx(8.0)
    assert 10.4 < house.eaves_z - house.ground_z < 11.5 and house.ridge_z == house.eaves_z
    rows = [[o for o in facade.openings if o.floor == k] for k in (1, 2)]
    assert [len(r) for r in rows] == [3, 3] and {o.shape for r in rows for o in r} == {"round"}
    assert {o.depth for r in rows for o in r} == {0.2} and facade.roughness == 0.004
    assert np.degrees(np.arcsin(-facade.local_from_facade.R[2, 1])) == pytest.approx(0.4)
    back = scene.local_from_street.inverse.apply(facade.local_from_facade.t[None])[0]
    np.testing.assert_allclose(back, [0.0, 1.5, 0.0], atol=1e-9)
    walls = [scene.materials[s.material].kind for s in scene.surfaces if s.id == "B01/F1/wall"]
    assert walls == ["brick"]


def test_a_leaning_wall_goes_back_with_height() -> None:
    scene = build_street(parse_spec(HOUSE + "lean = 0.5\nsetback = 0"))
    facade = scene.houses[0].facades[0]
    top = facade.local_from_facade.apply(np.array([[0.0, 0.0, 10.0]]))
    s, d, z = scene.local_from_street.inverse.apply(top)[0]
    assert d == pytest.approx(10 * np.sin(np.radians(0.5))) and z < 10 and s == pytest.approx(0.0, abs=1e-9)


def test_a_slope_runs_along_the_road_and_under_the_houses() -> None:
    scene = build_street(SceneSpec(seed=1, houses=3, slope=6.0, setting="terrace"))
    road = scene.local_from_street.inverse.apply(scene.road)
    assert np.polyfit(road[:, 0], road[:, 2], 1)[0] == pytest.approx(0.06)
    for house in scene.houses:
        outline = house.facades[0].outline
        climb = outline[1, 1] - outline[0, 1]
        assert abs(climb) == pytest.approx(0.06 * np.ptp(outline[:, 0])) and (climb > 0) == (house.side == 0)


def test_impossible_requests_are_refused_or_noted() -> None:
    two = f"[[house.opening]]\n{OPENING}[[house.opening]]\nshutters = 'open'\n{OPENING}"
    two = two[::-1].replace("x = 1.0"[::-1], "x = 2.4"[::-1], 1)[::-1]
    with pytest.raises(OptionError, match="the open shutters of opening 2 cover a neighbour"):
        build_street(parse_spec(HOUSE + two))
    with pytest.raises(OptionError, match=r"house B01: 20 columns of windows .* do not fit on 8\.00 m"):
        build_street(parse_spec(HOUSE + "columns = 20"))
    low = build_street(parse_spec(HOUSE + "floors = 1\noriel = true\nroof = 'flat'\ndormers = true"))
    assert low.notes == ("B01: no room for what `oriel` asks for", "B01: no room for what `dormers` asks for")


def test_stated_numbers_are_kept_and_listed_houses_are_the_only_ones() -> None:
    scene = build_street(
        parse_spec("opposite = false\nsetting = 'terrace'\n[[house]]\n[[house]]\ntwin = true")
    )
    assert [h.twin_of for h in scene.houses] == [None, "B01"]
    assert len(build_street(SceneSpec(houses=3)).houses) == 6
    assert build_street(SceneSpec(houses=0, trees=0)).houses == ()


def test_the_documentation_names_every_key() -> None:
    text = (Path(__file__).parents[2] / "docs/reference/simulate.md").read_text(encoding="utf-8")
    for model in (SceneSpec, HouseSpec, OpeningSpec, ModelSpec):
        tables = {"house", "opening", "scanners", "drive", "cameras", "model", "output"}
        for key in set(model.model_fields) - tables:
            assert f"`{key}`" in text, key


def test_the_example_of_the_documentation_is_a_street() -> None:
    text = (Path(__file__).parents[2] / "docs/reference/simulate.md").read_text(encoding="utf-8")
    example = next(b for b in text.split("```toml\n")[1:] if "[[house.opening]]" in b).split("```")[0]
    scene = build_street(parse_spec(example))
    assert scene.notes == () and [h.id for h in scene.houses if h.side == 0] == ["B01", "B02"]
    assert any(p.kind == "oriel" for p in scene.houses[0].facades[0].protrusions)
    assert {o.kind for o in scene.houses[1].facades[0].openings} == {"door", "window"}
