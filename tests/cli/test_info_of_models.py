"""`frontage info` of city models."""

import json
from pathlib import Path

import numpy as np
from click.testing import CliRunner

from city_files import house
from frontage.cli.main import main
from frontage.io.citymodels.cityjson.write import write_cityjson
from io_files import UTM
from shape_files import FACES, city, lod2_surface, members, polygon


def test_info_says_what_a_city_model_holds(tmp_path: Path) -> None:
    path = write_cityjson(tmp_path / "m.city.json", [house("A", 0), house("B", 8)], UTM, "t")
    (tmp_path / "bad.gml").write_text(city(lod2_surface(members(polygon(FACES[0]), polygon([0, 0, 0])))))
    told = CliRunner().invoke(main, ["info", "--json", str(path), str(tmp_path / "bad.gml")])
    assert told.exit_code == 0, told.output
    facts, bad = json.loads(told.output)
    assert (facts["format"], facts["buildings"], facts["addresses"]) == ("CityJSON", 2, 2)
    assert facts["levels"] == {"2.2": 2} and facts["solids"] == 2
    assert facts["surfaces"] == {"WallSurface": 8, "GroundSurface": 2, "RoofSurface": 2}
    np.testing.assert_allclose(facts["extent"], UTM.to_world(np.array([[0, 0, 0], [16, 6, 5]])))
    assert "address" in facts["attributes"] and facts["problems"] == []
    assert len(bad["problems"]) == 1 and "fewer than 3 corners" in bad["problems"][0]
    plain = CliRunner().invoke(main, ["info", str(path)])
    assert "buildings: 2" in plain.output and "WallSurface: 8" in plain.output


def test_info_of_a_damaged_model_is_one_sentence(tmp_path: Path) -> None:
    (tmp_path / "a.json").write_text('{"type": ')
    told = CliRunner().invoke(main, ["info", str(tmp_path / "a.json")])
    assert told.exit_code == 1 and told.output.count("\n") == 1 and "not a readable city model" in told.output
