"""What every format of tables writes: named columns with units, rows, and at most one geometry per row."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import shapely

Value = str | float | int | None
Kind = Literal["text", "real", "whole"]
GeometryKind = Literal["POINT", "LINESTRING", "POLYGON"]


@dataclass(frozen=True)
class Column:
    """A column: its name, what its values are, their unit ("" = none), and one line about it."""

    name: str
    kind: Kind
    about: str
    unit: str = ""

    @property
    def description(self) -> str:
        """What the column holds, with its unit."""
        return f"{self.about} ({self.unit})" if self.unit else self.about


@dataclass(frozen=True, eq=False)
class Table:
    """Rows of values in the order of the columns; None = not known.

    name        of the layer, such as "openings"
    geometry    kind of the geometries
    geometries  one per row, m; None where a row has no place
    height      whether the geometries have heights (z)
    in_world    whether they are in the CRS of the world; else in a plane of their own, such as a facade's

    Raises ValueError for rows of another length than the columns, or a wrong number of geometries.
    """

    name: str
    about: str
    columns: tuple[Column, ...]
    rows: tuple[tuple[Value, ...], ...]
    geometry: GeometryKind
    geometries: tuple[shapely.Geometry | None, ...]
    height: bool = True
    in_world: bool = True

    def __post_init__(self) -> None:
        if any(len(row) != len(self.columns) for row in self.rows):
            raise ValueError(f"{self.name}: a row has another length than the {len(self.columns)} columns")
        if len(self.rows) != len(self.geometries):
            raise ValueError(f"{self.name}: {len(self.rows)} rows, {len(self.geometries)} geometries")

    def __len__(self) -> int:
        return len(self.rows)

    def values(self, name: str) -> list[Value]:
        """Return the values of a column. Raises KeyError for an unknown name."""
        names = [column.name for column in self.columns]
        if name not in names:
            raise KeyError(name)
        k = names.index(name)
        return [row[k] for row in self.rows]


def find(tables: Sequence[Table], name: str) -> Table:
    """Return the table of this name. Raises KeyError if there is none."""
    found = next((table for table in tables if table.name == name), None)
    if found is None:
        raise KeyError(name)
    return found
