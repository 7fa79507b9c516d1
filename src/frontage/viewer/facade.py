"""`facade.json`: what the page of one facade shows and measures with."""

import json
from dataclasses import asdict
from typing import Any

import numpy as np

from frontage.geometry.arrays import Float
from frontage.model import Elements, Opening, Protrusion
from frontage.queries.answer import Located, Place, answers
from frontage.queries.pixels import FacadePixels
from frontage.viewer.run import Run


def facade_json(run: Run, name: str) -> bytes:
    """Return `facade.json` of a facade. Lengths are m, `ring` and `bars` in the frame of the ortho-image."""
    facade, elements = run.plane(name), run.store.elements(name)
    table: dict[str, Any] = {
        "id": name,
        "building": facade.building,
        "crs": facade.world.crs,
        "outline": _ring(facade.outline),
        "notes": list(facade.notes) + (list(elements.notes) if elements else []),
        "pictures": [{"path": f"{run.facade_path(name)}/{p.name}.png", "name": p.name, "caption": p.caption,
                      "extent": list(p.extent)} for p in run.evidence(name)],
        "ortho": _ortho(run, name),
        "openings": _openings(run, name, elements) if elements else None,
        "protrusions": [_protrusion(p) for p in elements.protrusions] if elements else [],
    }  # fmt: skip
    return json.dumps(table, ensure_ascii=False, allow_nan=False, separators=(",", ":")).encode()


def _ortho(run: Run, name: str) -> dict[str, Any] | None:
    """Return how pixels are measured: the values that `FacadePixels` uses."""
    if not run.store.has(name, "ortho"):
        return None
    pixels = FacadePixels(run.store.facade_folder(name))
    sidecar = pixels.sidecar
    return {
        "width": sidecar.size[0],
        "height": sidecar.size[1],
        "gsd": sidecar.gsd,
        "corner": list(sidecar.corner),
        "raster_to_world": sidecar.raster_to_world.tolist(),
        "relief": sidecar.relief,
        "plane_variance": _numbers(pixels.plane_variance),
        "scatter": _number(pixels.scatter),
        "sources": list(sidecar.sources),
        "photos": sidecar.photos,
    }


def _openings(run: Run, name: str, elements: Elements) -> list[dict[str, Any]]:
    place = Place(elements.facade.rsplit("/", 1)[0], None, name, "")
    found = answers(run.store, place, elements, elements.openings, run.witnesses)
    return [_opening(run, elements, o, located) for o, located in zip(elements.openings, found, strict=True)]


def _opening(run: Run, elements: Elements, o: Opening, found: Located) -> dict[str, Any]:
    table = {
        k: v for k, v in asdict(found).items() if k not in ("address", "chosen", "crs", "building", "facade")
    }
    wall_y = elements.wall_y(o)
    table["ring"], table["wall_y"] = _ring(o.ring), wall_y
    table["bars"] = [
        {"axis": bar.axis, "position": bar.position, "extent": list(bar.extent), "width": bar.width}
        for bar in o.bars
    ]
    table["photos"] = [{**asdict(v), "number": run.photo_numbers[v.photo]} for v in found.photos]
    return table


def _protrusion(p: Protrusion) -> dict[str, Any]:
    return {
        "id": p.id,
        "kind": str(p.kind),
        "ring": _ring(p.ring),
        "front": float(p.front.value),
        "sigma_front": _number(float(p.front.sigma[0])),
        "sigma": _number(p.sigma),
        "provenance": str(p.provenance),
    }


def _ring(ring: Float) -> list[list[float]]:
    rows: list[list[float]] = np.round(ring, 5).tolist()
    return rows


def _number(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None


def _numbers(values: Float) -> list[float] | None:
    return [float(v) for v in values] if np.isfinite(values).all() else None
