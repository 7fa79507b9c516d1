"""Simulated scenes and runs that several tests share; most are made once for all workers."""

import os
from pathlib import Path

import cv2
import pytest

from frontage.pipeline.project import load_project
from frontage.pipeline.run import run
from frontage.simulate.spec import parse_spec
from frontage.studies.simulate import simulate
from once import once
from scanned_streets import ScannedStreet, terrace
from simulated import PAIR, TINY, without_model

cv2.setNumThreads(1)  # two workers share two cores
os.environ.pop(
    "PYTHONDONTWRITEBYTECODE", None
)  # or every process that tests start compiles the package again


@pytest.fixture(scope="session")
def street() -> ScannedStreet:
    """Four unlike terraced houses, every second one set back, behind trees, cars and lamps."""
    return terrace(seed=7, houses=[{"setback": back} for back in (0.0, 0.3, 0.0, 0.25)])


@pytest.fixture(scope="session")
def project(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The project file of a simulated scene of two houses with two small photos, without a city model."""

    def make(folder: Path) -> None:
        without_model(simulate(parse_spec(PAIR), folder).project)

    return once(tmp_path_factory, "pair_scene", make) / "project.toml"


@pytest.fixture(scope="session")
def pair_run(project: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The run folder of that scene. Tests that change it copy it first."""
    return once(tmp_path_factory, "pair_run", lambda out: run(load_project(project), out))


@pytest.fixture(scope="session")
def simulated(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a tiny simulated scene: one house, two stations, two small photos."""
    return once(tmp_path_factory, "tiny_scene", lambda folder: simulate(parse_spec(TINY), folder))


@pytest.fixture(scope="session")
def simulated_run(simulated: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The run folder of the tiny scene. Tests that change it copy it first."""
    return once(tmp_path_factory, "tiny_run", lambda out: run(load_project(simulated / "project.toml"), out))
