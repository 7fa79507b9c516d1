"""Registration to a city model from 5 m / 15 degrees off: ours, and plain ICP as in paper B.

    python benchmarks/bench_registration.py [--seeds 20] [--first 0] [--only exact,office] [--scene FOLDER]

Every seed is another simulated street (3 to 5 houses a side, terrace or detached, up to 6 trees and 4 cars)
with 1 to 3 stations. Two models: `exact` = the true shells; `office` = 0.26 m common shift per axis (sigma),
5 cm per building, 3 cm per corner, 15 cm per roof. Errors are against the model: its shift is inherent.
`found` = within 0.3 m in the observable directions, or flagged ambiguous. ICP gets 5 000 points above the
instrument, without priors. Last, one station of 2 M points, and the Ingolstadt scene if it is there.
Times are processor seconds.
"""

import argparse
import json
import time
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from scipy.stats import chi2

from _common import DATA, bootstrap, rate_interval, table
from frontage.geometry.arrays import Array, Float
from frontage.geometry.rigid import Rigid3
from frontage.io.citymodels.read import read_city_model
from frontage.io.scans.read import ScanSource, read_scans
from frontage.model import CityBuilding, CityModel, Scan, Shell, Surface
from frontage.registration import (
    Direction,
    PosePrior,
    Registration,
    RegistrationOptions,
    prior_of,
    register,
)
from frontage.registration.equations import rotation_vector
from frontage.registration.icp import plain_icp
from frontage.registration.walls import ModelWalls, model_walls
from frontage.simulate.scene import Scene
from frontage.simulate.sensors.instrument import ScannerSpec
from frontage.simulate.sensors.positions import rotation
from frontage.simulate.sensors.terrestrial import scan_stations
from frontage.simulate.spec import SceneSpec
from frontage.simulate.street.build import build_street
from frontage.simulate.survey import ModelSpec, survey_model

EXACT = RegistrationOptions(sigma_model=0.002, sigma_height=0.002, sigma_lean=0.02)
OFFICE = ModelSpec(shift=0.26)
SIGMA = float(np.hypot(OFFICE.building, OFFICE.corner / np.sqrt(2)))


@dataclass(frozen=True)
class Case:
    """Scans as given, priors, true corrections (R, place of the instrument) in the world."""

    scans: list[Scan]
    priors: list[PosePrior]
    true: list[tuple[Float, Float]]


def simulated(seed: int, spacing: float) -> tuple[Scene, Case]:
    scene = build_street(SceneSpec(seed=100 + seed, houses=3 + seed % 3, trees=seed % 7, cars=seed % 5))
    spec = ScannerSpec(stations=1 + seed % 3, spacing=spacing, subrays=1, colour=False, range_max=70.0)
    rng = np.random.default_rng([seed, 77])
    case = Case([], [], [])
    for s in scan_stations(scene, spec, 1000 + seed):
        a = rng.uniform(0, 2 * np.pi)
        shift = np.array([5 * np.cos(a), 5 * np.sin(a), rng.normal()])
        level = np.radians(0.1) * rng.normal(size=2)
        wrong = rotation(level[0], level[1], np.radians(15.0) * rng.choice([-1, 1]))
        place = s.true.t + shift
        xyz = s.true.inverse.apply(s.scan.xyz) @ (wrong @ s.true.R).T + place
        case.scans.append(
            Scan(f"S{len(case.scans)}", xyz, scene.world, place[None], np.zeros(len(xyz), np.int32))
        )
        case.priors.append(
            PosePrior(place, np.array([2.5, 2.5, 1.0]), float(np.radians(7.5)), float(np.radians(0.1)))
        )
        case.true.append((wrong.T, s.true.t))
    return scene, case


def models(scene: Scene, seed: int) -> dict[str, tuple[CityModel, Array]]:
    exact = [
        CityBuilding(
            h.id, (Shell("2.2", tuple(Surface(r, s, f"{h.id}_{n}") for n, (s, r) in enumerate(h.shell))),)
        )
        for h in scene.houses
    ]
    office = survey_model(scene, OFFICE, seed)
    drawn = [CityBuilding(b.id, (Shell("2.2", b.surfaces),)) for b in office.buildings]
    return {
        "exact": (CityModel(tuple(exact), scene.world), np.zeros(3)),
        "office": (CityModel(tuple(drawn), scene.world), np.asarray(office.shift)),
    }


@dataclass
class Tally:
    """What the table is made of."""

    plan: list[float]
    height: list[float]
    ratio: list[float]
    nees: list[float]
    seconds: list[float]
    beyond: list[tuple[float, float]]
    shifts: int = 0
    missed: int = 0
    flagged: int = 0
    stations: int = 0
    open: int = 0
    icp: int = 0


def measure(t: Tally, case: Case, model: CityModel, shift: Array, options: RegistrationOptions) -> None:
    start = time.process_time()
    result = register(case.scans, model, case.priors, options)
    t.seconds.append((time.process_time() - start) / len(case.scans))
    squared = []
    for r, (R, place) in zip(result.scans, case.true, strict=True):
        e = np.concatenate([r.position - place - shift, rotation_vector(r.local_from_given.value.R @ R.T)])
        squared.append(float(e @ np.linalg.solve(r.covariance, e)))
        good = judge(t, result, model_walls(model), e, r.directions)
        t.stations += 1
        t.flagged += result.ambiguous
        t.missed += not good and not result.ambiguous
        t.open += any(not d.observable for d in r.directions if d.kind == "shift")
    t.nees.append(float(np.mean(squared)) / 6)


def judge(
    t: Tally, result: Registration, walls: ModelWalls, e: Float, directions: tuple[Direction, ...]
) -> bool:
    """Whether every observable shift is within 0.3 m; its errors go into the tally."""
    seen = {w.surface for w in result.walls if w.kind == "wall" and w.area > 5}
    normals = np.array([p.normal for p in walls.patches if p.source in seen])
    good = True
    for d in directions:
        t.shifts += d.kind == "shift"
        if d.kind != "shift" or not d.observable:
            continue
        off = abs(float(d.axis @ e[:3]))
        good &= off < 0.3
        if off > 0.01:
            t.beyond.append((off, d.sigma))
        (t.height if abs(d.axis[2]) > 0.5 else t.plan).append(off)
        if abs(d.axis[2]) < 0.5 and len(normals):
            t.ratio.append(off / (SIGMA / np.sqrt(max(float(((normals @ d.axis) ** 2).sum()), 1e-9))))
    return good


def icp_hits(case: Case, model: CityModel, shift: Array) -> int:
    """Stations that plain point-to-plane ICP brings within 0.3 m in plan."""
    hits = 0
    for scan, prior, (_, place) in zip(case.scans, case.priors, case.true, strict=True):
        high = scan.xyz[scan.xyz[:, 2] > prior.position[2]]  # no ground, which the model lacks
        pose = plain_icp(high[:: max(1, len(high) // 5_000)], model)
        off = pose.apply(prior.position[None])[0] - place - shift
        hits += bool(np.hypot(off[0], off[1]) < 0.3)
    return hits


def row(name: str, t: Tally) -> list[str]:
    def rms(values: list[float]) -> str:
        if not values:
            return "-"
        got, low, high = bootstrap(np.square(values), np.mean)
        return f"{1000 * np.sqrt(got):.1f} [{1000 * np.sqrt(low):.1f}, {1000 * np.sqrt(high):.1f}]"

    found = rate_interval(t.stations - t.missed, t.stations)
    band = chi2.ppf([0.025, 0.975], 6 * len(t.nees)) / (6 * len(t.nees))
    return [
        name,
        f"{100 * found[0]:.0f} % [{100 * found[1]:.0f}, {100 * found[2]:.0f}] ({t.flagged} flagged)",
        rms(t.plan),
        rms(t.height),
        f"{np.sqrt(np.mean(np.square(t.ratio))):.2f}",
        f"{np.mean(t.nees):.2f} ({band[0]:.2f} to {band[1]:.2f})",
        f"{len(t.plan) + len(t.height)} of {t.shifts}",
        f"{t.open} of {t.stations}",
        f"{np.median(t.seconds):.1f}",
        f"{t.icp} of {t.stations}",
    ]


def large() -> str:
    """Processor seconds of one station with 2 M points."""
    scene = build_street(SceneSpec(seed=140, houses=4))
    (s,) = scan_stations(
        scene, ScannerSpec(stations=1, spacing=0.021, subrays=1, colour=False, range_max=70.0), 3
    )
    prior = PosePrior(s.true.t, np.array([2.5, 2.5, 1.0]), float(np.radians(7.5)), float(np.radians(0.1)))
    model = models(scene, 0)["office"][0]
    start = time.process_time()
    register([replace(s.scan, grid=None)], model, [prior])
    return f"one station of {len(s.scan) / 1e6:.2f} M points: {time.process_time() - start:.1f} s"


def ingolstadt(folder: Path) -> list[str]:
    """The coarse PTX of the Ingolstadt scene against its LoD2: errors against model and among stations."""
    source = ScanSource(
        path=str(folder / "input/coarse/scan_4cm.ptx"),
        crs="EPSG:25832",
        pose="approximate",
        sigma_position=2.0,
        sigma_heading=4.0,
        sigma_level=0.1,
    )
    scans = read_scans(source)
    world = scans[0].world
    model = read_city_model(folder / "input/lod2/lod2.city.json", world)
    start = time.process_time()
    result = register(scans, model, [prior_of(s) for s in scans])
    took = time.process_time() - start
    stations = json.loads((folder / "truth/truth.json").read_text())["stations"]
    true = [s for s in stations if "coarse" in s["file"]]
    shift = np.mean(list(json.loads((folder / "truth/lod2_shift.json").read_text()).values()), axis=0)
    off, poses = [], []
    for r, s in zip(result.scans, true, strict=True):
        at = np.array(s["position"]) - world.origin
        off.append(r.position - at - shift)
        R = np.array(s["R"]) @ np.array(s["given_R"]).T
        poses.append(
            (Rigid3("local", "s", R, at), Rigid3("local", "s", r.local_from_given.value.R, r.position))
        )
    between = [
        np.linalg.norm(a.inverse.apply(b.t[None]) - c.inverse.apply(d.t[None]))
        for i, (a, c) in enumerate(poses)
        for b, d in poses[:i]
    ]
    sigma = np.array([np.sqrt(np.diag(r.covariance))[:3] for r in result.scans]).mean(0)
    return [
        f"against the model (its mean shift), m: {np.mean(off, 0).round(3)}, sigma {sigma.round(3)}",
        f"stations among each other: {1000 * max(between):.1f} mm; surfaces {1000 * result.agreement:.1f} mm",
        f"explained {[round(r.explained, 2) for r in result.scans]}, {took:.1f} s",
    ]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--spacing", type=float, default=0.06)
    parser.add_argument("--only", default="exact,office")
    parser.add_argument("--scene", type=Path, default=DATA / "ingolstadt_scene")
    args = parser.parse_args()
    tallies = {name: Tally([], [], [], [], [], []) for name in args.only.split(",") if name}
    for seed in range(args.first, args.first + (args.seeds if tallies else 0)):
        scene, case = simulated(seed, args.spacing)
        for name, (model, shift) in models(scene, seed).items():
            if name in tallies:
                measure(
                    tallies[name], case, model, shift, EXACT if name == "exact" else RegistrationOptions()
                )
                tallies[name].icp += icp_hits(case, model, shift)
    head = [
        "model",
        "found",
        "plan mm (rms)",
        "height mm (rms)",
        "plan / (sigma / sqrt walls)",
        "NEES (95 %)",
        "observable shifts",
        "stations with one that is not",
        "s per station",
        "plain ICP within 0.3 m",
    ]
    if tallies:
        table("Simulated streets", head, [row(name, t) for name, t in tallies.items()])
    for name, t in tallies.items():
        worst = ", ".join(f"{1000 * e:.1f} ({1000 * s:.1f})" for e, s in sorted(t.beyond, reverse=True)[:5])
        print(f"{name}: {len(t.beyond)} observable shifts off by more than 1 cm: mm (sigma) {worst}")
    print("\n" + large())
    if args.scene.exists():
        print("\n".join(["\nIngolstadt, coarse PTX to its LoD2:", *ingolstadt(args.scene)]))


if __name__ == "__main__":
    main()
