"""Do simulated scans look like real ones? The same figures from both.

    python benchmarks/realism.py [--scenes 6]

Every figure comes from points in the facade frame and the outlines of the windows alone, so both sides are
measured alike: spread of wall points within 10 cm, relief between 10 cm cells at growing lags, the fate of
the beams into windows, points in the free air of reveals, and the pattern of the points on the wall.
"""

import argparse
import json
from dataclasses import dataclass

import laspy
import numpy as np
from scipy.spatial import cKDTree

from _common import DATA, bootstrap, figure, table
from frontage.model import merge_scans
from frontage.simulate.scene import Scene
from frontage.simulate.sensors.instrument import DriveSpec, ScannerSpec
from frontage.simulate.sensors.mobile import drive
from frontage.simulate.sensors.terrestrial import scan_stations
from frontage.simulate.spec import SceneSpec
from frontage.simulate.street.build import build_street

CELL = 0.1  # m
LAGS = (0.1, 0.3, 1.0, 2.0)  # m
FLUSH, FRAME = 0.05, 0.35  # m behind the wall: blinds and shutters | frames, panes, curtains | rooms


@dataclass
class View:
    """Points (n, 3) m, y from the local wall; windows (k, 5): x0, z0, x1, z1, frame depth; which to judge."""

    name: str
    xyz: np.ndarray
    windows: np.ndarray
    judged: np.ndarray


def real(name: str) -> View:
    folder = DATA / name / "street_front.laz"
    truth = json.loads((DATA / "truth" / f"{name}.json").read_text())
    las = laspy.read(folder)
    frame = truth["frame"]
    xyz = (np.column_stack([las.x, las.y, las.z]) - frame["origin"]) @ np.array(frame["axes_rows_XYZ"]).T
    n = np.array(truth["plane"]["normal_into_building"])
    xyz[:, 1] += xyz[:, 2] * n[2] / n[1]
    if "local_wall" in truth:
        xyz[:, 1] -= np.interp(xyz[:, 0], truth["local_wall"]["x"], truth["local_wall"]["depth"])
    openings = truth["openings"]
    windows = np.array(
        [[o[k] for k in ("x0", "z0", "x1", "z1")] + [o["frame_depth"] or np.nan] for o in openings]
    )
    judged = np.array(
        [o["confidence"] == "sure" and o["occluded"] <= 0.1 and o["kind"] == "window" for o in openings]
    )
    return View(name.replace("_", " "), xyz, windows, judged)


def lille() -> View:
    from frontage.io.scans.read import ScanSource, read_scans

    scan = read_scans(ScanSource(path=str(DATA / "lille_mobile" / "Lille_street_small.ply")))[0]
    xyz = scan.xyz[scan.xyz[:, 2] > np.quantile(scan.xyz[:, 2], 0.3)]
    rng = np.random.default_rng(0)
    best, inliers = None, 0
    for _ in range(300):  # the strongest upright plane is the facade row
        a, b = xyz[rng.integers(0, len(xyz), 2), :2]
        n = np.array([-(b - a)[1], (b - a)[0]]) / max(np.hypot(*(b - a)), 1e-9)
        count = int((np.abs((xyz[:, :2] - a) @ n) < 0.05).sum())
        if count > inliers:
            best, inliers = (a, n), count
    assert best is not None
    (a, n) = best
    x, y = (xyz[:, :2] - a) @ [n[1], -n[0]], (xyz[:, :2] - a) @ n
    return View("lille (mobile)", np.column_stack([x, y, xyz[:, 2]]), np.empty((0, 5)), np.empty(0, bool))


def simulated(scene: Scene, xyz: np.ndarray, name: str) -> list[View]:
    """The near side's facades of a scene."""
    out = []
    for house in (h for h in scene.houses if h.side == 0):
        plan = house.facades[0]
        p = plan.local_from_facade.inverse.apply(xyz)
        low, high = plan.outline.min(0), plan.outline.max(0)
        near = (p[:, 0] > low[0]) & (p[:, 0] < high[0]) & (p[:, 2] > low[1]) & (p[:, 2] < high[1])
        near &= (p[:, 1] > -1) & (p[:, 1] < 6)
        rows = [[*o.ring.min(0), *o.ring.max(0), o.depth] for o in plan.openings]
        judged = np.array(
            [o.kind == "window" and o.wall_y == 0 and o.shutters != "closed" for o in plan.openings], bool
        )
        out.append(View(name, p[near], np.array(rows).reshape(-1, 5), judged))
    return out


def wall_of(v: View) -> np.ndarray:
    """Points near the wall and away from every opening, (k, 3)."""
    p = v.xyz[np.abs(v.xyz[:, 1]) < 0.08]
    keep = np.ones(len(p), bool)
    for x0, z0, x1, z1, _ in v.windows:
        keep &= ~((p[:, 0] > x0 - 0.2) & (p[:, 0] < x1 + 0.2) & (p[:, 2] > z0 - 0.2) & (p[:, 2] < z1 + 0.2))
    return p[keep]


def cells(p: np.ndarray, size: float, least: int) -> tuple[np.ndarray, np.ndarray, list[np.ndarray]]:
    """Cells (k, 2) with `least` points or more, their mean y (k,), and the rows of each."""
    key = np.floor(p[:, [0, 2]] / size).astype(int)
    unique, inverse, count = np.unique(key, axis=0, return_inverse=True, return_counts=True)
    rows = np.split(np.argsort(inverse, kind="stable"), np.cumsum(count)[:-1])
    full = np.flatnonzero(count >= least)
    return unique[full], np.array([p[rows[i], 1].mean() for i in full]), [rows[i] for i in full]


def wall_figures(v: View) -> dict[str, list[float]]:
    p = wall_of(v)
    # 10 cm, or what holds some 20 points of a sparse scan
    per_area = np.median([len(r) for r in cells(p, 0.5, 1)[2]]) / 0.25
    _, _, patches = cells(p, max(CELL, np.sqrt(20 / per_area)), 12)
    spread = []
    for rows in patches[:: max(len(patches) // 400, 1)]:
        A = np.column_stack([p[rows][:, [0, 2]], np.ones(len(rows))])
        residual = p[rows, 1] - A @ np.linalg.lstsq(A, p[rows, 1], rcond=None)[0]
        spread.append(1.4826 * np.median(np.abs(residual)) * np.sqrt(len(rows) / (len(rows) - 3)) * 1e3)
    at, mean, _ = cells(p, CELL, 6)
    out = {"spread in 10 cm, mm": spread}
    place = {tuple(c): m for c, m in zip(at, mean, strict=True)}
    for lag in LAGS:
        step = round(lag / CELL)
        d = [place[i + step, j] - m for (i, j), m in place.items() if (i + step, j) in place]
        out[f"relief at {lag:g} m, mm"] = [float(1.4826 * np.median(np.abs(d)) * 1e3)] if len(d) > 20 else []
    return out


def pattern_figures(v: View) -> dict[str, list[float]]:
    p = wall_of(v)
    at, _, patches = cells(p, 1.0, 60)
    regular, cv = [], []
    for _, rows in zip(at, patches, strict=True):
        q = p[rows][:, [0, 2]]
        if len(cells(p[rows], CELL, 1)[0]) < 90:
            continue
        near = cKDTree(q).query(q, 2)[0][:, 1]
        regular.append(float(np.median(near) * np.sqrt(len(q))))
        cv.append(float(near.std() / near.mean()))
    return {"nearest / mean spacing": regular, "variation of nearest": cv}


def window_figures(v: View) -> dict[str, list[float]]:
    p = v.xyz
    at, _, rows = cells(wall_of(v), 0.2, 1)
    if not len(at):
        return {}
    tree = cKDTree((at + 0.5) * 0.2)
    density = np.array([len(r) for r in rows]) / 0.04
    out: dict[str, list[float]] = {
        k: [] for k in ("flush", "frame, pane, curtain", "room", "no return", "free air")
    }
    for x0, z0, x1, z1, depth in v.windows[v.judged]:
        near = tree.query_ball_point([(x0 + x1) / 2, (z0 + z1) / 2], max(x1 - x0, z1 - z0) / 2 + 0.8)
        if len(near) < 12:
            continue
        expected = np.quantile(density[near], 0.6)  # cells cut by cornices and sills hold fewer
        inside = (p[:, 0] > x0 + 0.03) & (p[:, 0] < x1 - 0.03) & (p[:, 2] > z0 + 0.03) & (p[:, 2] < z1 - 0.03)
        y, x = p[inside, 1], p[inside, 0]
        total = expected * (x1 - x0 - 0.06) * (z1 - z0 - 0.06)
        if total < 100:
            continue
        parts = [(np.abs(y) < FLUSH).sum(), ((y >= FLUSH) & (y < FRAME)).sum(), (y >= FRAME).sum()]
        for key, n in zip(list(out)[:3], parts, strict=True):
            out[key].append(float(n / total))
        out["no return"].append(float(np.clip(1 - sum(parts) / total, 0, 1)))
        if depth > 0.09:  # air between the wall's edge and the frame, beside the jambs, which nothing fills
            aside = np.minimum(x - x0, x1 - x)
            air = (y > 0.2 * depth) & (y < 0.5 * depth) & (aside > 0.03) & (aside < 0.1)
            air &= np.abs(p[inside, 2] - (z0 + z1) / 2) < (z1 - z0) / 2 - 0.1
            out["free air"].append(float(air.sum() / (2 * (z1 - z0 - 0.2) * np.sqrt(expected))))
    return out


def measure(views: list[View]) -> dict[str, list[float]]:
    total: dict[str, list[float]] = {}
    for v in views:
        for part in (wall_figures(v), window_figures(v), pattern_figures(v)):
            for key, values in part.items():
                total.setdefault(key, []).extend(values)
    return total


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--scenes", type=int, default=6)
    args = parser.parse_args()
    terrestrial, mobile = [], []
    for seed in range(args.scenes):
        scene = build_street(SceneSpec(seed=100 + seed, houses=3))
        stations = scan_stations(
            scene,
            ScannerSpec(stations=2, spacing=0.018, colour=False, field=165, lowest=-10, highest=50),
            seed,
        )
        cloud = merge_scans([s.scan for s in stations])
        terrestrial += simulated(scene, cloud.xyz, "simulated stations")
        d = drive(scene, DriveSpec(colour=False), seed)
        mobile += simulated(scene, d.scan.xyz, "simulated drive")
    groups = [terrestrial, mobile]
    names = ["simulated stations", "simulated drive"]
    for name in ("manhattan_apartment", "brooklyn_row"):
        if (DATA / name).exists():
            groups.append([real(name)])
            names.append(name.replace("_", " "))
    if (DATA / "lille_mobile").exists():
        groups.append([lille()])
        names.append("lille (mobile)")
    results = [measure(g) for g in groups]
    keys = list(dict.fromkeys(k for r in results for k in r))
    rows = []
    for key in keys:
        statistic = (
            np.mean
            if key in ("flush", "frame, pane, curtain", "room", "no return", "free air")
            else np.median
        )
        row = [figure(bootstrap(r[key], statistic, draws=500)) if r.get(key) else "-" for r in results]
        rows.append([key, *row])
    table("Realism", ["figure", *names], rows)


if __name__ == "__main__":
    main()
