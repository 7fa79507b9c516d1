"""`frontage validate`: what a user sees, what a script gets, and the exit code."""

import json
from pathlib import Path

from click.testing import CliRunner, Result

from frontage.cli.main import main
from shape_files import cityjson, obj, off, poly


def call(*words: object) -> Result:
    return CliRunner().invoke(main, ["validate", *(str(word) for word in words)])


def broken() -> str:
    """The cube with its top turned and a corner named twice."""
    return off().replace("4 4 5 6 7", "4 7 6 5 4").replace("4 0 3 2 1", "5 0 3 2 2 1")


def write(folder: Path, name: str, text: str) -> Path:
    path = folder / name
    path.write_text(text)
    return path


def test_a_valid_file(tmp_path: Path) -> None:
    path = write(tmp_path, "cube.city.json", json.dumps(cityjson()))
    result = call(path)
    assert result.exit_code == 0
    assert result.output == f"{path}: valid; CityJSON 2.0, 1 features, 1 geometries (1 Solid)\n"
    assert call(path, "--quiet").output == ""


def test_one_line_per_finding_and_a_summary(tmp_path: Path) -> None:
    path = write(tmp_path, "cube.off", off().replace("4 4 5 6 7", "4 7 6 5 4"))
    result = call(path)
    assert result.exit_code == 1
    line, summary = result.stdout.splitlines()
    assert line.startswith(f"{path}: 307 POLYGON_WRONG_ORIENTATION cube geometry=0|shell=0|face=1: ")
    assert line.endswith(" at 0.5000 0.5000 1.0000")
    assert summary.startswith(f"{path}: INVALID, 1 findings (307 x 1); OFF")


def test_older_names_are_told_too(tmp_path: Path) -> None:
    flipped = off()
    for face in ("0 3 2 1", "4 5 6 7", "0 1 5 4", "1 2 6 5", "2 3 7 6", "3 0 4 7"):
        flipped = flipped.replace(f"4 {face}", "4 " + face[::-1])
    result = call(write(tmp_path, "cube.off", flipped))
    assert "405 WRONG_ORIENTATION_SHELL (QIE 308 GE_S_ALL_POLYGONS_WRONG_ORIENTATION)" in result.stdout


def test_json_for_scripts(tmp_path: Path) -> None:
    good, bad = write(tmp_path, "good.obj", obj()), write(tmp_path, "bad.off", broken())
    missing = tmp_path / "none.gml"
    result = call(good, bad, missing, "--json")
    assert result.exit_code == 1
    table = json.loads(result.stdout)
    assert table["valid"] is False and table["codes"] == [102, 901]
    assert table["tolerances"] == {
        "snap": 0.001, "planarity_distance": 0.01, "planarity_normals": 20.0, "overlap": -1.0
    }  # fmt: skip
    assert [file["valid"] for file in table["files"]] == [True, False, False]
    finding = table["files"][1]["findings"][0]
    assert finding == {
        "code": 102, "name": "CONSECUTIVE_POINTS_SAME", "feature": "bad",
        "where": "geometry=0|shell=0|face=0|ring=0", "message": "a point is followed by the same point again",
        "location": [1.0, 1.0, 0.0],
    }  # fmt: skip
    assert "none.gml" in table["files"][2]["findings"][0]["message"]


def test_files_that_cannot_be_read_are_one_sentence_each(tmp_path: Path) -> None:
    good = write(tmp_path, "good.obj", obj())
    empty, corrupt = write(tmp_path, "empty.json", ""), write(tmp_path, "corrupt.gml", "<CityModel><a>")
    other = write(tmp_path, "other.txt", "hello")
    result = call(empty, tmp_path / "none.json", corrupt, other, good)
    assert result.exit_code == 1
    sentences = result.stderr.splitlines()
    assert [s.rsplit("[", 1)[1][:3] for s in sentences] == ["901", "901", "901", "904"]
    for text, path in zip(sentences, ("empty.json", "none.json", "corrupt.gml", "other.txt"), strict=True):
        assert path in text and text.startswith("frontage: ") and "Traceback" not in text
    assert result.stdout.splitlines()[-1].startswith(f"{good}: valid")


def test_tolerances(tmp_path: Path) -> None:
    path = write(tmp_path, "cube.off", off().replace("1 1 1", "1 1 1.2"))
    assert "203 x" in call(path).stdout
    assert call(path, "--planarity-d2p-tol", "0.1").exit_code == 0
    assert "204 x" in call(path, "--planarity-d2p-tol", "0.1", "--planarity-n-tol", "2").stdout
    for wrong in (["--snap-tol", "-1"], ["--planarity-d2p-tol", "nan"], ["--snap-tol", "1cm"]):
        assert call(path, *wrong).exit_code == 2


def test_faces_as_another_primitive_and_inner_shells(tmp_path: Path) -> None:
    sheet = write(tmp_path, "sheet.off", off().replace("8 6 0", "8 5 0").rsplit("\n", 1)[0])
    assert call(sheet).exit_code == 1
    assert call(sheet, "-p", "CompositeSurface").exit_code == 0
    outer = write(tmp_path, "outer.poly", poly())
    inner = write(tmp_path, "inner.poly", poly())
    result = call(outer, "--inner", inner)
    assert result.exit_code == 1 and "402 DUPLICATED_SHELLS" in result.stdout
    assert call(outer, sheet, "--inner", inner).exit_code == 2
    named = write(tmp_path, "cube.json", json.dumps(cityjson()))
    result = call(named, "--inner", inner)
    assert result.exit_code == 1 and "--inner" in result.stderr and "Traceback" not in result.stderr
