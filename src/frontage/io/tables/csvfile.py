"""A table as CSV (RFC 4180, UTF-8): a row per feature, its geometry as well-known text in the last column."""

import csv
import io
from pathlib import Path

import shapely

from frontage.io.files import whole_file
from frontage.io.tables.table import Table, Value

_DIGITS = 4  # 0.1 mm


def write_csv(path: Path, table: Table) -> None:
    """Write a table; numbers and coordinates are rounded to 0.1 mm. Raises FileError when that fails."""
    text = io.StringIO()
    writer = csv.writer(text)
    writer.writerow([*(column.name for column in table.columns), "wkt"])
    for row, geometry in zip(table.rows, table.geometries, strict=True):
        wkt = "" if geometry is None else shapely.to_wkt(geometry, rounding_precision=_DIGITS)
        writer.writerow([*(_text(value) for value in row), wkt])
    with whole_file(path) as temporary:
        temporary.write_bytes(text.getvalue().encode())


def _text(value: Value) -> str:
    if value is None:
        return ""
    return f"{value:.{_DIGITS}f}" if isinstance(value, float) else str(value)
