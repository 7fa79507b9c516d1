"""Main plane of a simulated 20 x 12 m wall: ours, the paper's 3-point RANSAC, least squares, Open3D.

    python benchmarks/bench_planes.py [--seeds 10] [--points 1 5] [--noise 0.005] [--peer-python PATH]

60 % clutter (frames, a balcony front, rooms behind windows, bushes, ground). Two walls: white noise only, and
with roughness of 3 mm correlated over 0.3 m besides. Errors are means over the seeds with 95 % bootstrap
intervals; NEES is the mean normalised squared error of (offset, lean, azimuth), 1 when the reported
covariance is honest. `--points` (millions) are timed: the whole of `find_facades`, and in it the plane's own
step (fit, covariance and raster of all points near a plane that was found among thinned ones).

`--peer-python` names the interpreter of another environment that has Open3D; its `segment_plane` then gets
the same points. Times are processor seconds, so that other work on the machine does not count.
"""

import argparse
import json
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from scipy import ndimage
from scipy.stats import chi2

from _common import bootstrap, figure, table
from frontage.facades import FacadeOptions, find_facades
from frontage.facades.candidate import refine_candidate
from frontage.facades.cloud import prepare
from frontage.facades.plane.paper import paper_plane
from frontage.facades.scene import FacadeScene
from frontage.facades.sequential import search_candidates
from frontage.geometry.arrays import Float
from frontage.geometry.plane import fit_plane
from frontage.model import Building, Facade, Scan, WorldRef

STATION = np.array([2.0, -12.0, 1.7])
CENTRE = np.array([0.0, 0.0, 6.0])
ROUGHNESS, LENGTH = 0.003, 0.3  # m: sigma and correlation length of the rough wall
Plane = tuple[Float, Float]

PEER = """
import json, sys, time
import numpy as np, open3d as o3d
xyz = np.load(sys.argv[1])
o3d.utility.random.seed(int(sys.argv[2]))
cloud = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(xyz))
start = time.process_time()
(a, b, c, d), rows = cloud.segment_plane(0.05, 3, 1000)
took = time.process_time() - start
print(json.dumps({"normal": [a, b, c], "point": xyz[rows].mean(0).tolist(), "seconds": took}))
"""


def roughness(rng: np.random.Generator, x: Float, z: Float, cell: float = 0.05) -> Float:
    """A Gaussian random field at (x, z), sigma 3 mm, correlated over 0.3 m."""
    field = ndimage.gaussian_filter(rng.normal(0, 1, (300, 460)), LENGTH / 2 / cell)
    at = np.stack([(z + 1.5) / cell, (x + 11.5) / cell])
    return np.asarray(ROUGHNESS / field.std() * ndimage.map_coordinates(field, at, order=1), np.float64)


def wall(seed: int, points: int, noise: float, rough: bool = False) -> Scan:
    """The wall is y = 0, x in -10..10, z in 0..12, with windows every 3 m; 40 % of the points are on it."""
    rng = np.random.default_rng(seed)
    n = int(0.4 * points)
    x, z = rng.uniform(-10, 10, 2 * n), rng.uniform(0, 12, 2 * n)
    hole = (np.abs((x + 300) % 3 - 1.5) < 0.6) & (z % 3 > 0.9) & (z % 3 < 2.4)
    y = rng.normal(0, noise, 2 * n) + (roughness(rng, x, z) if rough else 0.0)
    on = np.column_stack([x, y, z])
    k = int(0.12 * points)
    windows = np.column_stack([x, np.zeros(2 * n), z])[hole]
    rooms = windows[rng.integers(0, len(windows), k)]
    rooms = STATION + (rooms - STATION) * (1 + rng.uniform(0.05, 0.5, k))[:, None]
    frames = windows[rng.integers(0, len(windows), k)] + np.column_stack(
        [np.zeros(k), 0.12 + rng.normal(0, noise, k), np.zeros(k)]
    )
    balcony = np.column_stack([rng.uniform(-6, 6, k), rng.normal(-1.0, noise, k), rng.uniform(3, 4, k)])
    bushes = rng.normal([-5.0, -3.0, 1.5], 0.8, (k, 3))
    ground = np.column_stack([rng.uniform(-12, 12, k), rng.uniform(-10, 0, k), rng.normal(0, 0.01, k)])
    xyz = rng.permutation(np.vstack([on[~hole][:n], frames, rooms, balcony, bushes, ground]))
    return Scan("wall", xyz, WorldRef(np.zeros(3, np.int64)), STATION[None], np.zeros(len(xyz), np.int32))


def everything(scan: Scan) -> Building:
    return Building("B01", np.arange(len(scan)), 0.0)


def ours(scan: Scan, seed: int) -> Facade:
    found = find_facades(scan, everything(scan), FacadeOptions(), seed)[0]
    assert isinstance(found, Facade), found
    return found


def paper(scan: Scan, seed: int) -> Plane:
    plane = paper_plane(scan.xyz, 0.05, 200, np.random.default_rng(seed))
    assert plane is not None
    return plane[0], plane[1]


def least_squares(scan: Scan, seed: int) -> Plane:
    return fit_plane(scan.xyz)[:2]


def errors(plane: Plane) -> tuple[float, float]:
    """Offset at the wall's centre in mm, angle in degrees."""
    normal, point = plane[0] * np.sign(plane[0][1]), plane[1]
    angle = float(np.degrees(np.arctan2(np.hypot(normal[0], normal[2]), normal[1])))
    return 1000 * abs(float((point - CENTRE) @ normal)), angle


def nees(f: Facade) -> float:
    error = np.array([-f.frame.t[1], f.frame.R[1, 2], -f.frame.R[1, 0]])
    cov = f.local_from_facade.covariance[np.ix_([1, 3, 5], [1, 3, 5])]
    return float(error @ np.linalg.solve(cov, error)) / 3


def peer(python: str, scan: Scan, seed: int) -> tuple[Plane, float]:
    """Open3D's plane and its processor seconds, in the other environment."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "points.npy"
        np.save(path, scan.xyz)
        done = subprocess.run(
            [python, "-c", PEER, str(path), str(seed)], capture_output=True, text=True, check=True
        )
    told = json.loads(done.stdout.strip().splitlines()[-1])
    return (np.array(told["normal"]), np.array(told["point"])), float(told["seconds"])


def has_open3d(python: str | None) -> bool:
    if python is None:
        return False
    done = subprocess.run([python, "-c", "import open3d"], capture_output=True, check=False)
    return done.returncode == 0


def accuracy(seeds: int, points: int, noise: float, rough: bool, peer_python: str | None) -> None:
    methods: dict[str, Callable[[Scan, int], Plane]] = {
        "paper: 3-point RANSAC": paper,
        "least squares": least_squares,
    }
    rows: dict[str, list[tuple[float, float, float]]] = {"frontage": []}
    squares = []
    for seed in range(seeds):
        scan = wall(seed, points, noise, rough)
        start = time.process_time()
        facade = ours(scan, seed)
        took = time.process_time() - start
        rows["frontage"].append((*errors((facade.frame.R[:, 1], facade.frame.t)), took))
        squares.append(nees(facade))
        for name, method in methods.items():
            start = time.process_time()
            plane = method(scan, seed)
            rows.setdefault(name, []).append((*errors(plane), time.process_time() - start))
        if peer_python:
            plane, took = peer(peer_python, scan, seed)
            rows.setdefault("Open3D segment_plane", []).append((*errors(plane), took))
    lines = []
    for name, got in rows.items():
        offset, angle, seconds = np.array(got).T
        share = bootstrap(seconds * 1e6 / points)
        means = (figure(bootstrap(v, np.mean)) for v in (offset, angle))
        lines.append([name, *means, figure(share, digits=2)])
    kind = "noise and correlated roughness" if rough else "white noise"
    table(
        f"Wall with {kind}, {points:,} points",
        ["method", "offset mm", "angle deg", "processor s per million"],
        lines,
    )
    low, high = chi2.ppf([0.025, 0.975], 3 * seeds) / (3 * seeds)
    print(
        f"\nNEES {figure(bootstrap(squares, np.mean))} over {seeds} seeds (honest: {low:.2f} to {high:.2f})"
    )


def speed(millions: list[float], noise: float, repeat: int = 3) -> None:
    lines = []
    for million in millions:
        scan = wall(0, int(1e6 * million), noise)
        scene = FacadeScene(scan, prepare(scan.xyz, everything(scan).index, np.random.default_rng(0), None))
        few = FacadeScene(scan, scene.cloud.bounded())
        front = search_candidates(few, np.random.default_rng(0))[0]
        votes = few.cloud.xyz[front.wall.inliers]
        steps: dict[str, Callable[[], object]] = {
            "find_facades": lambda scan=scan: ours(scan, 0),
            "plane step": lambda front=front, votes=votes, scene=scene: refine_candidate(
                front, votes, scene, np.random.default_rng(0)
            ),
        }
        for name, step in steps.items():
            step()
            spent = []
            for _ in range(repeat):
                start = time.process_time()
                step()
                spent.append((time.process_time() - start) / million)
            lines.append([f"{million:g} M", name, figure(bootstrap(spent), digits=2)])
    table("Time", ["points", "what", "processor seconds per million points"], lines)


def main() -> None:
    arguments = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    arguments.add_argument("--seeds", type=int, default=10)
    arguments.add_argument("--points", type=float, nargs="+", default=[1.0, 5.0], metavar="MILLIONS")
    arguments.add_argument("--noise", type=float, default=0.005)
    arguments.add_argument("--peer-python", metavar="PATH")
    given = arguments.parse_args()
    python = given.peer_python if has_open3d(given.peer_python) else None
    if python is None:
        print("Open3D is not installed and is left out (--peer-python)", file=sys.stderr)
    for rough in (False, True):
        accuracy(given.seeds, int(1e6 * given.points[0]), given.noise, rough, python)
    speed(given.points, given.noise)


if __name__ == "__main__":
    main()
