"""What is read in every case, and what must hold of whatever was read: no silent nonsense."""

import math
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from frontage.errors import FrontageError
from frontage.io.citymodels.info import city_model_info
from frontage.io.citymodels.read import read_city_model
from frontage.io.photos.imagefile import image_header
from frontage.io.photos.photoset import PhotoSet
from frontage.io.photos.read import PhotoSource, read_photos
from frontage.io.scans.info import scan_info
from frontage.io.scans.read import ScanSource, read_scans
from frontage.model import Scan, WorldRef
from frontage.pipeline.graph import Graph
from frontage.pipeline.project import Project, load_project
from frontage.pipeline.stages import STAGES
from frontage.queries.runfolder import open_run
from frontage.queries.validation import validate_file

LARGEST_M = 1e9  # of anything that is measured on Earth
LARGEST_SHAPE_M = 1e15  # that the validator takes (`model.shape`)
LOCAL = WorldRef(np.array([678_000, 5_403_000, 400]), "EPSG:25832")
BUG = 999  # the validator's code for a fault of its own


class NonsenseError(AssertionError):
    """Something was read that cannot be true."""


def check(holds: bool, what: str) -> None:
    if not holds:
        raise NonsenseError(what)


def sane(values: Any, what: str, largest: float = LARGEST_M) -> None:
    """Check that coordinates are finite and less than `largest` apart from the origin."""
    array = np.asarray(values, np.float64)
    check(bool(np.isfinite(array).all()), f"{what} are not finite")
    check(array.size == 0 or float(np.abs(array).max()) < largest, f"{what} are beyond {largest:g} m")


def check_scan(scan: Scan) -> None:
    check(len(scan) > 0, "a scan without points")
    sane(scan.xyz, "points")
    sane(scan.origins, "origins")
    sane(scan.world.origin, "the origin of the world")
    index = scan.origin_index
    check(int(index.min()) >= -1 and int(index.max()) < len(scan.origins), "origin_index points nowhere")
    for name in ("intensity", "time"):
        values = getattr(scan, name)
        check(values is None or bool(np.isfinite(values).all()), f"{name} is not finite")
    if scan.grid is not None:
        cells = scan.grid.index
        check(cells.size == 0 or int(cells.max()) < len(scan), "the grid points at no point")
        check(cells.size == 0 or int(cells.min()) >= -1, "the grid has an index below -1")
    if scan.local_from_scanner is not None:
        sane(scan.local_from_scanner.value.matrix, "the pose")


def read_scan(path: Path) -> None:
    for scan in read_scans(path):
        check_scan(scan)


def read_copc(path: Path) -> None:
    read_scan(path)
    for scan in read_scans(path, bounds=(678_000, 5_403_000, 678_020, 5_403_020), resolution=2.0):
        check_scan(scan)
    scan_info(path)


def read_with_trajectory(path: Path) -> None:
    for scan in read_scans(ScanSource(path=str(path.with_name("scan.las")), trajectory=str(path))):
        check_scan(scan)


def read_with_stations(path: Path) -> None:
    read_scan(path.with_name("scan.las"))


def check_photos(photos: PhotoSet) -> None:
    for photo in photos.photos:
        sane(photo.camera.params, f"the parameters of {photo.id}")
        check(min(photo.camera.width, photo.camera.height) > 0, f"{photo.id} has no pixels")
        sane(photo.pose.matrix, f"the pose of {photo.id}")
        pixels = photos.image(photo.id)
        size = (photo.camera.height, photo.camera.width, 3)
        check(pixels.shape == size and pixels.dtype == np.uint8, f"{photo.id} has pixels {pixels.shape}")


def read_photo_folder(path: Path) -> None:
    check_photos(read_photos(PhotoSource(path=str(path.parent), cameras=str(path.parent)), LOCAL))


def read_photo(path: Path) -> None:
    """A picture whose size its camera states rightly, so that the pixels are decoded."""
    header = image_header(path)
    width, height = header.width, header.height
    if header.orientation > 4:
        width, height = height, width
    folder = path.parent / "cameras"
    folder.mkdir(exist_ok=True)
    (folder / "cameras.txt").write_text(f"1 SIMPLE_PINHOLE {width} {height} 50 {width / 2} {height / 2}\n")
    (folder / "images.txt").write_text(f"1 1 0 0 0 -1 0 0 1 {path.name}\n\n")
    check_photos(read_photos(PhotoSource(path=str(path), cameras=str(folder)), LOCAL))


def read_e57_photos(path: Path) -> None:
    check_photos(read_photos(PhotoSource(path=str(path)), LOCAL))


def read_model(path: Path) -> None:
    model = read_city_model(path)
    check(len(model.buildings) > 0, "a model without buildings")
    sane(model.world.origin, "the origin of the world")
    for building in model.buildings:
        for shell in building.shells:
            for surface in shell.surfaces:
                sane(surface.ring, f"a ring of {building.id!r:.40}")
                for hole in surface.holes:
                    sane(hole, f"a hole of {building.id!r:.40}")
    city_model_info(path)


def validate(path: Path) -> None:
    found = validate_file(path)
    if not found.format:
        raise FrontageError(found.findings[0].message)
    for finding in found.findings:
        check(finding.code != BUG, f"the validator failed: {finding.message}")
        if finding.location is not None:
            sane(finding.location, "the location of a finding", LARGEST_SHAPE_M)
    check(found.findings != () or sum(found.geometries.values()) > 0, "valid, though nothing was checked")


def _leaves(value: Any) -> Iterator[tuple[str, Any]]:
    if isinstance(value, dict):
        for key, entry in value.items():
            yield from ((f"{key}.{name}", leaf) for name, leaf in _leaves(entry))
    elif isinstance(value, (list, tuple)):
        for entry in value:
            yield from _leaves(entry)
    else:
        yield "", value


def check_project(project: Project) -> None:
    for name, value in _leaves(project.model_dump()):
        if isinstance(value, float):
            check(math.isfinite(value), f"{name.strip('.')} = {value}")


def read_project(path: Path) -> None:
    check_project(load_project(path))


def read_run(path: Path) -> None:
    """A run folder whose file `path` was changed: everything that queries and later stages read of it."""
    out = next(p for p in path.parents if (p / "manifest.json").exists())
    run = open_run(out)
    for stage in STAGES:
        marker = run.store.markers.read(stage.name)
        check(marker is None or isinstance(marker.key, str), "a marker without a key")
    str(run)
    for record in run.store.building_records():
        check_scan(run.store.working_cloud(record.id))
        index, cloud = run.store.building(record.id).index, run.store.working_cloud(record.id)
        check(int(index.min(initial=0)) >= 0, "a building has a point before the first")
        check(int(index.max(initial=0)) < len(cloud), "a building has points that its cloud has not")
    for name in run.facades:
        facade = run.plane(name)
        sane(facade.outline, "the outline of a facade")
        sane(facade.frame.matrix, "the frame of a facade")
        _read_pictures(run, name)
    project = run.store.project()
    check_project(project)
    graph = Graph(STAGES, run.store, project, run.store.manifest().inputs)
    for stage in STAGES:
        graph.kept(stage)


def _read_pictures(run: Any, name: str) -> None:
    found = run.openings(name)
    for element in () if found is None else (*found.openings, *found.protrusions):
        sane(element.ring, f"the outline of {element.id!r:.40}")
    ortho = run.ortho(name)
    if ortho is not None:
        check(ortho.depth.shape == ortho.pixels.shape[:2], "depth and picture differ in size")
        check(0 < ortho.gsd < LARGEST_M, f"a GSD of {ortho.gsd}")
        run.facade(name).pixel_to_world(1.0, 1.0)


READERS: dict[str, Callable[[Path], None]] = {
    "scan": read_scan,
    "copc": read_copc,
    "trajectory": read_with_trajectory,
    "stations": read_with_stations,
    "photos": read_photo_folder,
    "photo": read_photo,
    "e57photo": read_e57_photos,
    "city": read_model,
    "validate": validate,
    "project": read_project,
    "run": read_run,
}
"""The readers by the names that `seeds.Seed` uses."""
