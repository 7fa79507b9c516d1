"""Openings found by our method and by the published one on the same simulated and real facades.

    python benchmarks/bench_openings.py [--facades 200] [--first 0] [--workers 1] [--methods paper evidence]
                                        [--spacing 0.08] [--simulated-only | --real-only]

Simulated: every number draws a house, and a case of the mix: 1, 2 or 4 cm between beams 10 m away, one to
three stations, a third of the houses behind trees, cars and people; `--spacing` scans the same houses at
another spacing. Its facades are found from the points, as in a run. Openings of which the stations saw at
least half must be found, closed shutters left out; less visible ones may be found but cannot be missed. F1
at two IoU, border errors by spacing with their biases, depth; root mean square of the errors over their
standard errors (1 = honest); how many of the inferred openings are right, and of the kinds. Intervals: 95
%, bootstrap over houses.

Real: the two annotated fronts of the shared data and the registered scans of `ingolstadt_scene`, through
buildings and facades, by their own scorers; skipped where they are absent. (The coarse scan there has to be
registered first: `frontage run`.)
"""

import argparse
import sys
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from _common import bootstrap, figure, table
from _houses import Case, case_of, facades_of, openings_of, scanned
from _realfronts import COST, LEVELS, real
from frontage.evaluation.openings import score_openings
from frontage.evaluation.result import FoundOpening
from frontage.evaluation.truth import Truth, best_share
from frontage.geometry.arrays import Float

HALF = 0.5  # share of an opening that a station must have seen for it to be asked for
BORDERS = ("left", "right", "bottom", "top")
DETECTION = (
    *("method", "F1 at 0.5", "F1 at 0.75", "true", "false", "missed", "kind right"),
    *("inferred right", "inferred", "facades failed", COST),
)
MEASURED = ("spacing", "method", "border", "90 %", *BORDERS, "error / sigma", "depth bias", "depth error")


@dataclass
class Score:
    """The result of a method on one house."""

    spacing: float
    counts: dict[float, list[int]]  # by IoU: found and true, found but not true, missed
    borders: Float  # (n, 4) mm, left, right, bottom, top
    ratios: list[float]  # border errors over their sigmas
    depths: list[float]  # mm
    kinds: list[bool]
    inferred: list[bool]
    seconds: float  # per million points
    failed: int


def scored(number: int, methods: Sequence[str], spacing: float | None = None) -> dict[str, Score]:
    """The methods' scores on the house of a number, scanned at its own or another spacing m."""
    case = case_of(number, spacing)
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
    """Count a true opening, or one found in excess: found and true, found but not true, missed."""
    if "id" not in row:
        return 0, 1, 0
    opening = true[row["id"]]
    hit = (row.get("iou") or 0) >= level
    found = row.get("found") is not None
    if opening.shutters != "closed" and best_share(opening.visible) >= HALF:
        return int(hit), int(found and not hit), int(not hit)
    return 0, int(found and row["iou"] < 0.25), 0


def f1(counts: Float) -> float:
    """Return F1 of the counts (n, 3) of houses."""
    hit, wrong, missed = counts.sum(0)
    return float(2 * hit / max(2 * hit + wrong + missed, 1))


def f1_over(counts: Float) -> str:
    """Return F1 of counts (n, 3) with its interval over their rows."""
    pick = np.arange(len(counts))
    return figure(bootstrap(pick, lambda k: f1(counts[k.astype(int)])), digits=3)


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


def simulated(
    numbers: Sequence[int], methods: Sequence[str], workers: int, spacing: float | None = None
) -> None:
    """The tables of the simulated houses."""
    results: list[dict[str, Score]] = []
    one = partial(scored, methods=tuple(methods), spacing=spacing)
    with ProcessPoolExecutor(workers) as pool:
        for done, result in enumerate(pool.map(one, numbers), 1):
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


def main() -> None:
    arguments = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    arguments.add_argument("--facades", type=int, default=200, help="houses to draw")
    arguments.add_argument("--first", type=int, default=0, help="number of the first house")
    arguments.add_argument("--workers", type=int, default=1, help="processes")
    arguments.add_argument("--methods", nargs="+", default=["paper", "evidence"])
    arguments.add_argument("--spacing", type=float, help="m between beams 10 m away, in place of the mix's")
    which = arguments.add_mutually_exclusive_group()
    which.add_argument("--simulated-only", action="store_true")
    which.add_argument("--real-only", action="store_true")
    given = arguments.parse_args()
    if not given.real_only:
        numbers = range(given.first, given.first + given.facades)
        simulated(numbers, given.methods, given.workers, given.spacing)
    if not given.simulated_only:
        real(given.methods)


if __name__ == "__main__":
    main()
