"""The time of one large facade against the decoding of its photos, and the memory for 200 photos."""

import pickle
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np

import ortho_wall as wall
from _common import bootstrap, figure, peak_memory, table
from _mosaics import MOVED, Street, front
from frontage.geometry.arrays import Array
from frontage.io.photos.decoder import decode
from frontage.model import Facade, OrthoImage, Photo, Scan
from frontage.model.scan import merge_scans
from frontage.ortho import OrthoOptions, make_ortho
from frontage.ortho.bands import Bands
from frontage.ortho.orthoraster import facade_raster
from frontage.ortho.points import facade_points
from frontage.ortho.project import plane_homography
from frontage.ortho.relief import measure_relief
from frontage.ortho.scan_image import intensity_band
from frontage.ortho.standing.find import find_standing
from frontage.scale.executor import keep_freed_memory
from frontage.simulate.sensors.cameras import CameraSpec
from frontage.simulate.sensors.instrument import ScannerSpec
from frontage.simulate.sensors.photograph import iter_photographs
from frontage.simulate.sensors.terrestrial import scan_stations
from frontage.simulate.sensors.traffic import with_moved_traffic
from frontage.simulate.sensors.viewpoints import plan_photos
from frontage.simulate.spec import SceneSpec
from frontage.simulate.street.build import build_street

SEED = 5
GSD = 0.01
QUALITY = [cv2.IMWRITE_JPEG_QUALITY, 97]
NOISE = 3.0  # codes, one sigma: files of 0.4 bytes per pixel, as cameras write them
REPEAT = 5
SPACING_M = 0.02  # of the scan
FACADES, WIDTH_M, HEIGHT_M = 8, 25.0, 12.0  # of the long street
PHOTOS, STEP_M, AWAY_M = 200, 1.0, 15.0
PERIOD = 10  # photos after which the wall of the long street looks the same


@dataclass(frozen=True)
class LargeFront:
    """A facade of 30 x 15 m, its scan, six photos of 12 MP and the bytes of their files."""

    facade: Facade
    scan: Scan
    photos: tuple[Photo, ...]
    files: dict[str, bytes]


def large_front(folder: Path | None) -> LargeFront:
    """Simulates the facade with trees, cars and walkers before it; with a `folder` only the first time."""
    kept = None if folder is None else folder / "large_front.pickle"
    if kept is not None and kept.exists():
        return pickle.loads(kept.read_bytes())
    house = {"width": 30.0, "floors": 4, "floor_height": 3.4, "ground_floor_height": 4.0, "columns": 10}
    given: dict[str, Any] = {"seed": SEED, "houses": 1, "house": [house | {"roof": "gable"}], "slope": 0}
    given |= {"opposite": False, "setting": "terrace", "hedges": False, "street_width": 18}
    scene = build_street(SceneSpec.model_validate(given | {"lamps": 1, "trees": 2, "cars": 2, "people": 3}))
    camera = CameraSpec.model_validate(
        {"width": 4000, "height": 3000, "focal": 20, "most": 6, "spacing": 4.5, "samples": 1}
        | {"exposure_jitter": 0.5, "white_balance_jitter": 0.05}
        | {"light": {"overcast": 0.5, "sun_elevation": 42, "sun_azimuth": 35}}
    )
    scanner = ScannerSpec.model_validate(
        {"stations": 2, "spacing": SPACING_M, "field": 170, "lowest": -25, "highest": 60, "subrays": 1}
    )
    scan = merge_scans([s.scan for s in scan_stations(scene, scanner, SEED)])
    moments = [
        with_moved_traffic(scene, MOVED, 100 * SEED + k) for k in range(len(plan_photos(scene, camera, SEED)))
    ]
    shots = [next(iter_photographs(m, camera, SEED, only=[k])) for k, m in enumerate(moments)]
    photos = tuple(s.photo for s in shots)
    facade = front(Street(scene, tuple(moments), scan, photos, {}), 0, spacing=SPACING_M)
    files = {s.photo.id: _jpeg(s.image) for s in shots}
    made = LargeFront(facade, scan, photos, files)
    if kept is not None:
        kept.parent.mkdir(parents=True, exist_ok=True)
        kept.write_bytes(pickle.dumps(made))
    return made


def _jpeg(rgb: Array) -> bytes:
    return bytes(cv2.imencode(".jpg", rgb[..., ::-1], QUALITY)[1].tobytes())


def time_of_a_large_front(folder: Path | None) -> None:
    """Prints processor times of the whole image, of its parts and of paper A, over that of the decoding.

    Everything runs in one thread and uses freed memory again, as in worker processes. Rendered photos are
    smooth, and files of cameras decode more slowly, so the times are told for photos with the noise of a
    sensor, too.
    """
    cv2.setNumThreads(1)
    keep_freed_memory()
    case = large_front(folder)
    columns = [_times(case, case.files), _times(case, _with_noise(case.files))]
    rows = [[name, *(figure(bootstrap(found[name])) for found in columns)] for name in columns[0]]
    w, h = np.ptp(case.facade.outline, axis=0)
    title = f"{w:.0f} x {h:.0f} m at 1 cm from six photos of 12 MP, {len(case.scan.xyz)} points"
    table(f"{title}: processor time over that of decoding", ["what", "as rendered", "with noise"], rows)


def _times(case: LargeFront, files: dict[str, bytes]) -> dict[str, list[float]]:
    """Times over that of decoding, by name of the work, with files (by photo) of the front."""
    options = OrthoOptions(gsd=GSD)

    def image(name: str) -> Array:
        return decode(files[name], name)

    def decoded() -> list[Array]:
        return [image(photo.id) for photo in case.photos]

    def everything() -> None:
        made = make_ortho(case.facade, case.scan, case.photos, image, options=options)
        assert isinstance(made, OrthoImage)

    def scan_only() -> None:
        raster = facade_raster(case.facade, options)
        standing = find_standing(case.facade, case.scan)
        points = facade_points(case.scan, case.facade, raster, standing, options)
        relief = measure_relief(points.xyz_used, case.facade, raster, options, points.gaps)
        Bands(raster, relief)
        intensity_band(points.on_surface(relief), raster)

    def paper() -> None:
        raster = facade_raster(case.facade, options)
        for photo in case.photos:
            H = plane_homography(photo, case.facade, raster)
            flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
            cv2.warpPerspective(image(photo.id), H, (raster.width, raster.height), flags=flags)

    found: dict[str, list[float]] = {}
    for _ in range(REPEAT):
        once, whole, scan = _processor(decoded), _processor(everything), _processor(scan_only)
        ratios = {"whole image": whole, "of it what the photos add": whole - scan}
        ratios |= {"of it scan and relief": scan, "paper A, all photos": _processor(paper)}
        for name, spent in ratios.items():
            found.setdefault(name, []).append(spent / once)
        found.setdefault("decoding, s", []).append(once)
        found.setdefault("whole image, s", []).append(whole)
    found["files, bytes per pixel"] = [sum(map(len, files.values())) / sum(a.size / 3 for a in decoded())]
    return found


def _with_noise(files: dict[str, bytes]) -> dict[str, bytes]:
    """The same photos (files by id) with noise of `NOISE` codes."""
    noisy = {}
    for seed, (name, data) in enumerate(files.items()):
        image = decode(data, name)
        noise = np.random.default_rng(seed).normal(0.0, NOISE, image.shape).astype(np.float32)
        noisy[name] = _jpeg(np.clip(image + noise, 0, 255).astype(np.uint8))
    return noisy


def _processor(work: Callable[[], object]) -> float:
    start = time.process_time()
    work()
    return time.process_time() - start


def many_photos() -> None:
    """Makes the facades of a street with 200 photo files of 12 MP, and prints time, memory and decodings."""
    keep_freed_memory()  # as worker processes do
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        photos = _write_street(folder)
        before, start, rows = peak_memory(), time.process_time(), []
        for number in range(FACADES):
            facade, scan = _wall(number)
            decodings: dict[str, int] = {}

            def image(photo: str, counts: dict[str, int] = decodings) -> Array:
                counts[photo] = counts.get(photo, 0) + 1
                return decode((folder / photo).read_bytes(), photo)

            begun = time.process_time()
            made = make_ortho(facade, scan, photos, image, options=OrthoOptions(gsd=GSD))
            assert isinstance(made, OrthoImage)
            painted = len(np.unique(made.source[(made.source > 0) & (made.source <= len(made.sources))]))
            most = max(decodings.values())
            spent, peak = f"{time.process_time() - begun:.1f} s", f"{peak_memory():.2f} GB"
            rows.append([facade.id, len(decodings), most, painted, spent, peak])
        header = ["facade", "photos decoded", "times each", "photos painted", "processor", "peak so far"]
        table(f"{PHOTOS} photos of 12 MP before {FACADES} facades of 25 x 12 m at 1 cm", header, rows)
        whole = time.process_time() - start
        print(f"\nall: {whole:.0f} s, peak {peak_memory():.2f} GB ({before:.2f} GB before the first)")


def _wall(number: int) -> tuple[Facade, Scan]:
    """One facade of the long street, which stands along x of the local frame, and its scan."""
    facade = wall.facade(WIDTH_M, HEIGHT_M, azimuth=0.0, spacing=0.03)
    moved = replace(facade.frame, t=np.array([(number + 0.5) * WIDTH_M, 0.0, 0.5 * HEIGHT_M]))
    pose = replace(facade.local_from_facade, value=moved)
    facade = replace(
        facade, id=f"B{number + 1:02d}/F1", building=f"B{number + 1:02d}", local_from_facade=pose
    )
    return facade, wall.wall_cloud(facade, spacing=0.03, seed=number)


def _write_street(folder: Path) -> list[Photo]:
    """Writes the files of photos taken every metre along an endless wall that repeats every ten metres."""
    picture = wall.texture(PERIOD * STEP_M, HEIGHT_M)
    whole = np.concatenate([picture] * 6, axis=1)  # 60 m, more than a photo sees
    camera = wall.camera(4000, 3000, distorted=False, focal=0.55)
    fx, fy, cx, cy = camera.params
    K = np.array([[fx, 0.0, cx], [0.0, fy, cy], [0.0, 0.0, 1.0]])
    facade, _ = _wall(0)
    photos = []
    for k in range(PHOTOS):
        x = k * STEP_M - 0.5 * WIDTH_M
        photos.append(wall.photo(facade, camera, (x, -AWAY_M, -4.0), (x, 0.0, -1.0), f"{k:04d}.jpg"))
    for k, photo in enumerate(photos):
        path = folder / photo.id
        if k >= PERIOD:
            path.write_bytes((folder / photos[k % PERIOD].id).read_bytes())
            continue
        # The first pixel of the repeated picture lies 25 m left of the photo, at a whole period.
        left = np.floor((k * STEP_M - 25.0) / (PERIOD * STEP_M)) * PERIOD * STEP_M - 0.5 * WIDTH_M
        to_camera = photo.pose.inverse @ facade.frame
        plane = to_camera.R[:, [0, 2]] @ np.diag([wall.GSD, -wall.GSD])
        corner = to_camera.R @ np.array([left, 0.0, 0.5 * HEIGHT_M]) + to_camera.t
        H = K @ np.column_stack([plane, corner])
        shift = np.array([[1.0, 0.0, 0.5], [0.0, 1.0, 0.5], [0.0, 0.0, 1.0]])  # centres of pixels at 0.5
        image = cv2.warpPerspective(
            whole, np.linalg.inv(shift) @ H @ shift, (4000, 3000), flags=cv2.INTER_LINEAR
        )
        noise = np.random.default_rng(k).normal(0.0, NOISE, (3000, 4000, 1)).astype(np.float32)
        path.write_bytes(_jpeg(np.clip(image + noise, 0, 255).astype(np.uint8)))
    return photos
