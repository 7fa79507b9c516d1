"""Openings of real facades whose points somebody else labelled: ours and the paper's method.

    python benchmarks/bench_labelled.py FOLDER [--methods paper evidence] [--pictures FOLDER]

Data sets for semantic segmentation label every point, and those that keep one text file per object tell where
each opening is: every folder that holds `wall*.txt` is a facade, and every `window*.txt` or `door*.txt` in it
an opening, with x, y and z in the first three columns. The published street of shops of the NUIST facade data
set is laid out like this. The method gets all points as one cloud without sensor positions. An opening is the
box around its points, seen along the normal of the wall, without one point in two hundred on each side. F1 is
over all facades, its interval over facades.
"""

import argparse
import sys
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from _common import table
from _houses import openings_of
from _realfronts import LEVELS, fronts
from bench_openings import f1_over
from frontage.evaluation.match import assign, overlap
from frontage.geometry.arrays import Array, Float
from frontage.geometry.ring import rectangle
from frontage.model import Scan, WorldRef

COLUMNS = ("facade", "method", "F1 at 0.5", "F1 at 0.75", "asked", "found")
PARTS = {"wall": "wall*.txt", "window": "window*.txt", "door": "door*.txt"}
OUTER = 0.005  # share of the points of an opening that lie beyond its borders on each side
CELL = 0.04  # m, of pictures


@dataclass(frozen=True, eq=False)
class Labelled:
    """The points of a facade (n, 3) m, the rings (4, 2) m of its openings, and the axes (2, 3) of these."""

    name: str
    xyz: Float
    openings: list[Float]
    axes: Float


def labelled(folder: Path) -> Labelled:
    """Read the facade of a folder."""
    objects = {part: [_points(path) for path in sorted(folder.glob(PARTS[part]))] for part in PARTS}
    wall, openings = np.vstack(objects["wall"]), [*objects["window"], *objects["door"]]
    plan = wall[:, :2] - wall[:, :2].mean(0)
    along = np.linalg.svd(plan.T @ plan)[0][:, 0]
    axes = np.array([[*along, 0.0], [0.0, 0.0, 1.0]])
    flat = [points @ axes.T for points in openings]
    borders = [np.quantile(points, (OUTER, 1.0 - OUTER), axis=0).ravel() for points in flat]
    rings = [rectangle(*b) for b in borders]
    return Labelled("/".join(folder.parts[-2:]), np.vstack([wall, *openings]), rings, axes)


def _points(path: Path) -> Float:
    return np.loadtxt(path, usecols=(0, 1, 2), ndmin=2)


def rings_found(facade: Labelled, method: str) -> list[Float]:
    """Return the rings (k, 2) of the openings that a method finds, in the axes of the facade."""
    world = WorldRef(np.floor(facade.xyz.mean(0)).astype(np.int64))
    scan = Scan(facade.name, world.to_local(facade.xyz), world)
    found, _, _, _ = openings_of(fronts(scan), scan, method)
    return [scan.world.to_world(o.ring) @ facade.axes.T for o in found]


def counts(facade: Labelled, rings: list[Float]) -> Float:
    """Return how many openings are found, found though there are none, and missed, by level of IoU (k, 3)."""
    iou = overlap(facade.openings, rings)
    row, column = assign(iou)
    hits = [int((iou[row, column] >= level).sum()) for level in LEVELS]
    return np.array([(hit, len(rings) - hit, len(facade.openings) - hit) for hit in hits], np.float64)


def drawn(facade: Labelled, rings: list[Float]) -> Array:
    """Draw a facade: what lies deeper is brighter; asked for in green, found in red."""
    flat = facade.xyz @ facade.axes.T
    normal = np.cross(facade.axes[0], facade.axes[1])
    depth = facade.xyz @ normal
    depth = depth - np.median(depth)
    low, high = flat.min(0), flat.max(0)

    def pixels(places: Float) -> Array:
        return np.column_stack([places[:, 0] - low[0], high[1] - places[:, 1]]) / CELL

    at = pixels(flat).astype(int)
    shade = np.zeros(at.max(0)[::-1] + 1, np.uint8)
    shade[at[:, 1], at[:, 0]] = np.clip(150 + 250 * np.abs(depth), 0, 255)
    canvas = cv2.cvtColor(shade, cv2.COLOR_GRAY2BGR)
    for ring in facade.openings:
        cv2.polylines(canvas, [pixels(ring).round().astype(np.int32)], True, (0, 200, 0), 2)
    for ring in rings:
        cv2.polylines(canvas, [pixels(ring).round().astype(np.int32)], True, (0, 0, 255), 1)
    return canvas


def line(name: str, method: str, told: list[Float]) -> list[str]:
    """Return the row of the table of some facades, of whose counts (levels, 3) there is a list."""
    each = np.stack(told)
    scores = [f1_over(each[:, n]) for n in range(len(LEVELS))]
    hit, wrong, missed = each[:, 0].sum(0).astype(int)
    return [name, method, *scores, str(hit + missed), str(hit + wrong)]


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("folder", type=Path, nargs="?", help="the data set")
    parser.add_argument("--methods", nargs="+", default=["paper", "evidence"])
    parser.add_argument("--pictures", type=Path, help="folder for a picture of every facade")
    args = parser.parse_args()
    if args.folder is None:
        print("name the folder of a data set of labelled facades", file=sys.stderr)
        return
    folders = sorted({path.parent for path in args.folder.rglob("wall*.txt")})
    facades = [labelled(folder) for folder in folders]
    rows = []
    for method in args.methods:
        told = []
        for facade in facades:
            rings = rings_found(facade, method)
            told.append(counts(facade, rings))
            rows.append(line(facade.name, method, told[-1:]))
            if args.pictures:
                args.pictures.mkdir(parents=True, exist_ok=True)
                name = f"{facade.name.replace('/', '_')}_{method}.png"
                cv2.imwrite(str(args.pictures / name), drawn(facade, rings))
        rows.append(line("together", method, told))
    table("Facades whose points others labelled", COLUMNS, rows)


if __name__ == "__main__":
    main()
