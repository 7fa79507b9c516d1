"""The windows and doors of a city model, for its evaluation."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from frontage.geometry.arrays import Float
from frontage.io.citymodels.read import read_city_model
from frontage.model import OPENING_SURFACES


@dataclass(frozen=True, eq=False)
class CityOpening:
    """A Window or Door surface: its outer ring (k, 3) m world, and its attributes with its `id`."""

    kind: str
    ring: Float
    about: dict[str, Any]


def read_city_openings(path: str | Path) -> tuple[CityOpening, ...]:
    """Read every Window and Door surface of every building's finest level.

    Raises FileError and CrsError as `read_city_model` does.
    """
    model = read_city_model(path)
    return tuple(
        CityOpening(
            s.semantics, model.world.to_world(s.ring), {"id": s.source_id, **shell.about.get(s.source_id, {})}
        )
        for building in model.buildings
        for shell in building.level()
        for s in shell.surfaces
        if s.semantics in OPENING_SURFACES
    )
