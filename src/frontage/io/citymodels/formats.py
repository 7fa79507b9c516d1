"""The registry of city model formats. A new format is one module with a reader, and one entry here."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path

from frontage.io.citymodels.deferred import DeferredPlacement
from frontage.io.citymodels.draft import BuildingDraft
from frontage.io.citymodels.jsonstream import first_type

Reader = Callable[[Path, DeferredPlacement], Iterator[BuildingDraft]]

_HEAD_BYTES = 4096  # that are examined to tell a format
_IGNORED = b"\xef\xbb\xbf \t\r\n\x1e"  # byte order mark, blanks, record separator


@dataclass(frozen=True)
class CityModelFormat:
    """A kind of city model file.

    name        as users know it
    holds       what a file of it holds
    reader      "module:function", imported when it is first used
    begins      what the file begins with
    json_types  of a JSON file: values of `type` of its first object
    """

    name: str
    holds: str
    reader: str
    begins: bytes
    json_types: tuple[str, ...] = ()

    def read(self, path: Path, place: DeferredPlacement) -> Iterator[BuildingDraft]:
        """The buildings of a file of this format, as drafts."""
        module, function = self.reader.split(":")
        reader: Reader = getattr(import_module(module), function)
        return reader(path, place)


_MODELS = "frontage.io.citymodels"

FORMATS = (
    CityModelFormat(
        "CityGML",
        "buildings of CityGML 1 to 3 with solids, thematic surfaces, openings, parts, textures",
        f"{_MODELS}.citygml.read:read_citygml",
        b"<",
    ),
    CityModelFormat(
        "GeoPackage",
        "footprints, with heights where an attribute holds them",
        f"{_MODELS}.geopackage:read_geopackage",
        b"SQLite format 3",
    ),
    CityModelFormat(
        "CityJSON",
        "buildings of CityJSON 1.0 to 2.0 or CityJSONSeq with solids, semantic surfaces, parts, textures",
        f"{_MODELS}.cityjson.read:read_cityjson",
        b"{",
        ("CityJSON",),
    ),
    CityModelFormat(
        "GeoJSON",
        "footprints, with heights where a property holds them",
        f"{_MODELS}.geojson:read_geojson",
        b"{",
        ("FeatureCollection", "Feature"),
    ),
)
"""Every format, in the order in which they are tried."""


def city_model_format(path: Path) -> CityModelFormat | None:
    """The format of a file by its content; None when it is none of the registry's.

    Raises ValueError on damaged JSON.
    """
    with open(path, "rb") as f:
        head = f.read(_HEAD_BYTES).lstrip(_IGNORED)
    candidates = [f for f in FORMATS if head.startswith(f.begins)]
    if not any(f.json_types for f in candidates):
        return candidates[0] if candidates else None
    kind = first_type(path)
    return next((f for f in candidates if kind in f.json_types), None)
