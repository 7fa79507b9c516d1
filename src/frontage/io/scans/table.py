"""Text tables of numbers: the delimiter, the header row and decimal commas are found from the content."""

import io
import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from frontage.errors import FileError
from frontage.geometry.arrays import Float
from frontage.io.files import reading, require_file

_COMMENT = ("#", "//", "%")
_HEAD_BYTES = 64_000  # that are examined to find the layout


@dataclass(frozen=True, eq=False)
class Table:
    """Values (n, k) float64, and the names (k,) of the columns in lower case, empty without a header row."""

    path: Path
    values: Float
    names: tuple[str, ...]

    def column(self, *names: str) -> Float | None:
        """The column (n,) with the first of these names that the table has; None when it has none of them."""
        found = [n for n in names if n in self.names]
        return self.values[:, self.names.index(found[0])] if found else None


def read_table(path: str | Path, kind: str) -> Table:
    """Read a table of numbers that are separated by commas, semicolons, tabs or blanks.

    A header row names the columns and may begin with "#" or "//". Other comment lines, and a first line with
    the number of points, are skipped. Decimal commas are accepted where the separator is not a comma. `kind`
    says in messages what the file should be.

    Raises FileError when the file is missing, binary, or not a table.
    """
    p = require_file(path)
    with reading(p, kind):
        with open(p, "rb") as f:
            head = f.read(_HEAD_BYTES)
        if b"\0" in head:
            raise FileError(p, f"not a readable {kind} file (it is binary)", "check its type", code="I103")
        lines = head.decode("utf-8-sig", "replace").splitlines()
        skip, names, delimiter, commas = _layout(lines, p)
        values = _load(p, skip, delimiter, commas)
    if names and len(names) != values.shape[1]:
        names = ()
    return Table(p, values, names)


def _layout(lines: list[str], path: Path) -> tuple[int, tuple[str, ...], str | None, bool]:
    """The number of rows to skip, the names of the columns, the delimiter (None = blanks), decimal commas."""
    names: tuple[str, ...] = ()
    for row, line in enumerate(lines):
        text = line.strip()
        if not text:
            continue
        delimiter = next((d for d in (";", "\t") if d in text), None)
        commas = delimiter is not None and bool(re.search(r"\d,\d", text)) and "." not in text
        if delimiter is None and "," in text:
            delimiter = ","
        fields = [f.strip() for f in text.split(delimiter) if f.strip()] if delimiter else text.split()
        if len(fields) >= 2 and all(_is_number(f, commas) for f in fields):
            return row, names, delimiter, commas
        bare = text.lstrip("#/% ")
        parts = (
            [f.strip().strip('"').lower() for f in bare.split(delimiter)]
            if delimiter
            else bare.lower().split()
        )
        if not all(_is_number(f, commas) for f in fields):
            names = tuple(re.sub(r"\s*[\[(].*", "", f) for f in parts) if len(parts) >= 2 else names
    raise FileError(path, "holds no rows of numbers", "check its type and columns", code="I105")


def _is_number(text: str, commas: bool) -> bool:
    try:
        float(text.replace(",", ".") if commas else text)
    except ValueError:
        return False
    return True


def _load(path: Path, skip: int, delimiter: str | None, commas: bool) -> Float:
    """The numbers below the header as (n, k)."""
    source: Path | io.StringIO = path
    if commas:
        source = io.StringIO(path.read_text("utf-8-sig", "replace").replace(",", "."))
    table: Float = np.loadtxt(
        source,
        np.float64,
        comments=list(_COMMENT),
        delimiter=delimiter,
        skiprows=skip,
        ndmin=2,
        encoding="utf-8-sig",
    )
    return table
