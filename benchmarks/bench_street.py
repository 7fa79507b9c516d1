"""A whole street, from its file to its facades: time and peak memory, the paper's way beside ours.

    python benchmarks/bench_street.py [--points 3 10] [--workers 2]

A terrace that `frontage.simulate` draws and scans 2 cm apart is repeated along the street, so that houses,
walls and stations grow with the points, and written as LAZ (with station positions) to a temporary folder.
Every measurement runs in a process of its own: reading, buildings, facades. `paper` stops at connected
components and takes one RANSAC plane each. `found : read` compares the processor time of buildings and
facades with that of reading. 30 M points take some minutes.
"""

import argparse
import itertools
import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from pathlib import Path

import numpy as np

from _common import peak_memory, table
from frontage.buildings import BuildingOptions, find_buildings
from frontage.facades import FacadeOptions, find_facades
from frontage.io.scans.laswrite import write_las
from frontage.io.scans.read import read_scans
from frontage.model import Building, Facade, Scan
from frontage.pipeline.clouds import Neighbourhoods, working_cloud
from frontage.simulate.scene import Part
from scanned_streets import ScannedStreet, terrace

Clock = tuple[float, float]


def street(points: int, base: ScannedStreet) -> Scan:
    """`points` points of a terrace that repeats `base` along the street, without gap or overlap."""
    scan, frame = base.scan, base.scene.local_from_street
    length = max(base.span(h)[1] for h in range(len(base.houses)))
    s = frame.inverse.apply(scan.xyz)[:, 0]
    scan = scan.take(np.flatnonzero((base.part != Part.GROUND) | ((s >= 0) & (s < length))))
    copies = -(-points // len(scan))
    step = length * frame.R[:, 0]
    xyz = np.concatenate([scan.xyz + i * step for i in range(copies)])[:points]
    eyes = np.concatenate([scan.origins + i * step for i in range(copies)])
    index = np.concatenate([scan.origin_index + i * len(scan.origins) for i in range(copies)])[:points]
    rgb, intensity = np.tile(scan.rgb, (copies, 1))[:points], np.tile(scan.intensity, copies)[:points]
    return Scan("street", xyz, scan.world, eyes, index.astype(np.int32), intensity, rgb)


def clock() -> Clock:
    """Wall and processor seconds, finished children included."""
    own = os.times()
    return time.perf_counter(), own.user + own.system + own.children_user + own.children_system


def facades_of(task: tuple[Scan, Building, str]) -> int:
    """How many facades a building's working cloud gives."""
    scan, building, method = task
    options = FacadeOptions(method="paper") if method == "paper" else FacadeOptions()
    found = find_facades(scan, building, options)
    return sum(isinstance(f, Facade) for f in found)


def tasks_of(scan: Scan, buildings: Sequence[Building], method: str):
    """Working clouds as the pipeline cuts them, one after the other."""
    around = Neighbourhoods(scan.xyz)
    for b in buildings:
        cloud, own = working_cloud(scan, around, b.index)
        yield cloud, replace(b, index=np.asarray(own, np.int64)), method


def measure(path: Path, method: str, workers: int) -> dict[str, object]:
    """One run in this process: [wall, processor] seconds of each step, counts, peak GB with the workers'."""
    marks = [clock()]
    scan = read_scans(str(path))[0]
    marks.append(clock())
    split = find_buildings(scan, BuildingOptions(method=method))  # type: ignore[arg-type]
    marks.append(clock())
    tasks = tasks_of(scan, split.buildings, method)
    count = sum(map(facades_of, tasks)) if workers == 1 else _in_turns(tasks, workers)
    marks.append(clock())
    took = [[b - a for a, b in zip(m, n, strict=True)] for m, n in itertools.pairwise(marks)]
    return {
        "points": len(scan), "steps": took, "buildings": len(split.buildings), "facades": count,
        "memory": peak_memory(),
    }  # fmt: skip


def _in_turns(tasks, workers: int) -> int:
    """Sum over the tasks, never more of them in memory than there are workers."""
    with ProcessPoolExecutor(workers) as pool:
        waiting, count = [], 0
        for task in tasks:
            waiting.append(pool.submit(facades_of, task))
            while len(waiting) > workers:
                count += waiting.pop(0).result()
        return count + sum(w.result() for w in waiting)


def child(path: Path, method: str, workers: int) -> dict:
    """`measure` in a process of its own, so that its peak memory is its own."""
    command = [
        sys.executable,
        __file__,
        "--measure",
        str(path),
        "--method",
        method,
        "--workers",
        str(workers),
    ]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        raise RuntimeError(done.stderr.strip().splitlines()[-1])
    return json.loads(done.stdout.splitlines()[-1])


def _ratio(steps: Sequence[Clock]) -> float:
    """Processor time of finding buildings and facades over that of reading the file."""
    reading, *finding = (processor for _, processor in steps)
    return sum(finding) / max(reading, 1e-9)


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--points", type=float, nargs="*", default=[3, 10], help="millions of points")
    parser.add_argument("--workers", type=int, default=1, help="processes for the facades")
    parser.add_argument("--measure", type=Path, help=argparse.SUPPRESS)
    parser.add_argument("--method", default="frontage", help=argparse.SUPPRESS)
    args = parser.parse_args()
    if args.measure:
        print(json.dumps(measure(args.measure, args.method, args.workers)))
        return
    base, rows = terrace(seed=7, houses=5, spacing=0.02), []
    with tempfile.TemporaryDirectory() as folder:
        for m in args.points:
            path = write_las(Path(folder) / "street.laz", street(round(m * 1e6), base))
            for method in ("paper", "frontage"):
                r = child(path, method, args.workers)
                total = np.sum(r["steps"], axis=0)
                n = r["points"] * np.log2(r["points"]) / 1e9
                rows.append(
                    [f"{m:g} M", method, *(f"{w:.1f} / {p:.1f}" for w, p in [*r["steps"], total]),
                     f"{_ratio(r['steps']):.1f}", f"{total[1] / n:.0f}",
                     f"{r['memory']:.2f} GB", r["buildings"], r["facades"]]
                )  # fmt: skip
                print(rows[-1], file=sys.stderr)
    header = ["points", "method", "reading", "buildings", "facades", "all", "found : read",
              "per n log2 n / 1e9", "peak", "buildings", "facades"]  # fmt: skip
    table(f"Seconds wall / processor, {args.workers} worker(s)", header, rows)


if __name__ == "__main__":
    main()
