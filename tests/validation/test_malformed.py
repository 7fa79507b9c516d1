"""Files that hold nothing, or are nested in other ways than their format says: a finding, no traceback."""

import json
import logging
from pathlib import Path
from typing import Any

import pytest

from frontage.queries.validation import validate_file
from shape_files import cityjson

CUBE: list[Any] = cityjson()["CityObjects"]["B1"]["geometry"][0]["boundaries"][0]
GML = (
    '<core:CityModel xmlns:core="http://www.opengis.net/citygml/2.0" xmlns:gml="http://www.opengis.net/gml" '
    'xmlns:bldg="http://www.opengis.net/citygml/building/2.0" xmlns:xlink="http://www.w3.org/1999/xlink">'
    "<core:cityObjectMember><bldg:Building>{}</bldg:Building></core:cityObjectMember></core:CityModel>"
)
SEVERAL = {
    "an empty ring": ([[*CUBE, [[]]]], 101),
    "an empty hole": ([[[*CUBE[0], []], *CUBE[1:]]], 101),
    "a face without rings": ([[*CUBE, []]], 101),
    "no boundaries": (None, 901),
    "a shell that is null": ([None], 901),
    "a face that is null": ([[*CUBE, None]], 901),
    "a ring that is null": ([[*CUBE, [None]]], 901),
    "a vertex that is null": ([[*CUBE, [[None, 1, 2]]]], 901),
    "one level too few": ([1, 2, 3], 901),
    "one level too many": ([[*CUBE, [[[0, 1, 2]]]]], 901),
    "a text": ("abc", 901),
    "an object": ({"a": 1}, 901),
    "a negative vertex": ([[*CUBE, [[0, -1, 2]]]], 901),
    "a vertex beyond the last": ([[*CUBE, [[0, 1, 99]]]], 901),
    "an enormous vertex": ([[*CUBE, [[0, 1, 10**30]]]], 901),
    "a fraction of a vertex": ([[*CUBE, [[0, 1.5, 2]]]], 901),
    "vertices as texts": ([[*CUBE, [["0", "1", "2"]]]], 901),
    "no shells": ([], 902),
}


def model(boundaries: Any, **members: Any) -> str:
    data = cityjson(**members)
    data["CityObjects"]["B1"]["geometry"][0]["boundaries"] = boundaries
    return json.dumps(data)


def codes(path: Path, text: str) -> set[int]:
    path.write_text(text)
    found = validate_file(path)
    assert not found.valid
    assert all(len(f.message) < 300 and "Error" not in f.message for f in found.findings)
    return set(found.codes)


@pytest.mark.parametrize("name", SEVERAL)
def test_malformed_boundaries(name: str, tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    boundaries, code = SEVERAL[name]
    with caplog.at_level(logging.WARNING):
        assert codes(tmp_path / "m.json", model(boundaries)) == {code}
    assert not caplog.records


@pytest.mark.parametrize(
    "member",
    [
        {"CityObjects": {"b": []}},
        {"CityObjects": {"b": {"type": "Building", "geometry": [None]}}},
        {"CityObjects": {"b": {"type": "Building", "geometry": {"a": 1}}}},
        {"CityObjects": {"b": {"type": "Building", "parents": 7}}},
        {"vertices": [[0, 0]] * 9},
        {"vertices": [["a", 0, 0]] * 8},
        {"vertices": [[0, 0, None]] * 8},
    ],
)
def test_malformed_members(member: dict[str, Any], tmp_path: Path) -> None:
    assert codes(tmp_path / "m.json", json.dumps({**cityjson(), **member})) == {901}


def test_deep_nesting_is_told(tmp_path: Path) -> None:
    deep = 100_000
    text = json.dumps(cityjson())[:-1] + ', "x": ' + "[" * deep + "]" * deep + "}"
    assert codes(tmp_path / "m.json", text) == {901}
    (finding,) = validate_file(tmp_path / "m.json").findings
    assert "nested too deeply" in finding.message
    assert codes(tmp_path / "m.gml", "<a>" * deep + "</a>" * deep) == {901}


def test_a_file_in_which_nothing_is_checked_is_not_valid(tmp_path: Path) -> None:
    page = "<html><body><p>not found</p></body></html>"
    assert codes(tmp_path / "page.gml", page) == {901}
    outside = GML.format('<bldg:lod2Solid xlink:href="other.gml#s"/>')
    assert codes(tmp_path / "outside.gml", outside) == {901}
    assert codes(tmp_path / "missing.gml", GML.format('<bldg:lod2Solid xlink:href="#s"/>')) == {901}
    assert codes(tmp_path / "empty.gml", GML.format("")) == {902}
    assert codes(tmp_path / "none.json", json.dumps({**cityjson(), "CityObjects": {}})) == {902}
    points = {"type": "Building", "geometry": [{"type": "MultiPoint", "lod": "1", "boundaries": [0, 1]}]}
    assert codes(tmp_path / "points.json", json.dumps({**cityjson(), "CityObjects": {"b": points}})) == {902}


def test_parts_in_a_circle_are_checked(tmp_path: Path) -> None:
    data = cityjson()
    part = data["CityObjects"].pop("B1")
    part["geometry"][0]["boundaries"] = [CUBE[1:]]
    data["CityObjects"] = {
        "p": {**part, "type": "BuildingPart", "parents": ["q"]},
        "q": {"type": "BuildingPart", "parents": ["p"]},
    }
    assert codes(tmp_path / "m.json", json.dumps(data)) == {302}


@pytest.mark.parametrize("kind", ["BuildingPart", "BuildingInstallation", "BuildingRoom"])
@pytest.mark.parametrize("linked", ["parents", "children"])
def test_a_building_and_its_children_are_judged_together(kind: str, linked: str, tmp_path: Path) -> None:
    data = cityjson()
    whole = data["CityObjects"]["B1"]
    data["CityObjects"]["c"] = {**json.loads(json.dumps(whole)), "type": kind}
    if linked == "parents":
        data["CityObjects"]["c"]["parents"] = ["B1"]
    else:
        whole["children"] = ["c"]

    assert codes(tmp_path / "m.json", json.dumps(data)) == {601}
    data["CityObjects"]["c"]["geometry"][0]["lod"] = "1"  # another level of detail
    (tmp_path / "n.json").write_text(json.dumps(data))
    assert validate_file(tmp_path / "n.json").valid
