"""Facades and buildings as files and back. Numbers keep all their digits."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from frontage.errors import FileError
from frontage.geometry.arrays import Float, Int
from frontage.io.arrayfiles import read_arrays
from frontage.io.facadefile import facade_from_json, facade_to_json, finite_or_none, number_or_infinity
from frontage.io.files import MALFORMED
from frontage.model import Building, Facade
from frontage.pipeline.store.files import read_json, write_arrays, write_json


def save_facade(folder: Path, facade: Facade) -> None:
    """`folder/facade.json` and `folder/points.npz` (int64 indices into the building's working cloud)."""
    folder.mkdir(parents=True, exist_ok=True)
    indices = {"support": facade.support, "inliers": facade.inliers}
    write_arrays(folder / "points.npz", indices)
    write_json(folder / "facade.json", facade_to_json(facade))


def load_facade(folder: Path) -> Facade:
    """Read what `save_facade` wrote. Raises FileError when a file is missing or damaged."""
    advice = "run `frontage facades` again"
    indices = read_arrays(folder / "points.npz", advice)
    try:
        record = read_json(folder / "facade.json")
        return facade_from_json(record, indices["support"], indices["inliers"])
    except FileNotFoundError:
        raise FileError(folder / "facade.json", "no such file", advice) from None
    except (OSError, *MALFORMED) as error:
        raise FileError(folder / "facade.json", f"is damaged ({error})", advice) from None


@dataclass(frozen=True, eq=False)
class BuildingRecord:
    """A building without its points: what `buildings/index.json` says of it.

    points     number of points that are its own
    ground_z   m local, NaN or infinite if unknown
    footprint  (k, 2) m local, or None
    cuts       where it was cut from its neighbours: ((x, y) m local, posterior probability)
    """

    id: str
    address: str | None
    points: int
    ground_z: float
    footprint: Float | None
    cuts: tuple[tuple[tuple[float, float], float], ...]
    notes: tuple[str, ...]

    @classmethod
    def of(cls, building: Building, points: int) -> "BuildingRecord":
        """Return the record of a building that has this number of points."""
        b = building
        return cls(b.id, b.address, points, b.ground_z, b.footprint, b.cuts, b.notes)

    def with_points(self, index: Int) -> Building:
        """Return the building whose points are `index` (m,) int64 of its working cloud."""
        return Building(
            id=self.id,
            index=index,
            ground_z=self.ground_z,
            address=self.address,
            footprint=self.footprint,
            cuts=self.cuts,
            notes=self.notes,
        )

    def to_json(self) -> dict[str, Any]:
        """Return the record as JSON; infinite heights become null."""
        return {
            "id": self.id,
            "address": self.address,
            "points": self.points,
            "ground_z": finite_or_none(self.ground_z),
            "footprint": None if self.footprint is None else self.footprint.tolist(),
            "cuts": [{"at": [float(v) for v in at], "posterior": float(p)} for at, p in self.cuts],
            "notes": list(self.notes),
        }

    @classmethod
    def from_json(cls, table: dict[str, Any]) -> "BuildingRecord":
        """Return the inverse of `to_json`. Raises KeyError, TypeError or ValueError if it is none."""
        footprint = table["footprint"]
        if footprint is not None and np.shape(footprint)[1:] != (2,):
            raise ValueError("a footprint is no list of corners [x, y]")
        return cls(
            id=str(table["id"]),
            address=table["address"],
            points=int(table["points"]),
            ground_z=number_or_infinity(table["ground_z"]),
            footprint=None if footprint is None else np.array(footprint, np.float64),
            cuts=tuple(((c["at"][0], c["at"][1]), c["posterior"]) for c in table["cuts"]),
            notes=tuple(table["notes"]),
        )
