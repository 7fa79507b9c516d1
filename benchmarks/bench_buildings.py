"""Buildings along the street: F1, cut error, time; the paper's connected components beside ours.

    python benchmarks/bench_buildings.py [--streets 12] [--points 3 10 30]

`--points` repeats a simulated street until it has that many million points and times the stage alone.
"""

import argparse
import time

import numpy as np

from _common import bootstrap, figure, peak_memory, table
from frontage.buildings import BuildingOptions, BuildingSplit, find_buildings
from frontage.model import Scan
from scenes import FACADE, Scene, street_scene

HIT = 0.75  # IoU along the wall from which a house counts as found


def spans(split: BuildingSplit, scene: Scene) -> list[tuple[float, float]]:
    """Extent of every building's facade points along the street, 1 % quantiles."""
    s = scene.local_from_street.inverse.apply(scene.scan.xyz)[:, 0]
    own = [b.index[scene.label[b.index] == FACADE] for b in split.buildings]
    return [tuple(np.quantile(s[i], [0.01, 0.99])) for i in own if len(i) > 50]


def f1(found: list[tuple[float, float]], scene: Scene) -> float:
    hits = 0
    for h in scene.houses:
        iou = [(min(h.s1, b) - max(h.s0, a)) / (max(h.s1, b) - min(h.s0, a)) for a, b in found]
        hits += max(iou, default=0.0) >= HIT
    return 2 * hits / max(len(found) + len(scene.houses), 1)


def cut_errors(split: BuildingSplit, scene: Scene) -> list[float]:
    """Distance of every true party wall to the nearest cut, m; a wall without cut counts as half a house."""
    xy = np.array([c[0] for b in split.buildings for c in b.cuts]).reshape(-1, 2)
    s = scene.local_from_street.inverse.apply(np.column_stack([xy, np.zeros(len(xy))]))[:, 0]
    walls = sorted(h.s1 for h in scene.houses)[:-1]
    return [min(float(np.abs(s - w).min()) if len(s) else 3.0, 3.0) for w in walls]


def street(seed: int) -> Scene:
    """A terrace scanned as streets are: 3-6 cm apart, 0-8 % steep, thinning out sixfold along the row in
    every second one, up to 40 % of the wall in the shadow of trees in two of three."""
    scene = street_scene(
        seed=seed, houses=5, spacing=(0.03, 0.045, 0.06)[seed % 3], slope=(0.0, 0.02, 0.05, 0.08)[seed % 4]
    )
    rng = np.random.default_rng(seed)
    at = scene.local_from_street.inverse.apply(scene.scan.xyz)
    keep = rng.random(len(at)) < np.where(seed % 2, 6.0 ** -np.clip(at[:, 0] / scene.length, 0, 1), 1.0)
    share = (0.0, 0.2, 0.4)[(seed // 2) % 3]
    places = np.sort(rng.uniform(0, scene.length, 5)) if share else np.empty(0)
    for s in places:  # crowns, seen from the road: shadows 1.5 m above the ground and up
        half = share * scene.length / 10
        shadow = (np.abs(at[:, 0] - s) < half) & (at[:, 1] > -2.0) & (rng.random(len(at)) < 0.9)
        keep &= ~(shadow & (np.abs(at[:, 2] - scene.slope * s - 4.5) < 2.5))
    return Scene(
        scene.scan.take(keep), scene.houses, scene.label[keep], scene.house[keep], scene.local_from_street,
        scene.trees, scene.cars, scene.slope,
    )  # fmt: skip


def quality(streets: int) -> None:
    rows = []
    scenes = [street(100 + seed) for seed in range(streets)]
    for method in ("paper", "frontage"):
        scores, errors, times = [], [], []
        for scene in scenes:
            start = time.perf_counter()
            split = find_buildings(scene.scan, BuildingOptions(method=method))  # type: ignore[arg-type]
            times.append((time.perf_counter() - start) / len(scene.scan) * 1e6)
            scores.append(f1(spans(split, scene), scene))
            errors += cut_errors(split, scene)
        cells = [
            figure(bootstrap(scores, np.mean)),
            figure(bootstrap(errors), "m"),
            figure(bootstrap(times), "s"),
        ]
        rows.append([method, *cells])
    table(
        f"{streets} simulated terraces of 5 houses",
        ["method", "F1", "cut error (median)", "per 1 M points"],
        rows,
    )


def scaling(millions: list[int]) -> None:
    base = street_scene(seed=7, houses=5, spacing=0.02).scan
    length = float(np.ptp(base.xyz[:, :2], axis=0).max()) + 5.0
    rows = []
    for m in millions:
        copies = int(np.ceil(m * 1e6 / len(base)))
        xyz = np.concatenate([base.xyz + np.array([0.0, i * length * 2, 0.0]) for i in range(copies)])[
            : int(m * 1e6)
        ]
        scan = Scan("street", xyz, base.world)
        start = time.perf_counter()
        split = find_buildings(scan)
        rows.append(
            [
                f"{m} M",
                f"{time.perf_counter() - start:.1f} s",
                len(split.buildings),
                f"{peak_memory():.2f} GB",
            ]
        )
    table("Time of the stage", ["points", "time", "buildings", "peak memory, all included"], rows)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--streets", type=int, default=12)
    parser.add_argument("--points", type=int, nargs="*", default=[3], help="millions of points to time")
    args = parser.parse_args()
    quality(args.streets)
    scaling(args.points)


if __name__ == "__main__":
    main()
