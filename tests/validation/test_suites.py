"""The public validity suites: every code they name is found, and every valid case passes.

QIE codes that val3dity merged into others are reported too: 105 with 104, 304 with 303, 308 with 405.
"""

from pathlib import Path

import pytest

from frontage.io.shapes.read import read_shapes
from frontage.model import Finding
from frontage.queries.validation import validate_file
from frontage.validation import Tolerances, validate_feature
from realdata import DATA, data_path

UNIT, VAL = "validity/unittests", "validity/val3dity"
GENERIC, VALID = f"{VAL}/test_geometry_generic", f"{VAL}/test_valid"
BASE = f"{VALID}/basecube.poly"

# Codes that a file holds beside the one in its name; val3dity or the description of the file name them too.
ALSO = {
    "i105_1": {104},  # a collapsed ring, val3dity's 104
    "i204_2": {104},  # a fold seen edge on: its ring touches itself in the plane (val3dity: 104)
    "104_4": {204},  # the same geometry
    "i304_1": {302, 303},  # val3dity calls a vertex that one face lacks a hole
    "i304_2": {303},
    "304_1": {303},
    "i306_3": {305},  # the face inside another one is not connected to it
    "i306_4": {303, 304},  # four sheets meet along the edge that touches the wall
    "303_2": {304, 306},  # the same geometry
    "i308_1": {405},
    "i308_2": {405},
    "405": {308},
}
# File name -> correct code, where the name says another one.
INSTEAD = {
    "207_2": 208,  # facets are faces here, so no ring is nested; the hole runs the wrong way
    "304_2": 303,  # val3dity's own test expects 303
}
TOLERANCE = {
    "t203_1": {203},
    "t203_2": set(),
    "t203_3": set(),
    "t203_4": set(),
    "t203_5": set(),
    "t302_1": {302},
    "t302_2": {302},
    "t302_3": set(),
}
INNER = {"401_2", "401_3", "402_in_1", "inner_shell_2", "inner_shell_3", "inner_shell_4"}


def names(folder: str, pattern: str = "*") -> list[str]:
    """Returns the files of a folder of the suites, or the name "absent" without the data."""
    root = DATA / folder
    return sorted(p.name for p in root.glob(pattern)) if root.is_dir() else ["absent"]


def codes(findings: tuple[Finding, ...]) -> set[int]:
    return {f.code for f in findings} | {f.qie for f in findings if f.qie is not None}


def found(
    path: Path, *inner: Path, primitive: str = "Solid", tolerances: Tolerances | None = None
) -> set[int]:
    return codes(validate_file(path, tolerances, primitive, inner).findings)  # type: ignore[arg-type]


@pytest.mark.parametrize("name", names(UNIT, "[vit]*.gml"))
def test_unit(name: str) -> None:
    path = data_path(f"{UNIT}/{name}")
    expected = set() if name[0] == "v" else TOLERANCE.get(path.stem, set())
    if name[0] == "i":
        expected = {int(name[1:4])} | ALSO.get(path.stem, set())
    assert found(path) == expected


@pytest.mark.parametrize("name", [n for n in names(GENERIC) if not n.startswith("inner")])
def test_geometry_generic(name: str) -> None:
    path = data_path(f"{GENERIC}/{name}")
    code = INSTEAD.get(path.stem, int(path.stem[:3]))
    expected = set() if "valid" in name else {code} | ALSO.get(path.stem, set())
    if path.stem == "303_cs":
        assert found(path) == {302}
        assert found(path, primitive="CompositeSurface") == {303}
        return
    more = [data_path(f"{GENERIC}/inner_shell.poly")] if path.stem in INNER else []
    given = [data_path(BASE), path, *more] if 401 <= code <= 404 else [path]
    assert found(*given) == expected


@pytest.mark.parametrize("name", names(f"{VAL}/test_geometry_specific"))
def test_geometry_specific(name: str) -> None:
    path = data_path(f"{VAL}/test_geometry_specific/{name}")
    assert found(path) == {int(name[:3])}
    if name in ("501.json", "601_1.json"):
        for tolerance in (0.01, 0.1, 1.0):
            assert found(path, tolerances=Tolerances(overlap=tolerance)) == set()


@pytest.mark.parametrize("name", names(VALID))
def test_valid(name: str) -> None:
    path = data_path(f"{VALID}/{name}")
    if name.startswith("inner"):
        more = [data_path(f"{VALID}/inner_shell.poly")] if path.stem in INNER else []
        assert found(data_path(BASE), path, *more) == set()
    elif name in ("planar.off", "v104_1.off", "v104_2.off"):  # one face each
        assert found(path, primitive="MultiSurface") == set()
        assert found(path) == {301}
    elif name.startswith("two_objects"):  # val3dity's own test expects 102: a corner occurs twice
        assert found(path) == {102}
    else:
        assert found(path) == set()


OTHERS = {
    "test_cityjson/cube_v10.city.json": set(),
    "test_cityjson/cube_v11.city.json": set(),
    "test_cityjson/emptygeom.json": {902},  # valid for val3dity, but nothing in it was checked
    "test_cityjson/geomtemplate_1.json": set(),
    "test_cityjson/geomtemplate_2.json": {203},
    "test_cityjson/several_lods_invalid.json": {601},
    "test_cityjson/several_lods_valid.json": set(),
    "test_cityjson/torus.city.json": set(),
    "test_cjseq/denhaag_random_5.city.jsonl": {203, 601},
    "test_cjseq/notransform.city.jsonl": {901},
    "test_cjseq/unclosedbracket.city.jsonl": {901},
    "test_empty/completely_empty.json": {901},
    "test_empty/completely_empty.obj": {902},
    "test_empty/completely_empty.off": {901},
    "test_empty/empty_primitive.json": {902},
    "test_empty/empty_primitive_1.json": {902},
    "test_empty/empty_primitive.obj": {902},
    "test_empty/empty_primitive.off": {902},
    "test_empty/empty_primitive.poly": {902},
    "test_file_format/index0.obj": {901},
    "test_file_format/index901.obj": {901},
    "test_file_format/invalid_indoorgml_1.gml": {901},
    "test_file_format/invalid_indoorgml_2.gml": {901},
    "test_file_format/invalid_json_cityjson.json": {901},
    "test_file_format/invalid_schema_cityjson_1.json": {901},
    "test_file_format/invalid_schema_cityjson_2.json": {901},
    "test_jsonfg/building.fg.json": set(),
    "test_jsonfg/cubes.fg.json": set(),
    "test_jsonfg/cubes2.fg.json": {904},
    "test_jsonfg/e103.fg.json": {103},
    "test_jsonfg/geojson.json": {904},
    "test_tu3djson/cube.json": set(),
    "test_tu3djson/cube2.json": set(),
    "test_tu3djson/cube3.json": {104},
    "test_indoorgml/igml_701.gml": {701},
    "test_indoorgml/igml_702.gml": {702},
    "test_indoorgml/igml_703_1.gml": {703},
    "test_indoorgml/igml_703_2.gml": {703},
    "test_indoorgml/igml_704_1.gml": set(),  # valid according to its description
    "test_indoorgml/igml_704_2.gml": {704},
    "test_indoorgml/igml_v1.gml": set(),
    "test_indoorgml/igml_v2.gml": set(),
    "cityjson/cube2.json": {102},
    "gml/csol1.gml": set(),
    "gml/csol1b.gml": set(),
    "gml/csol5.gml": {104},
    "gml/csol6.gml": {302},
    "gml/csol7.gml": set(),
    "gml/msol1.gml": set(),
    "gml/msol2.gml": set(),
    "gml/msol3.gml": {302},
    "poly/104_valid.poly": set(),
    "poly/Cube14r2.poly": set(),
    "poly/concave.poly": set(),
    "poly/cube.poly": set(),
    "poly/cube13.poly": set(),
    "poly/cube14.poly": {405, 308},
    "poly/cube14r.poly": {405, 308},
    "poly/cube15.poly": {303},
    "poly/cube19.poly": {208},
    "poly/cube22.poly": set(),
    "poly/cube25.poly": set(),
    "poly/cube26.poly": set(),
    "poly/cube27.poly": set(),
    "poly/cube5.poly": set(),
    "poly/cube6.poly": set(),
    "poly/house.poly": set(),
    "poly/house4.poly": set(),
    "poly/m41.poly": set(),
    "poly/p1e-1.poly": {203},
    "poly/p1e-2.poly": set(),
    "poly/pfold1.poly": {204},
    "poly/pfold2.poly": {104, 204},
    "poly/snap1e-1.poly": {302},
    "poly/snap1e-2.poly": {302},
    "poly/snap1e-3.poly": set(),
    "poly/torus.poly": set(),
}


@pytest.mark.parametrize("name", OTHERS)
def test_other_files(name: str) -> None:
    assert found(data_path(f"{VAL}/{name}")) == OTHERS[name]


@pytest.mark.parametrize("name", ["cube_tol_1.json", "cube_tol_1.obj", "cube_tol_1.off"])
def test_duplicates(name: str) -> None:
    path = data_path(f"{VAL}/test_duplicates/{name}")
    for snap in (0.1, 0.01, 0.001):
        assert found(path, tolerances=Tolerances(snap=snap)) == set()
    for snap in (0.00001, 1e-12):
        assert found(path, tolerances=Tolerances(snap=snap)) == {302}


def test_a_thin_bent_triangle_counts() -> None:
    _, features = read_shapes(data_path(f"{VAL}/rotterdam/3-20-DELFSHAVEN.city.json"))
    bent = next(f for f in features if f.id.startswith("{EA541FCF"))
    assert codes(validate_feature(bent)) == {204}


def test_no_file_of_the_suites_breaks_the_validator() -> None:
    for folder in ("poly", "obj", "gml", "cityjson", "cityjsonseq", "test_indoorgml"):
        for path in sorted(data_path(f"{VAL}/{folder}").iterdir()):
            assert 999 not in found(path), path


@pytest.mark.parametrize("version", ["CityGMLv2", "CityGMLv3"])
@pytest.mark.parametrize("name", ["LOD1-EPSG25832", "LOD1-LocalEngineeringCRS", "LOD2-EPSG25832"])
def test_an_example_house_is_valid(version: str, name: str) -> None:
    report = validate_file(data_path(f"citymodels/lod_examples/{version}/Building_{name}.gml"))
    assert report.valid, report.findings
    assert report.geometries["Solid"] == 1
