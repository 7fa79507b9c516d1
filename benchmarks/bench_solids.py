"""Random facades cut into blocks and houses: how many solids are valid and exact, and what 300 openings cost.

    python benchmarks/bench_solids.py [--facades 10000] [--first 0] [--workers 1]

Half of the facades are random reliefs on blocks (touching, overlapping, at the border, arches, oriels in
oriels), half are those of simulated houses, whole buildings with their LoD2 as host, facades meeting at
corners, balconies and cornices as installations. There is no baseline: the paper describes the cells but
publishes no solids and no code for them.
"""

import argparse
import time
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass

import numpy as np

from _common import bootstrap, rate_interval
from frontage.geometry.ring import rectangle
from frontage.model import Failed, Surface
from frontage.model.citymodel import Shell
from frontage.simulate.spec import SceneSpec
from frontage.simulate.street.build import build_street
from frontage.solids import assemble
from frontage.solids.brep import unmatched_edges, volume6
from frontage.solids.cells.build import build_solid
from frontage.solids.relief import FacadeReliefs, Relief
from frontage.validation import validate
from frontage.validation.validate import overlapping
from planned_houses import building, elements, facade
from solids.facades import block, frame, random_facade

_HOUSES = 3  # on a simulated street


@dataclass(frozen=True)
class Tally:
    """Counts over some facades; `bad` and `inexact` name the cases."""

    facades: int = 0
    solids: int = 0
    reliefs: int = 0
    refused: int = 0
    exact: int = 0
    bad: tuple[str, ...] = ()
    inexact: tuple[str, ...] = ()

    def __add__(self, other: "Tally") -> "Tally":
        return Tally(*(getattr(self, k) + getattr(other, k) for k in self.__dataclass_fields__))


def random_case(seed: int) -> Tally:
    """One facade of random reliefs; even seeds lie on the grid's axes, where the volume must be exact."""
    straight = seed % 2 == 0
    host, facade = random_facade(np.random.default_rng(seed), np.pi / 2 if straight else None)
    built = build_solid(host, [facade])
    name = (f"random {seed}",)
    if isinstance(built, Failed) or unmatched_edges(built.solid.faces) or validate(built.solid):
        return Tally(1, 1, len(facade.reliefs), 0, 0, name)
    wrong = straight and volume6(built.solid) != cells6(built.solid, int(host.vertices[0, 1]))
    return Tally(1, 1, len(facade.reliefs), len(built.failed), int(straight), (), name if wrong else ())


def street_case(seed: int) -> Tally:
    """The houses of a simulated street, each whole."""
    spec = SceneSpec(seed=seed, houses=_HOUSES, opposite=False, trees=0, cars=0, people=0, lamps=0)
    scene = build_street(spec)
    total = Tally()
    for house in scene.houses:
        fronts = [(facade(f, scene.world), elements(f)) for f in house.facades]
        count = sum(len(e.openings) + len(e.protrusions) for _, e in fronts)
        shell = Shell("2", tuple(Surface(ring, kind) for kind, ring in house.shell))
        made = assemble(building(house), fronts, [shell], scene.world)
        name = (f"street {seed} {house.id}",)
        if isinstance(made, Failed):
            total += Tally(len(fronts), 1, count, 0, 0, name)
            continue
        solids = [*(b.solid for b in made.built), *(i.solid for i in made.installations)]
        lost = any(f.code in ("S318", "S320", "S399") for f in made.failed) or made.coarse.source != "model"
        apart = [*(b.solid for b in made.built), *(i.solid for i in made.installations if i.closed)]
        bad = lost or any(validate(s) for s in solids) or bool(overlapping(apart))
        total += Tally(len(fronts), len(solids), count, len(made.failed), 0, name if bad else ())
    return total


def cases(wanted: int, first: int) -> Iterator[tuple[int, str]]:
    """Seeds with their kinds: half of the facades random ones, the rest streets of five facades or more."""
    half = wanted // 2
    yield from ((first + k, "random") for k in range(half))
    yield from ((first + k, "street") for k in range(max(1, (wanted - half) // 5)))


def case(task: tuple[int, str]) -> Tally:
    return random_case(task[0]) if task[1] == "random" else street_case(task[0])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--facades", type=int, default=10_000)
    parser.add_argument("--first", type=int, default=0, help="seed of the first facade")
    parser.add_argument("--workers", type=int, default=1)
    args = parser.parse_args()
    _three_hundred()
    started, total = time.perf_counter(), {"random": Tally(), "street": Tally()}
    tasks = list(cases(args.facades, args.first))
    if args.workers > 1:
        with ProcessPoolExecutor(args.workers) as pool:
            tallies = list(pool.map(case, tasks, chunksize=8))
    else:
        tallies = [case(t) for t in tasks]
    for (_, kind), tally in zip(tasks, tallies, strict=True):
        total[kind] += tally
    for kind, t in {**total, "all": total["random"] + total["street"]}.items():
        _print(kind, t)
    print(f"{time.perf_counter() - started:.0f} s with {args.workers} workers")


def _print(kind: str, t: Tally) -> None:
    p, low, high = rate_interval(len(t.bad), max(t.solids, 1))
    print(f"{kind}: {t.facades} facades, {t.solids} solids, {t.reliefs} elements ({t.refused} refused)")
    print(f"  invalid {len(t.bad)} ({100 * p:.3f} %, 95 % {100 * low:.3f} to {100 * high:.3f}) {t.bad[:20]}")
    if t.exact:
        print(f"  volume not exact {len(t.inexact)} of {t.exact} on the grid's axes {t.inexact[:20]}")


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
