"""The simulator: beams per second with 19 sub-rays each, and seconds per 12 MP photo.

    python benchmarks/bench_simulate.py [--scenes 3]

Every scene is a street with trees, cars and rooms. Stations, drives and photos run in one process each
(`frontage simulate --workers 2` runs two of them at a time), so times are processor seconds of one core.
"""

import argparse
import time
from collections.abc import Callable
from typing import Any

from _common import bootstrap, figure, table
from frontage.simulate.sensors.cameras import CameraSpec
from frontage.simulate.sensors.instrument import DriveSpec, ScannerSpec
from frontage.simulate.sensors.mobile import drive
from frontage.simulate.sensors.photograph import iter_photographs
from frontage.simulate.sensors.terrestrial import scan_stations
from frontage.simulate.spec import SceneSpec
from frontage.simulate.street.build import build_street


def spent(work: Callable[[], Any]) -> tuple[Any, float]:
    start = time.process_time()
    result = work()
    return result, time.process_time() - start


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--scenes", type=int, default=3)
    scenes = parser.parse_args().scenes
    plain, coloured, mobile, photo, build = [], [], [], [], []
    for seed in range(scenes):
        scene, t = spent(lambda seed=seed: build_street(SceneSpec(seed=seed, houses=4)))
        build.append(t)
        spec = ScannerSpec(stations=1, spacing=0.033, subrays=19)
        for colour, into in ((False, plain), (True, coloured)):
            own = spec.model_copy(update={"colour": colour})
            (station,), t = spent(lambda scene=scene, own=own, seed=seed: scan_stations(scene, own, seed))
            into.append(t / station.scan.grid.index.size * 1e6)
        own = DriveSpec(colour=False)
        d, t = spent(lambda scene=scene, own=own, seed=seed: drive(scene, own, seed))
        mobile.append(t / len(d.scan) * 1e6)
        camera = CameraSpec(width=4032, height=3024)
        _, t = spent(
            lambda scene=scene, camera=camera, seed=seed: list(
                iter_photographs(scene, camera, seed, only=[0])
            )
        )
        photo.append(t)
    rows = [
        ("street of 4 + 4 houses", build, "s"),
        ("1 M beams, 19 sub-rays", plain, "s"),
        ("... with colour", coloured, "s"),
        ("1 M mobile points", mobile, "s"),
        ("photo of 12.2 MP", photo, "s"),
    ]
    table("Simulator", ["what", "processor time"], [(n, figure(bootstrap(v), u)) for n, v, u in rows])


if __name__ == "__main__":
    main()
