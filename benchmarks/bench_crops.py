"""How much depends on the rest of a front: random pieces of annotated fronts, scored with their truth.

    python benchmarks/bench_crops.py [--scans church_tower ...] [--pieces 6] [--seed 1] [--pictures FOLDER]

A piece keeps 45 to 80 % of the width of the annotated openings and, every other time, 60 to 90 % of their
height from below. The scan is cut across the whole depth of the building. Openings that lie inside by 0.3 m
are asked for; those that the cut touches count neither way. The scorer is that of the annotations. F1 is
over all openings of the pieces of a scan, its interval over pieces. `--method paper` takes the paper's.
"""

import argparse
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from _common import DATA, bootstrap, figure, table
from _houses import openings_of
from _realfronts import FRONTS, LEVELS, fronts, judged_rings, read_front, read_truth
from frontage.geometry.arrays import Array, Float
from frontage.model import Scan

WIDTHS, HEIGHTS = (0.45, 0.8), (0.6, 0.9)
HEADER = ("scan", "pieces", "asked", "told", "F1 at 0.5", "F1 at 0.75")
INSIDE_M = 0.3
AROUND_M = 1.5  # of wall beside the outermost openings


@dataclass(frozen=True, eq=False)
class Piece:
    """A piece of a front: its scan and its truth."""

    scan: Scan
    truth: dict[str, Any]


def in_frame(xyz: Float, scan: Scan, truth: dict[str, Any]) -> Float:
    """Return local points (n, 3) m of a scan in the frame of a truth."""
    axes, origin = np.array(truth["frame"]["axes_rows_XYZ"]), np.array(truth["frame"]["origin"])
    return np.asarray((scan.world.to_world(xyz) - origin) @ axes.T)


def pieces(scan: Scan, truth: dict[str, Any], count: int, seed: int) -> Iterator[Piece]:
    """Draw pieces of a front."""
    rng, place = np.random.default_rng(seed), in_frame(scan.xyz, scan, truth)
    known = np.array([[o["x0"], o["x1"], o["z0"], o["z1"]] for o in truth["openings"]])
    left, right = known[:, 0].min() - AROUND_M, known[:, 1].max() + AROUND_M
    bottom, top = place[:, 2].min(), known[:, 3].max() + AROUND_M
    for k in range(count):
        width = rng.uniform(*WIDTHS) * (right - left)
        x0 = rng.uniform(left, right - width)
        z1 = bottom + rng.uniform(*HEIGHTS) * (top - bottom) if k % 2 else np.inf
        kept = (place[:, 0] > x0) & (place[:, 0] < x0 + width) & (place[:, 2] < z1)
        cut = cut_truth(truth, (float(x0), float(x0 + width), float(z1)))
        yield Piece(scan.take(np.flatnonzero(kept)), cut)


def cut_truth(truth: dict[str, Any], borders: tuple[float, float, float]) -> dict[str, Any]:
    """Return the truth of a piece with the borders x0, x1, z1 (m, frame of the truth).

    Openings that the cut touches are unsure, and those outside are left out.
    """
    x0, x1, z1 = borders
    openings = []
    for o in truth["openings"]:
        if o["x1"] < x0 or o["x0"] > x1 or o["z0"] > z1:
            continue
        whole = o["x0"] > x0 + INSIDE_M and o["x1"] < x1 - INSIDE_M and o["z1"] < z1 - INSIDE_M
        openings.append(o if whole else {**o, "confidence": "unsure"})
    return {**truth, "openings": openings}


def judged(piece: Piece, method: str) -> tuple[dict[str, Any], list[Float]]:
    """Return the figures of a piece by the annotation's scorer, and the rings (k, 3) m local found."""
    found, _, _, _ = openings_of(fronts(piece.scan), piece.scan, method)
    figures = judged_rings([(o.kind, o.ring) for o in found], piece.scan, piece.truth)
    return figures, [o.ring for o in found]


def drawn(piece: Piece, rings: Sequence[Float], cell: float = 0.02) -> Array:
    """Draw the front of a piece, seen from the street: found in red, asked for in green, unsure in blue."""
    place = in_frame(piece.scan.xyz, piece.scan, piece.truth)
    near = place[np.abs(place[:, 1]) < 2.0]
    low, high = near[:, [0, 2]].min(0), near[:, [0, 2]].max(0)
    shape = np.ceil((high - low) / cell).astype(int)[::-1] + 1

    def pixels(flat: Float) -> Array:
        return np.column_stack([flat[:, 0] - low[0], high[1] - flat[:, 1]]) / cell

    depth = np.full(shape, np.nan)
    order = np.argsort(-near[:, 1])  # what stands farther out is drawn last
    at = pixels(near[order][:, [0, 2]]).astype(int)
    depth[at[:, 1], at[:, 0]] = near[order, 1]
    shade = np.where(np.isnan(depth), 0, 255 - 200 * np.clip(depth + 0.5, 0, 1.5) / 1.5).astype(np.uint8)
    canvas = cv2.cvtColor(shade, cv2.COLOR_GRAY2BGR)
    for o in piece.truth["openings"]:
        corners = [[o["x0"], o["z0"]], [o["x1"], o["z0"]], [o["x1"], o["z1"]], [o["x0"], o["z1"]]]
        ring = pixels(np.array(o.get("polygon") or corners)).round().astype(np.int32)
        cv2.polylines(canvas, [ring], True, (0, 200, 0) if o["confidence"] == "sure" else (255, 120, 0), 3)
    for ring in rings:
        flat = in_frame(ring, piece.scan, piece.truth)[:, [0, 2]]
        cv2.polylines(canvas, [pixels(flat).round().astype(np.int32)], True, (0, 0, 255), 1)
    return canvas


def examine(name: str, args: argparse.Namespace) -> list[Any]:
    """Return the table row of a scan."""
    front = FRONTS[name]
    scan, told = read_front(front), []
    for label in front.truths:
        for k, piece in enumerate(pieces(scan, read_truth(label), args.pieces, args.seed)):
            figures, rings = judged(piece, args.method)
            told.append(
                [figures["asked"], figures["predicted"], *(right(figures, level) for level in LEVELS)]
            )
            print(f"{label} {k}: {told[-1]}", file=sys.stderr, flush=True)
            if args.pictures:
                args.pictures.mkdir(parents=True, exist_ok=True)
                cv2.imwrite(str(args.pictures / f"{label}_{k}.png"), drawn(piece, rings))
    counts = np.array(told)
    return [name, len(counts), *counts[:, :2].sum(0), *(pooled(counts, 2 + i) for i in range(len(LEVELS)))]


def right(figures: dict[str, Any], level: float) -> int:
    """Return how many openings of a piece are right at a level of IoU."""
    return round(figures[f"recall@{level}"] * figures["asked"])


def pooled(counts: Float, column: int) -> str:
    """Return F1 over all pieces with its interval over pieces, of rows asked, told, right at each level."""

    def f1(chosen: Float) -> float:
        rows = counts[chosen.astype(int)]
        return float(2 * rows[:, column].sum() / max(rows[:, :2].sum(), 1))

    return figure(bootstrap(np.arange(len(counts)), f1))


def main() -> None:
    """Score the pieces of one scan after another."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    names = sorted(name for name, front in FRONTS.items() if front.truths)
    parser.add_argument("--scans", nargs="+", choices=names, default=names)
    parser.add_argument("--pieces", type=int, default=6)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--method", choices=("evidence", "paper"), default="evidence")
    parser.add_argument("--pictures", type=Path, help="folder for a picture of every piece")
    args = parser.parse_args()
    present = [name for name in args.scans if (DATA / FRONTS[name].path).exists()]
    for name in sorted(set(args.scans) - set(present)):
        print(f"{name}: shared data is absent and left out", file=sys.stderr)
    table("Pieces of annotated fronts", HEADER, [examine(name, args) for name in present])


if __name__ == "__main__":
    main()
