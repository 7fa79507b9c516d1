"""Random facades cut into blocks: how many solids are valid and exact, and what 300 openings cost.

    python benchmarks/bench_solids.py [--facades 10000]

There is no baseline: the paper describes the cells but publishes no solids and no code for them.
"""

import argparse
import time

import numpy as np

from _common import bootstrap, rate_interval
from frontage.geometry.ring import rectangle
from frontage.model import Failed
from frontage.solids import validate
from frontage.solids.build import build_solid
from frontage.solids.relief import FacadeReliefs, Relief
from frontage.solids.rims import unmatched, volume6
from solids.facades import block, frame, random_facade


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--facades", type=int, default=10_000)
    parser.add_argument("--first", type=int, default=0, help="seed of the first facade")
    args = parser.parse_args()
    _three_hundred()
    started, bad, inexact, given, left_out, exact = time.process_time(), [], [], 0, 0, 0
    for seed in range(args.first, args.first + args.facades):
        straight = seed % 2 == 0
        host, facade = random_facade(np.random.default_rng(seed), np.pi / 2 if straight else None)
        built = build_solid(host, [facade])
        if isinstance(built, Failed) or unmatched(built.solid.faces) or validate(built.solid):
            bad.append(seed)
            continue
        given += len(facade.reliefs)
        left_out += len(built.failed)
        if straight:
            exact += 1
            if volume6(built.solid) != cells6(built.solid, int(host.vertices[0, 1])):
                inexact.append(seed)
    p, low, high = rate_interval(len(bad), args.facades)
    print(f"facades {args.facades}, reliefs {given}, refused with a reason {left_out}")
    print(f"invalid {len(bad)} ({100 * p:.3f} %, 95 % {100 * low:.3f} to {100 * high:.3f}); seeds {bad[:20]}")
    print(f"volume not exact {len(inexact)} of {exact} on the grid's axes; seeds {inexact[:20]}")
    print(f"{time.process_time() - started:.0f} s of processor time")


def cells6(solid, front: int) -> int:
    """Six times the volume as the sum of its cells: prisms from the front's plane to every face along it."""
    total = 0
    for face in solid.faces:
        if len(set(solid.vertices[list(face.ring), 1].tolist())) == 1:
            deep = int(solid.vertices[face.ring[0], 1]) - front
            for ring in (face.ring, *face.holes):
                x, _, z = (solid.vertices[list(ring)] - solid.vertices[ring[0]]).astype(object).T
                total -= 3 * deep * int((x * np.roll(z, -1) - np.roll(x, -1) * z).sum())
    return total


def _three_hundred() -> None:
    """20 x 15 windows in a turned wall."""
    place, outline = frame(0.7), rectangle(0, 0, 60, 40)
    host = block(place, outline)
    windows = [
        Relief(
            f"{i}-{j}", rectangle(0.5 + 2.9 * i, 1.5 + 2.5 * j, 1.7 + 2.9 * i, 3 + 2.5 * j), 0.1 + 0.01 * j
        )
        for i in range(20)
        for j in range(15)
    ]
    facade = FacadeReliefs("F", place, outline, tuple(windows))
    times = []
    for _ in range(12):
        started = time.process_time()
        build_solid(host, [facade])
        times.append(time.process_time() - started)
    middle, low, high = bootstrap(times[2:])
    print(f"300 openings: {middle:.3f} s of processor time (95 % {low:.3f} to {high:.3f})")


if __name__ == "__main__":
    main()
