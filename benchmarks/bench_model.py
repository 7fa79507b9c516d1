"""From the points of a house to its LoD3 files: processor time of every step.

    python benchmarks/bench_model.py [--seed 0] [--points 1000000]

A simulated house is scanned from two stations, densely enough for the requested number of points on it;
then facades, openings, solids and files follow in one process. The goal is 10 s on two cores for a million
points on facades. There is no baseline: the papers give no times.
"""

import argparse
import tempfile
import time
from dataclasses import replace
from pathlib import Path

import numpy as np

from _common import ROOT  # noqa: F401  (finds the tests' helpers)
from frontage.catalog import number_facade
from frontage.exports import building_mesh, city_building, model_triangles, render_model
from frontage.facades import find_facades
from frontage.io.citymodels.citygml.write import write_citygml
from frontage.io.citymodels.cityjson.write import write_cityjson
from frontage.io.meshes.glb import glb_of
from frontage.model import Building, Elements, Facade, Failed, Scan
from frontage.model.scan import merge_scans
from frontage.openings import OpeningOptions, find_openings
from frontage.simulate.scene import Scene
from frontage.simulate.sensors.instrument import ScannerSpec
from frontage.simulate.sensors.terrestrial import scan_stations
from frontage.simulate.spec import SceneSpec
from frontage.simulate.street.build import build_street
from frontage.solids import assemble
from frontage.validation import validate

_FIRST = 0.03  # m between beams 10 m away, from which the spacing for the asked number follows


class Clock:
    """Processor and wall seconds between calls."""

    def __init__(self) -> None:
        self.rows: list[tuple[str, float, float]] = []
        self._at = time.process_time(), time.perf_counter()

    def tell(self, step: str) -> None:
        """Record the end of a step."""
        now = time.process_time(), time.perf_counter()
        self.rows.append((step, now[0] - self._at[0], now[1] - self._at[1]))
        self._at = now

    def show(self) -> None:
        """Print all steps."""
        for step, cpu, wall in [*self.rows, ("all", *(sum(r[k] for r in self.rows) for k in (1, 2)))]:
            print(f"{step:12} {cpu:8.2f} s of processor time, {wall:8.2f} s on the clock")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--points", type=int, default=1_000_000)
    args = parser.parse_args()
    scene = build_street(
        SceneSpec.model_validate(
            {"seed": args.seed, "houses": 1, "opposite": False, "setting": "terrace", "lamps": 0}
            | {"trees": 0, "cars": 0, "people": 0, "hedges": False}
        )
    )
    _, own = scanned(scene, args.seed, _FIRST)
    scan, own = scanned(scene, args.seed, _FIRST * (len(own) / args.points) ** 0.5)
    plan = scene.houses[0]
    print(f"{len(scan):,} points, {len(own):,} of them on the house {plan.id}")

    clock = Clock()
    building = Building(plan.id, own, plan.ground_z)
    facades = [f for f in find_facades(scan, building) if isinstance(f, Facade)]
    clock.tell("facades")
    fronts: list[tuple[Facade, Elements]] = []
    for f in facades:
        ground = (building.ground_z - float(f.frame.t[2])) / float(f.frame.R[2, 2])
        found = find_openings(f, scan, OpeningOptions(ground_z=ground))
        if not isinstance(found, Failed):
            named = number_facade(f.id, found.openings, ground)
            fronts.append((f, replace(found.elements, openings=named)))
    clock.tell("openings")
    made = assemble(building, fronts, (), scan.world)
    assert made, made
    clock.tell("solids")
    with tempfile.TemporaryDirectory() as folder:
        city = [city_building(building, made, fronts)]
        write_cityjson(Path(folder, "m.city.json"), city, scan.world, "m")
        write_citygml(Path(folder, "m.gml"), city, scan.world, "m", "2.0")
        write_citygml(Path(folder, "m3.gml"), city, scan.world, "m", "3.0")
        Path(folder, "m.glb").write_bytes(glb_of([building_mesh(made, (), 2.0)], scan.world))
        render_model(model_triangles(made), facades[0].frame.R[:, 1])
    clock.tell("files")
    clock.show()
    count = sum(len(e.openings) for _, e in fronts)
    near = sum(len(f.support) for f in facades)
    print(f"{len(facades)} facades with {near:,} points, {count} openings, {len(made.failed)} refused, "
          f"{sum(len(validate(b.solid)) for b in made.built)} findings")  # fmt: skip


def scanned(scene: Scene, seed: int, spacing: float) -> tuple[Scan, np.ndarray]:
    """The cloud of two stations and the points on the first house."""
    scanner = ScannerSpec.model_validate(
        {"stations": 2, "spacing": spacing, "field": 170, "lowest": -20, "highest": 60, "subrays": 1}
        | {"colour": False}
    )
    stations = scan_stations(scene, scanner, seed)
    surface = np.concatenate([s.surface for s in stations])
    owner = np.array([s.house for s in scene.surfaces])
    return merge_scans([s.scan for s in stations]), np.flatnonzero(
        np.where(surface >= 0, owner[surface], -1) == 0
    )


if __name__ == "__main__":
    main()
