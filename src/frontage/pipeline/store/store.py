"""The run folder, typed both ways: the only code that reads and writes its files.

Layout (more in the reference of the run folder)::

    OUT/manifest.json                inputs with hashes, versions, seed, resolved options, stages, warnings
    OUT/.done/                       markers of finished stages and items (see `markers`)
    OUT/scans/cloud.npz              all scans in one local frame, as given
    OUT/scans/part_000.npz, registered.npz   every scan as given, and all in place, if scans are registered
    OUT/registration/report.json     transforms, covariances, what was observable
    OUT/orientation/report.json      poses of photos, standard errors; colmap/: a COLMAP text model
    OUT/orientation/ties/            key points of every photo, matches with later photos
    OUT/buildings/index.json         the buildings; surroundings.npz: the whole cloud, thinned
    OUT/buildings/B07.laz            the building's own points, for users
    OUT/buildings/B07.npz, .index.npy   its working cloud (with surroundings) and which points are its own
    OUT/facades/B07_F1/              facade.json, points.npz, ortho.*, depth.tif, openings.json, ...
    OUT/model/  OUT/report.html

Every method that writes also takes note of the files, so that the marker of the stage can promise them.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import Any, TypeVar

from pydantic import ValidationError

from frontage.errors import FileError, InputError, WorkspaceError
from frontage.geometry.arrays import Int
from frontage.io.arrayfiles import read_array
from frontage.io.facadefile import world_to_json
from frontage.io.files import MALFORMED
from frontage.io.photos.photoset import PhotoSet
from frontage.io.photos.read import PhotoSource, read_photos
from frontage.io.rasters.ortho import FILES as ORTHO_FILES
from frontage.io.rasters.ortho import read_ortho, write_ortho
from frontage.io.rasters.sidecar import OrthoSidecar, read_sidecar
from frontage.io.scans.laswrite import BUILDING_CLASS, write_las
from frontage.io.scans.npz import load_scan, save_scan
from frontage.model import Building, Elements, Facade, OrthoImage, Scan, WorldRef
from frontage.pipeline.project import Project
from frontage.pipeline.store import elements as elementfiles
from frontage.pipeline.store.files import read_json, write_array, write_json
from frontage.pipeline.store.orientationfolder import OrientationFolder
from frontage.pipeline.store.records import BuildingRecord, load_facade, save_facade
from frontage.pipeline.store.results import (
    CrossbarsItemResult,
    ItemResult,
    OpeningsItemResult,
    ScansResult,
    result_from_json,
)

Item = TypeVar("Item", bound=ItemResult)

_AGAIN = "run `frontage run` again"


class Store(OrientationFolder):
    """A run folder. Methods named after a noun read it, methods named save_... write it."""

    def project(self) -> Project:
        """Return the project that made the run. Raises WorkspaceError if this version cannot read it."""
        try:
            return Project.model_validate(self.manifest().project)
        except ValidationError:
            raise WorkspaceError(f"{self.manifest_path} names no project of this version; {_AGAIN}") from None

    def scans(self) -> ScansResult:
        """Return what the stage `scans` told. Raises WorkspaceError before it has run."""
        marker = self.markers.read("scans")
        try:
            if marker is not None:
                return result_from_json(ScansResult, marker.result)
        except ValueError:
            pass
        raise WorkspaceError(f"{self.out}: no scan was read yet; run `frontage run` first")

    def world(self) -> WorldRef:
        """Return the local frame of the run. Raises WorkspaceError before a scan was read."""
        return self.scans().world_ref

    # -- scans -----------------------------------------------------------------------------------------

    def cloud(self, registered: bool = False) -> Scan:
        """Return the merged cloud of all scans: as given, or in place if they were `registered`."""
        return load_scan(self.out / "scans" / ("registered.npz" if registered else "cloud.npz"))

    def save_cloud(self, scan: Scan, registered: bool = False) -> None:
        """Write the merged cloud of all scans."""
        self._save_scan(self.out / "scans" / ("registered.npz" if registered else "cloud.npz"), scan)

    def part(self, number: int) -> Scan:
        """Return one scan as given, of a run that registers scans."""
        return load_scan(self._part_path(number))

    def save_part(self, number: int, scan: Scan) -> None:
        """Write one scan as given."""
        self._save_scan(self._part_path(number), scan)

    def _part_path(self, number: int) -> Path:
        return self.out / "scans" / f"part_{number:03d}.npz"

    def _save_scan(self, path: Path, scan: Scan) -> None:
        save_scan(path, scan)
        self.wrote(path)

    # -- buildings -------------------------------------------------------------------------------------

    def building_records(self) -> tuple[BuildingRecord, ...]:
        """Return the buildings found, in order; empty before that stage. Raises FileError if damaged."""
        path = self.buildings_folder / "index.json"
        if not path.is_file():
            return ()
        try:
            return tuple(BuildingRecord.from_json(entry) for entry in read_json(path)["buildings"])
        except (OSError, *MALFORMED) as error:
            raise FileError(path, f"is damaged ({error})", _AGAIN) from None

    def save_building_records(self, records: Sequence[BuildingRecord], world: WorldRef) -> None:
        """Write the list of buildings."""
        path = self.buildings_folder / "index.json"
        write_json(path, {"world": world_to_json(world), "buildings": [r.to_json() for r in records]})
        self.wrote(path)

    def building(self, building: str) -> Building:
        """Return a building, whose points index its working cloud. Raises InputError for an unknown id."""
        return self.surveyed(building)[1]

    def working_cloud(self, building: str) -> Scan:
        """Return the points of a building with what surrounds it."""
        return load_scan(self._building_path(building, ".npz"))

    def surveyed(self, building: str) -> tuple[Scan, Building]:
        """Return the working cloud of a building, and the building whose points index it."""
        record = next((r for r in self.building_records() if r.id == building), None)
        if record is None:
            raise InputError(f"no building {building!r} in {self.out}")
        cloud, path = self.working_cloud(building), self._building_path(building, ".index.npy")
        advice = "run `frontage buildings` again"
        index = read_array(path, advice)
        if index.dtype.kind != "i" or not (index.size == 0 or 0 <= index.min() <= index.max() < len(cloud)):
            raise FileError(path, "names points that its cloud does not have", advice)
        return cloud, record.with_points(index)

    def save_building(self, building: str, cloud: Scan, own: Int) -> None:
        """Write a working cloud and which of its points are the building's own, also as LAZ for users."""
        self._save_scan(self._building_path(building, ".npz"), cloud)
        index, laz = (self._building_path(building, ending) for ending in (".index.npy", ".laz"))
        write_array(index, own)
        write_las(laz, cloud.take(own), BUILDING_CLASS)
        self.wrote(index, laz)
        stations = laz.with_name(f"{laz.name}.stations.json")
        if stations.is_file():
            self.wrote(stations)

    def surroundings(self) -> Scan | None:
        """Return the whole cloud, thinned; None before the buildings were split."""
        path = self.buildings_folder / "surroundings.npz"
        return load_scan(path) if path.is_file() else None

    def save_surroundings(self, scan: Scan) -> None:
        """Write the whole cloud, thinned."""
        self._save_scan(self.buildings_folder / "surroundings.npz", scan)

    def _building_path(self, building: str, ending: str) -> Path:
        return self.buildings_folder / f"{building}{ending}"

    # -- facades ---------------------------------------------------------------------------------------

    def facades_of(self, building: str, stage: str = "facades") -> list[str]:
        """Return the facades of a building that `stage` has a result for; empty before that stage."""
        marker = self.markers.read(stage, building)
        try:
            return list(result_from_json(ItemResult, marker.result).facades) if marker else []
        except ValueError:
            return []  # a damaged marker promises nothing

    def facade_ids(self, stage: str = "facades") -> list[str]:
        """Return the facades that `stage` has a result for, in the order of the buildings."""
        return [f for record in self.building_records() for f in self.facades_of(record.id, stage)]

    def has(self, facade: str, stage: str) -> bool:
        """Tell whether `stage` has a result for a facade."""
        return facade in self.facades_of(facade.rsplit("/", 1)[0], stage)

    def known_facade(self, facade: str) -> str:
        """Return the id of a facade that is named "B07/F1" or "b07_f1". Raises InputError if unknown."""
        name = facade.strip().replace("_", "/")
        if self.has(name, "facades"):
            return name
        ids = self.facade_ids()
        known = {known.casefold(): known for known in ids}.get(name.casefold())
        if known is None:
            some = ", ".join(ids[:12]) + (", ..." if len(ids) > 12 else "") or "none yet"
            raise InputError(f"no facade {facade!r} in {self.out}; known: {some}")
        return known

    def facade(self, facade: str) -> Facade:
        """Return a facade. Raises InputError for an unknown id, FileError if its files are damaged."""
        return load_facade(self.facade_folder(self.known_facade(facade)))

    def save_facade(self, facade: Facade) -> None:
        """Write a facade."""
        folder = self.facade_folder(facade.id)
        save_facade(folder, facade)
        self.wrote(folder / "facade.json", folder / "points.npz")

    # -- what is on a facade ---------------------------------------------------------------------------

    def ortho(self, facade: str) -> OrthoImage | None:
        """Return the ortho-image of a facade, None if it has none. Raises FileError if damaged."""
        return read_ortho(self.facade_folder(facade)) if self.has(facade, "ortho") else None

    def sidecar(self, facade: str) -> OrthoSidecar | None:
        """Return what `ortho.json` says of the ortho-image of a facade, None if it has none."""
        return read_sidecar(self.facade_folder(facade)) if self.has(facade, "ortho") else None

    def save_ortho(self, ortho: OrthoImage) -> None:
        """Write the ortho-image of a facade, with its depth, sources, pixel sizes and sidecar."""
        folder = self.facade_folder(ortho.facade.id)
        write_ortho(folder, ortho)
        self.wrote(*(path for name in ORTHO_FILES if (path := folder / name).is_file()))

    def elements(self, facade: str) -> Elements | None:
        """Return the openings and protrusions of a facade, None if it was not judged. Raises FileError."""
        if not self.has(facade, "openings"):
            return None
        folder = self.facade_folder(facade)
        product = self.has(facade, "crossbars")
        return elementfiles.load_elements(
            folder, facade, elementfiles.PRODUCT if product else elementfiles.FOUND[0]
        )

    def openings_item(self, building: str) -> OpeningsItemResult:
        """Return what the stage `openings` told of a building; empty before that stage."""
        return self._item("openings", building, OpeningsItemResult)

    def crossbars_item(self, building: str) -> CrossbarsItemResult:
        """Return what the stage `crossbars` told of a building; empty before that stage."""
        return self._item("crossbars", building, CrossbarsItemResult)

    def _item(self, stage: str, building: str, kind: type[Item]) -> Item:
        """Return what a stage told of a building; an empty `kind` if there is no readable marker."""
        marker = self.markers.read(stage, building)
        try:
            return kind() if marker is None else result_from_json(kind, marker.result)
        except ValueError:
            return kind()

    def found_elements(self, facade: str) -> Elements:
        """Return what the stage `openings` found on a facade, without what later stages added."""
        folder = self.facade_folder(facade)
        return elementfiles.load_elements(folder, facade, elementfiles.FOUND[0])

    def save_found_elements(self, facade: Facade, elements: Elements) -> None:
        """Write what the stage `openings` found on a facade."""
        folder = self.facade_folder(facade.id)
        elementfiles.save_elements(folder, facade, elements)
        self.wrote(*(folder / name for name in elementfiles.FOUND))

    def save_elements(self, facade: Facade, elements: Elements) -> None:
        """Write `openings.json`, the product of all stages."""
        folder = self.facade_folder(facade.id)
        elementfiles.save_product(folder, facade, elements)
        self.wrote(folder / elementfiles.PRODUCT)

    # -- photos and the model --------------------------------------------------------------------------

    def photos(self) -> PhotoSet | None:
        """Return the photos of the run, None if it has none. Raises FrontageError if they cannot be read."""
        source = self.project().photos
        return None if source is None else self.photos_of(source)

    def photos_of(self, source: PhotoSource) -> PhotoSet:
        """Return the photos of a source, with the poses that orienting them found if they were oriented.

        Photos that could not be oriented have no pose. Raises FrontageError if they cannot be read.
        """
        photos = read_photos(source, self.world())
        return photos if source.pose == "trusted" else self.with_oriented_poses(photos, self.world())

    def model(self) -> dict[str, dict[str, Any]]:
        """Return what `model/report.json` says of every building of the model; empty without a model."""
        path = self.model_folder / "report.json"
        if self.markers.read("model") is None or not path.is_file():
            return {}
        try:
            return dict(read_json(path))
        except (OSError, ValueError) as error:
            raise FileError(path, f"is damaged ({error})", "run `frontage model` again") from None
