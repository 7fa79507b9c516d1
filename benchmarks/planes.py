"""Main plane of a simulated 20 x 12 m wall: ours, the paper's 3-point RANSAC, least squares, Open3D
where installed.

    python benchmarks/planes.py [--seeds 10] [--points 1000000] [--noise 0.005]

5 mm noise, 60 % clutter (frames, a balcony front, rooms behind windows, bushes, ground). Prints mean absolute
errors with 95 % bootstrap intervals, the time per million points and, for ours, NEES (1 = honest sigmas).
"""

import argparse
import time
from collections.abc import Callable

import numpy as np

from frontage.facades import FacadeOptions, find_facades
from frontage.facades.paper import paper_plane
from frontage.geometry.arrays import Float
from frontage.geometry.plane import fit_plane
from frontage.model import Building, Facade, Scan, WorldRef

STATION = np.array([2.0, -12.0, 1.7])
Plane = tuple[Float, Float]


def wall(seed: int, points: int, noise: float) -> Scan:
    """The wall is y = 0, x in -10..10, z in 0..12, with windows every 3 m; 40 % of the points are on it."""
    rng = np.random.default_rng(seed)
    n = int(0.4 * points)
    x, z = rng.uniform(-10, 10, 2 * n), rng.uniform(0, 12, 2 * n)
    hole = (np.abs((x + 300) % 3 - 1.5) < 0.6) & (z % 3 > 0.9) & (z % 3 < 2.4)
    on = np.column_stack([x, rng.normal(0, noise, 2 * n), z])
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
    xyz = np.vstack([on[~hole][:n], frames, rooms, balcony, bushes, ground])
    return Scan(
        "wall",
        rng.permutation(xyz),
        WorldRef(np.zeros(3, np.int64)),
        STATION[None],
        np.zeros(len(xyz), np.int32),
    )


def ours(scan: Scan, seed: int) -> Facade:
    found = find_facades(scan, Building("B01", np.arange(len(scan)), 0.0), FacadeOptions(), seed)[0]
    assert isinstance(found, Facade), found
    return found


def paper(scan: Scan, seed: int) -> Plane:
    plane = paper_plane(scan.xyz, 0.05, 200, np.random.default_rng(seed))
    assert plane is not None
    return plane[0], plane[1]


def least_squares(scan: Scan, seed: int) -> Plane:
    return fit_plane(scan.xyz)[:2]


def open3d_plane(scan: Scan, seed: int) -> Plane:
    import open3d as o3d  # type: ignore[import-not-found,unused-ignore]

    o3d.utility.random.seed(seed)
    cloud = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(scan.xyz))
    (a, b, c, _d), rows = cloud.segment_plane(0.05, 3, 1000)
    return np.array([a, b, c]), scan.xyz[rows].mean(0)


def interval(values: Float) -> str:
    """Mean with its 95 % bootstrap interval."""
    rng = np.random.default_rng(0)
    means = rng.choice(values, (2000, len(values))).mean(1)
    low, high = np.quantile(means, [0.025, 0.975])
    return f"{values.mean():9.4f} [{low:.4f}, {high:.4f}]"


def errors(plane: Plane, centre: Float) -> tuple[float, float]:
    """Offset at the wall's centre in mm, angle in degrees."""
    normal, point = plane[0] * np.sign(plane[0][1]), plane[1]
    angle = float(np.degrees(np.arctan2(np.hypot(normal[0], normal[2]), normal[1])))
    return 1000 * abs(float((point - centre) @ normal)), angle


def nees(f: Facade) -> float:
    error = np.array([-f.frame.t[1], f.frame.R[1, 2], -f.frame.R[1, 0]])
    cov = f.local_from_facade.covariance[np.ix_([1, 3, 5], [1, 3, 5])]
    return float(error @ np.linalg.solve(cov, error)) / 3


def main() -> None:
    arguments = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    arguments.add_argument("--seeds", type=int, default=10)
    arguments.add_argument("--points", type=int, default=1_000_000)
    arguments.add_argument("--noise", type=float, default=0.005)
    given = arguments.parse_args()
    methods: dict[str, Callable[[Scan, int], Plane]] = {
        "paper, 3-point RANSAC": paper,
        "least squares": least_squares,
    }
    try:
        import open3d  # type: ignore[import-not-found,unused-ignore]  # noqa: F401

        methods["Open3D segment_plane"] = open3d_plane
    except ImportError:
        print("Open3D is not installed: left out")
    rows: dict[str, list[tuple[float, float, float]]] = {name: [] for name in ("frontage", *methods)}
    squares = []
    for seed in range(given.seeds):
        scan = wall(seed, given.points, given.noise)
        start = time.perf_counter()
        facade = ours(scan, seed)
        took = time.perf_counter() - start
        centre = np.array([0.0, 0.0, 6.0])
        rows["frontage"].append((*errors((facade.frame.R[:, 1], facade.frame.t), centre), took))
        squares.append(nees(facade))
        for name, method in methods.items():
            start = time.perf_counter()
            plane = method(scan, seed)
            rows[name].append((*errors(plane, centre), time.perf_counter() - start))
    print(f"{'method':24s} {'offset mm':28s} {'angle deg':28s} s per million points")
    for name, got in rows.items():
        offset, angle, took_all = np.array(got).T
        per_million = np.median(took_all) * 1e6 / given.points
        print(f"{name:24s} {interval(offset):28s} {interval(angle):28s} {per_million:.2f}")
    print(f"NEES of frontage: {np.mean(squares):.2f} over {given.seeds} seeds (honest: 1)")


if __name__ == "__main__":
    main()
