"""Does the result depend on what must not matter? Real scans, changed, against the result of the whole cloud.

    python benchmarks/bench_stability.py [--scans brooklyn_row ...] [--changes shuffle turn ...] [--part 1]

Needs no truth: facades and openings found in the changed cloud are compared with those found in the cloud as
it is. `--part 4` takes every fourth point first, for a quick look. Changes:

    shuffle           another order of the points
    turn              37 degrees about the vertical
    mirror            left and right swapped
    half quarter eighth  of the points, drawn at random
    crop              20 % of the length cut off; only what is left is compared
    noise             3 mm on every coordinate
    colour            neither colour nor intensity
    sensors           no sensor positions, where there were any

A facade is the same when the outlines cover one another with an IoU of 0.5 or more and the planes lie within
0.5 m and 5 degrees. Openings are matched one to one at an IoU of 0.5. Where the scan has a truth, F1
against it is told as well. `whole` is the unchanged cloud against its truth.
"""

import argparse
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import shapely
from scipy.optimize import linear_sum_assignment

from _changes import (
    Changed,
    colourless,
    cropped,
    mirrored,
    noisy,
    shuffled,
    sightless,
    thinned,
    turned,
)
from _common import DATA, table
from _houses import openings_of
from _realfronts import FRONTS, fronts, judged_rings, read_front, read_truth
from frontage.evaluation.result import FoundOpening
from frontage.geometry.arrays import Float
from frontage.model import Facade, Scan

CHANGES: dict[str, Callable[[Scan], Changed]] = {
    "shuffle": shuffled,
    "turn": turned,
    "mirror": mirrored,
    "half": lambda scan: thinned(scan, 2),
    "quarter": lambda scan: thinned(scan, 4),
    "eighth": lambda scan: thinned(scan, 8),
    "noise": noisy,
    "colour": colourless,
    "sensors": sightless,
}
ALL = ("whole", *CHANGES, "crop")
HEADER = (
    *("scan", "change", "facades", "same", "offset mm", "turn deg", "outline IoU"),
    *("openings", "F1", "shift mm", "largest mm", "90 % in sigmas", "F1 truth 0.5 / 0.75", "s"),
)
SAME_IOU, SAME_M, SAME_COS = 0.5, 0.5, np.cos(np.radians(5.0))
SIDES = ("left", "bottom", "right", "top")


@dataclass(frozen=True, eq=False)
class Result:
    """What was found in a cloud, in the frame of the cloud before its change."""

    facades: list[tuple[Float, Float, Float]]  # outline (k, 3) m, barycentre (3,) m, normal (3,)
    openings: list[tuple[Float, Float]]  # ring (k, 3) m, sigmas (4,) m of its sides
    truth: str
    seconds: float


def result(scan: Scan, back: Callable[[Float], Float], truths: Sequence[str]) -> tuple[Result, list[Any]]:
    """Find facades and openings of a cloud."""
    start = time.perf_counter()
    found = fronts(scan)
    openings, _, _, _ = openings_of(found, scan, "evidence")
    seconds = time.perf_counter() - start
    rings = [(back(o.ring), _sigmas(o)) for o in openings]
    told = []
    for truth in truths:
        score = judged_rings(
            [(o.kind, ring) for o, (ring, _) in zip(openings, rings, strict=True)], scan, read_truth(truth)
        )
        told.append(f"{score['f1@0.5']:.2f} / {score['f1@0.75']:.2f}")
    facades = [_surface(facade, back) for facade, _ in found]
    return Result(facades, rings, ", ".join(told), seconds), found


def _sigmas(opening: FoundOpening) -> Float:
    return np.array([opening.sigma[side] for side in SIDES])


def _surface(facade: Facade, back: Callable[[Float], Float]) -> tuple[Float, Float, Float]:
    flat = np.column_stack([facade.outline[:, 0], np.zeros(len(facade.outline)), facade.outline[:, 1]])
    centre, tip = back(np.array([facade.frame.t, facade.frame.t + facade.frame.R[:, 1]]))
    return back(facade.frame.apply(flat)), centre, tip - centre


def _plane(ring: Float, normal: Float) -> tuple[Float, Float]:
    """Horizontal axes (2, 3) in a plane with a unit normal, and the ring in it."""
    across = np.array([-normal[1], normal[0], 0.0]) / np.hypot(*normal[:2])
    axes = np.array([across, [0.0, 0.0, 1.0]])
    return axes, ring @ axes.T


def _polygon(ring: Float) -> Any:
    return shapely.make_valid(shapely.Polygon(ring))


def _iou(a: Any, b: Any) -> float:
    shared = a.intersection(b).area
    return float(shared / (a.area + b.area - shared)) if shared else 0.0


def _overlap(ring: Float, other: Float) -> tuple[float, float, Float]:
    """IoU of two rings in the plane of the first, the share of the second that both have, and shifts.

    Shifts (4,) m are those of the sides of the box around the second ring. Rings that are far apart have
    nothing in common.
    """
    if np.abs(other.mean(0) - ring.mean(0)).max() >= 3.0:
        return 0.0, 0.0, np.zeros(4)
    normal = np.cross(ring[1] - ring[0], ring[2] - ring[1])
    axes, flat = _plane(ring, normal / np.linalg.norm(normal))
    seen = other @ axes.T
    a, b = _polygon(flat), _polygon(seen)
    shift = np.r_[seen.min(0), seen.max(0)] - np.r_[flat.min(0), flat.max(0)]
    return _iou(a, b), float(a.intersection(b).area / max(b.area, 1e-9)), shift


def facade_figures(own: Result, reference: Result) -> list[str]:
    """How many facades of the reference there are again, and how far their planes and outlines moved."""
    offsets, turns, ious = [], [], []
    for ring, centre, normal in reference.facades:
        axes, flat = _plane(ring, normal)
        best = (0.0, 0.0, 0.0)
        for other, place, towards in own.facades:
            apart, cos = float((place - centre) @ towards), abs(float(normal @ towards))
            if abs(apart) < SAME_M and cos > SAME_COS:
                best = max(best, (_iou(_polygon(flat), _polygon(other @ axes.T)), abs(apart), cos))
        if best[0] >= SAME_IOU:
            ious.append(best[0])
            offsets.append(best[1])
            turns.append(np.degrees(np.arccos(min(best[2], 1.0))))
    told = f"{len(ious)} of {len(reference.facades)}"
    if not ious:
        return [str(len(own.facades)), told, "-", "-", "-"]
    median = [1e3 * float(np.median(offsets)), float(np.median(turns)), float(np.median(ious))]
    return [str(len(own.facades)), told, f"{median[0]:.1f}", f"{median[1]:.3f}", f"{median[2]:.3f}"]


def opening_figures(own: Result, reference: Result, kept: Callable[[Float], bool]) -> list[str]:
    """F1 of the openings against those of the reference, and how far the borders of the same ones moved.

    An opening that a crop cuts is not asked for, nor is what is found in its place.
    """
    asked = [o for o in reference.openings if kept(o[0])]
    cut = [o for o in reference.openings if not kept(o[0])]
    found = [o for o in own.openings if kept(o[0])]
    found = [o for o in found if all(_overlap(ring, o[0])[1] < SAME_IOU for ring, _ in cut)]
    overlap = np.zeros((len(asked), len(found)))
    shifts = np.zeros((len(asked), len(found), 4))
    for i, (ring, _) in enumerate(asked):
        for j, (other, _) in enumerate(found):
            overlap[i, j], _, shifts[i, j] = _overlap(ring, other)
    rows, columns = linear_sum_assignment(-overlap)
    good = overlap[rows, columns] >= SAME_IOU
    rows, columns = rows[good], columns[good]
    f1 = 2 * len(rows) / max(len(asked) + len(found), 1)
    told = [f"{len(found)} of {len(asked)}", f"{f1:.3f}"]
    if not len(rows):
        return [*told, "-", "-", "-"]
    moved = np.abs(shifts[rows, columns])
    sigma = np.array([np.hypot(asked[i][1], found[j][1]) for i, j in zip(rows, columns, strict=True)])
    return [
        *told,
        f"{1e3 * np.median(moved):.1f}",
        f"{1e3 * moved.max():.0f}",
        f"{np.quantile(moved / np.maximum(sigma, 1e-9), 0.9):.2f}",
    ]


def street_of(found: list[Any]) -> tuple[Float, tuple[float, float]]:
    """Direction of the largest facade and where it begins and ends along it."""
    facade = max((f for f, _ in found), key=lambda f: shapely.Polygon(f.outline).area)
    along = facade.frame.R[:, 0]
    place = float(facade.frame.t @ along)
    return along, (place + float(facade.outline[:, 0].min()), place + float(facade.outline[:, 0].max()))


def examine(name: str, changes: Sequence[str], part: int) -> None:
    """Print the table of one scan, line by line as it is found."""
    front = FRONTS[name]
    scan = read_front(front)
    if part > 1:
        scan = thinned(scan, part, seed=0).scan
    reference, found = result(scan, lambda p: p, front.truths)
    lines = [[name, "whole", str(len(reference.facades)), "", "", "", "", str(len(reference.openings)), ""]]
    lines[0] += ["", "", "", reference.truth, f"{reference.seconds:.0f}"]
    for change in changes:
        if change == "whole" or (change == "sensors" and not scan.has_origins):
            continue
        if change == "crop":
            if not found:
                continue
            changed = cropped(scan, *street_of(found))
        else:
            changed = CHANGES[change](scan)
        own, _ = result(changed.scan, changed.back, front.truths if change != "crop" else ())
        figures = facade_figures(own, reference) + opening_figures(own, reference, changed.kept)
        lines.append([name, change, *figures, own.truth, f"{own.seconds:.0f}"])
    table(name, HEADER, lines)


def main() -> None:
    """Examine the scans one after another."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--scans", nargs="+", choices=sorted(FRONTS), default=sorted(FRONTS))
    parser.add_argument("--changes", nargs="+", choices=ALL, default=ALL)
    parser.add_argument("--part", type=int, default=1, help="take one point in so many first")
    args = parser.parse_args()
    for name in args.scans:
        if not (DATA / FRONTS[name].path).exists():
            print(f"{name}: shared data is absent and left out")
            continue
        examine(name, args.changes, args.part)


if __name__ == "__main__":
    main()
