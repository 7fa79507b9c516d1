"""A simulated scene as a folder: recordings, photos, city model, the truth, and a project that reads them."""

import hashlib
import json
import time
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

import frontage
from frontage.errors import OptionError
from frontage.geometry.arrays import Float
from frontage.io.colmapwrite import write_colmap
from frontage.io.files import require_file
from frontage.model import Estimate, Photo
from frontage.pipeline.graph import code_hash
from frontage.pipeline.progress import Progress, Silent
from frontage.pipeline.store.files import fingerprint, read_json, write_bytes, write_json
from frontage.scale import make_executor
from frontage.simulate.optics.rays import Tracer
from frontage.simulate.scene import Scene
from frontage.simulate.sensors.cameras import CameraSpec
from frontage.simulate.sensors.instrument import ScannerSpec
from frontage.simulate.sensors.viewpoints import plan_photos
from frontage.simulate.spec import SceneSpec
from frontage.simulate.truth.tables import scene_table, surface_arrays
from frontage.simulate.truth.visibility import Visibility, visibility
from frontage.studies.measurements import (
    MOBILE,
    TRAJECTORY,
    TRUE_TRAJECTORY,
    MeasurementTask,
    camera_seed,
    ortho_names,
    points_name,
    record,
    save_arrays,
    scene_of,
)
from frontage.studies.scenefolder import SceneFolder
from frontage.studies.scenemodels import write_lod2, write_lod3
from frontage.studies.sceneproject import project_text

_SHOWN = 0.1  # share of a facade that some sensor saw, for its true ortho-image to be made
_CODE = (
    "geometry", "model", "raster", "io", "simulate", "pipeline/store/files.py", "studies/simulate.py",
    "studies/scenemodels.py", "studies/sceneproject.py", "studies/measurements.py",
)  # fmt: skip
_PLAIN = (
    "project.toml",
    "lod2.city.json",
    "lod2.gml",
    "truth/truth.json",
    "truth/spec.json",
    "truth/surfaces.npz",
    "truth/lod3.city.json",
    *(f"{folder}/{name}.txt" for folder in ("cameras", "cameras_approximate")
      for name in ("cameras", "images", "points3D", "offset")),
)  # fmt: skip

DEFAULT_SCANNER = ScannerSpec.model_validate({"stations": 2, "spacing": 0.03, "field": 200.0})
DEFAULT_CAMERA = CameraSpec.model_validate({"width": 2400, "height": 1800, "most": 6})


@dataclass(frozen=True)
class Simulated:
    """What was written: the folder, its project file, counts, notes."""

    out: Path
    project: Path
    scans: int
    points: int
    photos: int
    facades: int
    openings: int
    notes: tuple[str, ...]
    seconds: float


def simulate(
    spec: SceneSpec,
    out: Path | str,
    *,
    base: Path | str = ".",
    workers: int = 1,
    progress: Progress | None = None,
) -> Simulated:
    """Build the street of `spec`, measure it, and write everything into the folder `out`.

    The city models of `from_model` are looked for from `base`. The same spec gives the same bytes at any
    number of workers. A spec that names no instrument gets two stations and six photos. An earlier scene in
    the folder is replaced; the same one is kept as it is.

    Raises OptionError for a spec that cannot be built, FileError, UnsupportedFormat or CrsError for a city
    model that cannot be read, WorkspaceError for a folder with other things in it,
    MissingExtra without the ray tracer or pye57.
    """
    start, told, folder = time.perf_counter(), progress or Silent(), Path(out).resolve()
    asked, notes = _with_instruments(spec)
    paths = [require_file(Path(base) / path) for path in asked.from_model]
    spec = asked.model_copy(update={"from_model": tuple(str(path.resolve()) for path in paths)})
    contents = [hashlib.sha256(path.read_bytes()).hexdigest() for path in paths]
    place = SceneFolder(folder, _made_of(asked, contents))
    if place.current():
        made = _summary(folder, notes, start)
        told.end("scene", made.seconds, True, made.facades)
        return made
    if why := place.outdated():
        notes = (*notes, f"the scene in {out} is simulated again, because {why}")
    scene = _built(spec, told)
    tasks = [*_scan_tasks(spec, folder), *_photo_tasks(spec, scene, folder)]
    place.begin(_names(tasks, scene))
    with make_executor(workers) as executor:

        def each(stage: str, some: Sequence[MeasurementTask]) -> list[dict[str, Any]]:
            begun = time.perf_counter()
            told.begin(stage, len(some))
            found = executor.map(record, some, lambda _: told.advance(stage))
            told.end(stage, time.perf_counter() - begun, False, len(some))
            return found

        found = each("record", tasks)
        seen = _seen(scene, found)
        orthos = each("truth", _ortho_tasks(spec, scene, seen, folder))
    _write(asked, scene, folder, _truth(spec, scene, seen, found, orthos), found)
    place.finish()
    return _summary(folder, notes, start)


def _summary(out: Path, notes: tuple[str, ...], start: float) -> Simulated:
    """What a finished folder holds, from its truth."""
    table = read_json(out / "truth" / "truth.json")
    return Simulated(
        out,
        out / "project.toml",
        len(table["points"]),
        sum(entry["points"] for entry in (*table["stations"], table["drive"]) if entry),
        len(table["photos"]),
        len(table["facades"]),
        sum(len(facade["openings"]) for facade in table["facades"]),
        (*notes, *table["notes"]),
        time.perf_counter() - start,
    )


def _made_of(spec: SceneSpec, contents: Sequence[str]) -> dict[str, str]:
    """What a scene follows from; `contents` are the hashes of its city models."""
    return {
        "the simulator": code_hash(_CODE),
        "the spec": fingerprint(spec.model_dump(mode="json")),
        "the city models": fingerprint(list(contents)),
    }


def _with_instruments(spec: SceneSpec) -> tuple[SceneSpec, tuple[str, ...]]:
    """A spec that measures something."""
    if spec.scanners or spec.drive or spec.cameras:
        return spec, ()
    more = spec.model_copy(update={"scanners": (DEFAULT_SCANNER,), "cameras": (DEFAULT_CAMERA,)})
    return more, ("the spec names no scanner, drive or camera: two stations and six photos are simulated",)


def _built(spec: SceneSpec, told: Progress) -> Scene:
    start = time.perf_counter()
    told.begin("street", 1)
    scene = scene_of(spec)
    told.end("street", time.perf_counter() - start, False, len(scene.houses))
    if not scene.houses:
        raise OptionError(f"scene {spec.name!r} has no houses; ask for at least one to measure")
    return scene


def _scan_tasks(spec: SceneSpec, out: Path) -> list[MeasurementTask]:
    """The drive, then every station; files are numbered through all scanners."""
    tasks = [MeasurementTask(spec, out, "drive", 0, 0, MOBILE)] if spec.drive is not None else []
    for series, scanner in enumerate(spec.scanners):
        count = scanner.stations if scanner.positions is None else len(scanner.positions)
        before = sum(t.kind == "station" for t in tasks)
        tasks += [
            MeasurementTask(spec, out, "station", series, k, f"scans/S{before + k + 1}.{spec.output.scans}")
            for k in range(count)
        ]
    return tasks


def _photo_tasks(spec: SceneSpec, scene: Scene, out: Path) -> list[MeasurementTask]:
    """Every photo of every series; names are unique over all series."""
    tasks = []
    for series, camera in enumerate(spec.cameras):
        prefix = "photos/" if series == 0 else f"photos/C{series + 1}_"
        aims = plan_photos(scene, camera, camera_seed(spec, series))
        tasks += [MeasurementTask(spec, out, "photo", series, k, prefix + a.name) for k, a in enumerate(aims)]
    return tasks


def _ortho_tasks(spec: SceneSpec, scene: Scene, seen: Visibility, out: Path) -> list[MeasurementTask]:
    """True ortho-images of the facades that any sensor saw."""
    return [
        MeasurementTask(spec, out, "ortho", h, f, ortho_names(facade.id)[0])
        for h, house in enumerate(scene.houses)
        for f, facade in enumerate(house.facades)
        if seen.facades.get((h, f), {}).get("any", 0.0) >= _SHOWN
    ]


def _names(tasks: Sequence[MeasurementTask], scene: Scene) -> list[str]:
    """Every file that may be written, known before the first is."""
    names = [name for task in tasks for name in _files(task)]
    names += [n for house in scene.houses for facade in house.facades for n in ortho_names(facade.id)]
    return [*_PLAIN, *names]


def _files(task: MeasurementTask) -> Iterable[str]:
    """What a task writes."""
    if task.kind == "photo":
        return [task.name]
    if task.kind == "drive":
        return [MOBILE, TRAJECTORY, TRUE_TRAJECTORY, points_name(MOBILE)]
    return [task.name, f"{task.name}.stations.json", points_name(task.name)]


def _seen(scene: Scene, found: Sequence[dict[str, Any]]) -> Visibility:
    none: Float = np.empty((0, 3))
    stations = [f["eye"] for f in found if "eye" in f]
    track = np.concatenate([none, *(f["track"] for f in found if "track" in f)])
    return visibility(scene, Tracer(scene.mesh), stations, track, [f["photo"] for f in found if "photo" in f])


def _truth(
    spec: SceneSpec,
    scene: Scene,
    seen: Visibility,
    found: Sequence[dict[str, Any]],
    orthos: Sequence[dict[str, Any]],
) -> dict[str, Any]:
    """The contents of truth.json."""
    stations = [f["station"] for f in found if "station" in f]
    drives = [f["drive"] for f in found if "drive" in f]
    files = [s["file"] for s in stations] + [d["file"] for d in drives]
    return scene_table(scene, seen, {o["facade"]: o["ortho"] for o in orthos}) | {
        "frontage": frontage.__version__,
        "stations": stations,
        "drive": drives[0] if drives else None,
        "photos": [f["table"] for f in found if "table" in f],
        "points": [{"file": name, "truth": points_name(name)} for name in files],
        "surfaces": "truth/surfaces.npz",
        "lod2": {"cityjson": "lod2.city.json", "citygml": "lod2.gml"},
        "lod3": "truth/lod3.city.json",
        "spec": "truth/spec.json",
    }


def _write(
    spec: SceneSpec, scene: Scene, out: Path, table: dict[str, Any], found: Sequence[dict[str, Any]]
) -> None:
    """Everything that is not a recording; truth.json comes last, so that a folder that has it is whole."""
    photos: list[Photo] = [f["photo"] for f in found if "photo" in f]
    if photos:
        write_colmap(out / "cameras", photos, scene.world.origin.astype(np.float64))
        given = [_given(f["photo"], f) for f in found if "photo" in f]
        write_colmap(out / "cameras_approximate", given, scene.world.origin.astype(np.float64))
    table["lod2"] |= write_lod2(out, scene, spec)
    write_lod3(out / "truth" / "lod3.city.json", scene)
    save_arrays(out / "truth" / "surfaces.npz", surface_arrays(scene))
    write_json(out / "truth" / "spec.json", json.loads(spec.model_dump_json()))
    write_bytes(out / "project.toml", project_text(spec, scene.world, table).encode())
    write_json(out / "truth" / "truth.json", table)


def _given(photo: Photo, entry: dict[str, Any]) -> Photo:
    pose = Estimate(entry["given"], np.zeros((6, 6)), 0.0)
    return Photo(photo.id, photo.camera, pose, photo.time)
