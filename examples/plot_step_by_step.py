"""From a scan to a validated LoD3 solid, one function at a time.

Simulates one house, scans it from two stations, and calls each step of the chain on the objects that the step
before returned, without a run folder. The true values stand beside the estimates.
"""

import json
import tempfile
from pathlib import Path

import numpy as np

import frontage
from frontage.simulate.spec import parse_spec
from frontage.studies.simulate import simulate

SPEC = """
seed = 7
opposite = false
setting = "terrace"
trees = 0
cars = 0
lamps = 0
people = 0
hedges = false
[[house]]
width = 9.0
floors = 3
shutters = false
balconies = false
oriel = false
[[scanners]]
stations = 2
spacing = 0.05
subrays = 1
field = 180.0
lowest = -35.0
highest = 55.0
ranging = "pulsed"
"""


def main() -> None:
    with tempfile.TemporaryDirectory() as folder:
        scene = Path(folder) / "scene"
        simulate(parse_spec(SPEC), scene)
        truth = json.loads((scene / "truth" / "truth.json").read_text())
        scan = frontage.read_scans(*sorted((scene / "scans").glob("*.e57")))
    print(f"scan: {len(scan)} points from {len(scan.origins)} stations; simulated: {len(truth['stations'])}")

    buildings = frontage.find_buildings(scan).buildings
    print(f"buildings: {len(buildings)}; true: {len(truth['buildings'])}")

    facade = frontage.find_facades(scan, buildings[0])[0]
    true = next(one for one in truth["facades"] if one["id"] == "B01/F1")
    offset, sigma = plane_error(true["frame"], scan, facade), facade.local_from_facade.sigma[1]
    print(f"plane: {offset * 1000:+.2f} mm from the true one, standard error {sigma * 1000:.2f} mm")

    ortho = frontage.make_ortho(facade, scan, gsd=0.05)
    print(f"ortho-image from the scan alone: {ortho.size[0]} x {ortho.size[1]} px")

    elements = frontage.find_openings(facade, scan)
    print(f"openings: {len(elements.openings)}; true: {len(true['openings'])}")
    found, real = areas([o.ring for o in elements.openings]), areas([o["outline"] for o in true["openings"]])
    print(f"their area: {found.sum():.2f} m2; true: {real.sum():.2f} m2")

    model = frontage.build_model(buildings[0], [(facade, elements)])
    findings = [finding for built in model.built for finding in frontage.validate(built.solid)]
    print(f"model: {len(model.built)} solid, {len(model.failed)} openings refused, {len(findings)} findings")


def plane_error(frame: dict, scan: frontage.model.Scan, facade: frontage.model.Facade) -> float:
    """Signed distance in m of the found plane's origin from the true plane, positive into the building."""
    origin = facade.frame.t + np.array(scan.world.origin)
    return float((origin - np.array(frame["origin"])) @ np.array(frame["y"]))


def areas(outlines: list) -> np.ndarray:
    """Areas in m2 of outlines (k, 2), by the shoelace formula."""
    out = []
    for outline in outlines:
        x, z = np.array(outline).T
        out.append(abs(x @ np.roll(z, -1) - z @ np.roll(x, -1)) / 2)
    return np.array(out)


if __name__ == "__main__":
    main()
