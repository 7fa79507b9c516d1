"""What a run folder holds, as the scorers take it: in the truth's own local coordinates."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from frontage.errors import FileError, InputError
from frontage.evaluation.facades import match_facades
from frontage.evaluation.metric import Absent
from frontage.evaluation.result import (
    FoundFacade,
    FoundOpening,
    FoundPose,
    FoundProtrusion,
    LabelledPoints,
    OrthoPair,
)
from frontage.evaluation.truth import TrueFacade, Truth
from frontage.geometry.arrays import Array, Float, Int
from frontage.geometry.rigid import Rigid3
from frontage.io.citymodels.openings import read_city_openings
from frontage.io.facadefile import world_from_json
from frontage.io.rasters.geotiff import read_geotiff
from frontage.pipeline.store.files import read_json
from frontage.pipeline.store.store import Store
from frontage.queries.pixels import FacadePixels
from frontage.simulate.scene import Part
from frontage.simulate.sensors.recording import Echo
from frontage.studies.claims import (
    city_opening,
    json_openings,
    json_protrusions,
    photo_poses,
    scan_poses,
)

_HOUSE = (Part.WALL, Part.ROOF, Part.REVEAL, Part.SILL, Part.PLINTH, Part.CORNICE, Part.BALCONY, Part.ORIEL,
          Part.DORMER, Part.CHIMNEY, Part.FRAME, Part.BAR, Part.LEAF, Part.SHUTTER, Part.RAILING)  # fmt: skip


class Results:
    """A run folder read for scoring; every method returns what is there, or Absent with the reason."""

    def __init__(self, run: Path, truth: Truth, base: Path) -> None:
        """Open `run`; `base` is the folder that the truth's file names are relative to.

        Raises WorkspaceError when it is no run folder, InputError for another coordinate system.
        """
        self.store, self.truth, self.base = Store(run), truth, base
        self.manifest = self.store.manifest()
        if self.manifest.world is None or self.manifest.project is None:
            raise InputError(f"{run}: nothing has run here yet; start with `frontage run`")
        self.project = self.manifest.project
        self.world = world_from_json(dict(self.manifest.world))
        if self.world.crs != truth.world.crs:
            raise InputError(
                f"{run} is in {self.world.crs or 'no CRS'} and the truth in {truth.world.crs or 'no CRS'}; "
                f"run it with [project] crs = {truth.world.crs!r}"
            )
        self.shift: Float = (self.world.origin - truth.world.origin).astype(np.float64)

    def sensors(self) -> tuple[str, ...]:
        """Which of the scene's sensors the run read: "stations", "drive", "photos"."""
        project = self.project
        names = {Path(scan["path"]).name for scan in project["scans"]}
        stations = {pose.name.rsplit(":", 1)[0].rsplit("/", 1)[-1] for pose in self.truth.scans}
        mobile = {Path(p["file"]).name for p in self.truth.points} - stations
        read = {"stations": names & stations, "drive": names & mobile, "photos": project.get("photos")}
        return tuple(name for name, found in read.items() if found)

    def facades(self) -> list[FoundFacade] | Absent:
        """Planes with their frames and covariances."""
        if "facades" not in self.manifest.stages:
            return Absent("no facades have been looked for")
        return [self._facade(name) for name in self.store.facade_ids()]

    def _facade(self, name: str) -> FoundFacade:
        f = self.store.facade(name)
        frame = Rigid3("local", "facade", f.frame.R, f.frame.t + self.shift)
        return FoundFacade(f.id, f.building, frame, f.outline, f.local_from_facade.covariance)

    def points(self) -> LabelledPoints | Absent:
        """The cloud with the true house and the building found of every point."""
        records = self.store.building_records()
        if "buildings" not in self.manifest.stages:
            return Absent("no buildings have been looked for")
        house = self._true_houses()
        if isinstance(house, Absent):
            return house
        moved = any(scan["pose"] == "approximate" for scan in self.project["scans"])
        cloud = self.store.cloud(registered=moved).xyz
        if len(cloud) != len(house):
            return Absent(f"the cloud has {len(cloud)} points, the truth of its scans {len(house)}")
        found = np.full(len(cloud), -1, np.int64)
        key = _fingerprints(cloud)
        order = np.argsort(key, kind="stable")
        for number, record in enumerate(records):
            own = _fingerprints(self._own_points(record.id))
            at = np.searchsorted(key[order], own)
            at = np.minimum(at, len(key) - 1)
            same = key[order[at]] == own
            found[order[at[same]]] = number
        return LabelledPoints(cloud + self.shift, house, found, tuple(r.id for r in records))

    def _own_points(self, building: str) -> Float:
        cloud, found = self.store.surveyed(building)
        return np.asarray(cloud.xyz[found.index])

    def _true_houses(self) -> Int | Absent:
        """True house (n,) of every point of the run's scans, in their order; -1 = none."""
        known = {Path(p["file"]).name: p["truth"] for p in self.truth.points}
        parts = [np.empty(0, np.int64)]
        for scan in self.project["scans"]:
            name = Path(scan["path"]).name
            if name not in known:
                return Absent(f"the run used {name}, of whose points the truth knows nothing")
            with np.load(self.base / known[name], allow_pickle=False) as arrays:
                solid = np.isin(arrays["part"], _HOUSE) & np.isin(arrays["echo"], (Echo.PLAIN, Echo.MIXED))
                parts.append(np.where(solid, arrays["house"].astype(np.int64), -1))
        return np.concatenate(parts)

    def orthos(self) -> list[OrthoPair] | Absent:
        """Ortho-images of true facades, each beside its true one."""
        names = self.store.facade_ids("ortho")
        if not names:
            return Absent("no ortho-image has been made")
        if not any(f.ortho for f in self.truth.facades):
            return Absent("the truth holds no true ortho-images")
        found = [self._facade(name) for name in names]
        pairs = match_facades(self.truth, found)
        return [p for k, j in pairs if (p := self._pair(self.truth.facades[k], names[j])) is not None]

    def _pair(self, facade: TrueFacade, name: str) -> OrthoPair | None:
        """A found image resampled to the true one's raster."""
        if facade.ortho is None:
            return None
        about = facade.ortho
        true = _picture(self.base / about["file"], cv2.IMREAD_COLOR)[..., ::-1]
        opening = _picture(self.base / about["ids"], cv2.IMREAD_UNCHANGED)
        with np.load(self.base / about["arrays"], allow_pickle=False) as arrays:
            depth_true = arrays["depth"].astype(np.float64)
        pixels = FacadePixels(self.store.facade_folder(name))
        at = _raster_places(pixels, facade, about, self.truth)
        image, _, gsd = read_geotiff(self.store.facade_folder(name) / "ortho.tif")
        warped = cv2.remap(np.ascontiguousarray(image), *at, cv2.INTER_LINEAR)
        valid = cv2.remap(np.ascontiguousarray(image[..., 3]), *at, cv2.INTER_NEAREST) > 0
        depth = _depth_on_truth(pixels, facade, at, self.truth)
        return OrthoPair(
            facade.id, true, warped[..., :3], valid, opening, about["gsd"], gsd, depth_true, depth
        )

    def openings(self) -> list[FoundOpening] | Absent:
        """What the facades' openings.json list."""
        files = [(n, self.store.facade_folder(n) / "openings.json") for n in self.store.facade_ids()]
        there = [(name, path) for name, path in files if path.is_file()]
        if not there:
            return Absent("no facade has an openings.json")
        return [o for name, path in there for o in self._openings_of(name, path)]

    def _openings_of(self, name: str, path: Path) -> Iterator[FoundOpening]:
        frame = self.store.facade(name).frame
        placed = Rigid3("local", "facade", frame.R, frame.t + self.shift)
        yield from json_openings(_json(path), path, placed, self.truth.world)

    def protrusions(self) -> list[FoundProtrusion] | Absent:
        """What the facades' protrusions.json list."""
        folders = [self.store.facade_folder(name) for name in self.store.facade_ids()]
        there = [path for folder in folders if (path := folder / "protrusions.json").is_file()]
        if not there:
            return Absent("no facade has a protrusions.json")
        return [p for path in there for p in json_protrusions(_json(path), path, self.truth.world)]

    def model(self) -> list[FoundOpening] | Absent:
        """Windows and doors of the LoD3 model."""
        path = self.store.out / "model" / "lod3.city.json"
        if not path.is_file():
            return Absent("there is no model/lod3.city.json")
        return [city_opening(o, k, self.truth.world) for k, o in enumerate(read_city_openings(path), 1)]

    def photos(self) -> list[FoundPose] | Absent:
        """Poses that the run estimated for its photos."""
        path = self.store.out / "orientation" / "report.json"
        if not path.is_file():
            return Absent("the run estimated no poses of photos (no orientation/report.json)")
        return photo_poses(_json(path), path, self.truth.world)

    def scans(self) -> list[FoundPose] | Absent:
        """Poses that the run estimated for its scans."""
        path = self.store.out / "registration" / "report.json"
        if not path.is_file():
            return Absent("the run estimated no poses of scans (no registration/report.json)")
        return scan_poses(_json(path), path, self.truth)


def _json(path: Path) -> Any:
    try:
        return read_json(path)
    except ValueError as error:
        raise FileError(path, f"is not JSON ({error})", "make it again") from None


def _picture(path: Path, flags: int) -> Array:
    image = cv2.imread(str(path), flags)
    if image is None:
        raise FileError(path, "is missing or no picture", "simulate the scene again")
    return np.asarray(image)


def _fingerprints(xyz: Float) -> Array:
    """A number (n,) uint64 per point that only equal coordinates share."""
    bits = np.ascontiguousarray(xyz + 0.0).view(np.uint64).reshape(-1, 3)
    primes = np.array([0x9E3779B97F4A7C15, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9], np.uint64)
    mixed = (bits ^ (bits >> np.uint64(29))) * primes
    mixed ^= mixed >> np.uint64(32)
    return np.asarray((mixed * primes[::-1]).sum(1, dtype=np.uint64))


def _raster_places(pixels: FacadePixels, facade: TrueFacade, about: Any, truth: Truth) -> tuple[Array, Array]:
    """Columns and rows (h, w) float32 of the found image under the true raster, as cv2.remap counts them."""
    gsd, (x0, z1) = float(about["gsd"]), about["corner"]
    x = x0 + (np.arange(about["width"]) + 0.5) * gsd
    z = z1 - (np.arange(about["height"]) + 0.5) * gsd
    X, Z = np.meshgrid(x, z)
    local = facade.frame.apply(np.column_stack([X.ravel(), np.zeros(X.size), Z.ravel()]))
    places, _ = pixels.pixels_from_world(truth.world.to_world(local))
    at = (places - 0.5).astype(np.float32).reshape(*X.shape, 2)
    return np.ascontiguousarray(at[..., 0]), np.ascontiguousarray(at[..., 1])


def _depth_on_truth(pixels: FacadePixels, facade: TrueFacade, at: tuple[Array, Array], truth: Truth) -> Float:
    """The found relief (h, w) m on the true raster, behind the true plane; NaN where there is none."""
    nowhere: Any = float("nan")
    depth = cv2.remap(
        np.ascontiguousarray(pixels.depth),
        *at,
        cv2.INTER_NEAREST,
        borderMode=cv2.BORDER_CONSTANT,
        borderValue=nowhere,
    ).astype(np.float64)
    column, row = (a.astype(np.float64) + 0.5 for a in at)
    M, normal = pixels.raster_to_world, facade.frame.R[:, 1]
    start = (truth.world.to_local(M[:3, 3]) - facade.frame.t) @ normal
    along = M[:3, :3].T @ normal
    return np.asarray(start + column * along[0] + row * along[1] + depth * along[2])
