"""City models of any format as buildings in local metres: the one way in for every stage."""

from collections.abc import Callable, Iterator
from pathlib import Path

from frontage.errors import FileError
from frontage.io.citymodels.citygml.read import read_citygml
from frontage.io.citymodels.cityjson.read import read_cityjson
from frontage.io.citymodels.draft import Draft, finish
from frontage.io.citymodels.geojson import json_kind, read_geojson
from frontage.io.citymodels.geopackage import read_geopackage
from frontage.io.citymodels.place import Place
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
    """Read the buildings of CityJSON 1.0 to 2.0, CityJSONSeq, CityGML 1 to 3, GeoJSON or GeoPackage.

    Of the last two, footprints of known height become blocks of LoD1 (docs/citymodels.md).

    world   the world of the run; decided from the file when None (projected metric CRS, integer origin)
    bounds  (x0, y0, x1, y1) or (x0, y0, z0, x1, y1, z1), m world: buildings that do not touch it are left out
    crs     the CRS of the file, over what it says itself

    Polygons that cannot be used are left out and named in the model's `problems`, building by building.

    Raises FileError (missing, empty, damaged, no buildings, none within the bounds), UnsupportedFormat,
    CrsError (unknown, missing, cannot be transformed).
    """
    p = require_file(path)
    place = Place(p.name, world, crs, bounds)
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
        raise _nothing(p, seen, problems, place)
    assert place.world is not None
    return CityModel(tuple(buildings), place.world, tuple(problems), tuple(place.notes))


def _nothing(path: Path, seen: int, problems: list[Failed], place: Place) -> FileError:
    """Why there is no building."""
    if problems:
        what = f"none of its {seen} buildings can be used ({problems[0].message})"
        return FileError(path, what, "repair the model", code="I103")
    far = place.far()
    if not far:
        return FileError(path, "holds no buildings", _ADVICE, code="I105")
    return FileError(path, "holds no buildings within the bounds", far, code="I206")


def kind_of(path: Path) -> str | None:
    """CityGML, CityJSON, GeoJSON or GeoPackage by the content of a file; None for anything else.

    Raises ValueError on damaged JSON.
    """
    with open(path, "rb") as f:
        head = f.read(4096).lstrip(b"\xef\xbb\xbf \t\r\n\x1e")
    if head[:1] == b"<":
        return "CityGML"
    if head.startswith(b"SQLite format 3"):
        return "GeoPackage"
    if head[:1] != b"{":
        return None
    return {"CityJSON": "CityJSON", "FeatureCollection": "GeoJSON", "Feature": "GeoJSON"}.get(json_kind(path))


_READERS: dict[str, Callable[[Path, Place], Iterator[Draft]]] = {
    "CityGML": read_citygml,
    "CityJSON": read_cityjson,
    "GeoJSON": read_geojson,
    "GeoPackage": read_geopackage,
}


def _drafts(path: Path, place: Place) -> Iterator[Draft]:
    """The buildings of a file of any format."""
    kind = kind_of(path)
    if kind is None:
        raise ValueError("it is no CityGML, CityJSON, GeoJSON or GeoPackage")
    yield from _READERS[kind](path, place)
