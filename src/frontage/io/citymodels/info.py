"""What a city model holds, for `frontage info`."""

from collections import Counter
from pathlib import Path
from typing import Any

from frontage.io.citymodels.read import kind_of, read_city_model
from frontage.model import CityModel

_SHOWN = 5  # problems named one by one


def looks_like_city_model(path: Path) -> bool:
    """Whether a file is XML, JSON or a GeoPackage, by its content."""
    try:
        return path.is_file() and kind_of(path) is not None
    except ValueError:
        return True  # damaged JSON: reading it says where


def city_model_info(path: str | Path) -> dict[str, Any]:
    """Format, CRS, extent (m world), buildings, parts, levels, surfaces by class, problems.

    Raises FileError, CrsError as `read_city_model`.
    """
    model = read_city_model(path)
    shells = [s for b in model.buildings for s in b.shells]
    low, high = model.world.to_world(model.bounds())
    return {
        "path": str(path),
        "format": kind_of(Path(path)),
        "crs": model.world.crs,
        "extent": [low.round(3).tolist(), high.round(3).tolist()],
        "buildings": len(model.buildings),
        "parts": len({s.part for s in shells if s.part and not s.installation}),
        "installations": len({s.part for s in shells if s.installation}),
        "levels": dict(sorted(Counter(s.lod or "unknown" for s in shells).items())),
        "solids": sum(s.closed for s in shells),
        "surfaces": dict(Counter(p.semantics for s in shells for p in s.surfaces).most_common()),
        "addresses": sum(b.address is not None for b in model.buildings),
        "attributes": sorted({name for b in model.buildings for name in b.attributes}),
        "problems": _problems(model),
        "notes": list(model.notes),
    }


def _problems(model: CityModel) -> list[str]:
    """The first problems, and how many more there are."""
    said = [p.message for p in model.problems]
    return said if len(said) <= _SHOWN else [*said[:_SHOWN], f"and {len(said) - _SHOWN} more"]
