"""Buildings along the street: F1, cut error, time; the paper's connected components beside ours.

    python benchmarks/bench_buildings.py [--streets 24] [--seed 2000]

Streets are drawn and scanned by `frontage.simulate`: terraces of unlike houses; rows of twins, which only a
map can part, with and without one; and wide houses with a risalit, an attic, a recess or an oriel, which
nothing may part. `bench_street.py` times whole streets.
"""

import argparse
import time
from dataclasses import replace

import numpy as np

from _common import bootstrap, figure, rate_interval, table
from frontage.buildings import BuildingOptions, BuildingSplit, find_buildings
from frontage.model import Footprint
from scanned_streets import ScannedStreet, terrace
from wide_houses import KINDS, wide_house

HIT = 0.75  # IoU along the wall from which a house counts as found


def along(scene: ScannedStreet, xyz: np.ndarray) -> np.ndarray:
    """Places (n,) along the street of points (n, 3) local, m."""
    return scene.scene.local_from_street.inverse.apply(xyz)[:, 0]


def true_spans(scene: ScannedStreet) -> list[tuple[float, float]]:
    """Extent of every house along the street."""
    return [scene.span(h) for h in range(len(scene.houses))]


def spans(split: BuildingSplit, scene: ScannedStreet) -> list[tuple[float, float]]:
    """Extent along the street of the points of every building that lie on a front, 1 % quantiles."""
    own = [b.index[scene.front[b.index]] for b in split.buildings]
    return [tuple(np.quantile(along(scene, scene.scan.xyz[i]), [0.01, 0.99])) for i in own if len(i) > 50]


def f1(found: list[tuple[float, float]], scene: ScannedStreet) -> float:
    """F1 of the houses; each counts as found by a building that shares `HIT` of their common extent."""
    hits = 0
    for s0, s1 in true_spans(scene):
        iou = [(min(s1, b) - max(s0, a)) / (max(s1, b) - min(s0, a)) for a, b in found]
        hits += max(iou, default=0.0) >= HIT
    return 2 * hits / max(len(found) + len(scene.houses), 1)


def cut_errors(split: BuildingSplit, scene: ScannedStreet) -> list[float]:
    """Distance of every true party wall to the nearest cut, m; a wall without cut counts as half a house."""
    xy = np.array([c[0] for b in split.buildings for c in b.cuts]).reshape(-1, 2)
    s = along(scene, np.column_stack([xy, np.zeros(len(xy))]))
    walls = sorted(s1 for _, s1 in true_spans(scene))[:-1]
    return [min(float(np.abs(s - w).min()) if len(s) else 3.0, 3.0) for w in walls]


def street(seed: int) -> ScannedStreet:
    """A terrace scanned as streets are: 3-6 cm apart, 0-8 % steep, thinning out sixfold along the row in
    every second one, up to 40 % of the wall in the shadow of trees in two of three."""
    scene = terrace(
        seed, houses=5, spacing=(0.03, 0.045, 0.06)[seed % 3], slope=(0.0, 2.0, 5.0, 8.0)[seed % 4]
    )
    rng = np.random.default_rng(seed)
    at = scene.scene.local_from_street.inverse.apply(scene.scan.xyz)
    length = max(s1 for _, s1 in true_spans(scene))
    keep = rng.random(len(at)) < np.where(seed % 2, 6.0 ** -np.clip(at[:, 0] / length, 0, 1), 1.0)
    share = (0.0, 0.2, 0.4)[(seed // 2) % 3]
    places = np.sort(rng.uniform(0, length, 5)) if share else np.empty(0)
    slope = (0.0, 0.02, 0.05, 0.08)[seed % 4]
    for s in places:  # crowns, seen from the road: shadows 1.5 m above the ground and up
        half = share * length / 10
        shadow = (np.abs(at[:, 0] - s) < half) & (at[:, 1] > -2.0) & (rng.random(len(at)) < 0.9)
        keep &= ~(shadow & (np.abs(at[:, 2] - slope * s - 4.5) < 2.5))
    return replace(
        scene, scan=scene.scan.take(keep), part=scene.part[keep], house=scene.house[keep],
        front=scene.front[keep],
    )  # fmt: skip


def twins(seed: int) -> ScannedStreet:
    """A row of four houses built alike: nothing in the cloud tells them apart."""
    return terrace(seed, houses=4, spacing=0.05, twins=True)


def map_of(scene: ScannedStreet, seed: int) -> list[Footprint]:
    """The houses as a map: off by up to 0.45 m along and across the street, 3 cm per corner."""
    rng = np.random.default_rng(seed)
    shift = scene.scene.local_from_street.rotate(np.array([[*rng.uniform(-0.45, 0.45, 2), 0.0]]))[0, :2]
    rings = [h.footprint + shift + rng.normal(0, 0.03, h.footprint.shape) for h in scene.houses]
    return [Footprint(h.id, ring) for h, ring in zip(scene.houses, rings, strict=True)]


def row(scenes: list[ScannedStreet], method: str, maps: list[list[Footprint]] | None = None) -> list[str]:
    """F1, cut error and time of a method over streets, as cells."""
    scores, errors, times = [], [], []
    options = BuildingOptions(method="paper") if method == "paper" else BuildingOptions()
    for i, scene in enumerate(scenes):
        start = time.process_time()
        split = find_buildings(scene.scan, options, maps[i] if maps else ())
        times.append((time.process_time() - start) / len(scene.scan) * 1e6)
        scores.append(f1(spans(split, scene), scene))
        errors.append(float(np.median(cut_errors(split, scene))))
    return [
        figure(bootstrap(scores, np.mean)), figure(bootstrap(errors), "m"), figure(bootstrap(times), "s"),
    ]  # fmt: skip


def quality(streets: int, seed: int) -> None:
    scenes = [street(seed + i) for i in range(streets)]
    rows = [["terraces", method, *row(scenes, method)] for method in ("paper", "frontage")]
    alike = [twins(seed + i) for i in range(max(4, streets // 4))]
    maps = [map_of(scene, seed + i) for i, scene in enumerate(alike)]
    rows.append(["twins, undecidable", "frontage", *row(alike, "frontage")])
    rows.append(["twins with a map", "frontage", *row(alike, "frontage", maps)])
    header = ["streets", "method", "F1", "cut error, median of a street", "processor time per 1 M points"]
    table(f"{streets} simulated terraces of 5 houses, {len(alike)} rows of 4 twins", header, rows)


def wide_houses(count: int, seed: int) -> None:
    """One house with an uneven front must stay one."""
    rows = []
    for kind in KINDS:
        scenes = [wide_house(kind, seed + i, spacing=(0.03, 0.045, 0.06)[i % 3]) for i in range(count)]
        whole = sum(len(find_buildings(scene.scan).buildings) == 1 for scene in scenes)
        rows.append([kind, figure(rate_interval(whole, count))])
    table(f"{count} wide houses of each kind", ["front", "left whole"], rows)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--streets", type=int, default=24)
    parser.add_argument("--seed", type=int, default=2000, help="of the first street")
    args = parser.parse_args()
    quality(args.streets, args.seed)
    wide_houses(max(4, args.streets // 4), args.seed)


if __name__ == "__main__":
    main()
