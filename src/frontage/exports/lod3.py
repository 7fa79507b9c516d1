"""Converts the solids of a building to a city model: LoD2 and LoD3 shells, classes and attributes."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from frontage.exports.glazing import attributes_of_glazing, estimated
from frontage.exports.openingwalls import walls_of_openings
from frontage.model import FRAME_THICKNESS_M, Building, Elements, Facade, Opening, Protrusion, Solid, Surface
from frontage.model.citymodel import FRAME, CityBuilding, Shell
from frontage.solids import Assembled, Built, Installation, WindowFrame
from frontage.solids.brep import GRID_PER_M
from frontage.solids.elements import depth_of

Value = str | float | int
_DIGITS = 4  # 0.1 mm
_OF_FRAME = ("facade", "n_vertical", "n_horizontal", "frame_width", "sigma_frame_width", "bars")


def city_building(
    building: Building, assembled: Assembled, fronts: Sequence[tuple[Facade, Elements]]
) -> CityBuilding:
    """Returns the building with its installations and, per part, a coarse solid (LoD2) and a fine one (LoD3).

    Window and Door surfaces have the id of their opening and the attributes that docs/reference/model.md
    lists; `parent` is the id of the wall that holds the opening.
    """
    about = dict(_of_elements(fronts))
    several = len(assembled.built) > 1
    shells: list[Shell] = []
    for number, name in enumerate(assembled.coarse.names):
        part = (name or f"{building.id}-{number + 1}") if several else ""
        shells += _levels(assembled, number, part or building.id, part, about)
    shells += [_installation(i, about) for i in assembled.installations]
    shells += [_frame(f, about) for f in assembled.frames]
    attributes = _attributes(assembled, range(len(assembled.built)))
    return CityBuilding(building.id, tuple(shells), building.address, attributes)


def city_buildings(
    building: Building,
    assembled: Assembled,
    fronts: Sequence[tuple[Facade, Elements]],
    owners: Mapping[str, str | None],
) -> tuple[CityBuilding, ...]:
    """Does the same as `city_building`, but keeps apart what the city model holds as separate buildings.

    Parts that intersect each other also become separate buildings. `owners` maps the ids of the buildings in
    the city model, which are the names of the parts, to their addresses. The first building keeps the id, the
    others get "-2", "-3", ...; the attribute `model_id` holds the id in the city model.
    """
    known = assembled.coarse.source == "model"
    if len(assembled.built) < 2 or not (assembled.parts_overlap or (known and len(owners) > 1)):
        whole = city_building(building, assembled, fronts)
        named = {"model_id": ", ".join(owners)} if owners and known else {}
        return (replace(whole, attributes={**whole.attributes, **named}),)
    about = dict(_of_elements(fronts))
    home = [_nearest(assembled, i) for i in assembled.installations]
    parts = {f.opening: k for k, b in enumerate(assembled.built) for f in b.solid.faces if f.opening}
    found = []
    for number, name in enumerate(assembled.coarse.names):
        own = building.id if number == 0 else f"{building.id}-{number + 1}"
        shells = _levels(assembled, number, own, "", about)
        hung = [i for i, h in zip(assembled.installations, home, strict=True) if h == number]
        attributes = _attributes(assembled, [number]) | ({"model_id": name} if known and name else {})
        shells += [_installation(i, about) for i in hung]
        shells += [_frame(f, about) for f in assembled.frames if parts[f.opening] == number]
        address = owners.get(name) or (building.address if number == 0 else None)
        found.append(CityBuilding(own, tuple(shells), address, attributes))
    return tuple(found)


def _levels(
    assembled: Assembled, number: int, prefix: str, part: str, about: Mapping[str, Mapping[str, Value]]
) -> list[Shell]:
    """Returns LoD2 and, where anything was cut into it, LoD3 of one part."""
    built = assembled.built[number]
    shells = [_shell(built.host, "2", f"{prefix}/lod2", part, {})]
    if assembled.fine[number]:
        shells.append(_shell(built.solid, "3", f"{prefix}/lod3", part, _with_offsets(about, built)))
    return shells


def _nearest(assembled: Assembled, thing: Installation) -> int:
    """Returns the number of the part whose bounding box is nearest to an installation."""
    middle = thing.solid.vertices.mean(0)
    boxes = [(b.host.vertices.min(0), b.host.vertices.max(0)) for b in assembled.built]
    away = [
        float(np.linalg.norm(np.maximum(0, np.maximum(low - middle, middle - high)))) for low, high in boxes
    ]
    return int(np.argmin(away))


def surfaces_of(solid: Solid, prefix: str) -> tuple[Surface, ...]:
    """Returns the faces of a solid in local metres, with the id of their opening or a number."""
    xyz = solid.vertices / GRID_PER_M
    return tuple(
        Surface(
            xyz[list(f.ring)], f.semantics, f.opening or f"{prefix}/{k}", tuple(xyz[list(h)] for h in f.holes)
        )
        for k, f in enumerate(solid.faces)
    )


def _shell(solid: Solid, lod: str, prefix: str, part: str, about: Mapping[str, Mapping[str, Value]]) -> Shell:
    """A solid as a shell whose openings name their wall, and whose walls name their facade and offset."""
    surfaces = surfaces_of(solid, prefix)
    known: dict[str, dict[str, Value]] = {}
    for k, wall in walls_of_openings(solid).items():
        name, parent = surfaces[k].source_id, surfaces[wall].source_id
        known[name] = {**about.get(name, {}), "parent": parent}
        if "offset" in known[name]:
            here = known.setdefault(parent, dict(about.get(parent, {})))
            here |= {key: known[name][key] for key in ("facade", "offset") if key in known[name]}
    for s in surfaces:
        if s.source_id in about:
            known.setdefault(s.source_id, dict(about[s.source_id]))
    return Shell(lod, surfaces, known, True, part)


def _installation(thing: Installation, about: Mapping[str, Mapping[str, Value]]) -> Shell:
    """An installation as a shell with its attributes; a solid unless it reaches into another one."""
    attributes = {**about.get(thing.id, {}), **({"assumed": thing.assumed} if thing.assumed else {})}
    surfaces = surfaces_of(thing.solid, f"{thing.id}/face")
    return Shell("3", surfaces, {}, thing.closed, thing.id, True, attributes=attributes)


def _frame(frame: WindowFrame, about: Mapping[str, Mapping[str, Value]]) -> Shell:
    """A window's frame with its bars as surfaces without semantic classes, which together are closed.

    They are no solid in the file: behind its front, a frame reaches into the building's own solid, and solids
    of one building must not overlap (601).
    """
    kept = {k: v for k, v in about.get(frame.opening, {}).items() if k in _OF_FRAME}
    assumed = f"{FRAME_THICKNESS_M:g} m thick"
    attributes = {"kind": FRAME, "opening": frame.opening, **kept, "assumed": assumed}
    surfaces = surfaces_of(frame.solid, f"{frame.id}/face")
    return Shell("3", surfaces, {}, False, frame.id, True, attributes=attributes, frame_of=frame.opening)


def _of_elements(
    fronts: Sequence[tuple[Facade, Elements]],
) -> Iterator[tuple[str, dict[str, Value]]]:
    """Yields the id and the attributes of every opening and protrusion."""
    for facade, elements in fronts:
        for o in elements.openings:
            yield o.id, {**_of_opening(o), "facade": facade.id}
        for p in elements.protrusions:
            yield p.id, {**_of_protrusion(p), "facade": facade.id}


def _of_opening(o: Opening) -> dict[str, Value]:
    """Attributes of a Window or Door surface; what was not measured is left out."""
    variance = np.diag(o.ring_covariance)
    out: dict[str, Value] = {
        "kind": o.kind,
        "shape": o.shape,
        "provenance": str(o.provenance),
        "confidence": round(float(o.confidence), _DIGITS),
        "floor": o.floor,
        "bay": o.bay,
    }
    out |= attributes_of_glazing(o)
    if len(variance) and np.isfinite(variance).all():
        out["sigma_border"] = round(float(np.sqrt(variance.mean())), 5)
    return out | estimated("depth", depth_of(o))


def _of_protrusion(p: Protrusion) -> dict[str, Value]:
    """Attributes of a protrusion; what was not measured is left out."""
    out: dict[str, Value] = {
        "kind": p.kind,
        "front": round(float(p.front.value), _DIGITS),
        "provenance": str(p.provenance),
        "confidence": round(float(p.confidence), _DIGITS),
    }
    for name, sigma in (("sigma_border", p.sigma), ("sigma_front", float(p.front.sigma[0]))):
        if np.isfinite(sigma):
            out[name] = round(float(sigma), 5)
    return out


def _with_offsets(about: Mapping[str, Mapping[str, Value]], built: Built) -> dict[str, dict[str, Value]]:
    """Adds `offset`, m: from the measured plane to the wall that holds an element, positive = inwards."""
    offsets = {k: {"offset": round(v, _DIGITS)} for k, v in built.offsets.items()}
    return {k: {**v, **offsets.get(k, {})} for k, v in about.items()}


def _attributes(assembled: Assembled, parts: Iterable[int]) -> dict[str, Value]:
    """Attributes of the building that consists of some of the parts."""
    own = [assembled.built[k] for k in parts]
    heights = np.concatenate([b.host.vertices[:, 2] for b in own]) / GRID_PER_M
    offsets = [abs(d) for b in own for d in b.offsets.values()]
    out: dict[str, Value] = {"host": assembled.coarse.source}
    out["measuredHeight"] = round(float(np.ptp(heights)), 2)
    if offsets:
        out["largest_offset"] = round(max(offsets), _DIGITS)
    if assembled.coarse.source == "cloud":
        out["host_made_of"] = "blocks behind the measured facades: only the facades are measured"
    return out
