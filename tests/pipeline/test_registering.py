"""Scans with GPS and compass poses, from the project file to the report."""

import json
import shutil
from pathlib import Path

import numpy as np
import pytest

from frontage.errors import OptionError
from frontage.io.scans.npz import load_scan
from frontage.pipeline.project import load_project
from frontage.pipeline.run import run, run_stage
from frontage.pipeline.store.store import Store
from frontage.simulate.spec import parse_spec
from frontage.studies.simulate import simulate
from simulated import truth_of

STREET = """
seed = 11
houses = 2
trees = 0
cars = 1
people = 0
lamps = 0
[[scanners]]
stations = 2
spacing = 0.15
subrays = 1
pose = "approximate"
sigma_position = 1.0
[model]
shift = 0.0
building = 0.0
corner = 0.0
height = 0.0
roof = 0.0
[output]
gsd = 0.1
"""


@pytest.fixture(scope="module")
def scene(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return simulate(parse_spec(STREET), tmp_path_factory.mktemp("rough") / "street").out


@pytest.fixture(scope="module")
def out(scene: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("registered") / "run"
    run(load_project(scene / "project.toml"), folder)
    return folder


def test_scans_come_to_their_true_poses_and_say_how_well(scene: Path, out: Path) -> None:
    report = json.loads((out / "registration" / "report.json").read_text())
    stations = truth_of(scene)["stations"]
    assert len(report["scans"]) == len(stations) == 2 and not report["ambiguous"]
    for found, station in zip(report["scans"], stations, strict=True):
        true, given = (np.array(station[key]["position"]) for key in ("true", "given"))
        error = np.array(found["position"]) - true
        assert np.linalg.norm(given - true) > 0.3, "the test must have something to correct"
        covariance = np.array(found["covariance"])[:3, :3]
        assert error @ np.linalg.solve(covariance, error) < 16.3  # 99.9 % of three degrees of freedom
        seen = [d for d in found["observable"] if d["kind"] == "shift" and d["observable"]]
        assert not any(d["weak"] and d["observable"] for d in found["observable"])
        assert seen, "facing walls determine at least the distance from them"
        assert all(abs(error @ d["axis"]) < 0.05 for d in seen)
        stated = np.array([d["sigma"] for d in seen])
        assert ((stated > 0.002) & (stated < 0.1)).all()  # of 1 m that was known before
        assert np.allclose([np.sqrt(d["axis"] @ covariance @ d["axis"]) for d in seen], stated, rtol=1e-3)
        # the matrix takes the scanner's own coordinates into the world: its origin is the station
        assert np.allclose(np.array(found["matrix"])[:3, 3], found["position"], atol=1e-6)


def test_later_stages_work_on_the_registered_points(out: Path) -> None:
    given, placed = (Store(out).cloud(registered=moved).xyz for moved in (False, True))
    assert np.median(np.linalg.norm(given - placed, axis=1)) > 0.2
    own = load_scan(out / "buildings" / "B01.npz").xyz
    rows = {tuple(p) for p in placed.tolist()}
    assert all(tuple(p) in rows for p in own[:100].tolist())
    assert "Registration</h2>" in (out / "report.html").read_text()


def test_nothing_to_register_is_said(simulated_run: Path, tmp_path: Path) -> None:
    out = Path(shutil.copytree(simulated_run, tmp_path / "copy"))
    with pytest.raises(OptionError, match="all scans have trusted poses"):
        run_stage(out, "register")
    assert not (out / "registration").exists()
