"""City models of any format as buildings in local metres: the one entry for every stage."""

from collections.abc import Iterator
from pathlib import Path

from frontage.errors import FileError
from frontage.io.citymodels.deferred import DeferredPlacement
from frontage.io.citymodels.draft import BuildingDraft, finish
from frontage.io.citymodels.formats import FORMATS, city_model_format
from frontage.io.files import reading, require_file
from frontage.model import CityModel, Failed, WorldRef
from frontage.model.citymodel import CityBuilding

_ADVICE = "name a CityJSON, CityGML, GeoJSON or GeoPackage file"


def read_city_model(
    path: str | Path,
    world: WorldRef | None = None,
    bounds: tuple[float, ...] | None = None,
    crs: str | None = None,
) -> CityModel:
    """Read the buildings of a CityJSON, CityJSONSeq, CityGML, GeoJSON or GeoPackage file.

    In GeoJSON and GeoPackage files, footprints of known height become blocks of LoD1
    (docs/reference/city-models.md).
    Polygons that cannot be used are left out; the model's `problems` name them, building by building.

    world   the world of the run; None: decided from the file (projected metric CRS, whole-metre origin)
    bounds  (x0, y0, x1, y1) or (x0, y0, z0, x1, y1, z1), m world: buildings that do not touch it are left out
    crs     the CRS of the file's coordinates; it overrides what the file states

    Raises FileError (missing, empty, damaged, no buildings, none within the bounds), UnsupportedFormat,
    CrsError (unknown, missing, cannot be transformed).
    """
    p = require_file(path)
    place = DeferredPlacement(p.name, world, crs, bounds)
    buildings: list[CityBuilding] = []
    problems: list[Failed] = []
    seen = 0
    with reading(p, "city model", _ADVICE):
        for draft in _drafts(p, place):
            seen += 1
            building, failed = finish(draft, place.to_local)
            buildings += [] if building is None else [building]
            problems += [] if failed is None else [failed]
    if not buildings:
        raise _no_buildings(p, seen, problems, place)
    assert place.world is not None
    return CityModel(tuple(buildings), place.world, tuple(problems), tuple(place.notes))


def _no_buildings(path: Path, seen: int, problems: list[Failed], place: DeferredPlacement) -> FileError:
    """The error that says why there is no building."""
    if problems:
        what = f"none of its {seen} buildings can be used ({problems[0].message})"
        return FileError(path, what, "repair the model", code="I103")
    advice = place.advice()
    if not advice:
        return FileError(path, "holds no buildings", _ADVICE, code="I105")
    return FileError(path, "holds no buildings within the bounds", advice, code="I206")


def _drafts(path: Path, place: DeferredPlacement) -> Iterator[BuildingDraft]:
    """The buildings of a file of any format."""
    found = city_model_format(path)
    if found is None:
        raise ValueError("it is none of " + ", ".join(f.name for f in FORMATS))
    yield from found.read(path, place)
