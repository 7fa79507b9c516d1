"""One measurement of a simulated scene, written: a station, a drive, a photo, or a true ortho-image.

Tasks are picklable; every process builds the street once. Files of a scene (all below its folder)::

    scans/S1.e57, S2.e57, ...   terrestrial scans, one file each (or .ptx, .laz)
    scans/mobile.laz            the mobile recording, with scans/trajectory.csv
    photos/IMG_0001.jpg ...     with EXIF of the approximate poses
    truth/points_S1.npz ...     per point of a scan, in the order of its file
    truth/ortho_B01_F1.png, ids_B01_F1.png, ortho_B01_F1.npz
"""

from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from frontage.geometry.arrays import Array, Int
from frontage.geometry.rigid import Rigid3
from frontage.io.citymodels.read import read_city_model
from frontage.io.geographic import latitude_longitude, true_heading
from frontage.io.photos.exif import Exif, write_jpeg
from frontage.io.scans.e57write import write_e57
from frontage.io.scans.laswrite import write_las
from frontage.io.scans.ptx import write_ptx
from frontage.io.scans.trajectory import write_trajectory
from frontage.model import Scan, WorldRef
from frontage.pipeline.store.files import write_bytes, write_with
from frontage.simulate.citymodel.scene import build_model_scene
from frontage.simulate.scene import Scene
from frontage.simulate.sensors.cameras import CameraSpec
from frontage.simulate.sensors.instrument import ScannerSpec
from frontage.simulate.sensors.mobile import drive
from frontage.simulate.sensors.photograph import iter_photographs
from frontage.simulate.sensors.recording import Station
from frontage.simulate.sensors.terrestrial import scan_stations
from frontage.simulate.spec import SceneSpec
from frontage.simulate.street.build import build_street
from frontage.simulate.truth.ortho import true_ortho
from frontage.simulate.truth.tables import drive_table, photo_table, point_arrays, station_table
from frontage.simulate.truth.visibility import ScannerView

MOBILE, TRAJECTORY, TRUE_TRAJECTORY = "scans/mobile.laz", "scans/trajectory.csv", "truth/trajectory.csv"
_CROP = 1.5  # a sensor's diagonal against 35 mm film


@dataclass(frozen=True)
class MeasurementTask:
    """What to record: "station", "drive", "photo" or "ortho"; series and number count from 0.

    For an ortho-image `series` is the house and `number` its facade. `name` is the file's.
    """

    spec: SceneSpec
    out: Path
    kind: str
    series: int
    number: int
    name: str


def record(task: MeasurementTask) -> dict[str, Any]:
    """Do one task; returns its entry in the truth and what else the caller needs."""
    return {"station": _station, "drive": _drive, "photo": _photo, "ortho": _ortho}[task.kind](task)


@lru_cache(maxsize=1)
def scene_of(spec: SceneSpec) -> Scene:
    """The street of a spec, or the scene of its city models; the last one is remembered.

    Raises OptionError, FileError, UnsupportedFormat, CrsError.
    """
    if not spec.from_model:
        return build_street(spec)
    models = [read_city_model(spec.from_model[0])]
    models += [read_city_model(path, models[0].world) for path in spec.from_model[1:]]
    return build_model_scene(spec, models)


def points_name(scan: str) -> str:
    """truth/points_S1.npz of scans/S1.e57."""
    return f"truth/points_{Path(scan).stem}.npz"


def ortho_names(facade: str) -> tuple[str, str, str]:
    """Picture, openings and arrays of the true ortho-image of a facade "B01/F1"."""
    stem = facade.replace("/", "_")
    return f"truth/ortho_{stem}.png", f"truth/ids_{stem}.png", f"truth/ortho_{stem}.npz"


def save_arrays(path: Path, arrays: dict[str, Array]) -> None:
    """Write named arrays as .npz, compressed, without pickles; the bytes depend on the arrays alone."""

    def write(temporary: Path) -> None:
        with temporary.open("wb") as file:
            np.savez_compressed(file, allow_pickle=False, **arrays)

    write_with(path, write)


def _station(task: MeasurementTask) -> dict[str, Any]:
    scene, spec = scene_of(task.spec), task.spec.scanners[task.series]
    (station,) = scan_stations(scene, spec, task.series, _light(task.spec), only=[task.number])
    _write_station(task.out / task.name, station, spec)
    order = _file_order(station.scan, task.name)
    save_arrays(task.out / points_name(task.name), point_arrays(scene, station, order))
    table = station_table(station, scene.world, task.name)
    field, lowest, highest = np.radians([spec.field, spec.lowest, spec.highest])
    eye = ScannerView(
        station.true.t, scene.local_from_street.R[:, 1], float(field), float(lowest), float(highest)
    )
    return {"station": table | {"points": len(order)}, "eye": eye}


def _light(spec: SceneSpec) -> Any:
    """Scanners and the first camera work on the same day."""
    return spec.cameras[0].light if spec.cameras else None


def _write_station(path: Path, station: Station, spec: ScannerSpec) -> None:
    scan = replace(station.scan, name=path.stem)
    writer: Any = {".e57": write_e57, ".ptx": write_ptx}.get(path.suffix)
    if writer is None:
        write_las(path, scan)
    else:
        writer(path, [scan])


def _file_order(scan: Scan, name: str) -> Int:
    """Index of every point of the file: structured formats keep one echo per beam, column by column."""
    if scan.grid is None or name.endswith(".laz"):
        return np.arange(len(scan), dtype=np.int64)
    index: Int = scan.grid.index.T.ravel()
    return index[index >= 0]


def _drive(task: MeasurementTask) -> dict[str, Any]:
    scene = scene_of(task.spec)
    assert task.spec.drive is not None
    made = drive(scene, task.spec.drive, 0, _light(task.spec))
    scan = replace(made.scan, origins=np.empty((0, 3)), origin_index=np.full(len(made.scan), -1, np.int32))
    write_las(task.out / MOBILE, scan)
    write_trajectory(task.out / TRAJECTORY, made.trajectory, scene.world)
    write_trajectory(task.out / TRUE_TRAJECTORY, made.true_trajectory, scene.world)
    arrays = point_arrays(scene, made, np.arange(len(scan), dtype=np.int64))
    save_arrays(task.out / points_name(MOBILE), arrays | {"scanner": made.scanner})
    table = drive_table(made, MOBILE, TRAJECTORY, TRUE_TRAJECTORY)
    return {"drive": table, "track": made.true_trajectory[:, 1:4]}


def _photo(task: MeasurementTask) -> dict[str, Any]:
    scene, spec = scene_of(task.spec), task.spec.cameras[task.series]
    (shot,) = iter_photographs(scene, spec, camera_seed(task.spec, task.series), only=[task.number])
    exif = _exif(spec, shot.given, scene.world)
    write_jpeg(task.out / task.name, shot.image, exif, task.spec.output.quality)
    photo = replace(shot.photo, id=Path(task.name).name)
    return {"table": photo_table(photo, shot.given, scene.world), "photo": photo, "given": shot.given}


def camera_seed(spec: SceneSpec, series: int) -> int:
    """The seed of a series of photos."""
    return spec.seed * 101 + series


def _exif(spec: CameraSpec, given: Rigid3, world: WorldRef) -> Exif:
    """What a phone writes: nominal focal length, GPS position and compass heading of the given pose."""
    about = {"make": "Frontage", "model": "Simulated camera", "focal_length": round(spec.focal / _CROP, 2)}
    if world.crs is None:
        return Exif(**about, focal_length_35mm=round(spec.focal))  # type: ignore[arg-type]
    place = world.to_world(given.t)
    ((latitude, longitude),) = latitude_longitude(place[None, :2], world.crs)
    return Exif(
        **about,  # type: ignore[arg-type]
        focal_length_35mm=round(spec.focal),
        position=(float(latitude), float(longitude), float(place[2])),
        heading=true_heading(place, given.R[:, 2], world.crs),
        position_error=spec.sigma_position,
    )


def _ortho(task: MeasurementTask) -> dict[str, Any]:
    scene, gsd = scene_of(task.spec), task.spec.output.gsd
    facade = scene.houses[task.series].facades[task.number]
    truth = true_ortho(scene, task.series, task.number, gsd)
    picture, ids, arrays = ortho_names(facade.id)
    for name, image in ((picture, truth.rgb[..., ::-1]), (ids, truth.opening.astype(np.uint16))):
        done, data = cv2.imencode(".png", np.ascontiguousarray(image))
        assert done
        write_bytes(task.out / name, data.tobytes())
    depth = np.asarray(truth.depth, np.float32)
    save_arrays(task.out / arrays, {"depth": depth, "surface": np.asarray(truth.surface, np.int32)})
    table = {"file": picture, "ids": ids, "arrays": arrays, "gsd": gsd, "corner": list(truth.corner)}
    return {"facade": facade.id, "ortho": table | {"width": depth.shape[1], "height": depth.shape[0]}}
