"""A facade's openings and protrusions as files: what users script against, and what later stages read back.

`openings.json` and `protrusions.json` are lists whose keys are documented in the reference of the run folder.
`outlines.npz` holds the covariance of every opening's outline, which is too large for a text file.
"""

from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from frontage.errors import FileError
from frontage.geometry.arrays import Float
from frontage.geometry.ring import at_depth, box_sigmas
from frontage.io.arrayfiles import read_arrays
from frontage.io.files import MALFORMED
from frontage.model import (
    AXES,
    Bar,
    Elements,
    Facade,
    Glazing,
    Opening,
    OpeningKind,
    Protrusion,
    ProtrusionKind,
    Provenance,
)
from frontage.pipeline.store.files import read_json, write_arrays, write_json
from frontage.pipeline.store.values import (
    estimate,
    estimate_record,
    measure_record,
    number,
    or_infinite,
    real,
    text,
    truth,
    whole,
)

FOUND = ("elements.json", "protrusions.json", "outlines.npz")
"""What `save_elements` leaves in a facade's folder."""

PRODUCT = "openings.json"
"""What users script against: the openings of `elements.json` with what later stages know of them."""

_AGAIN = "make it again with `frontage openings`"
_FAR_M = 1e7  # no local coordinate is as large
_MEASURES = ("frame_width", "depth")
_SIDES = ("left", "bottom", "right", "top")
Noun = TypeVar("Noun")


def save_elements(folder: Path, facade: Facade, elements: Elements) -> None:
    """Write what the scan tells of `facade` to `folder`. The notes of `elements` are not kept there."""
    covariances = {str(k): o.ring_covariance for k, o in enumerate(elements.openings)}
    write_arrays(folder / "outlines.npz", covariances)
    write_json(folder / "protrusions.json", [_protrusion_record(p, facade) for p in elements.protrusions])
    _save_openings(folder / "elements.json", facade, elements)


def save_product(folder: Path, facade: Facade, elements: Elements) -> None:
    """Write `openings.json`, the product of all stages that know something of a facade's openings."""
    _save_openings(folder / PRODUCT, facade, elements)


def load_elements(folder: Path, facade: str, openings: str = PRODUCT) -> Elements:
    """Read what was written, exactly. Raises FileError.

    facade    the facade's id
    openings  the file of the openings: the product, or `elements.json`
    """
    covariances = read_arrays(folder / "outlines.npz", _AGAIN)

    def opening(record: dict[str, Any], number: int) -> Opening:
        if str(number) not in covariances:
            raise ValueError("outlines.npz holds no outline of it")
        return _opening(record, covariances[str(number)])

    found = _nouns(folder / openings, opening)
    if len(found) != len(covariances):
        problem = f"holds {len(covariances)} outlines, {openings} {len(found)} openings"
        raise FileError(folder / "outlines.npz", problem, _AGAIN)
    protrusions = _nouns(folder / "protrusions.json", lambda record, _: _protrusion(record))
    return Elements(facade, found, protrusions)


def check_elements(elements: Elements) -> Elements:
    """The elements, when files can hold them. Raises ValueError that names the one that they cannot."""
    known = {"", *(p.id for p in elements.protrusions)}
    for o in elements.openings:
        name = o.id or f"a {o.kind} of {elements.facade}"
        if o.on not in known:
            raise ValueError(f"{name}: it is on {o.on}, which was not found")
        depth = 0.0 if o.depth is None else float(o.depth.value)
        values = (*o.ring.ravel(), depth, o.evidence, o.confidence)
        if not np.isfinite(values).all():
            raise ValueError(f"{name}: its outline, depth, evidence or confidence is no number")
    for p in elements.protrusions:
        if not np.isfinite((*p.ring.ravel(), float(p.front.value), p.confidence)).all():
            raise ValueError(f"{p.id}: its outline, front or confidence is no number")
    return elements


def _save_openings(path: Path, facade: Facade, elements: Elements) -> None:
    write_json(path, [_opening_record(o, facade, elements.wall_y(o)) for o in elements.openings])


def _opening_record(o: Opening, facade: Facade, front: float) -> dict[str, Any]:
    """`front`: y m of the wall or protrusion that the opening is in."""
    return {
        "id": o.id,
        "kind": o.kind,
        "shape": o.shape,
        "outline": o.ring.tolist(),
        "outline_world": _in_world(o.ring, front, facade),
        "depth": None if o.depth is None else float(o.depth.value),
        "bars": {axis: [_bar_record(b) for b in o.bars if b.axis == axis] for axis in AXES},
        "glazing": None if o.glazing is None else _glazing_record(o.glazing),
        "sigma": _sigmas(o),
        "provenance": str(o.provenance),
        "confidence": float(o.confidence),
        "floor": int(o.floor),
        "bay": int(o.bay),
        "evidence": float(o.evidence),
        "photos": list(o.photos),
        "on": o.on,
        "depth_estimate": None if o.depth is None else estimate_record(o.depth),
    }


def _protrusion_record(p: Protrusion, facade: Facade) -> dict[str, Any]:
    front = float(p.front.value)
    return {
        "id": p.id,
        "kind": p.kind,
        "outline": p.ring.tolist(),
        "outline_world": _in_world(p.ring, front, facade),
        "front": front,
        "sigma": {"border": number(p.sigma), "front": number(p.front.sigma[0])},
        "provenance": str(p.provenance),
        "confidence": float(p.confidence),
        "front_estimate": estimate_record(p.front),
    }


def _sigmas(o: Opening) -> dict[str, float | None]:
    """Standard errors m of an opening's borders and depth; None = not known."""
    sides = box_sigmas(o.ring, o.ring_covariance)
    found = {name: number(sigma) for name, sigma in zip(_SIDES, sides, strict=True)}
    return found | {"depth": None if o.depth is None else number(o.depth.sigma[0])}


def _bar_record(b: Bar) -> dict[str, Any]:
    extent = [float(v) for v in b.extent]
    return {
        "position": float(b.position),
        "extent": extent,
        "width": float(b.width),
        "sigma": number(b.sigma),
        "sigma_width": number(b.sigma_width),
        "provenance": str(b.provenance),
    }


def _glazing_record(g: Glazing) -> dict[str, Any]:
    """Everything of a window's frame and bars but the bars, which have a place of their own."""
    return {
        "resolved": g.resolved,
        "frame_width": None if g.frame_width is None else measure_record(g.frame_width),
        "depth": None if g.depth is None else measure_record(g.depth),
        "confidence": float(g.confidence),
        "sources": list(g.sources),
        "note": g.note,
    }


def _in_world(ring: Float, y: float, facade: Facade) -> list[list[float]]:
    """A ring (k, 2) m at depth y m of the facade's frame in world coordinates (k, 3)."""
    return list(facade.world.to_world(facade.frame.apply(at_depth(ring, y))).tolist())


def _nouns(path: Path, make: Callable[[dict[str, Any], int], Noun]) -> tuple[Noun, ...]:
    """Every record of a list as a noun. Raises FileError that names the file and the record."""
    try:
        table = read_json(path)
    except FileNotFoundError:
        raise FileError(path, "no such file", _AGAIN) from None
    except (OSError, ValueError) as error:
        raise FileError(path, f"is not JSON ({error})", _AGAIN) from None
    if not isinstance(table, list) or not all(isinstance(record, dict) for record in table):
        raise FileError(path, "is no list of objects", _AGAIN)
    made = []
    for place, record in enumerate(table):
        try:
            made.append(make(record, place))
        except KeyError as error:
            raise FileError(path, f"{_name(record, place)} lacks {error}", _AGAIN) from None
        except MALFORMED as error:
            raise FileError(path, f"{_name(record, place)}: {error}", _AGAIN) from None
    return tuple(made)


def _name(record: dict[str, Any], number: int) -> str:
    return str(record.get("id", f"entry {number}"))


def _opening(r: dict[str, Any], covariance: Float) -> Opening:
    depth = None
    if r["depth"] is not None:
        depth = estimate(real(r["depth"], "depth"), r["depth_estimate"])
    return Opening(
        id=text(r, "id"),
        kind=OpeningKind(text(r, "kind")),
        ring=_ring(r["outline"]),
        ring_covariance=covariance,
        depth=depth,
        shape=text(r, "shape"),
        provenance=Provenance(r["provenance"]),
        evidence=real(r["evidence"], "evidence"),
        confidence=real(r["confidence"], "confidence"),
        floor=whole(r, "floor"),
        bay=whole(r, "bay"),
        glazing=_glazing(r),
        photos=tuple(str(photo) for photo in r["photos"]),
        on=text(r, "on"),
    )


def _protrusion(r: dict[str, Any]) -> Protrusion:
    return Protrusion(
        id=text(r, "id"),
        kind=ProtrusionKind(text(r, "kind")),
        ring=_ring(r["outline"]),
        sigma=or_infinite(r["sigma"]["border"], "sigma"),
        front=estimate(real(r["front"], "front"), r["front_estimate"]),
        provenance=Provenance(r["provenance"]),
        confidence=real(r["confidence"], "confidence"),
    )


def _bar(r: dict[str, Any], axis: str) -> Bar:
    low, high = (real(v, "extent") for v in r["extent"])
    return Bar(
        axis,
        real(r["position"], "position"),
        (low, high),
        real(r["width"], "width"),
        or_infinite(r["sigma"], "sigma"),
        or_infinite(r["sigma_width"], "sigma_width"),
        Provenance(r["provenance"]),
    )


def _glazing(r: dict[str, Any]) -> Glazing | None:
    """Of an opening's record; None where bars were not looked for."""
    g = r["glazing"]
    if g is None:
        return None
    width, depth = (None if g[k] is None else estimate(real(g[k]["value"], k), g[k]) for k in _MEASURES)
    return Glazing(
        resolved=truth(g, "resolved"),
        bars=tuple(_bar(b, axis) for axis in AXES for b in r["bars"][axis]),
        frame_width=width,
        depth=depth,
        confidence=real(g["confidence"], "confidence"),
        sources=tuple(str(source) for source in g["sources"]),
        note=text(g, "note"),
    )


def _ring(value: Any) -> Float:
    ring = np.array([[real(v, "outline") for v in corner] for corner in value], np.float64)
    if ring.ndim != 2 or ring.shape[1] != 2 or len(ring) < 3:
        raise ValueError("its outline is no ring of three or more corners [x, z]")
    if np.abs(ring).max() > _FAR_M:
        raise ValueError(f"its outline lies beyond {_FAR_M:g} m")
    return ring
