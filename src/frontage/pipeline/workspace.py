"""The run folder: where everything lies, what is finished, and the answers it gives.

Layout (DESIGN section 6, plus what makes a run resumable)::

    OUT/manifest.json                inputs with hashes, versions, seed, resolved options, stages, warnings
    OUT/.done/<stage>[.<item>].json  marker of a finished stage or task: its key and its result
    OUT/scans/cloud.npz              all scans in one local frame, as given
    OUT/scans/part_000.npz, registered.npz   each scan as given, and all in place, when scans are registered
    OUT/registration/report.json     transforms, covariances, what was observable
    OUT/buildings/index.json         the buildings; surroundings.npz: the whole cloud, thinned
    OUT/buildings/B07.laz            the building's own points, for users
    OUT/buildings/B07.npz, .index.npy   its working cloud (with surroundings) and which points are its own
    OUT/facades/B07_F1/              facade.json, points.npz, ortho.*, depth.tif, openings.json, ...
    OUT/model/  OUT/report.html

A marker's key is a fingerprint of inputs, options and code. It is removed before its files are touched and
written after the last of them, so a run that was killed at any point goes on where it was.
"""

import shutil
from pathlib import Path
from typing import TYPE_CHECKING, Any

from frontage.errors import InputError, WorkspaceError
from frontage.model import Facade
from frontage.pipeline.files import read_json, write_json
from frontage.pipeline.pixels import FacadePixels
from frontage.pipeline.records import load_facade

if TYPE_CHECKING:
    from frontage.pipeline.located import Located


class Workspace:
    """A run folder. `Workspace(out).facade("B07/F1").pixel_to_world(column, row)` measures in it."""

    def __init__(self, out: Path | str) -> None:
        """Open an existing run folder. Raises WorkspaceError when it is none."""
        self.out = Path(out)
        if self.out.exists() and not self.out.is_dir():
            raise WorkspaceError(f"{self.out} is a file, not a run folder; give another name")
        if not self.manifest_path.is_file():
            raise WorkspaceError(
                f"{self.out} is not a run folder (it has no manifest.json); `frontage run` makes one"
            )

    @classmethod
    def create(cls, out: Path | str) -> "Workspace":
        """Open a run folder, made when it does not exist. Raises WorkspaceError when it cannot be one."""
        path = Path(out)
        if path.exists() and not path.is_dir():
            raise WorkspaceError(f"{path} is a file; give another name for the run folder")
        try:
            path.mkdir(parents=True, exist_ok=True)
            if not (path / "manifest.json").is_file():
                write_json(path / "manifest.json", {})
        except OSError as error:
            raise WorkspaceError(
                f"{path} cannot be written ({error.strerror}); give another run folder"
            ) from None
        return cls(path)

    # -- where things lie ------------------------------------------------------------------------------

    @property
    def manifest_path(self) -> Path:
        """OUT/manifest.json."""
        return self.out / "manifest.json"

    @property
    def cloud_path(self) -> Path:
        """The merged cloud of all scans, as given."""
        return self.out / "scans" / "cloud.npz"

    def part_path(self, number: int) -> Path:
        """One scan as given, of a run that registers scans."""
        return self.out / "scans" / f"part_{number:03d}.npz"

    @property
    def registered_path(self) -> Path:
        """The merged cloud of all scans, in place."""
        return self.out / "scans" / "registered.npz"

    @property
    def registration_folder(self) -> Path:
        """OUT/registration."""
        return self.out / "registration"

    @property
    def buildings_folder(self) -> Path:
        """OUT/buildings."""
        return self.out / "buildings"

    @property
    def surroundings_path(self) -> Path:
        """The whole cloud, thinned, for the photos' z-buffer."""
        return self.buildings_folder / "surroundings.npz"

    def facade_folder(self, facade: str) -> Path:
        """OUT/facades/B07_F1 of "B07/F1"."""
        return self.out / "facades" / facade.replace("/", "_")

    # -- what is in it ---------------------------------------------------------------------------------

    def manifest(self) -> dict[str, Any]:
        """The manifest. Raises WorkspaceError when it cannot be read."""
        try:
            manifest = read_json(self.manifest_path)
        except (OSError, ValueError) as error:
            raise WorkspaceError(
                f"{self.manifest_path} cannot be read ({error}); run `frontage run` again"
            ) from None
        return dict(manifest)

    def building_records(self) -> list[dict[str, Any]]:
        """The buildings found, in order; empty before that stage."""
        path = self.buildings_folder / "index.json"
        return list(read_json(path)["buildings"]) if path.is_file() else []

    def facade_ids(self) -> list[str]:
        """The facades found, in the order of the buildings."""
        return [facade for record in self.building_records() for facade in self.facades_of(record["id"])]

    def facades_of(self, building: str) -> list[str]:
        """The facades found of one building; empty before that stage."""
        marker = self.done("facades", building)
        return list(marker["result"]["facades"]) if marker else []

    def ortho_ids(self) -> list[str]:
        """The facades that have an ortho-image, in the order of the buildings."""
        done = [self.done("ortho", record["id"]) for record in self.building_records()]
        return [facade for marker in done if marker for facade in marker["result"]["orthos"]]

    def opening_ids(self) -> list[str]:
        """The facades whose openings were looked for with success, in the order of the buildings."""
        done = [self.done("openings", record["id"]) for record in self.building_records()]
        return [facade for marker in done if marker for facade in marker["result"]["facades"]]

    def load_facade(self, facade: str) -> Facade:
        """The facade noun. Raises WorkspaceError when there is none of that name."""
        return load_facade(self._known_facade(facade))

    def facade(self, facade: str) -> FacadePixels:
        """Pixel <-> world of a facade ("B07/F1" or "B07_F1"). Raises InputError for an unknown name."""
        return FacadePixels(self._known_facade(facade))

    def locate(
        self,
        address: str,
        *,
        floor: int | None = None,
        window: int | None = None,
        door: int | None = None,
        facade: str | None = None,
    ) -> "Located":
        """Where an opening is: `locate("13 rue Soufflot", floor=3, window=2)`, or by its id alone.

        See `frontage.pipeline.locate.locate`. Raises InputError with one sentence when there is none.
        """
        from frontage.pipeline.locate import locate

        return locate(self, address, floor=floor, window=window, door=door, facade=facade)

    def remove_building(self, building: str) -> None:
        """Remove the files of a building that the latest split does not know any more."""
        facades = self.facades_of(building)
        self.begin("facades", building)
        self.begin("ortho", building)
        self.begin("openings", building)
        for facade in facades:
            shutil.rmtree(self.facade_folder(facade), ignore_errors=True)
        for ending in (".npz", ".index.npy", ".laz", ".laz.stations.json"):
            (self.buildings_folder / f"{building}{ending}").unlink(missing_ok=True)

    def _known_facade(self, facade: str) -> Path:
        ids = self.facade_ids()
        known = facade.replace("_", "/")
        if known not in ids:
            some = ", ".join(ids[:12]) + (", ..." if len(ids) > 12 else "") or "none yet"
            raise InputError(f"no facade {facade!r} in {self.out}; known: {some}")
        return self.facade_folder(known)

    # -- what is finished ------------------------------------------------------------------------------

    def _marker(self, stage: str, item: str) -> Path:
        return self.out / ".done" / (f"{stage}.{item.replace('/', '_')}.json" if item else f"{stage}.json")

    def done(self, stage: str, item: str = "", key: str | None = None) -> dict[str, Any] | None:
        """The marker (`key`, `result`) of a finished stage or task; None when not finished or not current."""
        try:
            marker = read_json(self._marker(stage, item))
        except (OSError, ValueError):
            return None
        return dict(marker) if key is None or marker.get("key") == key else None

    def begin(self, stage: str, item: str = "") -> None:
        """Files of this task are about to change: forget that it was finished."""
        self._marker(stage, item).unlink(missing_ok=True)

    def finish(self, stage: str, item: str, key: str, result: dict[str, Any]) -> None:
        """Every file of this task is written."""
        write_json(self._marker(stage, item), {"key": key, "result": result})
