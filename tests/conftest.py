"""Simulated scenes that several tests share; each is made once per worker."""

from pathlib import Path

import cv2
import pytest

from frontage.pipeline.project import load_project
from frontage.pipeline.run import run
from frontage.simulate.spec import parse_spec
from frontage.studies.simulate import simulate
from scanned_streets import ScannedStreet, terrace
from simulated import PAIR, TINY, without_model

cv2.setNumThreads(1)  # two workers share two cores


@pytest.fixture(scope="session")
def street() -> ScannedStreet:
    """Four unlike terraced houses, every second one set back, behind trees, cars and lamps."""
    return terrace(seed=7, houses=[{"setback": back} for back in (0.0, 0.3, 0.0, 0.25)])


@pytest.fixture(scope="session")
def project(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The project file of a simulated scene of two houses with two small photos, without a city model."""
    scene = simulate(parse_spec(PAIR), tmp_path_factory.mktemp("scenes") / "pair")
    return without_model(scene.project)


@pytest.fixture(scope="session")
def simulated(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a tiny simulated scene: one house, two stations, two small photos."""
    return simulate(parse_spec(TINY), tmp_path_factory.mktemp("scenes") / "tiny").out


@pytest.fixture(scope="session")
def simulated_run(simulated: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The run folder of the tiny scene. Tests that change it copy it first."""
    out = tmp_path_factory.mktemp("runs") / "tiny"
    run(load_project(simulated / "project.toml"), out)
    return out
