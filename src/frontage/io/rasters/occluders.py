"""`occluders.json`: what stood free before a facade when it was scanned."""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from frontage.errors import FileError
from frontage.io.files import MALFORMED, whole_file
from frontage.model import OCCLUDER_KINDS, Facade, Occluder

_DECIMALS = 4  # of a metre


def write_occluders(path: Path, occluders: Sequence[Occluder], facade: Facade) -> None:
    """Write the occluders of a facade, from left to right.

    `centre` and `heading` (degrees from x towards y) are in the facade frame, `corners_world` are the eight
    corners of the box in the world, and `sigma` is the standard error of its sides; lengths are in metres.
    """
    records = [_record(one, facade) for one in occluders]
    with whole_file(path) as temporary:
        temporary.write_text(json.dumps(records, indent=1) + "\n", encoding="utf-8")


def read_occluders(path: Path) -> tuple[Occluder, ...]:
    """Read what `write_occluders` wrote; empty without a file. Raises FileError if it is damaged."""
    if not path.is_file():
        return ()
    try:
        return tuple(_occluder(one) for one in json.loads(path.read_text(encoding="utf-8")))
    except (OSError, *MALFORMED) as error:
        raise FileError(path, f"is damaged ({error})", "run `frontage ortho` again") from None


def _record(one: Occluder, facade: Facade) -> dict[str, Any]:
    corners = facade.world.to_world(facade.frame.apply(one.corners))
    return {
        "id": one.id,
        "class": one.kind,
        "confidence": round(one.confidence, 3),
        "chances": {k: round(float(p), 6) for k, p in zip(OCCLUDER_KINDS, one.chances, strict=True)},
        "centre": np.round(one.centre, _DECIMALS).tolist(),
        "size": np.round(one.size, _DECIMALS).tolist(),
        "heading": round(float(np.degrees(one.heading)), 2),
        "corners_world": np.round(corners, _DECIMALS).tolist(),
        "sigma": round(one.sigma, _DECIMALS),
        "points": one.points,
        "provenance": "measured",
    }


def _occluder(record: dict[str, Any]) -> Occluder:
    return Occluder(
        str(record["id"]),
        np.array([record["chances"][kind] for kind in OCCLUDER_KINDS], np.float64),
        np.array(record["centre"], np.float64),
        np.array(record["size"], np.float64),
        float(np.radians(record["heading"])),
        float(record["sigma"]),
        int(record["points"]),
    )
