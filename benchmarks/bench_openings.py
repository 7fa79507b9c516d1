"""Openings: ours beside the published method, on the same facades, simulated and real.

    python benchmarks/bench_openings.py [--facades 200] [--first 0] [--workers 1] [--methods paper evidence]
                                        [--simulated-only | --real-only]

Simulated: every number draws a house, and a case of the mix: 1, 2 or 4 cm between beams 10 m away, one to
three stations, a third of the houses behind trees, cars and people. Its facades are found from the points, as
in a run. Asked for are openings of which the stations saw at least half, closed shutters left out; what was
less visible may be found, not missed. F1 at two IoU, border errors by spacing with their biases, depth; root
mean square of the errors over their standard errors (1 = honest); how many of the inferred openings are
right, and of the kinds. Intervals: 95 %, bootstrap over houses.

Real: the two annotated fronts of the shared data and the registered scans of `ingolstadt_scene`, through
buildings and facades, by their own scorers; skipped where they are absent. (The coarse scan there has to be
registered first: `frontage run`.)
"""

import argparse
import importlib.util
import json
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from _common import DATA, bootstrap, figure, table
from frontage.buildings import find_buildings
from frontage.evaluation.openings import score_openings
from frontage.evaluation.result import FoundOpening
from frontage.evaluation.truth import Truth, best_share, read_truth
from frontage.facades import find_facades
from frontage.geometry.arrays import Float
from frontage.io.scans import ScanSource, read_scans
from frontage.model import Building, Facade, Opening, Provenance, Scan
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
SCENE = ("registered/scan_2cm.e57", "registered/scan_4cm.laz", "mobile/mobile.laz")
LEVELS = (0.5, 0.75)
HALF = 0.5  # share of an opening that a station must have seen for it to be asked for
BORDERS = ("left", "right", "bottom", "top")


@dataclass(frozen=True)
class Case:
    """A house and how it is scanned."""

    seed: int
    spacing: float
    stations: int
    occluded: bool


@dataclass
class Score:
    """What a method did on one house."""

    spacing: float
    counts: dict[float, list[int]]  # by IoU: found and true, found but not true, missed
    borders: Float  # (n, 4) mm, left, right, bottom, top
    ratios: list[float]  # border errors over their sigmas
    depths: list[float]  # mm
    kinds: list[bool]
    inferred: list[bool]
    seconds: float  # per million points
    failed: int


def case_of(number: int) -> Case:
    """The case of a number: 1, 2, 4 cm; one to three stations; every third pair behind things."""
    spacing = (0.02, 0.04, 0.01, 0.02, 0.04)[number % 5]
    stations = 1 + (number // 5) % 2 if spacing == 0.01 else (2, 1, 1, 3, 2)[number % 5]
    return Case(number, spacing, stations, (number // 2) % 3 == 1)


def scanned(case: Case) -> tuple[Scan, Scene, Truth, Any]:
    """A house: its cloud, scene, truth, and the house of every point; colour and photos are left out."""
    things = (2, 3, 4) if case.occluded else (0, 0, 0)
    spec = SceneSpec.model_validate(
        {"seed": case.seed, "houses": 1, "opposite": False, "setting": "terrace", "lamps": 0, "hedges": False}
        | dict(zip(("trees", "cars", "people"), things, strict=True))
    )
    scanner = ScannerSpec.model_validate(
        {"stations": case.stations, "spacing": case.spacing, "field": 170, "lowest": -20, "highest": 60}
        | {"subrays": 7, "colour": False}
    )
    scene = street(spec)
    stations = scan_stations(scene, scanner, case.seed)
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


def openings_of(
    facades: Sequence[tuple[Facade, float]], scan: Scan, method: str
) -> tuple[list[FoundOpening], list[str], int, float]:
    """All openings of the facades with their grounds' heights, the ids of the inferred ones, the number of
    facades that failed, and the processor seconds per million facade points.
    """
    found: list[FoundOpening] = []
    inferred: list[str] = []
    failed = 0
    start = time.process_time()
    for facade, ground in facades:
        foot = facade.frame.inverse.apply(np.array([[*facade.frame.t[:2], ground]]))
        options = OpeningOptions.model_validate({"method": method, "ground_z": float(foot[0, 2])})
        elements = find_openings(facade, scan, options)
        failed += not elements
        own = elements.openings if elements else ()
        found += [claim(facade, o) for o in own]
        inferred += [o.id for o in own if o.provenance is Provenance.INFERRED]
    points = sum(len(f.support) for f, _ in facades)
    return found, inferred, failed, (time.process_time() - start) / max(points, 1) * 1e6


def scored(number: int, methods: Sequence[str]) -> dict[str, Score]:
    """The methods' scores on the house of a number."""
    case = case_of(number)
    scan, scene, truth, house = scanned(case)
    ground = {plan.id: plan.ground_z for plan in scene.houses}
    facades = [(f, ground[f.building]) for f in facades_of(scan, house, scene)]
    return {method: score(case, truth, *openings_of(facades, scan, method)) for method in methods}


def score(
    case: Case,
    truth: Truth,
    found: Sequence[FoundOpening],
    inferred: Sequence[str],
    failed: int,
    seconds: float,
) -> Score:
    """One house's score."""
    rows = score_openings(truth, found).items
    true = {o.id: o for f in truth.facades for o in f.openings}
    told = {o.id: o for o in found}
    counts = {v: np.sum([_counts(r, v, true) for r in rows], axis=0, initial=0).tolist() for v in LEVELS}
    good = [r for r in rows if (r.get("iou") or 0) >= LEVELS[0]]
    errors = np.array([[r["borders_mm"][b] for b in BORDERS] for r in good]).reshape(-1, 4)
    sigma = [[told[r["found"]].sigma.get(b, 0.0) for b in BORDERS] for r in good]
    ratios = [e / (1000 * s) for e, s in zip(errors.ravel(), np.ravel(sigma), strict=True) if s > 0]
    right = {r["found"] for r in good}
    return Score(
        case.spacing,
        counts,
        errors,
        ratios,
        [r["depth_mm"] for r in good if "depth_mm" in r],
        [told[r["found"]].kind == true[r["id"]].kind for r in good],
        [k in right for k in inferred],
        seconds,
        failed,
    )


def _counts(row: Any, level: float, true: Any) -> tuple[int, int, int]:
    """A true opening, or one found in excess: found and true, found but not true, missed."""
    if "id" not in row:
        return 0, 1, 0
    opening = true[row["id"]]
    hit = (row.get("iou") or 0) >= level
    found = row.get("found") is not None
    if opening.shutters != "closed" and best_share(opening.visible) >= HALF:
        return int(hit), int(found and not hit), int(not hit)
    return 0, int(found and row["iou"] < 0.25), 0


def f1(counts: Float) -> float:
    """Of counts (n, 3) of houses."""
    hit, wrong, missed = counts.sum(0)
    return float(2 * hit / max(2 * hit + wrong + missed, 1))


def over(scores: Sequence[Score], values: Any, statistic: Any) -> str:
    """A statistic of the values of all houses, with its interval over houses."""
    joined = [v for v in map(values, scores) if len(v)]
    if not joined:
        return "-"
    pick = np.arange(len(joined))
    both = bootstrap(pick, lambda k: statistic(np.concatenate([joined[int(i)] for i in k])))
    return figure(both)


def _f1_of(scores: Sequence[Score], level: float) -> str:
    counts = np.array([s.counts[level] for s in scores])
    return figure(bootstrap(np.arange(len(counts)), lambda k: f1(counts[k.astype(int)])), digits=3)


def _rms(v: Float) -> float:
    return float(np.sqrt(np.mean(np.square(v))))


def simulated(numbers: Sequence[int], methods: Sequence[str], workers: int) -> None:
    """The tables of the simulated houses."""
    results: list[dict[str, Score]] = []
    with ProcessPoolExecutor(workers) as pool:
        for done, result in enumerate(pool.map(partial(scored, methods=tuple(methods)), numbers), 1):
            results.append(result)
            print(f"{done} of {len(numbers)} houses", file=sys.stderr)
    by_method = {m: [r[m] for r in results] for m in methods}
    first = by_method[methods[0]]
    asked = sum(s.counts[LEVELS[0]][0] + s.counts[LEVELS[0]][2] for s in first)
    detection = []
    for method, scores in by_method.items():
        wrong = np.sum([s.counts[LEVELS[0]] for s in scores], axis=0)
        shares = [
            over(scores, lambda s: s.kinds, np.mean),
            over(scores, lambda s: s.inferred, np.mean),
        ]
        sums = [sum(len(s.inferred) for s in scores), sum(s.failed for s in scores)]
        levels = [_f1_of(scores, level) for level in LEVELS]
        cost = over(scores, lambda s: [s.seconds], np.median)
        detection.append([method, *levels, *map(int, wrong), *shares, *sums, cost])
    table(f"{len(results)} houses, {asked} openings at least half visible", DETECTION, detection)
    measured = []
    for spacing in sorted({s.spacing for s in first}):
        for method, scores in by_method.items():
            own = [s for s in scores if s.spacing == spacing]
            figures = [
                over(own, lambda s: np.abs(s.borders).ravel(), np.median),
                over(own, lambda s: np.abs(s.borders).ravel(), lambda v: np.quantile(v, 0.9)),
                *(over(own, lambda s, k=k: s.borders[:, k], np.median) for k in range(4)),
                over(own, lambda s: s.ratios, _rms),
                over(own, lambda s: s.depths, np.median),
                over(own, lambda s: np.abs(s.depths), np.median),
            ]
            measured.append([f"{100 * spacing:g} cm", method, *figures])
    table("Borders and depth, mm", MEASURED, measured)


COST = "processor s per million points"
DETECTION = (
    *("method", "F1 at 0.5", "F1 at 0.75", "true", "false", "missed", "kind right"),
    *("inferred right", "inferred", "facades failed", COST),
)
MEASURED = ("spacing", "method", "border", "90 %", *BORDERS, "error / sigma", "depth bias", "depth error")


def fronts(scan: Scan) -> list[tuple[Facade, float]]:
    """The facades of a real scan with the heights of the ground, as a run finds them."""
    return [
        (f, building.ground_z)
        for building in find_buildings(scan).buildings
        for f in find_facades(scan, building)
        if isinstance(f, Facade)
    ]


def real(methods: Sequence[str]) -> None:
    """The tables of the annotated fronts and of the complete scene."""
    lines = []
    for name in REAL:
        truth = DATA / "truth" / f"{name}.json"
        if not truth.exists():
            print(f"{name}: shared data is absent, left out", file=sys.stderr)
            continue
        (scan,) = read_scans(ScanSource(path=str(DATA / name / "street_front.laz")))
        facades = fronts(scan)
        for method in methods:
            found, _, _, seconds = openings_of(facades, scan, method)
            told = judged(found, scan, truth)
            numbers = [f"{told[f'f1@{level}']:.3f}" for level in LEVELS]
            borders = [told.get("border_median_cm", "-"), told.get("border_p90_cm", "-")]
            lines.append(
                [name, method, *numbers, told["asked"], told["predicted"], *borders, f"{seconds:.1f}"]
            )
    lines += scene(methods)
    if lines:
        table("Real fronts, and the scene of real buildings", REALITY, lines)


REALITY = ("front", "method", "F1 at 0.5", "F1 at 0.75", "asked", "found", "border cm", "90 % cm", COST)


def scene(methods: Sequence[str]) -> list[list[Any]]:
    """Lines of the registered scans of `ingolstadt_scene`, by its scorer."""
    folder = DATA / "ingolstadt_scene"
    if not folder.exists():
        print("ingolstadt_scene: shared data is absent, left out", file=sys.stderr)
        return []
    spec = importlib.util.spec_from_file_location("score_scene", folder / "score_scene.py")
    assert spec is not None and spec.loader is not None
    scorer: Any = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(scorer)
    truth = scorer.load_truth(folder / "truth" / "truth.json")
    lines = []
    for name in SCENE:
        path = folder / "input" / name
        trajectory = path.with_name("trajectory.csv") if name.startswith("mobile") else None
        source = {"path": str(path)} | ({"trajectory": str(trajectory)} if trajectory else {})
        scan = merge_scans(read_scans(ScanSource.model_validate(source)))
        facades = fronts(scan)
        visible = "visible_mobile" if trajectory else "visible_tls"
        for method in methods:
            found, _, _, seconds = openings_of(facades, scan, method)
            doors = ("door", "garage", "passage")
            claims = [
                {"kind": "Door" if o.kind in doors else "Window", "polygons": [scan.world.to_world(o.ring)]}
                | {"building": None, **({} if o.depth is None else {"depth": o.depth})}
                for o in found
            ]
            told = scorer.score_openings(claims, truth, visible)
            numbers = [f"{told[f'f1@{level}']:.3f}" for level in LEVELS]
            borders = [told["border_median_cm"], told["border_p90_cm"]]
            lines.append(
                [name, method, *numbers, told["n_truth"], told["n_pred"], *borders, f"{seconds:.1f}"]
            )
    return lines


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
    arguments.add_argument("--facades", type=int, default=200, help="houses to draw")
    arguments.add_argument("--first", type=int, default=0, help="number of the first house")
    arguments.add_argument("--workers", type=int, default=1, help="processes")
    arguments.add_argument("--methods", nargs="+", default=["paper", "evidence"])
    which = arguments.add_mutually_exclusive_group()
    which.add_argument("--simulated-only", action="store_true")
    which.add_argument("--real-only", action="store_true")
    given = arguments.parse_args()
    if not given.real_only:
        simulated(range(given.first, given.first + given.facades), given.methods, given.workers)
    if not given.simulated_only:
        real(given.methods)


if __name__ == "__main__":
    main()
