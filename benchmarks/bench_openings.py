"""Openings: ours beside the published method, on the same facades, simulated and real.

    python benchmarks/bench_openings.py [--seeds 6] [--spacing 0.02 0.04 0.08] [--methods paper evidence]
                                        [--simulated-only | --real-only]

Simulated: for every seed a house drawn from it, scanned from two stations with `--spacing` m between beams
10 m away, and once more (at 4 cm) behind trees, cars and people; its facades are found from the points, as
in a run. What is asked for: openings of which the stations saw 20 % or more, closed shutters left out. F1 at
two IoU, absolute border errors and their bias, depth errors; root mean square of the errors over their
standard errors (1 = honest). Intervals: 95 %, bootstrap over houses.

Real: the two annotated fronts of the shared data, through buildings and facades, by their own scorer; skipped
where they are absent.
"""

import argparse
import json
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from _common import DATA, bootstrap, figure, table
from frontage.buildings import find_buildings
from frontage.evaluation.openings import score_openings
from frontage.evaluation.result import FoundOpening
from frontage.evaluation.truth import Truth, read_truth
from frontage.facades import find_facades
from frontage.geometry.arrays import Float
from frontage.io.scans import ScanSource, read_scans
from frontage.model import Building, Facade, Opening, Scan
from frontage.model.scan import merge_scans
from frontage.openings.find import find_openings
from frontage.openings.options import OpeningOptions
from frontage.simulate.build import street
from frontage.simulate.instrument import ScannerSpec
from frontage.simulate.rays import Tracer
from frontage.simulate.scene import Scene
from frontage.simulate.spec import SceneSpec
from frontage.simulate.terrestrial import scan_stations
from frontage.simulate.truth import scene_table
from frontage.simulate.visibility import Eye, visibility

REAL = ("brooklyn_row", "manhattan_apartment")
OCCLUDED = 0.04  # m, spacing of the case with things in the way


@dataclass
class Tally:
    """What a method did on each house: counts (found and true, found but not true, missed) by IoU level."""

    counts: dict[float, list[tuple[int, int, int]]] = field(default_factory=lambda: {0.5: [], 0.75: []})
    borders: list[Float] = field(default_factory=list)
    depths: list[Float] = field(default_factory=list)
    honest: list[float] = field(default_factory=list)
    seconds: list[float] = field(default_factory=list)


def scanned(seed: int, spacing: float, occluded: bool) -> tuple[Scan, Scene, Truth, Any]:
    """A house, its cloud from two stations, and the truth; colour, rooms of others and photos left out."""
    things = {"trees": 3, "cars": 3, "people": 4} if occluded else {"trees": 0, "cars": 0, "people": 0}
    spec = SceneSpec.model_validate(
        {"seed": seed, "houses": 1, "opposite": False, "setting": "terrace", "lamps": 0, "hedges": False}
        | things
    )
    scanner = ScannerSpec.model_validate(
        {"stations": 2, "spacing": spacing, "field": 170, "lowest": -20, "highest": 60, "subrays": 7}
        | {"colour": False}
    )
    scene = street(spec)
    stations = scan_stations(scene, scanner, seed)
    angles = np.radians([scanner.field, scanner.lowest, scanner.highest])
    eyes = [Eye(s.true.t, scene.local_from_street.R[:, 1], *map(float, angles)) for s in stations]
    seen = visibility(scene, Tracer(scene.mesh), eyes, np.empty((0, 3)), [])
    empty: dict[str, Any] = {"stations": [], "photos": [], "points": [], "drive": None}
    truth = read_truth(scene_table(scene, seen, {}) | empty)
    owner = np.array([s.house for s in scene.surfaces])
    surface = np.concatenate([s.surface for s in stations])
    house = np.where(surface >= 0, owner[surface], -1)
    return merge_scans([s.scan for s in stations]), scene, truth, house


def facades_of(scan: Scan, house: Any, scene: Scene) -> list[Facade]:
    """The street facades, as a run would find them in the points of each house."""
    out: list[Facade] = []
    for number, plan in enumerate(scene.houses):
        index = np.flatnonzero(house == number)
        found = find_facades(scan, Building(plan.id, index, plan.ground_z))
        out += [f for f in found if isinstance(f, Facade)]
    return out


def claim(facade: Facade, opening: Opening) -> FoundOpening:
    """An opening as the scorer takes it."""
    ring = np.column_stack([opening.ring[:, 0], np.zeros(len(opening.ring)), opening.ring[:, 1]])
    sigma = np.sqrt(np.diag(opening.ring_covariance)).reshape(-1, 2)
    ends = [*opening.ring.argmin(0), *opening.ring.argmax(0)]
    errors = dict(
        zip(
            ("left", "bottom", "right", "top"),
            (float(sigma[e, k % 2]) for k, e in enumerate(ends)),
            strict=True,
        )
    )
    depth = opening.depth
    if depth is not None:
        errors["depth"] = float(depth.sigma[0])
    return FoundOpening(
        opening.id,
        opening.kind,
        facade.frame.apply(ring),
        None if depth is None else float(depth.value),
        opening.shape,
        sigma=errors,
    )


def openings_of(facades: Sequence[Facade], scan: Scan, method: str) -> tuple[list[FoundOpening], float]:
    """All openings of the facades, and the processor seconds per million facade points."""
    options = OpeningOptions.model_validate({"method": method})
    found: list[FoundOpening] = []
    start = time.process_time()
    for facade in facades:
        elements = find_openings(facade, scan, options)
        found += [claim(facade, o) for o in elements.openings] if elements else []
    points = sum(len(f.support) for f in facades)
    return found, (time.process_time() - start) / max(points, 1) * 1e6


def add(tally: Tally, truth: Truth, found: Sequence[FoundOpening], seconds: float) -> None:
    """One house's scores."""
    part = score_openings(truth, found)
    for level, counts in tally.counts.items():
        counts.append(tuple(np.sum([_counted(r, level) for r in part.items], axis=0, initial=0).tolist()))  # type: ignore[arg-type]
    good = [r for r in part.items if (r.get("iou") or 0) >= 0.5]
    tally.borders.append(np.array([list(r["borders_mm"].values()) for r in good]).reshape(-1, 4))
    tally.depths.append(np.array([r["depth_mm"] for r in good if "depth_mm" in r]))
    honest = part.figures["border_normalised"].value
    if honest is not None:
        tally.honest.append(honest)
    tally.seconds.append(seconds)


def _counted(row: Any, level: float) -> tuple[int, int, int]:
    """A true opening, or one found in excess: found and true, found but not true, missed."""
    if "id" not in row:
        return 0, 1, 0
    hit = (row.get("iou") or 0) >= level
    found = row.get("found") is not None
    if row["seen"] in ("visible", "partly"):
        return int(hit), int(found and not hit), int(not hit)
    return 0, int(found and row["iou"] < 0.25), 0


def f1(counts: Float) -> float:
    """Of counts (n, 3) of houses."""
    hit, wrong, missed = counts.sum(0)
    return float(2 * hit / max(2 * hit + wrong + missed, 1))


def rows_of(name: str, tally: Tally) -> list[str]:
    """One line of the table."""
    houses = np.arange(len(tally.seconds))

    def over(values: Sequence[Any], statistic: Any) -> str:
        joined = [v for v in values if len(v)]
        if not joined:
            return "-"
        pick = np.arange(len(joined))
        return figure(bootstrap(pick, lambda k: statistic(np.concatenate([joined[int(i)] for i in k]))))

    scores = [
        figure(bootstrap(houses, lambda k, c=counts: f1(np.array(c)[k.astype(int)])))
        for counts in tally.counts.values()
    ]
    return [
        name,
        *scores,
        over(tally.borders, lambda e: np.median(np.abs(e))),
        over(tally.borders, lambda e: np.median((e[:, 1] - e[:, 0]) / 2)),
        figure(bootstrap(tally.honest)) if tally.honest else "-",
        over(tally.depths, lambda e: np.median(np.abs(e))),
        figure(bootstrap(tally.seconds), digits=2),
    ]


HEADER = (
    "method",
    "F1 at 0.5",
    "F1 at 0.75",
    "border mm",
    "outward bias mm",
    "border error / sigma",
    "depth mm",
    "processor s per million points",
)


def simulated(seeds: int, spacings: Sequence[float], methods: Sequence[str]) -> None:
    for spacing, occluded in [*((s, False) for s in spacings), (OCCLUDED, True)]:
        tallies = {method: Tally() for method in methods}
        asked = 0
        for seed in range(seeds):
            scan, scene, truth, house = scanned(seed, spacing, occluded)
            facades = facades_of(scan, house, scene)
            for method, tally in tallies.items():
                add(tally, truth, *openings_of(facades, scan, method))
            asked += sum(next(iter(tallies.values())).counts[0.5][-1][::2])
        table(
            f"{seeds} houses, {100 * spacing:g} cm{', behind trees, cars and people' if occluded else ''}: "
            f"{asked} openings",
            HEADER,
            [rows_of(method, tally) for method, tally in tallies.items()],
        )


def real(methods: Sequence[str]) -> None:
    lines = []
    for name in REAL:
        truth = DATA / "truth" / f"{name}.json"
        if not truth.exists():
            print(f"{name}: shared data is absent, left out", file=sys.stderr)
            continue
        (scan,) = read_scans(ScanSource(path=str(DATA / name / "street_front.laz")))
        facades = [
            f
            for building in find_buildings(scan).buildings
            for f in find_facades(scan, building)
            if isinstance(f, Facade)
        ]
        for method in methods:
            found, seconds = openings_of(facades, scan, method)
            told = judged(found, scan, truth)
            numbers = [f"{told[f'f1@{level}']:.3f}" for level in (0.5, 0.75)]
            borders = [told.get("border_median_cm", "-"), told.get("border_p90_cm", "-")]
            lines.append(
                [name, method, *numbers, told["asked"], told["predicted"], *borders, f"{seconds:.2f}"]
            )
    if lines:
        scores = ("F1 at 0.5", "F1 at 0.75", "asked", "found", "border cm", "90 % cm")
        table("Annotated fronts", ["front", "method", *scores, HEADER[-1]], lines)


def judged(found: Sequence[FoundOpening], scan: Scan, truth: Path) -> dict[str, Any]:
    """The figures of the annotation's own scorer."""
    entries = [{"kind": o.kind, "outline_world": scan.world.to_world(o.ring).tolist()} for o in found]
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "facades" / "all" / "openings.json"
        path.parent.mkdir(parents=True)
        path.write_text(json.dumps({"openings": entries}))
        command = [sys.executable, str(truth.parent / "score_real.py"), folder, str(truth)]
        done = subprocess.run(command, capture_output=True, text=True, check=True)
    told: dict[str, Any] = json.loads(done.stdout)
    return told


def main() -> None:
    arguments = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    arguments.add_argument("--seeds", type=int, default=6)
    arguments.add_argument("--spacing", type=float, nargs="*", default=[0.02, 0.04, 0.08], metavar="METRES")
    arguments.add_argument("--methods", nargs="+", default=["paper", "evidence"])
    which = arguments.add_mutually_exclusive_group()
    which.add_argument("--simulated-only", action="store_true")
    which.add_argument("--real-only", action="store_true")
    given = arguments.parse_args()
    if not given.real_only:
        simulated(given.seeds, given.spacing, given.methods)
    if not given.simulated_only:
        real(given.methods)


if __name__ == "__main__":
    main()
