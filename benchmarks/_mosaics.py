"""Simulated streets photographed from several places, for the benchmark of mosaics.

Between two photos cars and pedestrians move or go, and every photo has its own exposure and white balance.
The facades are the true ones, so that nothing but the picture is judged.
"""

from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np

from frontage.geometry.arrays import Array, Bool
from frontage.model import Estimate, Facade, OrthoImage, Photo, Scan
from frontage.model.scan import merge_scans
from frontage.ortho import OrthoOptions
from frontage.ortho.bands import Bands
from frontage.ortho.mosaic.compose import compose_mosaic
from frontage.ortho.occluders import find_occluders
from frontage.ortho.orthoraster import facade_raster
from frontage.ortho.photo_image import paint_photos
from frontage.ortho.points import facade_points
from frontage.ortho.rectified import CellPhotos
from frontage.ortho.relief import measure_relief
from frontage.ortho.standing.find import find_standing
from frontage.ortho.surface import DrawingSurface
from frontage.ortho.views import plan_views
from frontage.simulate.optics.rays import Tracer
from frontage.simulate.scene import FacadePlan, Part, Scene
from frontage.simulate.sensors.cameras import CameraSpec
from frontage.simulate.sensors.instrument import ScannerSpec
from frontage.simulate.sensors.photograph import iter_photographs
from frontage.simulate.sensors.terrestrial import scan_stations
from frontage.simulate.sensors.traffic import with_moved_traffic
from frontage.simulate.sensors.viewpoints import plan_photos
from frontage.simulate.spec import SceneSpec
from frontage.simulate.street.build import build_street
from frontage.simulate.truth.ortho import true_ortho

LOOSE = (Part.TREE, Part.CAR, Part.LAMP, Part.PERSON)
SCAN_M = 0.03  # spacing of the scans
MOVED = 0.7  # share of cars and pedestrians that move between two photos
BEFORE_M = 0.03  # a line of sight ends so far before the surface that it leads to
NEAR_M = 2.0  # points so near the plane belong to the facade
SAMPLED = 4  # every so many pixels, along rows and columns, a line of sight is followed


@dataclass(frozen=True)
class StreetCase:
    """A street and how it is photographed: stops of exposure (one sigma), clouds (0..1), things before it."""

    seed: int
    exposure: float
    overcast: float
    trees: int
    cars: int
    people: int


CASES = (
    StreetCase(seed=3, exposure=0.75, overcast=1.0, trees=2, cars=2, people=3),
    StreetCase(seed=11, exposure=0.75, overcast=0.1, trees=1, cars=2, people=2),
    StreetCase(seed=7, exposure=0.3, overcast=0.6, trees=2, cars=1, people=4),
)


@dataclass(frozen=True)
class Street:
    """What was recorded: a scan of the street as it is, and photos (n) of n moments of it."""

    scene: Scene
    moments: tuple[Scene, ...]
    scan: Scan
    photos: tuple[Photo, ...]
    images: dict[str, Array]


@dataclass(frozen=True)
class Single:
    """One photo on the facade: pixels (h, w, 3) uint8, what it shows (h, w), gsd (h, w) m."""

    pixels: Array
    shown: Bool
    gsd: Array


@dataclass(frozen=True)
class SeenWall:
    """The truth at the pixels of an ortho-image.

    rgb     (h, w, 3) uint8, the facade in even light
    wall    (h, w) bool, what shows the facade and is no glass
    glass   (h, w) bool
    at      rows (m,), columns (n,) of the pixels that lines of sight were followed to
    clear   (photos, m, n) bool, seen by the photo with nothing in between
    behind  (photos, m, n) bool, behind a tree, car, lamp or pedestrian
    """

    rgb: Array
    wall: Bool
    glass: Bool
    at: tuple[Array, Array]
    clear: Bool
    behind: Bool


def record(case: StreetCase, photos: int = 7, width: int = 1600) -> Street:
    """Scan a street of two houses and take its photos, each at another moment."""
    given: dict[str, Any] = {"seed": case.seed, "houses": 2, "opposite": False, "setting": "terrace"}
    given |= {"lamps": 1, "hedges": False, "street_width": 16, "slope": 0}
    spec = SceneSpec.model_validate(given | {"trees": case.trees, "cars": case.cars, "people": case.people})
    camera = CameraSpec.model_validate(
        {
            "width": width,
            "height": width,
            "focal": 22,
            "most": photos,
            "spacing": 2.0,
            "samples": 4,
            "pitches": (16.0,),
        }
        | {"exposure_jitter": case.exposure, "white_balance_jitter": 0.06}
        | {"light": {"overcast": case.overcast, "sun_elevation": 42, "sun_azimuth": 35}}
    )
    scanner = ScannerSpec.model_validate(
        {"stations": 2, "spacing": SCAN_M, "field": 170, "lowest": -25, "highest": 60, "subrays": 1}
    )
    scene = build_street(spec)
    scans = scan_stations(scene, scanner, case.seed)
    count = len(plan_photos(scene, camera, case.seed))
    moments = tuple(with_moved_traffic(scene, MOVED, 100 * case.seed + k + 1) for k in range(count))
    shots = [next(iter_photographs(moments[k], camera, case.seed, only=[k])) for k in range(count)]
    return Street(
        scene,
        moments,
        merge_scans([s.scan for s in scans]),
        tuple(s.photo for s in shots),
        {s.photo.id: s.image for s in shots},
    )


def front(street: Street, house: int, spacing: float = SCAN_M) -> Facade:
    """The true street facade of a house, with the points of the scan, `spacing` m apart, that lie near it."""
    plan = street.scene.houses[house].facades[0]
    xyz = plan.local_from_facade.inverse.apply(street.scan.xyz)
    (x0, z0), (x1, z1) = plan.outline.min(0), plan.outline.max(0)
    near = (np.abs(xyz[:, 1]) < NEAR_M) & (xyz[:, 0] > x0) & (xyz[:, 0] < x1)
    support = np.flatnonzero(near & (xyz[:, 2] > z0) & (xyz[:, 2] < z1))
    pose = Estimate(plan.local_from_facade, np.eye(6) * 1e-8, 100.0)
    inliers = support[np.abs(xyz[support, 1]) < 0.03]
    world, name = street.scan.world, street.scene.houses[house].id
    return Facade(
        f"{name}/F1", name, pose, world, plan.outline, (), support, inliers, 0.004, spacing, 1.0, "rays"
    )


def single_photos(street: Street, facade: Facade, options: OrthoOptions) -> list[Single]:
    """Every photo alone on the facade, without what the scan knows to stand before it."""
    raster = facade_raster(facade, options)
    standing = find_standing(facade, street.scan)
    points = facade_points(street.scan, facade, raster, standing, options)
    relief = measure_relief(points.xyz_used, facade, raster, options, points.gaps)
    surface = DrawingSurface(facade, raster, relief)
    occluders = find_occluders(facade, points.xyz, standing, None, options, street.scan)
    out = []
    for photo in street.photos:
        bands, plan = Bands(raster), plan_views(surface, occluders, [photo], options)
        image_of = street.images.__getitem__
        cells = plan and CellPhotos(surface.on(plan.cells, plan.depth), options.projection, image_of)
        mosaic = compose_mosaic(surface, plan, cells, options, {})
        paint_photos(bands, surface, mosaic, image_of, options)
        gsd = np.where(bands.source > 0, bands.gsd, np.inf)
        out.append(Single(bands.pixels[..., :3], bands.source > 0, gsd))
    return out


def seen_wall(street: Street, house: int, ortho: OrthoImage) -> SeenWall:
    """The truth at the pixels of an ortho-image of the facade that `front` returned."""
    plan = street.scene.houses[house].facades[0]
    truth = true_ortho(street.scene, house, 0, ortho.gsd)
    w, h = ortho.size
    x = ortho.corner[0] + (np.arange(w) + 0.5) * ortho.gsd
    z = ortho.corner[1] - (np.arange(h) + 0.5) * ortho.gsd
    u = ((x - truth.corner[0]) / truth.gsd - 0.5).astype(np.float32)
    v = ((truth.corner[1] - z) / truth.gsd - 0.5).astype(np.float32)
    to = (np.broadcast_to(u, (h, w)).copy(), np.broadcast_to(v[:, None], (h, w)).copy())

    def moved(band: Array, how: int) -> Array:
        return cv2.remap(band, *to, how, borderMode=cv2.BORDER_CONSTANT, borderValue=-1)

    surface = moved(truth.surface.astype(np.float32), cv2.INTER_NEAREST).astype(np.int64)
    part = np.where(surface >= 0, street.scene.parts[surface], -1)
    inside = (x > plan.outline[:, 0].min()) & (x < plan.outline[:, 0].max())
    hole = moved(truth.opening.astype(np.float32), cv2.INTER_NEAREST) > 0
    shown = (surface >= 0) & inside & ~np.isin(part, (Part.GROUND, Part.ROOF, *LOOSE))
    glass = shown & hole & (part == Part.PANE)
    rows, columns = np.arange(SAMPLED // 2, h, SAMPLED), np.arange(SAMPLED // 2, w, SAMPLED)
    depth = moved(truth.depth, cv2.INTER_NEAREST)[np.ix_(rows, columns)]
    clear, behind = _sight(street, plan, x[columns], z[rows], depth)
    known = shown[np.ix_(rows, columns)]
    wall = shown & ~np.isin(part, (Part.PANE, Part.ROOM))
    return SeenWall(
        moved(truth.rgb, cv2.INTER_LINEAR), wall, glass, (rows, columns), clear & known, behind & known
    )


def _sight(street: Street, plan: FacadePlan, x: Array, z: Array, depth: Array) -> tuple[Bool, Bool]:
    """Which points (m, n) of the surface each photo sees, and which lie behind something that stands free."""
    px, pz = np.meshgrid(x, z)
    xyz = plan.local_from_facade.apply(
        np.column_stack([px.ravel(), np.nan_to_num(depth).ravel() - 0.01, pz.ravel()])
    )
    clear, behind = [], []
    for photo, moment in zip(street.photos, street.moments, strict=True):
        at = photo.project(xyz)
        with np.errstate(invalid="ignore"):
            inside = ((at > 1) & (at < [photo.camera.width - 1, photo.camera.height - 1])).all(1)
        ray = xyz - photo.pose.t
        reach = np.linalg.norm(ray, axis=1)
        ray, start = ray / reach[:, None], np.broadcast_to(photo.pose.t, xyz.shape)
        loose = np.isin(moment.parts[moment.mesh.surface], LOOSE)
        stands = Tracer(moment.mesh, loose).blocked(start, ray, reach - BEFORE_M)
        house = Tracer(moment.mesh, ~loose).blocked(start, ray, reach - BEFORE_M)
        clear.append((inside & ~stands & ~house).reshape(px.shape))
        behind.append((inside & stands).reshape(px.shape))
    return np.stack(clear), np.stack(behind)
