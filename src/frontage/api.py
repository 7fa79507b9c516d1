"""The public functions of Frontage. `frontage.__all__` is the promise; import them from `frontage`."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from frontage.buildings import BuildingOptions, BuildingSplit
from frontage.buildings import find_buildings as _find_buildings
from frontage.catalog.sightlines import name_photos, scanned_surfaces
from frontage.crossbars import CrossbarOptions, FoundBars
from frontage.crossbars.find import find_bars as _find_bars
from frontage.errors import InputError
from frontage.facades import FacadeOptions
from frontage.facades import find_facades as _find_facades
from frontage.io.citymodels.footprints import read_footprints
from frontage.io.citymodels.read import read_city_model
from frontage.io.photos.photoset import PhotoSet
from frontage.io.photos.read import PhotoSource
from frontage.io.photos.read import read_photos as _read_photos
from frontage.io.scans.read import ScanSource
from frontage.io.scans.read import read_scans as _read_scans
from frontage.model import Building, Elements, Facade, Failed, Finding, OrthoImage, Scan, Solid, merge_scans
from frontage.openings import FoundOpenings, OpeningOptions
from frontage.openings import find_openings as _find_openings
from frontage.ortho import OrthoOptions
from frontage.ortho import make_ortho as _make_ortho
from frontage.pipeline.progress import Progress
from frontage.pipeline.project import Project, found_offset, load_project, make_project
from frontage.pipeline.run import Summary
from frontage.pipeline.run import run as _run
from frontage.queries.answer import Located
from frontage.queries.runfolder import RunFolder, open_run
from frontage.queries.validation import FileFindings, validate_file
from frontage.solids import Assembled, BuildOptions, assemble, match_model
from frontage.validation import validate as _validate_solid

__all__ = [
    "build_model",
    "find_bars",
    "find_buildings",
    "find_facades",
    "find_openings",
    "locate",
    "make_ortho",
    "open_run",
    "read_photos",
    "read_scans",
    "run",
    "validate",
]


def run(
    project: Project | Path | str | dict[str, Any],
    out: Path | str,
    *,
    workers: int = 1,
    progress: Progress | None = None,
) -> Summary:
    """Run the whole chain into the folder `out` and return what it made; finished stages are kept.

    project  a project file (TOML), a table of the same shape (paths relative to the current folder), or a
             checked `Project`

    Raises FrontageError with one sentence: bad input, an unusable folder, or nothing found.
    """
    if isinstance(project, dict):
        project = make_project(project, Path.cwd())
    elif not isinstance(project, Project):
        project = load_project(Path(project))
    return _run(project, out, workers=workers, progress=progress)


def read_scans(*paths: Path | str, crs: str | None = None, **about: Any) -> Scan:
    """Read scans (LAS, LAZ, COPC, E57, PTX, PLY, PCD, XYZ, COLMAP points) into one cloud in one local frame.

    crs    projected metric CRS of the result; default: that of the first file
    about  what you know of the files, as in `[[scans]]` of a project file: crs of the file as `file_crs`,
           units, offset, trajectory, stations, sigma_range

    Returns points (n, 3) float64 m in local coordinates; `scan.world` takes them to the world.
    Raises FileError, CrsError, MissingExtra.
    """
    if not paths:
        raise InputError("give at least one scan file")
    if "file_crs" in about:
        about["crs"] = about.pop("file_crs")
    scans: list[Scan] = []
    for path in paths:
        world = scans[0].world if scans else None
        scans += _read_scans(ScanSource(path=str(path), **about), world, crs)
    return merge_scans(scans)


def read_photos(path: Path | str, scan: Scan, *, cameras: Path | str | None = None, **about: Any) -> PhotoSet:
    """Read photographs with their poses into the local frame of a scan; pixels are read on demand.

    path     folder, file or glob of pictures, or an E57 file with embedded ones
    cameras  COLMAP model folder with their cameras and poses; an `offset.txt` in it is added to the positions
    about    as in `[photos]` of a project file: offset (m, added to camera positions), pose, sigmas

    Raises FileError, InputError.
    """
    table = {"path": str(path), "cameras": None if cameras is None else str(cameras), **about}
    return _read_photos(PhotoSource.model_validate(found_offset(table)), scan.world)


def find_buildings(
    scan: Scan, footprints: Path | str | None = None, options: BuildingOptions | None = None
) -> BuildingSplit:
    """Divide a street cloud into buildings, ground, occluders and the rest (paper A, section 2.1).

    footprints  a city model or map (CityJSON, CityGML, GeoJSON, GeoPackage) that tells where houses end

    The indices of the result are int64 into the scan. Raises FileError for the map.
    """
    plans = read_footprints(Path(footprints), scan.world) if footprints is not None else ()
    return _find_buildings(scan, options or BuildingOptions(), plans)


def find_facades(
    scan: Scan, building: Building, options: FacadeOptions | None = None, *, seed: int = 0
) -> tuple[Facade | Failed, ...]:
    """Find the main facades of a building: plane, frame, outline, layers (paper A, section 2.2).

    scan  the cloud that `building.index` points into; what surrounds the building tells the street side

    The facade with the most wall comes first. A `Failed` says why there is none.
    """
    return _find_facades(scan, building, options, seed)


def make_ortho(
    facade: Facade,
    scan: Scan,
    photos: PhotoSet | None = None,
    *,
    gsd: float | None = None,
    options: OrthoOptions | None = None,
) -> OrthoImage | Failed:
    """Make the ortho-image of a facade from photos, or from the scan without them (paper A, section 2.3).

    scan  the cloud that the facade was found in; it also tells what hides the facade from the photos
    gsd   m per pixel; default: that of the options

    A `Failed` says why nothing shows the facade. Raises OptionError for a raster too large to store.
    """
    options = options or OrthoOptions()
    if gsd is not None:
        options = OrthoOptions.model_validate({**options.model_dump(), "gsd": gsd})
    if photos is None:
        return _make_ortho(facade, scan, options=options)
    return _make_ortho(facade, scan, photos.photos, photos.image, surroundings=scan, options=options)


def find_openings(
    facade: Facade, scan: Scan, options: OpeningOptions | None = None, *, ortho: OrthoImage | None = None
) -> FoundOpenings | Failed:
    """Find openings and protrusions of a facade from the beams of the scan (paper B, sections 3.1 and 3.2).

    scan   the cloud that the facade was found in
    ortho  its ortho-image, for scans without intensity and colour: closed shutters are told by their look

    The result holds `openings`, `protrusions`, `notes` and the evidence. Lengths are m in the facade frame;
    every opening carries the covariance of its outline. A `Failed` says why the facade cannot be judged.
    """
    return _find_openings(facade, scan, options, ortho)


def find_bars(
    facade: Facade,
    elements: Elements | FoundOpenings,
    scan: Scan | None,
    photos: PhotoSet | None = None,
    options: CrossbarOptions | None = None,
) -> FoundBars:
    """Find the bars in the windows of a facade from photos and scan (paper B, section 3.3).

    elements  what `find_openings` found on it
    scan      the cloud that the facade was found in; it also tells what hides windows from the photos
    photos    with their poses; None = bars from the scan alone

    The result holds the elements with the `glazing` of every window, and pictures of what each layout was
    chosen from. A window that nothing shows well enough is "not resolved" with a reason.
    Raises FileError for a picture that cannot be read.
    """
    found = elements.elements if isinstance(elements, FoundOpenings) else elements
    oriented = [p for p in photos.photos if p.local_from_camera is not None] if photos else []
    surfaces = None if scan is None or not oriented else scanned_surfaces(scan.xyz)
    named = name_photos(facade, found, oriented, surfaces)
    image = photos.image if photos else _no_pixels
    return _find_bars(facade, named, oriented, image, scan, options)


def _no_pixels(name: str) -> Any:
    raise KeyError(name)


def build_model(
    building: Building,
    facades: Sequence[tuple[Facade, Elements | FoundOpenings | FoundBars]],
    city_model: Path | str | None = None,
    options: BuildOptions | None = None,
) -> Assembled | Failed:
    """Build the closed LoD3 solids of a building from what was found on its facades (paper B, 3.2.3).

    city_model  the coarse solid to cut the openings into; without one, a block behind the facades

    Every solid has passed the validator. A `Failed` says why there is none. Raises FileError for the model.
    """
    if not facades:
        raise InputError("give at least one facade with its elements")
    options, world = options or BuildOptions(), facades[0][0].world
    shells: tuple[Any, ...] = ()
    if city_model is not None:
        city = read_city_model(Path(city_model), world).buildings
        (group,) = match_model({building.id: [facade for facade, _ in facades]}, city, options)
        shells = tuple(shell for b in city if b.id in group.model for shell in b.level("2"))
    fronts = [(f, e if isinstance(e, Elements) else e.elements) for f, e in facades]
    return assemble(building, fronts, shells, world, options)


def validate(model: Solid | Path | str) -> tuple[Finding, ...] | FileFindings:
    """Check solids by ISO 19107, with the error codes of val3dity.

    model  a solid of this program, which gives its findings; or a file (CityJSON, CityGML, OBJ, OFF, ...),
           which gives a summary with `.valid` and `.findings`
    """
    return _validate_solid(model) if isinstance(model, Solid) else validate_file(model)


def locate(
    out: RunFolder | Path | str,
    address: str,
    *,
    floor: int | None = None,
    window: int | None = None,
    door: int | None = None,
    facade: str | None = None,
) -> Located:
    """Locate an opening of a run: `locate("out", "13 rue Soufflot", floor=3, window=2)`, or by its id.

    Returns its outline in the world with standard errors, and the photos that show it. Raises InputError
    with one sentence if there is none.
    """
    folder = out if isinstance(out, RunFolder) else open_run(out)
    return folder.locate(address, floor=floor, window=window, door=door, facade=facade)
