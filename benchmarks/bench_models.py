"""How many random city models of ours are faultless by the official schemas and by val3dity's rules.

    python benchmarks/bench_models.py [--models 500] [--first 0] [--workers 1]

A model is a house of a simulated street as it was planned, with elements left out, moved and added at random,
with window bars, with pictures, on the LoD2 of the street or on a block of its own. Each is written as
CityJSON 2.0 and CityGML 2.0 and 3.0. Every file is checked against its official schema, its solids by the
rules of val3dity, installations together with their building, and read again. Needs the schemas of the real
data (`../shared/data/schemas`). There is no baseline: the papers write no files.
"""

import argparse
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from _common import rate_interval, table
from random_models import HOUSES, KINDS, faults, random_models


@dataclass(frozen=True)
class Judged:
    """A model: what it holds, how many elements it was to have and how many were refused, its faults."""

    name: str
    holds: frozenset[str]
    elements: int
    refused: int
    faults: tuple[str, ...]


def judged(seed: int) -> list[Judged]:
    """The models of a street."""
    with tempfile.TemporaryDirectory() as folder:
        return [
            Judged(m.name, frozenset(m.levels | ({"pictures"} if m.textures else set())), m.elements,
                   m.refused, tuple(faults(m, Path(folder))))
            for m in random_models(seed)
        ]  # fmt: skip


def show(models: Sequence[Judged]) -> None:
    """Print the shares of faultless models, all and by what they hold, and every fault."""
    groups = {"all": models}
    groups |= {name: [m for m in models if name in m.holds] for name in ("pictures", "installation", "frame")}
    rows = []
    for name, own in groups.items():
        bad = sum(1 for m in own if m.faults)
        _, low, high = rate_interval(bad, max(len(own), 1))
        rows.append((name, len(own), sum(m.elements for m in own), sum(m.refused for m in own), bad,
                     f"{100 * low:.2f} to {100 * high:.2f} %"))  # fmt: skip
    table("Random models", ("models with", "models", "elements", "refused", "with faults", "95 %"), rows)
    count = Counter(kind for m in models for kind in KINDS if any(kind in text for text in m.faults))
    table("Files", ("format", "with faults"), [(kind, count[kind]) for kind in KINDS])
    for text in (text for m in models for text in m.faults):
        print(text)


def _one_by_one(seeds: Sequence[int]) -> list[list[Judged]]:
    """The models of all streets; when somebody interrupts, those so far."""
    found: list[list[Judged]] = []
    with suppress(KeyboardInterrupt):
        for seed in seeds:
            found.append(judged(seed))
            print(f"\r{len(found)} of {len(seeds)} streets", end="", file=sys.stderr, flush=True)
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--models", type=int, default=500)
    parser.add_argument("--first", type=int, default=0, help="seed of the first street")
    parser.add_argument("--workers", type=int, default=1)
    args = parser.parse_args()
    started, seeds = time.perf_counter(), range(args.first, args.first + -(-args.models // HOUSES))
    if args.workers > 1:
        with ProcessPoolExecutor(args.workers) as pool:
            found = list(pool.map(judged, seeds))
    else:
        found = _one_by_one(seeds)
    show([m for street in found for m in street][: args.models])
    print(f"\n{time.perf_counter() - started:.0f} s with {args.workers} workers")


if __name__ == "__main__":
    main()
