"""Simulated windows for the benchmark of window bars: one house, the photos that show it, and its scan.

    from _windows import WindowSet, window_scene

    scene = window_scene(WindowSet(seed=3, gsd=0.004, views=4), cache=Path("..."))
    found = find_bars(scene.facade, scene.elements, scene.photos, scene.image_of, scene.scan)
    scene.truth[opening.id].bars        # what was built, in the same facade frame

Only the parts of the photos that show windows are rendered; the rest of each picture is black. Pictures are
kept in `cache` under a hash of all that they depend on.
"""

import hashlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import Any

import cv2
import numpy as np

import _common  # noqa: F401  # puts tests/ on the path
from frontage.geometry.arrays import Array, Float
from frontage.geometry.rigid import Rigid3
from frontage.model import (
    Camera,
    Elements,
    Estimate,
    Facade,
    Layer,
    Opening,
    OpeningKind,
    Photo,
    Protrusion,
    ProtrusionKind,
    Provenance,
    Scan,
    merge_scans,
)
from frontage.simulate.optics.light import LightSpec
from frontage.simulate.scene import FacadePlan, OpeningPlan, Scene
from frontage.simulate.sensors.cameras import CameraSpec
from frontage.simulate.sensors.imaging import develop
from frontage.simulate.sensors.instrument import ScannerSpec
from frontage.simulate.sensors.photograph import lit_scene_of
from frontage.simulate.sensors.render import render
from frontage.simulate.sensors.terrestrial import scan_stations
from frontage.simulate.spec import SceneSpec
from frontage.simulate.street.build import build_street

MARGIN_M = 0.15  # of wall around each window that is rendered
_GLAZED = ("window", "basement", "shopfront")
_VERSION = 2  # raise it when pictures of the same scene come out differently


@dataclass(frozen=True)
class WindowSet:
    """Some windows of a simulated house and how they are recorded.

    seed       of the house, the light and all errors
    gsd        m on the wall per photo px, at right angles to the line of sight
    views      number of photos
    oblique    degrees to the wall's normal from which all photos look; None = from a walk along the street
    position, angle   m per axis and degrees per axis: one sigma of the errors of the photos' poses
    outline    m, one sigma by which each border of an outline is off
    depth      m, one sigma of the measured depth of the frames
    spacing    m between scan points 10 m away; None = no scan
    most       largest number of windows, those nearest the middle of the front; None = all
    house      keys of the house (`HouseSpec`)
    """

    seed: int
    gsd: float = 0.004
    views: int = 4
    oblique: float | None = None
    position: float = 0.0
    angle: float = 0.0
    outline: float = 0.005
    depth: float = 0.02
    spacing: float | None = None
    most: int | None = None
    house: tuple[tuple[str, Any], ...] = (("windows", "varied"),)


@dataclass(frozen=True, eq=False)
class WindowScene:
    """What the estimators are given, and the truth.

    facade, elements   outlines and depths carry the errors of a scan; ids are those of the truth
    photos             with poses as an adjustment gives them; `true_poses` are the right ones, by name
    image_of           the (h, w, 3) uint8 RGB pixels of a photo's name; black where no window is near
    truth              the openings as built, by id, in the frame of the facade
    """

    asked: WindowSet
    facade: Facade
    elements: Elements
    photos: tuple[Photo, ...]
    image_of: Callable[[str], Array]
    scan: Scan | None
    truth: dict[str, OpeningPlan]
    true_poses: dict[str, Rigid3]


def window_scene(asked: WindowSet, cache: Path | None = None) -> WindowScene:
    """Build the house, take the photos (or read them from `cache`) and disturb what a scan would give."""
    scene = _street(asked.seed, asked.house)
    plan = scene.houses[1].facades[0]
    chosen = _chosen(plan, asked.most)
    rng = np.random.default_rng([asked.seed, 0xBA25])
    exact = [_photo(scene, plan, chosen, asked, k) for k in range(asked.views)]
    pictures = {p.id: _picture(scene, plan, chosen, p, asked.seed, cache) for p in exact}
    scan = _scanned(scene, asked, cache)
    facade = _facade(plan, scene, scan)
    return WindowScene(
        asked=asked,
        facade=facade,
        elements=Elements(facade.id, tuple(_as_measured(o, asked, rng) for o in chosen), _oriels(chosen)),
        photos=tuple(_disturbed(p, asked, rng) for p in exact),
        image_of=lambda name: pictures[name](),
        scan=scan,
        truth={o.id: o for o in chosen},
        true_poses={p.id: p.pose for p in exact},
    )


@lru_cache(maxsize=2)
def _street(seed: int, house: tuple[tuple[str, Any], ...]) -> Scene:
    """A terrace of three houses on each side; the middle one of the near side is looked at."""
    rng = np.random.default_rng([seed, 0x57])
    own = {"width": float(rng.uniform(8, 14)), "floors": int(rng.integers(3, 6)), "shutters": False} | dict(
        house
    )
    beside = {"width": 7.0, "floors": 3}
    keys: dict[str, Any] = {"seed": seed, "setting": "terrace", "street_width": float(rng.uniform(13, 20))}
    empty = dict.fromkeys(("trees", "cars", "lamps", "people"), 0)
    houses = {"slope": 0.0, "hedges": False, "houses": 3, "house": [beside, own, beside]}
    return build_street(SceneSpec.model_validate(keys | empty | houses))


def _chosen(plan: FacadePlan, most: int | None) -> tuple[OpeningPlan, ...]:
    """The glazed openings without closed shutters, those nearest the middle of the front first picked."""
    middle = (plan.outline.min(0) + plan.outline.max(0)) / 2
    glazed = [o for o in plan.openings if o.glazed and o.kind in _GLAZED and o.shutters != "closed"]
    away = [float(np.linalg.norm(o.ring.mean(0) - middle)) for o in glazed]
    kept = sorted(np.argsort(away, kind="stable")[:most].tolist())
    return tuple(glazed[k] for k in kept)


def _photo(scene: Scene, plan: FacadePlan, chosen: Sequence[OpeningPlan], asked: WindowSet, k: int) -> Photo:
    """A photo aimed at the middle of the chosen windows, as large as it takes to show them all."""
    rng = np.random.default_rng([asked.seed, k, asked.views, round(10 * (asked.oblique or 0)), 0xCA])
    corners = np.concatenate([_in_space(o.ring, o.wall_y) for o in chosen])
    aim = (corners.min(0) + corners.max(0)) / 2
    width = float(np.ptp(corners[:, 0]))
    eye = _eye(asked, k, aim, width, rng)
    pose = _looking(plan.local_from_facade, eye, aim, float(rng.normal(0, 0.02)))
    focal = float(np.linalg.norm(aim - eye)) / asked.gsd
    lens = [focal, focal, 0.0, 0.0, -0.03 + 0.01 * rng.normal(), 0.01, *(2e-4 * rng.normal(size=2))]
    wide = Camera("OPENCV", 1, 1, np.array(lens))
    around = np.array([MARGIN_M, 0.0, MARGIN_M])
    margin = np.concatenate([corners - around, corners + around])
    seen = wide.project(pose.inverse.apply(plan.local_from_facade.apply(margin)))
    low, high = np.floor(seen.min(0)) - 8, np.ceil(seen.max(0)) + 8
    lens[2:4] = -low
    size = (high - low).astype(int).tolist()
    camera = Camera("OPENCV", size[0], size[1], np.array(lens))
    return Photo(f"view{k + 1}.jpg", camera, _estimate(pose, np.zeros((6, 6))), 4.0 * k)


def _eye(asked: WindowSet, k: int, aim: Float, width: float, rng: np.random.Generator) -> Float:
    """Where the k-th photo is taken from, in the facade frame (y < 0 = the street)."""
    n = asked.views
    if asked.oblique is not None:  # a fan of 20 degrees about the direction, at the height of the windows
        turn = np.radians(asked.oblique + (np.linspace(-10, 10, n)[k] if n > 1 else 0.0))
        side = 1.0 if asked.seed % 2 else -1.0
        away = 9.0 / max(np.cos(np.radians(asked.oblique)), 0.4)
        offset = [side * away * np.sin(turn), -away * np.cos(turn), rng.normal(0, 0.3)]
        return np.asarray(aim + offset)
    away = float(np.random.default_rng([asked.seed, 0xD1]).uniform(7.5, 11.0))
    reach = 0.5 * width + 2.0
    along = 0.0 if n == 1 else float(np.linspace(-reach, reach, n)[k])
    height = (
        1.65 if rng.random() < 0.7 else float(rng.uniform(3.0, 7.0))
    )  # the others from a window or a mast
    return np.array([aim[0] + along + rng.normal(0, 0.4), -away + rng.normal(0, 0.3), height])


def _looking(local_from_facade: Rigid3, eye: Float, aim: Float, roll: float) -> Rigid3:
    forward = (aim - eye) / np.linalg.norm(aim - eye)
    right = np.cross(forward, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    down = np.cross(forward, right)
    c, s = np.cos(roll), np.sin(roll)
    R = np.column_stack([c * right + s * down, c * down - s * right, forward])
    return local_from_facade @ Rigid3("facade", "camera", R, eye)


def _picture(
    scene: Scene,
    plan: FacadePlan,
    chosen: Sequence[OpeningPlan],
    photo: Photo,
    seed: int,
    cache: Path | None,
) -> Callable[[], Array]:
    """Return what reads the pixels of a photo, after making sure that they exist."""
    light = LightSpec()
    key = hashlib.sha256()
    for array in (scene.mesh.vertices, scene.mesh.corners, photo.camera.params, photo.pose.R, photo.pose.t):
        key.update(np.ascontiguousarray(array).tobytes())
    key.update(repr((_VERSION, seed, photo.id, scene.materials, light, [o.id for o in chosen])).encode())
    file = None if cache is None else cache / f"{key.hexdigest()[:24]}.jpg"
    if file is not None and file.exists():
        return lambda: _read(file)
    spec = CameraSpec(model="OPENCV", width=photo.camera.width, height=photo.camera.height, light=light)
    linear = np.zeros((photo.camera.height, photo.camera.width, 3), np.float32)
    lit = lit_scene_of(scene, light)
    for c0, r0, c1, r1 in _crops(plan, chosen, photo):
        params = photo.camera.params.copy()
        params[2:4] -= (c0, r0)
        part = Camera(photo.camera.model, c1 - c0, r1 - r0, params)
        linear[r0:r1, c0:c1] = render(lit, part, photo.pose, spec.samples)
    pixels = develop(linear, spec, np.random.default_rng([seed, 0xF117, int(photo.time or 0)]))
    _, packed = cv2.imencode(".jpg", pixels[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, 92])
    if file is not None:
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_bytes(packed.tobytes())
        return lambda: _read(file)
    return lambda: np.ascontiguousarray(cv2.imdecode(packed, cv2.IMREAD_COLOR)[..., ::-1])


def _read(file: Path) -> Array:
    return np.ascontiguousarray(cv2.imread(str(file))[..., ::-1])


def _crops(plan: FacadePlan, chosen: Sequence[OpeningPlan], photo: Photo) -> list[tuple[int, int, int, int]]:
    """The rectangles (c0, r0, c1, r1) px of a photo that show windows, joined where they overlap much."""
    out = []
    for o in chosen:
        (x0, z0), (x1, z1) = o.ring.min(0) - MARGIN_M, o.ring.max(0) + MARGIN_M
        box = np.array([[x, z] for x in (x0, x1) for z in (z0, z1)])
        deep = np.concatenate([_in_space(box, y) for y in (o.wall_y, o.wall_y + o.depth)])
        px = photo.project(plan.local_from_facade.apply(deep))
        low = np.maximum(np.floor(px.min(0)).astype(int), 0)
        high = np.minimum(np.ceil(px.max(0)).astype(int), [photo.camera.width, photo.camera.height])
        out.append((int(low[0]), int(low[1]), int(high[0]), int(high[1])))
    return out


def _as_measured(plan: OpeningPlan, asked: WindowSet, rng: np.random.Generator) -> Opening:
    """The opening as a scan gives it: borders and depth with errors that its covariance tells."""
    (x0, z0), (x1, z1) = plan.ring.min(0), plan.ring.max(0)
    right = (plan.ring[:, 0] - x0) / (x1 - x0)
    up = (plan.ring[:, 1] - z0) / (z1 - z0)
    off = rng.normal(0, asked.outline, 4)  # left, right, bottom, top
    shift = np.column_stack([(1 - right) * off[0] + right * off[1], (1 - up) * off[2] + up * off[3]])
    k = len(plan.ring)
    J = np.zeros((2 * k, 4))
    J[0::2, 0], J[0::2, 1], J[1::2, 2], J[1::2, 3] = 1 - right, right, 1 - up, up
    sigma = max(asked.depth, 1e-4)
    depth = Estimate(plan.depth + float(rng.normal(0, asked.depth)), np.array([[sigma**2]]), 20.0)
    covariance = J @ J.T * max(asked.outline, 1e-4) ** 2
    return Opening(
        plan.id, OpeningKind(plan.kind), plan.ring + shift, covariance, depth, plan.shape,
        Provenance.MEASURED, 50.0, 0.99, plan.floor, plan.bay,
        photos=tuple(f"view{k + 1}.jpg" for k in range(asked.views)), on=_oriel(plan.wall_y),
    )  # fmt: skip


def _oriel(wall_y: float) -> str:
    return "" if wall_y == 0.0 else f"oriel at {wall_y:.3f}"


def _oriels(chosen: Sequence[OpeningPlan]) -> tuple[Protrusion, ...]:
    """The oriels whose fronts hold windows."""
    fronts = sorted({o.wall_y for o in chosen} - {0.0})
    return tuple(
        Protrusion(
            _oriel(y), ProtrusionKind.ORIEL, np.concatenate([o.ring for o in chosen if o.wall_y == y]), 0.01,
            Estimate(y, np.array([[1e-6]]), 100.0), Provenance.MEASURED, 1.0,
        )
        for y in fronts
    )  # fmt: skip


def _disturbed(photo: Photo, asked: WindowSet, rng: np.random.Generator) -> Photo:
    """The photo with the errors of its pose, and the covariance that belongs to them."""
    angle = np.radians(asked.angle)
    turn, _ = cv2.Rodrigues(rng.normal(0, 1, 3) * angle)
    pose = photo.pose
    moved = Rigid3(
        pose.to, pose.frm, np.asarray(turn) @ pose.R, pose.t + rng.normal(0, 1, 3) * asked.position
    )
    return replace(
        photo, local_from_camera=_estimate(moved, np.diag([asked.position**2] * 3 + [angle**2] * 3))
    )


def _scanned(scene: Scene, asked: WindowSet, cache: Path | None) -> Scan | None:
    """What two stations scan of the surroundings, without colour."""
    if asked.spacing is None:
        return None
    spec = ScannerSpec(
        stations=2, spacing=asked.spacing, field=170, lowest=-20, highest=70, subrays=7, colour=False
    )
    key = hashlib.sha256(scene.mesh.vertices.tobytes())
    key.update(repr((_VERSION, spec, asked.seed)).encode())
    file = None if cache is None else cache / f"{key.hexdigest()[:24]}.npz"
    if file is None or not file.exists():
        scan = merge_scans([s.scan for s in scan_stations(scene, spec, asked.seed)])
        if file is None:
            return scan
        file.parent.mkdir(parents=True, exist_ok=True)
        np.savez(file, xyz=scan.xyz, origins=scan.origins, origin_index=scan.origin_index)
    kept = np.load(file)
    return Scan("scan", kept["xyz"], scene.world, kept["origins"], kept["origin_index"])


def _facade(plan: FacadePlan, scene: Scene, scan: Scan | None) -> Facade:
    """The facade with its frame as planned, and its points in the scan."""
    frame = plan.local_from_facade
    own = frame.inverse.apply(scan.xyz if scan else np.empty((0, 3)))
    (x0, z0), (x1, z1) = plan.outline.min(0), plan.outline.max(0)
    near = (own[:, 0] > x0) & (own[:, 0] < x1) & (own[:, 2] > z0) & (own[:, 2] < z1)
    near &= np.abs(own[:, 1]) < 1.0
    on = near & (np.abs(own[:, 1]) < 0.02)
    sigma = np.array([1e-3] * 3 + [1e-4] * 3)
    return Facade(
        plan.id, plan.id.rsplit("/", 1)[0], Estimate(frame, np.diag(sigma**2), 100.0), scene.world,
        plan.outline, (Layer(0.0, 1e-3, float((x1 - x0) * (z1 - z0)), plan.outline),),
        np.flatnonzero(near), np.flatnonzero(on), max(plan.roughness, 1e-3), 0.02, 1.0, "rays",
    )  # fmt: skip


def _in_space(ring: Float, y: float) -> Float:
    return np.column_stack([ring[:, 0], np.full(len(ring), y), ring[:, 1]])


def _estimate(pose: Rigid3, covariance: Float) -> Estimate[Rigid3]:
    return Estimate(pose, covariance, np.inf, Provenance.GIVEN)
