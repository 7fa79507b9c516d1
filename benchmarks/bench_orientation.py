"""Photos oriented against the scan: ours, the chain of paper B, and pycolmap alone.

    python benchmarks/bench_orientation.py [--quick] [--only paper,ingolstadt] [--seeds 3] [--scenes FOLDER]

Scenes: `paper` = the set-up of paper B (12 MP, lens of 30 mm equivalent, scans at 4 cm; approximate poses
3 m, 10 and 1 degrees off), one street per seed; `band` = the same with another band, damp walls, 8 bit and
moved cars; `repeat` = ten equal window axes on plain plaster; `thirty` = thirty photos of the first street;
`model` and `town` = real buildings; `ingolstadt` and `castle` (photos alone, all poses known) where
present. `--quick` makes one small street instead. Simulated scenes are kept in `--scenes`. Every method
runs in a process of its own on each scene; times are wall times.

A pose is wrong when it is 0.3 m or 1 degree off and was handed over all the same. Sigmas are per axis. The
normalised squared error is 1 when covariances are right. Object points are our tie points intersected with
the poses of each method, compared with the same measurements intersected with the true poses. pycolmap runs
with its defaults and the given cameras; a similarity takes its poses to the true places (`to truth`) or to
the approximate ones (`to GPS`). Places on a line leave the turn about that line open. Intervals are over
photos; photos of one scene are not quite independent.
"""

import argparse
import itertools
import multiprocessing
import sys
import tempfile
import time
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from pathlib import Path

import cv2
import numpy as np

from _castle import HEAD, castle_rows, similarity
from _common import DATA, bootstrap, figure, peak_memory, rate_interval, table
from frontage.geometry.arrays import Float
from frontage.geometry.rigid import Rigid3, rotation_angle
from frontage.io.photos.photoset import PhotoSet
from frontage.io.photos.read import PhotoSource, read_photos
from frontage.io.scans.read import ScanSource, read_scans
from frontage.model import Estimate, Photo, Scan, WorldRef, merge_scans
from frontage.orientation.free import adjusted_block
from frontage.orientation.nouns import Block
from frontage.orientation.orient import orient_photos
from frontage.orientation.paper import orient_as_paper
from frontage.orientation.result import MANY, PRECISE_PX
from frontage.orientation.ties import build_blocks, candidate_pairs, key_points, match_pair
from frontage.orientation.ties.colmap import silent
from frontage.simulate.spec import SceneSpec
from frontage.studies.simulate import simulate

WRONG_M, WRONG_RAD = 0.3, np.radians(1.0)

METHODS = ("ours", "paper", "pycolmap")
BAND = {"wavelength": 1550, "wet": 0.25, "spectral": 1.0, "response": "root", "bits": 8, "moved": 0.8}
TOWN = DATA / "citymodels" / "ingolstadt_lod3"
HOUSES = (
    {"width": 8.5, "floors": 3, "wall": "plaster"},
    {"width": 7.0, "floors": 4, "wall": "brick", "oriel": True},
    {"width": 9.0, "floors": 3, "wall": "plaster", "shutters": True},
)
PLAIN: dict[str, object] = {
    "width": 28.0,
    "floors": 3,
    "columns": 10,
    "wall": "plaster",
    "shape": "rectangle",
    "roughness": 0.001,
    "vertical": 1,
    "horizontal": 0,
    "bars": "grid",
    "roof": "gable",
    "lean": 0.0,
} | dict.fromkeys(("shutters", "balconies", "oriel", "shop", "dormers"), False)


@dataclass(frozen=True)
class Scene:
    """Where a scene lies: its name, scan files, photos, true and approximate cameras, sigmas (m, degrees)."""

    name: str
    scans: tuple[str, ...]
    photos: str
    true: Path
    given: Path
    sigmas: tuple[float, float] = (3.0, 10.0)


@dataclass(frozen=True)
class Found:
    """What a method found of one photo: pose, covariance (6, 6) or None, control points and their rms px.

    `best` is the rms of the 200 with the smallest standard errors, NaN where there are fewer.
    """

    pose: Rigid3
    covariance: Float | None = None
    control: int = 0
    rms: float = np.nan
    best: float = np.nan
    check: float = np.nan


@dataclass(frozen=True)
class Outcome:
    """Poses by photo, seconds, GB, tie points (photo id, number, pixel) and their median standard error m.

    `block` is that of photos without a scan.
    """

    poses: dict[str, Found]
    seconds: float
    memory: float
    ties: tuple[tuple[str, int, Float], ...] = ()
    sigma_points: float = np.nan
    block: Block | None = None


def street(seed: int, *, small: bool = False, **scanner: object) -> dict:
    """The spec of a street as in paper B: photos while walking, turned to both sides."""
    houses, step = (HOUSES[:2], 3.4) if small else (HOUSES, 2.75)
    return {
        "seed": seed,
        "setting": "terrace",
        "street_width": 15.0,
        "slope": 2.0,
        "cars": 2,
        "trees": 1,
        "people": 2,
        "opposite": not small,
        "house": houses,
        "scanners": [{"stations": 2, "spacing": 0.04, **({"field": 180.0} if small else {}), **scanner}],
        "cameras": [walk(seed, 4 if small else 9, step, (1608, 1068) if small else (4288, 2848))],
    }


def walk(seed: int, count: int, step: float, size: tuple[int, int]) -> dict:
    """A series of photos every `step` m, aimed by hand to the right, ahead and to the left in turn."""
    rng = np.random.default_rng([seed, 9])
    turns = (18.0, 0.0, -18.0) if count < 9 else (25.0, 0.0, -25.0)
    places = [
        {
            "along": 1.5 + step * k + rng.normal(0, 0.2),
            "across": -12.5 + rng.normal(0, 0.3),
            "height": 1.65,
            "heading": turns[k % 3] + rng.normal(0, 2.0),
            "pitch": 12.5 + rng.normal(0, 1.5),
            "roll": rng.normal(0, 0.8),
        }
        for k in range(count)
    ]
    sigmas = {"sigma_position": 3.0, "sigma_heading": 10.0, "sigma_level": 1.0}
    lens = {"model": "OPENCV", "width": size[0], "height": size[1], "focal": 30.0}
    return {**lens, **sigmas, "layout": "places", "places": places}


def specs(quick: bool, seeds: int) -> dict[str, dict]:
    """The specs of the simulated scenes by name."""
    if quick:
        return {"quick": street(41, small=True, subrays=7)}
    plain = street(44)
    plain |= {"house": (PLAIN,), "slope": 0.0, "cars": 0, "trees": 0, "people": 0}
    plain["cameras"] = [walk(44, 9, 3.1, (4288, 2848))]
    found = {f"paper {41 + k}": street(41 + k) for k in range(seeds)}
    many = street(41) | {"cameras": [walk(41, 30, 0.85, (4288, 2848))]}
    found |= {"band 41": street(41, **BAND), "repeat 44": plain, "thirty 41": many}
    town = [TOWN / f"{name}.xml" for name in ("4018262", "4018115")]
    if all(path.exists() for path in town):
        lens = {"width": 4000, "height": 3000, "focal": 26.0, "most": 7, "spacing": 3.8, "pitches": [14.0]}
        sigmas = {"sigma_position": 3.0, "sigma_heading": 10.0, "sigma_level": 1.0}
        scanner, traffic = {"stations": 2, "spacing": 0.04}, {"cars": 3, "trees": 1, "people": 3}
        model = {"from_model": [str(p) for p in town], "cameras": [{**lens, **sigmas}]}
        found["model 42"] = {"seed": 42, "scanners": [scanner], **traffic, **model}
        found |= towns()
    return found


def towns() -> dict[str, dict]:
    """Groups of real buildings with few photos for the length of their fronts."""

    def town(seed: int, names: str, scanner: dict, *cameras: tuple, **traffic: int) -> dict:
        sigmas = {"sigma_position": 3.0, "sigma_heading": 10.0, "sigma_level": 1.0}
        keys = ("width", "height", "focal", "most", "spacing", "pitches")
        lenses = [dict(zip(keys, (*camera[:-1], [camera[-1]]), strict=True)) | sigmas for camera in cameras]
        files = [str(TOWN / f"{name}.xml") for name in names.split()]
        return {"seed": seed, "from_model": files, "scanners": [scanner], "cameras": lenses, **traffic}

    two = {"stations": 2}
    return {
        "town 101": town(
            101, "4018257 4018258 4018260", two | {"spacing": 0.03},
            (4000, 3000, 24.0, 8, 4.5, 12.0), cars=4, trees=2, people=3,
        ),
        "town 102": town(
            102, "4018270", two | {"spacing": 0.05},
            (3264, 2448, 28.0, 9, 5.0, 8.0), cars=3, trees=2, people=2,
        ),
        "town 103": town(
            103, "4018115 4018150a", {"stations": 1, "spacing": 0.05, **BAND},
            (3264, 2448, 26.0, 7, 3.0, 12.0), cars=2, trees=1, people=4,
        ),
        "town 104": town(
            104, "4018267", two | {"spacing": 0.04, **BAND},
            (4000, 3000, 35.0, 10, 3.5, 10.0), cars=3, trees=3, people=2,
        ),
        "town 105": town(
            105, "4018152a 4018152b 4018262", two | {"spacing": 0.02},
            (4000, 3000, 24.0, 7, 3.0, 15.0), (2000, 1500, 30.0, 5, 4.0, 10.0), cars=3, trees=2, people=2,
        ),
        "town 106": town(
            106, "4018194 4018260", two | {"spacing": 0.03},
            (4000, 3000, 26.0, 9, 3.5, 12.0), cars=3, trees=2, people=3,
        ),
        "town 107": town(
            107, "4018150b 4018152a", two | {"spacing": 0.04},
            (3264, 2448, 28.0, 8, 4.0, 12.0), cars=2, trees=1, people=2,
        ),
        "town 108": town(
            108, "4018257 4018267", two | {"spacing": 0.03, **BAND},
            (4000, 3000, 28.0, 11, 3.5, 14.0), cars=4, trees=3, people=3,
        ),
        "town 109": town(
            109, "4018270 4018258", two | {"spacing": 0.03},
            (4000, 3000, 30.0, 13, 3.0, 10.0), cars=4, trees=2, people=3,
        ),
        "town 110": town(
            110, "4018262", {"stations": 1, "spacing": 0.02},
            (4608, 3456, 24.0, 7, 3.0, 15.0), cars=2, trees=1, people=2,
        ),
    }  # fmt: skip


def simulated(name: str, spec: dict, folder: Path) -> Scene:
    """The scene of a spec, made unless the folder has it."""
    out = simulate(
        SceneSpec.model_validate({"name": name, **spec}), folder / name.replace(" ", "_"), workers=2
    ).out
    scans = tuple(str(p) for p in sorted((out / "scans").glob("S*.e57")))
    return Scene(name, scans, str(out / "photos"), out / "cameras", out / "cameras_approximate")


def ingolstadt(spacing: str) -> Scene:
    folder = DATA / "ingolstadt_scene" / "input"
    scan = folder / "registered" / {"2cm": "scan_2cm.e57", "4cm": "scan_4cm.laz"}[spacing]
    true, given = folder / "registered" / "colmap", folder / "coarse" / "colmap"
    return Scene(f"ingolstadt {spacing}", (str(scan),), str(folder / "photos"), true, given, (2.0, 5.0))


def read(scene: Scene) -> tuple[list[Scan], PhotoSet, PhotoSet]:
    """Scans, photos with approximate poses, photos with true poses; the castle has no scans."""
    scans: list[Scan] = []
    for path in scene.scans:
        scans += read_scans(ScanSource(path=path), scans[0].world if scans else None, "EPSG:25832")
    world = scans[0].world if scans else WorldRef(np.zeros(3, np.int64))
    offset = scene.true / "offset.txt"
    at = tuple(np.loadtxt(offset).ravel().tolist()) if offset.exists() else (0.0, 0.0, 0.0)
    metres, degrees = scene.sigmas
    sigmas = {"pose": "approximate", "sigma_position": metres, "sigma_angle": degrees}
    given = PhotoSource(path=scene.photos, cameras=str(scene.given), offset=at, **sigmas)
    true = PhotoSource(path=scene.photos, cameras=str(scene.true), offset=at)
    return scans, read_photos(given, world), read_photos(true, world)


def measure(scene: Scene, method: str) -> Outcome:
    """Runs a method on a scene; the castle has only photos."""
    scans, given, _ = read(scene)
    start = time.perf_counter()
    if method == "pycolmap":
        poses, rest = by_pycolmap(given), ((), np.nan)
    elif method == "paper":
        found = orient_as_paper(given.photos, scans, given.image)
        poses = {
            p.id: Found(p.photo.pose, p.photo.local_from_camera.covariance, len(p.xyz), p.rms)
            for p in found
            if p.photo is not None
        }
        rest = ((), np.nan)
    else:
        poses, *rest = by_us(scans, given)
    return Outcome(poses, time.perf_counter() - start, peak_memory(), *rest)


def by_pycolmap(given: PhotoSet) -> dict[str, Found]:
    """pycolmap's defaults on the photos with the given cameras: the largest model, in a frame of its own."""
    folder = Path(next(iter(given.pixels.values())).path).parent
    with tempfile.TemporaryDirectory() as work, silent() as colmap:
        database = Path(work) / "database.db"
        key = lambda p: (p.camera.model, p.camera.width, tuple(p.camera.params))  # noqa: E731
        for (model, _, params), group in itertools.groupby(sorted(given.photos, key=key), key):
            reader = colmap.ImageReaderOptions(
                camera_model=model, camera_params=",".join(repr(float(p)) for p in params)
            )
            names = [Path(given.pixels[p.id].path).name for p in group]
            single = colmap.CameraMode.SINGLE
            colmap.extract_features(database, folder, names, camera_mode=single, reader_options=reader)
        colmap.match_exhaustive(database)
        models = colmap.incremental_mapping(database, folder, work)
        if not models:
            return {}
        largest = max(models.values(), key=lambda m: m.num_reg_images())
        name_of = {Path(source.path).name: photo for photo, source in given.pixels.items()}
        poses = {}
        for number in largest.reg_image_ids():
            motion = largest.image(number).cam_from_world().inverse()
            pose = Rigid3("local", "camera", motion.rotation.matrix(), motion.translation)
            poses[name_of[largest.image(number).name]] = Found(pose)
    return poses


def by_us(scans: list[Scan], given: PhotoSet) -> tuple[dict[str, Found], tuple, float, Block | None]:
    photos = given.photos if scans else tuple(Photo(p.id, p.camera) for p in given.photos)
    points = [key_points(given.image(p.id)) for p in photos]
    pairs = [
        match_pair(points[i], points[j], photos[i].camera, photos[j].camera, first=i, second=j)
        for i, j in candidate_pairs(photos, points)
    ]
    blocks = build_blocks(photos, points, [pair for pair in pairs if pair is not None])
    if not scans:
        block = adjusted_block(blocks.blocks[0])
        poses = {p.id: Found(p.pose, p.local_from_camera.covariance) for p in block.photos}
        return poses, (), np.nan, block
    got = orient_photos(photos, blocks, merge_scans(scans), given.image)
    poses = {
        o.photo.id: Found(
            o.photo.pose,
            o.photo.local_from_camera.covariance,
            o.control,
            o.control_rms,
            o.precise_rms,
            o.check_rms,
        )
        for o in got.photos
    }
    names = [o.photo.id for o in got.photos]
    ties = tuple(
        (names[k], n, xy) for k, n, xy in zip(got.photo.tolist(), got.point.tolist(), got.pixels, strict=True)
    )
    return poses, ties, float(np.nanmedian(got.sigma_points)), None


def on_places(poses: dict[str, Found], photos: dict[str, Photo]) -> dict[str, Found]:
    """Poses moved by the similarity that fits their places best to those of `photos` (Umeyama 1991)."""
    if len(poses) < 3:
        return {}
    a = np.array([found.pose.t for found in poses.values()])
    R, scale, shift = similarity(a, np.array([photos[name].pose.t for name in poses]))
    turned = np.kron(np.diag([scale, 1.0]), R)
    return {
        name: Found(
            Rigid3("local", "camera", R @ f.pose.R, scale * R @ f.pose.t + shift),
            None if f.covariance is None else turned @ f.covariance @ turned.T,
        )
        for name, f in poses.items()
    }


def intersected(ties: tuple[tuple[str, int, Float], ...], photos: dict[str, Photo], count: int) -> Float:
    """Points (n, 3) m nearest to the rays of their measurements; NaN with fewer than two rays."""
    normal, right, rays = np.zeros((count, 3, 3)), np.zeros((count, 3)), np.zeros(count)
    for name, photo in photos.items():
        mine = [(n, xy) for other, n, xy in ties if other == name]
        if not mine:
            continue
        number = np.array([n for n, _ in mine])
        origin, ray = photo.ray(np.array([xy for _, xy in mine]))
        across = np.eye(3) - ray[:, :, None] * ray[:, None, :]
        np.add.at(normal, number, across)
        np.add.at(right, number, across @ origin)
        np.add.at(rays, number, 1)
    xyz = np.full((count, 3), np.nan)
    good = rays >= 2
    xyz[good] = np.linalg.solve(normal[good], right[good, :, None])[..., 0]
    return xyz


def with_poses(photos: dict[str, Photo], poses: dict[str, Found]) -> dict[str, Photo]:
    """The photos that have a pose, with it."""
    none = np.zeros((6, 6))
    return {
        name: replace(photos[name], local_from_camera=Estimate(found.pose, none, 0.0))
        for name, found in poses.items()
    }


class Tally:
    """Figures of a method over photos: what the rows of the tables are made of."""

    def __init__(self) -> None:
        self.photos = self.found = self.wrong = 0
        self.position, self.angle, self.nees = list[float](), list[float](), list[float]()
        self.sigma, self.sigma_angle = list[float](), list[float]()
        self.control, self.rms = list[float](), list[float]()
        self.best, self.check = list[float](), list[float]()
        self.points, self.sigma_points, self.seconds, self.memory = [], [], list[float](), list[float]()

    def add(self, poses: dict[str, Found], true: dict[str, Photo], outcome: Outcome) -> None:
        """Counts the poses of one scene; errors are those of right ones."""
        self.photos += len(true)
        self.seconds.append(outcome.seconds)
        self.memory.append(outcome.memory)
        for name, found in poses.items():
            off = found.pose.t - true[name].pose.t
            turn = found.pose.R @ true[name].pose.R.T
            angle = rotation_angle(turn)
            if np.linalg.norm(off) > WRONG_M or angle > WRONG_RAD:
                self.wrong += 1
                continue
            self.found += 1
            self.position.append(1000 * float(np.linalg.norm(off)))
            self.angle.append(float(np.degrees(angle)))
            if found.covariance is not None:
                error = np.concatenate([off, cv2.Rodrigues(turn)[0][:, 0]])
                self.nees.append(float(error @ np.linalg.solve(found.covariance, error)) / 6)
                sigma = np.sqrt(np.diag(found.covariance))
                self.sigma.append(1000 * float(np.sqrt((sigma[:3] ** 2).mean())))
                self.sigma_angle.append(float(np.degrees(np.sqrt((sigma[3:] ** 2).mean()))))
                self.control.append(found.control)
                self.rms.append(found.rms)
                self.best.append(found.best)
                self.check.append(1000 * found.check)

    def add_points(self, ties: tuple, poses: dict[str, Found], true: dict[str, Photo], sigma: float) -> None:
        """Errors of object points intersected with the right poses of a scene."""
        good = {
            name: f
            for name, f in poses.items()
            if np.linalg.norm(f.pose.t - true[name].pose.t) < WRONG_M
            and rotation_angle(f.pose.R @ true[name].pose.R.T) < WRONG_RAD
        }
        some = tuple(tie for tie in ties if tie[0] in good)
        if not some:
            return
        count = 1 + max(n for _, n, _ in some)
        ours = intersected(some, with_poses(true, good), count)
        theirs = intersected(some, {name: true[name] for name in good}, count)
        error = np.linalg.norm(ours - theirs, axis=1)
        error = error[np.isfinite(error)]
        if len(error):
            self.points.append(1000 * float(np.median(error)))
            self.sigma_points.append(1000 * sigma)

    def poses_row(self, name: str, method: str) -> list[str]:
        """A row of the table of poses."""
        rate, low, high = rate_interval(self.found, self.photos)
        return [
            name,
            method,
            f"{self.found} of {self.photos}: {100 * rate:.0f} % [{100 * low:.0f}, {100 * high:.0f}]",
            str(self.wrong),
            *(spread(values) for values in (self.position, self.angle)),
            *(middle(values) for values in (self.sigma, self.sigma_angle)),
            figure(bootstrap(self.nees, np.mean), digits=2) if self.nees else "-",
            f"{sum(self.seconds):.0f}",
            f"{max(self.memory):.1f}",
        ]

    def control_row(self, name: str, method: str) -> list[str]:
        """A row of the table of control and object points."""
        return [
            name,
            method,
            figure(bootstrap(self.control)) if self.control else "-",
            f"{min(self.control):.0f}" if self.control else "-",
            figure(bootstrap(self.rms), digits=2) if self.rms else "-",
            f"{sum(b <= PRECISE_PX for b in self.best)} of {len(self.best)}" if self.best else "-",
            middle(self.check),
            middle(self.points),
            middle(self.sigma_points),
        ]


def spread(values: list[float]) -> str:
    """The median with its interval, and the largest."""
    return f"{figure(bootstrap(values))}, max {max(values):.3g}" if values else "-"


def middle(values: list[float]) -> str:
    known = [v for v in values if np.isfinite(v)]
    return f"{np.median(known):.2g}" if known else "-"


def compare(scene: Scene, methods: list[str], tallies: dict[tuple[str, str], Tally]) -> list[list[str]]:
    """Runs the methods on a scene, each in a process of its own, and counts what they found.

    Returns rows on the standard errors of photos without a scan.
    """
    _, given, photos = read(scene)
    true, approximate = ({p.id: p for p in which.photos} for which in (photos, given))
    kind = scene.name.split()[0] if scene.name.startswith("paper") else scene.name
    ties: tuple = ()
    rows: list[list[str]] = []
    for method in methods:
        if method == "paper" and not scene.scans:
            continue
        with ProcessPoolExecutor(1, multiprocessing.get_context("spawn")) as pool:
            outcome = pool.submit(measure, scene, method).result()
        print(f"{scene.name}, {method}: {outcome.seconds:.0f} s", file=sys.stderr, flush=True)
        ties = outcome.ties or ties
        results = {method: outcome.poses}
        if method == "pycolmap" or not scene.scans:
            results = {f"{method}, to truth": on_places(outcome.poses, true)}
            if scene.scans:
                results[f"{method}, to GPS"] = on_places(outcome.poses, approximate)
        for label, poses in results.items():
            tally = tallies.setdefault((kind, label), Tally())
            tally.add(poses, true, outcome)
            tally.add_points(ties, poses, true, outcome.sigma_points)
            print(" | ".join(tally.poses_row(kind, label)), file=sys.stderr, flush=True)
        if outcome.block is not None:
            rows += castle_rows(outcome.block, [true[photo.id] for photo in outcome.block.photos])
    return rows


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="one small street, nothing else")
    parser.add_argument("--only", default="", help="kinds of scenes, separated by commas")
    parser.add_argument("--methods", default=",".join(METHODS))
    parser.add_argument("--seeds", type=int, default=3, help="streets as in the paper")
    parser.add_argument("--scenes", type=Path, help="where simulated scenes are kept")
    args = parser.parse_args()
    only = [kind for kind in args.only.split(",") if kind]
    tallies: dict[tuple[str, str], Tally] = {}
    alone: list[list[str]] = []
    with tempfile.TemporaryDirectory() as temporary:
        folder = args.scenes or Path(temporary)
        for scene in scenes(args.quick, only, args.seeds, folder):
            alone += compare(scene, args.methods.split(","), tallies)
    head = ("scene", "method", "right (95 %)", "wrong", "position mm", "angle deg", "sigma mm", "sigma deg")
    rows = [tally.poses_row(*name) for name, tally in tallies.items()]
    table("Poses of photos (medians)", (*head, "normalised squared error", "s", "GB"), rows)
    head = ("scene", "method", "control points of a photo", "fewest", "rms px")
    rows = [tally.control_row(*name) for name, tally in tallies.items() if tally.control or tally.points]
    if rows:
        head = (*head, f"photos with {MANY} at {PRECISE_PX} px", "left-out control mm")
        table("Control and object points (medians)", (*head, "object points mm", "their sigma mm"), rows)
    if alone:
        table("Photos alone: differences of poses and their standard errors (medians)", HEAD, alone)


def scenes(quick: bool, only: list[str], seeds: int, folder: Path) -> Iterator[Scene]:
    """The scenes asked for, one after the other."""
    for name, spec in specs(quick, seeds).items():
        if not only or name.split()[0] in only:
            yield simulated(name, spec, folder)
    if quick and not only:
        return
    if (DATA / "ingolstadt_scene").exists() and (not only or "ingolstadt" in only):
        yield ingolstadt("2cm")
        yield ingolstadt("4cm")
    castle = DATA / "castle_photos"
    if castle.exists() and (not only or "castle" in only):
        yield Scene("castle", (), str(castle / "images"), castle / "colmap", castle / "colmap")


if __name__ == "__main__":
    main()
