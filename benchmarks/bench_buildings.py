"""Buildings along the street: F1, cut error, time; the paper's connected components beside ours.

    python benchmarks/bench_buildings.py [--streets 24] [--seed 2000]

Terraces of unlike houses; rows of twins, which only a map can separate, with and without one; and wide
houses with an avant-corps, an attic, a recess or an oriel, which must stay whole. `bench_street.py` times
whole streets.
"""

import argparse
import time

import numpy as np

from _common import bootstrap, figure, rate_interval, table
from frontage.buildings import BuildingOptions, BuildingSplit, find_buildings
from frontage.model import Footprint
from one_house import KINDS, one_house
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
    """Simulate a terrace scanned as streets are: 3-6 cm apart, 0-8 % steep, sixfold thinning along the row in
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


def twins(seed: int) -> Scene:
    """Simulate four houses that differ only in the noise of their colours, so that no cue separates them."""
    return street_scene(seed=seed, houses=4, spacing=0.05, twins=True)


def map_of(scene: Scene, seed: int) -> list[Footprint]:
    """Return the houses as a map that is off by up to 0.45 m along and across the street, 3 cm per corner."""
    rng = np.random.default_rng(seed)
    shift, maps = rng.uniform(-0.45, 0.45, 2), []
    for h in scene.houses:
        ring = np.array([[h.s0, h.offset], [h.s1, h.offset], [h.s1, h.offset + 10], [h.s0, h.offset + 10]])
        ring = np.column_stack([ring + shift + rng.normal(0, 0.03, ring.shape), np.zeros(4)])
        maps.append(Footprint(h.id, scene.local_from_street.apply(ring)[:, :2]))
    return maps


def row(scenes: list[Scene], method: str, maps: list[list[Footprint]] | None = None) -> list[str]:
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
    """Count how often one house with an uneven facade stays whole."""
    rows = []
    for kind in KINDS:
        scenes = [one_house(kind, seed + i, spacing=(0.03, 0.045, 0.06)[i % 3]) for i in range(count)]
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
