"""Measured facades as parts of a building information model: walls, openings, windows, doors."""

from collections.abc import Iterator
from math import isfinite

import numpy as np

from frontage.exports.survey import Survey, SurveyedBuilding
from frontage.exports.tables.columns import OPENINGS, PROTRUSIONS
from frontage.exports.tables.layers import opening_row, protrusion_row
from frontage.io.bim.parts import BimBuilding, Body, Part, Value, Void
from frontage.io.tables.table import Column
from frontage.model import FRAME_THICKNESS_M, Elements, Facade, Opening, OpeningKind, Protrusion
from frontage.model.opening import DOORS

WALL_THICKNESS_M = 0.365
"""A wall of one and a half bricks (DIN 105), which no scan from the street shows: `assumed` says so."""

_LEAST_FRONT_M = 1e-3  # a thing on the wall that stands out less has no body
_GATES = (OpeningKind.GARAGE,)


def bim_buildings(survey: Survey) -> tuple[BimBuilding, ...]:
    """Return the buildings with a wall per facade, thick enough for its deepest window.

    What stands out of the wall becomes a body of its own, what is set back a recess and, if it is a wall, a
    wall behind it. A window or door is a plate at its measured depth; one whose depth was not measured lies
    flush. Passages are openings that nothing fills. An opening in an oriel goes on through the wall behind.
    """
    return tuple(
        BimBuilding(b.id, b.address, tuple(part for f, e in b.fronts for part in _parts(b, f, e)))
        for b in survey.buildings
    )


def _parts(b: SurveyedBuilding, facade: Facade, elements: Elements | None) -> Iterator[Part]:
    found = elements or Elements(facade.id, ())
    deepest = max((_depth(o) for o in found.openings), default=0.0)
    thick = max(WALL_THICKNESS_M, deepest + FRAME_THICKNESS_M)
    things = {p.id: p for p in found.protrusions if abs(float(p.front.value)) > _LEAST_FRONT_M}
    held: dict[str, list[Void]] = {}
    for o in found.openings:
        back = _back(things.get(o.on), thick)
        holder = "" if back is None else o.on
        held.setdefault(holder, []).append(_void(b, facade, found, o, thick if back is None else back))
        if back == 0.0:  # the wall behind the oriel is open, too
            held.setdefault("", []).append(Void(f"{o.id}/wall", Body(o.ring, 0.0, thick)))
    recesses = tuple(_recess(b, facade, p) for p in things.values() if float(p.front.value) > 0)
    about: dict[str, Value] = {"facade": facade.id, "sigma_plane": _known(facade.sigma_plane),
                               "assumed": f"thickness of {thick:.3f} m"}  # fmt: skip
    body = Body(facade.outline, 0.0, thick)
    yield Part(facade.id, "wall", facade.frame, body, (*recesses, *held.get("", ())), about)
    for p in things.values():
        y, voids = float(p.front.value), tuple(held.get(p.id, ()))
        row = _about(PROTRUSIONS, protrusion_row(b, facade, p))
        if y < 0:
            yield Part(p.id, str(p.kind), facade.frame, Body(p.ring, y, 0.0), voids, row)
        elif p.kind.is_wall:
            yield Part(p.id, "wall", facade.frame, Body(p.ring, y, y + thick), voids, row)


def _back(holder: Protrusion | None, thick: float) -> float | None:
    """Return y m where the body ends that holds an opening; None for the wall of the facade."""
    if holder is None:
        return None
    y = float(holder.front.value)
    return 0.0 if y < 0 else y + thick if holder.kind.is_wall else None


def _void(b: SurveyedBuilding, facade: Facade, found: Elements, o: Opening, back: float) -> Void:
    y = found.wall_y(o)
    front = y + _depth(o)
    passage = o.kind is OpeningKind.PASSAGE
    kind = "" if passage else "gate" if o.kind in _GATES else "door" if o.kind in DOORS else "window"
    filling = None if passage else Body(o.ring, front, front + FRAME_THICKNESS_M)
    row = _about(OPENINGS, opening_row(b, facade, found, o))
    assumed = {} if o.depth is not None else {"assumed": "flush with the wall, since its depth is not known"}
    return Void(o.id, Body(o.ring, y, back), kind, filling, about={**row, **assumed})


def _recess(b: SurveyedBuilding, facade: Facade, p: Protrusion) -> Void:
    body = Body(p.ring, 0.0, float(p.front.value))
    return Void(f"{p.id}/recess", body, recess=True, about=_about(PROTRUSIONS, protrusion_row(b, facade, p)))


def _depth(o: Opening) -> float:
    return 0.0 if o.depth is None else max(float(o.depth.value), 0.0)


def _about(columns: tuple[Column, ...], row: tuple[Value, ...]) -> dict[str, Value]:
    """Return a row of a table by its columns; unknown values are None."""
    return {column.name: value for column, value in zip(columns, row, strict=True)}


def _known(value: float) -> float | None:
    return float(np.round(value, 6)) if isfinite(value) else None
