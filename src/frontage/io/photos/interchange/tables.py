"""Tables in text files: a row of names, then rows of values, divided by comma, semicolon, tab or space."""

import csv
import re
from dataclasses import dataclass
from pathlib import Path

from frontage.io.photos.interchange.numbers import finite

_HEAD = 65536  # characters in which the row of names is searched when a file is only looked at
_UNIT = re.compile(r"(.*?)[\s_]*[\[(/_]\s*([a-z°]+)\s*[\])]?$")
_UNITS = {
    **dict.fromkeys(("deg", "degree", "degrees", "°"), "deg"),
    **dict.fromkeys(("gon", "grad", "grads", "gons"), "gon"),
    **dict.fromkeys(("rad", "radian", "radians"), "rad"),
    **dict.fromkeys(("m", "metre", "meter", "metres", "meters"), "m"),
}


@dataclass(frozen=True)
class Table:
    """The values of a file under the names that the reader asked for.

    rows      one mapping of name to text for every row
    units     "deg", "gon", "rad" or "m" of the columns whose name states it
    order     the names in the order of the columns
    comments  the lines before the row of names
    """

    rows: list[dict[str, str]]
    units: dict[str, str]
    order: tuple[str, ...]
    comments: tuple[str, ...]


Names = dict[str, tuple[str, ...]]
"""The column that a reader asks for, and the names that files give it, in lower case."""


def header(line: str, names: Names) -> tuple[tuple[str, ...], dict[str, str]]:
    """The columns of a row of names, "" for those not asked for, and the units that they state."""
    parts = (
        re.split(r"[,;\t]", line.strip().lstrip("#").strip()) if re.search(r"[,;\t]", line) else line.split()
    )
    found: list[str] = []
    units: dict[str, str] = {}
    for part in parts:
        text = part.strip().strip('"').lstrip("#").strip().lower()
        stated = _UNIT.match(text)
        unit = _UNITS.get(stated[2]) if stated else None
        plain = stated[1].strip() if stated and unit else text
        column = next((column for column, known in names.items() if plain in known), "")
        column = "" if column in found else column
        found.append(column)
        if unit and column:
            units[column] = unit
    return tuple(found), units


def has_header(path: Path, names: Names, needed: tuple[str, ...]) -> bool:
    """Whether one of the first lines of a file names all of the columns `needed`; False if unreadable."""
    if not path.is_file():
        return False
    try:
        with path.open(encoding="utf-8-sig", errors="replace") as file:
            head = file.read(_HEAD)
    except (OSError, ValueError):
        return False
    return any(set(needed) <= set(header(line, names)[0]) for line in head.splitlines())


def read_table(path: Path, names: Names, needed: tuple[str, ...]) -> Table:
    """Read a table whose row of names holds the columns `needed`.

    Raises ValueError when there is no such row or a row of values does not fit it.
    """
    lines = path.read_text("utf-8-sig").splitlines()
    at = next((k for k, line in enumerate(lines) if set(needed) <= set(header(line, names)[0])), None)
    if at is None:
        raise ValueError(f"no row names the columns {', '.join(needed)}")
    order, units = header(lines[at], names)
    rows = []
    for number, line in enumerate(lines[at + 1 :], at + 2):
        if not line.strip() or line.lstrip().startswith("#"):
            continue
        values = _split(line, len(order))
        if len(values) != len(order):
            raise ValueError(f"line {number} has {len(values)} values instead of {len(order)}")
        rows.append({n: v.strip() for n, v in zip(order, values, strict=True) if n})
    return Table(rows, units, tuple(n for n in order if n), tuple(lines[:at]))


def _split(line: str, count: int) -> list[str]:
    """The values of a row; with spaces between them, the first, a name, may hold spaces itself."""
    for divider in ("\t", ";", ","):
        if divider in line:
            values = next(csv.reader([line], delimiter=divider))
            return (
                values[:count]
                if len(values) > count and not any(v.strip() for v in values[count:])
                else values
            )
    return line.strip().rsplit(None, count - 1) if count > 1 else [line]


def numbers(row: dict[str, str], columns: tuple[str, ...], name: str) -> list[float]:
    """The numbers of a row under some columns. Raises ValueError that names the photo."""
    return [finite(row[column], f"{column} of {name}") for column in columns]
