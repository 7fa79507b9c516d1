"""`simulate`, `score` and `demo` as a user meets them."""

import json
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from frontage.cli.main import main
from frontage.studies import demo as demonstration
from simulated import BARE, TINY


def call(*words: object) -> Result:
    return CliRunner().invoke(main, [str(word) for word in words])


def test_simulate_writes_a_scene_and_says_what_comes_next(tmp_path: Path) -> None:
    (tmp_path / "spec.toml").write_text(BARE)
    out = tmp_path / "scene"
    result = call("simulate", tmp_path / "spec.toml", "-o", out)
    assert result.exit_code == 0, result.output
    assert (out / "project.toml").is_file() and f"frontage run {out / 'project.toml'}" in result.output
    facts = json.loads(call("simulate", tmp_path / "spec.toml", "--seed", 4, "-o", out, "--json").stdout)
    assert facts["photos"] == 2 and facts["points"] > 1000
    assert json.loads((out / "truth" / "spec.json").read_text())["seed"] == 4


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("houses = -1\n", "houses = -1 is not usable"),
        ("haus = 1\n", "unknown key haus"),
        ("houses = 1\nhouses = 2\n", "not TOML"),
        ("[[scanners]]\nspacing = 0\n", "spacing = 0 is not usable"),
        ("[[cameras]]\nmodel = 'BOX'\n", "BOX"),
        ("[output]\nscans = 'doc'\n", "scans = 'doc' is not usable"),
        ("[[house]]\n[[house.opening]]\nx=1\nz=1\nwidth=99\nheight=1\n", "width = 99 is not usable"),
    ],
)
def test_bad_specs_are_one_sentence_with_the_file_s_name(tmp_path: Path, text: str, words: str) -> None:
    (tmp_path / "spec.toml").write_text(text)
    result = call("simulate", tmp_path / "spec.toml", "-o", tmp_path / "scene")
    assert result.exit_code == 1
    assert result.stderr.startswith("frontage: ") and len(result.stderr.splitlines()) == 1
    assert words in result.stderr and "spec.toml" in result.stderr
    assert not (tmp_path / "scene").exists()


def test_wrong_usage_and_missing_files(tmp_path: Path) -> None:
    assert call("simulate", "-o", tmp_path).exit_code == 2
    assert call("simulate", "--seed", "3").exit_code == 2
    missing = call("simulate", tmp_path / "none.toml", "-o", tmp_path / "scene")
    assert missing.exit_code == 1 and "none.toml: no such file" in missing.stderr
    assert call("score", tmp_path).exit_code == 2
    no_run = call("score", tmp_path, tmp_path)
    assert no_run.exit_code == 1 and "truth.json" in no_run.stderr


def test_score_shows_figures_and_what_is_absent(simulated_run: Path, simulated: Path) -> None:
    result = call("score", simulated_run, simulated)
    assert result.exit_code == 0, result.output
    lines = result.stdout.splitlines()
    assert any(line.startswith("photos") and "absent" in line for line in lines)
    table = json.loads(call("score", simulated_run, simulated, "--json").stdout)
    figures = table["parts"]["facades"]["figures"]
    assert figures["recall"]["value"] == 1.0
    (shown,) = [line.split() for line in lines if line.split()[:1] == ["offset_median"]]
    assert shown[2] == "mm" and 0 < float(shown[1]) < 20
    assert float(shown[1]) == pytest.approx(1000 * figures["offset_median"]["value"], rel=0.01)
    assert table["bounds"] == []


def test_bounds_decide_the_exit_code(simulated_run: Path, simulated: Path) -> None:
    good = call("score", simulated_run, simulated, "--require", "facades.offset_median<=0.01")
    assert good.exit_code == 0, good.output
    bounds = ["--require", "facades.offset_median<=0.01", "--require", "photos.found>=1"]
    bad = call("score", simulated_run, simulated, "--json", *bounds)
    assert bad.exit_code == 1 and "photos is absent" in bad.stderr
    kept = [bound["kept"] for bound in json.loads(bad.stdout)["bounds"]]
    assert kept == [True, False]
    unknown = call("score", simulated_run, simulated, "--require", "facades.offset<=1")
    assert unknown.exit_code == 1 and "no figure 'offset'" in unknown.stderr


def test_the_demo_runs_the_chain_and_shows_its_scores(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(demonstration, "SPEC", TINY)
    out = tmp_path / "demo"
    result = call("demo", out, "--workers", 1)
    assert result.exit_code == 0, result.output
    assert (out / "result" / "report.html").is_file()
    assert f"the report: {out / 'result' / 'report.html'}" in result.stdout
    assert "facade planes, median offset" in result.stdout
    again = json.loads(call("demo", out, "--workers", 1, "--json").stdout)
    assert again["scores"]["parts"]["buildings"]["figures"]["f1"]["value"] == 1.0


def test_the_spec_of_the_demo_can_be_built() -> None:
    from frontage.simulate.spec import parse_spec
    from frontage.simulate.street.build import build_street

    spec = parse_spec(demonstration.SPEC)
    scene = build_street(spec)
    assert len(scene.houses) == 6 and spec.scanners and spec.cameras
    assert sum(len(f.openings) for h in scene.houses for f in h.facades) > 60
