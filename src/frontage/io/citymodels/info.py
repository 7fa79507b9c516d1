"""What a city model holds, for `frontage info`."""

from collections import Counter
from pathlib import Path
from typing import Any

from frontage.io.citymodels.formats import city_model_format
from frontage.io.citymodels.read import read_city_model
from frontage.model import CityModel

_SHOWN = 5  # problems that are listed one by one


def looks_like_city_model(path: Path) -> bool:
    """Whether a file is a city model by its content; damaged JSON counts as one."""
    try:
        return path.is_file() and city_model_format(path) is not None
    except ValueError:
        return True  # reading it then says where the damage is


def city_model_info(path: str | Path) -> dict[str, Any]:
    """JSON-able facts of a city model: format, CRS, extent (m world), counts, problems, notes.

    Raises FileError and CrsError as `read_city_model` does.
    """
    model = read_city_model(path)
    found = city_model_format(Path(path))
    shells = [s for b in model.buildings for s in b.shells]
    low, high = model.world.to_world(model.bounds())
    return {
        "path": str(path),
        "format": None if found is None else found.name,
        "crs": model.world.crs,
        "extent": [low.round(3).tolist(), high.round(3).tolist()],
        "buildings": len(model.buildings),
        "parts": len({s.part for s in shells if s.part and not s.installation}),
        "installations": len({s.part for s in shells if s.installation and not s.frame_of}),
        "window_frames": len({s.frame_of for s in shells if s.frame_of}),
        "levels": dict(sorted(Counter(s.lod or "unknown" for s in shells).items())),
        "solids": sum(s.closed for s in shells),
        "surfaces": dict(Counter(p.semantics for s in shells for p in s.surfaces).most_common()),
        "addresses": sum(b.address is not None for b in model.buildings),
        "attributes": sorted({name for b in model.buildings for name in b.attributes}),
        "problems": _problems(model),
        "notes": list(model.notes),
    }


def _problems(model: CityModel) -> list[str]:
    """The first problems, and the number of the others."""
    said = [p.message for p in model.problems]
    return said if len(said) <= _SHOWN else [*said[:_SHOWN], f"and {len(said) - _SHOWN} more"]
