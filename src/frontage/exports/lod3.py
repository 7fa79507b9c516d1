"""A building's solids as a city model holds them: LoD2 and LoD3 shells, classes, what is known of them."""

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from frontage.exports.parents import walls_of_openings
from frontage.model import Building, Elements, Facade, Opening, Protrusion, Solid, Surface
from frontage.model.citymodel import CityBuilding, Shell
from frontage.solids import Assembled, Built, Installation
from frontage.solids.relief import GRID

Value = str | float | int
_DIGITS = 4  # 0.1 mm


def city_building(
    building: Building, assembled: Assembled, fronts: Sequence[tuple[Facade, Elements]]
) -> CityBuilding:
    """The building with, per part, its coarse solid as LoD2 and its fine one as LoD3, and its installations.

    Window and Door surfaces are named after their opening and carry what docs/model.md lists; `parent` names
    the wall that an opening stands in.
    """
    about = dict(_of_elements(fronts))
    several = len(assembled.built) > 1
    shells: list[Shell] = []
    for number, (built, fine, name) in enumerate(
        zip(assembled.built, assembled.fine, assembled.coarse.names, strict=True)
    ):
        part = (name or f"{building.id}-{number + 1}") if several else ""
        prefix = part or building.id
        shells.append(_shell(built.host, "2", f"{prefix}/lod2", part, {}))
        if fine:
            shells.append(_shell(built.solid, "3", f"{prefix}/lod3", part, _with_offsets(about, built)))
    shells += [_hanging(i, about) for i in assembled.installations]
    return CityBuilding(building.id, tuple(shells), building.address, _attributes(building, assembled))


def surfaces_of(solid: Solid, prefix: str) -> tuple[Surface, ...]:
    """The faces of a solid in local metres, named after their opening or numbered."""
    xyz = solid.vertices / GRID
    return tuple(
        Surface(
            xyz[list(f.ring)], f.semantics, f.opening or f"{prefix}/{k}", tuple(xyz[list(h)] for h in f.holes)
        )
        for k, f in enumerate(solid.faces)
    )


def _shell(solid: Solid, lod: str, prefix: str, part: str, about: Mapping[str, Mapping[str, Value]]) -> Shell:
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


def _hanging(thing: Installation, about: Mapping[str, Mapping[str, Value]]) -> Shell:
    attributes = {**about.get(thing.id, {}), **({"assumed": thing.assumed} if thing.assumed else {})}
    surfaces = surfaces_of(thing.solid, f"{thing.id}/face")
    return Shell("3", surfaces, {}, True, thing.id, True, attributes=attributes)


def _of_elements(
    fronts: Sequence[tuple[Facade, Elements]],
) -> Iterator[tuple[str, dict[str, Value]]]:
    for facade, elements in fronts:
        for o in elements.openings:
            yield o.id, {**_of_opening(o), "facade": facade.id}
        for p in elements.protrusions:
            yield p.id, {**_of_protrusion(p), "facade": facade.id}


def _of_opening(o: Opening) -> dict[str, Value]:
    """What a Window or Door surface says; what was not measured is left out."""
    variance = np.diag(o.ring_covariance)
    out: dict[str, Value] = {
        "kind": o.kind,
        "shape": o.shape,
        "n_vertical": sum(b.axis == "vertical" for b in o.bars),
        "n_horizontal": sum(b.axis == "horizontal" for b in o.bars),
        "provenance": str(o.provenance),
        "confidence": round(float(o.confidence), _DIGITS),
        "floor": o.floor,
        "bay": o.bay,
    }
    if not o.bars:
        out["bars"] = "not measured"
    if len(variance) and np.isfinite(variance).all():
        out["sigma_border"] = round(float(np.sqrt(variance.mean())), 5)
    if o.depth is not None:
        out["depth"] = round(float(o.depth.value), _DIGITS)
        if np.isfinite(o.depth.sigma[0]):
            out["sigma_depth"] = round(float(o.depth.sigma[0]), 5)
    return out


def _of_protrusion(p: Protrusion) -> dict[str, Value]:
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
    """`offset`: m from the measured plane to the wall that an element was put in, positive = inwards."""
    offsets = {k: {"offset": round(v, _DIGITS)} for k, v in built.offsets.items()}
    return {k: {**v, **offsets.get(k, {})} for k, v in about.items()}


def _attributes(building: Building, assembled: Assembled) -> dict[str, Value]:
    heights = np.concatenate([b.host.vertices[:, 2] for b in assembled.built]) / GRID
    offsets = [abs(d) for b in assembled.built for d in b.offsets.values()]
    out: dict[str, Value] = {"host": assembled.coarse.source}
    out["measuredHeight"] = round(float(np.ptp(heights)), 2)
    if offsets:
        out["largest_offset"] = round(max(offsets), _DIGITS)
    if assembled.coarse.source == "cloud":
        out["host_made_of"] = "blocks behind the measured facades: only the facades are measured"
    return out
