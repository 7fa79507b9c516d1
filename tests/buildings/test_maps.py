"""Given a map or a city model, buildings are those of the map, cut where walls were measured."""

import json

import numpy as np
import pytest

from frontage.buildings import BuildingSplit, find_buildings
from frontage.io.citymodels.footprints import read_footprints
from frontage.io.scans.read import ScanSource, read_scans
from frontage.model import Footprint, merge_scans
from realdata import data_path
from scenes import Scene, street_scene


@pytest.fixture(scope="module")
def street() -> Scene:
    return street_scene(seed=3, houses=4, spacing=0.06)


def _map(scene: Scene, shift: tuple[float, float] = (0.0, 0.0)) -> list[Footprint]:
    """Returns the houses of a row as a map, shifted by `shift` m (along, across), with 3 cm of noise."""
    rng = np.random.default_rng(0)
    out = []
    for i, h in enumerate(scene.houses):
        ring = np.array([[h.s0, h.offset], [h.s1, h.offset], [h.s1, 10.0], [h.s0, 10.0]]) + shift
        ring = np.column_stack([ring + rng.normal(0, 0.03, ring.shape), np.zeros(4)])
        out.append(Footprint(f"P{i}", scene.local_from_street.apply(ring)[:, :2], f"{i} High Street"))
    return out


def _cuts_along(split: BuildingSplit, scene: Scene) -> np.ndarray:
    """Returns the positions (k,) m of the cuts along the street."""
    xy = sorted({c[0] for b in split.buildings for c in b.cuts})
    s = scene.local_from_street.inverse.apply(np.array([[*c, 0.0] for c in xy]).reshape(-1, 3))[:, 0]
    return np.sort(s)


@pytest.mark.parametrize("shift", [(0.0, 0.0), (0.3, -0.3), (-0.45, 0.2), (0.2, 0.45)])
def test_twin_houses_are_cut_by_an_inaccurate_map_only(shift: tuple[float, float]) -> None:
    scene = street_scene(seed=1, houses=3, spacing=0.08, twins=True, trees=False, cars=False)
    assert len(find_buildings(scene.scan).buildings) == 1
    split = find_buildings(scene.scan, footprints=_map(scene, shift))
    assert [b.address for b in split.buildings] == ["0 High Street", "1 High Street", "2 High Street"]
    assert [b.notes for b in split.buildings] == [("footprint P0",), ("footprint P1",), ("footprint P2",)]
    walls = np.array([h.s1 for h in scene.houses[:-1]])
    assert np.abs(_cuts_along(split, scene) - walls).max() < 0.25
    assert all(0.9 < p < 1 for b in split.buildings for _, p in b.cuts)


def test_a_measured_step_prevails_over_an_inaccurate_map(street: Scene) -> None:
    split = find_buildings(street.scan, footprints=_map(street, (0.45, 0.3)))
    assert [b.address for b in split.buildings] == [f"{i} High Street" for i in range(4)]
    walls = np.array([h.s1 for h in street.houses[:-1]])
    assert np.abs(_cuts_along(split, street) - walls).max() < 0.25


def test_one_footprint_is_one_building(street: Scene) -> None:
    """Where a map covers the street, it decides: three houses of the row are one building on the map."""
    rings = _map(street)
    block = np.vstack([rings[0].ring[[0]], rings[2].ring[[1, 2]], rings[0].ring[[3]]])
    split = find_buildings(street.scan, footprints=[Footprint("block", block), rings[3]])
    assert [b.notes for b in split.buildings] == [("footprint block",), ("footprint P3",)]
    assert [b.address for b in split.buildings] == [None, "3 High Street"]


def test_the_buildings_of_the_ingolstadt_scan_follow_the_city_model() -> None:
    scene = "ingolstadt_scene/input"
    pytest.importorskip("pye57")
    source = ScanSource(path=str(data_path(f"{scene}/registered/scan_2cm.e57")), crs="EPSG:25832")
    scan = merge_scans(read_scans(source, resolution=0.05))
    found = []
    for model in ("lod2.city.json", "lod2.gml"):
        footprints = read_footprints(data_path(f"{scene}/lod2/{model}"), scan.world)
        found.append(find_buildings(scan, footprints=footprints).buildings)
    names = [b.notes[0].removeprefix("footprint DEBY_LOD2_") for b in found[0]]
    assert sorted(names) == ["4018115", "4018150a", "4018150b"]
    assert [b.index.tobytes() for b in found[0]] == [b.index.tobytes() for b in found[1]]
    (x, y), posterior = next(b for b in found[0] if b.notes[0].endswith("150b")).cuts[0]
    assert posterior > 0.99
    truth = json.loads(data_path("ingolstadt_scene/truth/truth.json").read_text())
    bay = next(f for f in truth["facades"] if f["id"] == "F10_4018150b")
    party = np.array(bay["origin"][:2]) - scan.world.origin[:2]
    assert abs((np.array([x, y]) - party) @ np.array(bay["e_u"][:2])) < 0.3
