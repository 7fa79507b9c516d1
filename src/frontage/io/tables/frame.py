"""Tables as data frames of GeoPandas, and as GeoParquet 1.1."""

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import shapely
from pyproj import CRS

from frontage.errors import MissingExtra
from frontage.io.crs import parse_crs
from frontage.io.files import whole_file
from frontage.io.tables.table import Table

if TYPE_CHECKING:
    import geopandas

_KINDS = {"POINT": "Point", "LINESTRING": "LineString", "POLYGON": "Polygon"}


def geo_frame(table: Table, crs: str | None) -> "geopandas.GeoDataFrame":
    """Return a table as a GeoDataFrame: the columns by name, None as missing.

    crs  of geometries in the world; others, and all where it is None, have no CRS

    Raises MissingExtra without GeoPandas.
    """
    try:
        import geopandas
        import pandas
    except ImportError as error:
        raise MissingExtra("a table as a data frame", "tables") from error
    types = {"text": "str", "real": "float64", "whole": "Int64"}
    columns = {c.name: pandas.Series(table.values(c.name), dtype=types[c.kind]) for c in table.columns}
    places = geopandas.GeoSeries(list(table.geometries), crs=_system(table, crs))
    return geopandas.GeoDataFrame(columns, geometry=places)


def write_geoparquet(path: Path, table: Table, crs: str | None) -> None:
    """Write a table as GeoParquet 1.1 (geometries as WKB, CRS as PROJJSON).

    Raises MissingExtra without PyArrow, FileError when the file cannot be written.
    """
    try:
        import pyarrow
        import pyarrow.parquet
    except ImportError as error:
        raise MissingExtra("writing GeoParquet", "tables") from error
    types = {"text": pyarrow.string(), "real": pyarrow.float64(), "whole": pyarrow.int64()}
    fields = [
        pyarrow.field(c.name, types[c.kind], metadata={"description": c.description}) for c in table.columns
    ]
    arrays = [pyarrow.array(table.values(c.name), f.type) for c, f in zip(table.columns, fields, strict=True)]
    wkb = [None if g is None else shapely.to_wkb(g, byte_order=1, flavor="iso") for g in table.geometries]
    schema = pyarrow.schema(
        [*fields, pyarrow.field("geometry", pyarrow.binary())],
        metadata={"geo": json.dumps(_about(table, crs)), "description": table.about},
    )
    made = pyarrow.Table.from_arrays([*arrays, pyarrow.array(wkb, pyarrow.binary())], schema=schema)
    with whole_file(path) as temporary:
        pyarrow.parquet.write_table(made, temporary)


def _system(table: Table, crs: str | None) -> CRS | None:
    return parse_crs(crs) if crs is not None and table.in_world else None


def _about(table: Table, crs: str | None) -> dict[str, Any]:
    """The metadata "geo" of the file (GeoParquet 1.1.0)."""
    system = _system(table, crs)
    kind = _KINDS[table.geometry] + (" Z" if table.height else "")
    places = [g for g in table.geometries if g is not None]
    geometry: dict[str, Any] = {
        "encoding": "WKB",
        "geometry_types": [kind] if places else [],
        "crs": None if system is None else system.to_json_dict(),
    }
    if places:
        geometry["bbox"] = _bounds(places, table.height)
    return {"version": "1.1.0", "primary_column": "geometry", "columns": {"geometry": geometry}}


def _bounds(places: list[shapely.Geometry], height: bool) -> list[float]:
    xyz = shapely.get_coordinates(places, include_z=height)
    return [*map(float, xyz.min(0)), *map(float, xyz.max(0))]
