"""The Ingolstadt scene: coarse stations against its LoD2, which is itself 0.2 to 0.45 m off."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from frontage.geometry.arrays import Array
from frontage.io.citymodels.read import read_city_model
from frontage.io.scans.read import ScanSource, read_scans
from frontage.model import CityModel, Scan
from frontage.registration import Registration, prior_of, register
from frontage.registration.select import select_walls
from realdata import data_path


@pytest.fixture(scope="module")
def scans() -> list[Scan]:
    return read_scans(
        ScanSource(
            path=str(data_path("ingolstadt_scene/input/coarse/scan_4cm.ptx")),
            crs="EPSG:25832",
            pose="approximate",
            sigma_position=2.0,
            sigma_heading=4.0,
            sigma_level=0.1,
        )
    )


@pytest.fixture(scope="module")
def model(scans: list[Scan]) -> CityModel:
    return read_city_model(data_path("ingolstadt_scene/input/lod2/lod2.city.json"), scans[0].world)


@pytest.fixture(scope="module")
def result(scans: list[Scan], model: CityModel) -> Registration:
    return register(scans, model, [prior_of(s) for s in scans])


def truth(name: str) -> Any:
    path: Path = data_path("ingolstadt_scene/truth") / name
    return json.loads(path.read_text())


def true_places(scans: list[Scan]) -> list[tuple[Array, Array]]:
    """True rotation (of the scanner) and position, local, of the coarse stations."""
    stations = [s for s in truth("truth.json")["stations"] if "coarse" in s["file"]]
    return [(np.array(s["R"]), np.array(s["position"]) - scans[0].world.origin) for s in stations]


def test_stations_are_placed_as_the_shifted_model_says(scans: list[Scan], result: Registration) -> None:
    shift = np.mean(list(truth("lod2_shift.json").values()), axis=0)
    for r, (_, place) in zip(result.scans, true_places(scans), strict=True):
        off = r.position - place - shift
        assert np.linalg.norm(off[:2]) < 0.08
        assert abs(off[2]) < 0.25
        assert np.abs(off / np.sqrt(np.diag(r.covariance))[:3]).max() < 3
        assert r.explained > 0.7
    assert not result.ambiguous


def test_stations_agree_to_a_centimetre(scans: list[Scan], result: Registration) -> None:
    true = true_places(scans)
    for i, (R, place) in enumerate(true):
        for j in range(i):
            given = [scans[k].local_from_scanner for k in (i, j)]
            assert given[0] is not None and given[1] is not None
            found = result.scans[i].local_from_given.value.R @ given[0].value.R
            apart = found.T @ (result.scans[j].position - result.scans[i].position)
            assert np.linalg.norm(apart - R.T @ (true[j][1] - place)) < 0.01
    assert result.agreement < 0.005


def test_facades_are_selected_from_the_registered_scan(
    scans: list[Scan], model: CityModel, result: Registration
) -> None:
    pose = result.scans[0].local_from_given.value
    scan = scans[0]
    placed = Scan(scan.name, pose.apply(scan.xyz), scan.world, pose.apply(scan.origins), scan.origin_index)
    found = select_walls(placed, model)
    front = max(found.walls, key=lambda w: len(w.index))
    assert front.building in {"DEBY_LOD2_4018150a", "DEBY_LOD2_4018150b"}
    assert abs(front.offset) < 0.2
    assert front.sigma[0] < 0.01
    assert found.absent == ()
