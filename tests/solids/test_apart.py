"""Installations stand just in front of what carries them, and no two solids of a building overlap."""

import json
from pathlib import Path

import numpy as np
import pytest

from frontage.exports.lod3 import city_buildings
from frontage.io.citymodels.cityjson.write import write_cityjson
from frontage.model import Building, Elements
from frontage.queries.validation import validate_file
from frontage.solids.brep import GRID_PER_M
from frontage.validation.validate import overlapping
from solids.test_assemble import WORLD, Assembled, house, protrusion, wall, window

THINGS = Elements(
    "B01/F1",
    (window("W1", (-4, -2, -3, -0.5)),),
    (protrusion("oriel", (1, -1, 4, 2), -0.8), protrusion("balcony", (-2, 0, 0, 1.2), -1.0)),
)


@pytest.mark.parametrize("turn", [0.0, 0.1, 0.7, 1.234, 2.9, 4.4])
def test_a_gap_of_a_grid_step_is_left_whatever_the_direction_of_the_wall(turn: float) -> None:
    at = wall(turn=turn)
    made = house(at, THINGS)
    (balcony,) = made.installations
    assert balcony.closed and not overlapping([made.built[0].solid, balcony.solid])
    host = at.frame.inverse.apply(made.built[0].solid.vertices / GRID_PER_M)[:, 1]
    back = at.frame.inverse.apply(balcony.solid.vertices / GRID_PER_M)[:, 1].max()
    foremost = host[np.abs(host) < 0.005].min()
    assert 0.9e-4 < foremost - back < 4e-4


def saved(made: Assembled, elements: Elements, path: Path) -> Path:
    building = Building("B01", np.arange(3), 11.9)
    found = city_buildings(building, made, [(wall(), elements)], {})
    return write_cityjson(path, found, WORLD, "t")


def test_the_written_model_is_valid_with_parents_and_children_together(tmp_path: Path) -> None:
    found = validate_file(saved(house(wall(), THINGS), THINGS, tmp_path / "m.city.json"))
    assert found.valid and found.geometries == {"Solid": 3, "CompositeSurface": 1}, found.findings


def test_an_installation_that_reaches_into_another_is_kept_as_surfaces(tmp_path: Path) -> None:
    both = (protrusion("balcony", (-2, 0, 0, 1.2), -1.0), protrusion("cornice", (-4, 0.05, 4, 0.15), -0.3))
    elements = Elements("B01/F1", THINGS.openings, both)
    made = house(wall(), elements)
    assert [i.closed for i in made.installations] == [True, False]
    (note,) = (n for n in made.notes if "reaches" in n)
    assert note.startswith("B01/F1/cornice: reaches 0.") and "kept as surfaces" in note
    path = saved(made, elements, tmp_path / "m.city.json")
    assert validate_file(path).valid
    objects = json.loads(path.read_text())["CityObjects"]
    assert [g["type"] for g in objects["B01/F1/cornice"]["geometry"]] == ["MultiSurface"]
