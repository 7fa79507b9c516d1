"""Makes the windows of a house as varied as those of real streets: `windows = "varied"`.

What it draws comes from generators of its own, so that everything else about the house stays the same.
"""

from dataclasses import replace

import numpy as np
import shapely

from frontage.simulate.houses.designs import draw_design
from frontage.simulate.houses.draft import HouseDraft
from frontage.simulate.houses.elevation import Dressing
from frontage.simulate.houses.glazing import Design
from frontage.simulate.houses.placements import PlacedOpening
from frontage.simulate.houses.shapes import opening_ring
from frontage.simulate.houses.style import WindowType
from frontage.simulate.meshing import inset

_ODD = (0.0, 0.0, 0.1, 0.3)  # shares of windows that were replaced by another design, house by house
_CURTAINS = ("none", "sides", "net", "blind", "cafe", "venetian")
_CURTAIN_SHARES = (0.34, 0.22, 0.2, 0.09, 0.07, 0.08)
_AJAR = 0.08  # share of the windows of two casements of which one stands open
_DEEPEST_SASH_M = 0.32  # whose box is thick and needs room before the inner face of the wall
_THINGS = 0.25  # share of the windows with things on the sill


def vary(placements: tuple[PlacedOpening, ...], draft: HouseDraft, facade: str) -> tuple[PlacedOpening, ...]:
    """Return the openings of a facade, its windows divided and furnished anew; equal ones stay equal."""
    rng = np.random.default_rng((*draft.seed, 0xDE, *facade.encode()))
    odd = float(rng.choice(_ODD))
    looks: dict[tuple[object, ...], WindowType] = {}
    out = []
    for placed in placements:
        if placed.type.kind not in ("window", "basement") or not placed.type.glazed:
            out.append(placed)
            continue
        kind, own = placed.type, np.random.default_rng(rng.integers(2**63, size=2))
        look = (kind.shape, round(kind.width, 3), round(kind.height, 3), kind.bars)
        redesigned = _redesigned(kind, own)
        if own.random() >= odd:
            redesigned = looks.setdefault(look, redesigned)
        dressing = _furnished(kind.dressing, own)
        if isinstance(redesigned.bars, Design) and redesigned.bars.ajar:
            dressing = replace(dressing, curtain="none")  # which would hang in its way
        out.append(replace(placed, type=replace(redesigned, dressing=dressing)))
    return tuple(out)


def _redesigned(kind: WindowType, rng: np.random.Generator) -> WindowType:
    ring = opening_ring(kind.shape, 0.0, 0.0, kind.width, kind.height, rise=kind.rise)
    frame = float(rng.uniform(0.055, 0.11))
    if not shapely.Polygon(inset(ring, frame)).is_valid:  # too wide for the tight corner of a head
        frame = kind.frame
    design = draw_design(ring, frame, rng)
    design = _left_open(design, kind.shape, rng)
    depth = min(kind.depth, _DEEPEST_SASH_M) if design.sashes else kind.depth
    return replace(kind, bars=design, frame=frame, depth=depth)


def _left_open(design: Design, shape: str, rng: np.random.Generator) -> Design:
    """Turns one of two plain casements of a rectangular window inwards, rarely."""
    side, turn, rare = rng.choice([-1.0, 1.0]), rng.uniform(0.3, 1.3), rng.random() < _AJAR
    plain = len(design.field.vertical) == 1 and not design.field.parts and not design.field.horizontal
    if not (rare and plain and shape == "rectangle" and not design.leads):
        return design
    return replace(design, ajar=float(side * turn))


def _furnished(dressing: Dressing, rng: np.random.Generator) -> Dressing:
    """Draws curtains, blinds and things on the sill."""
    things = []
    for _ in range(int(rng.integers(1, 5)) if rng.random() < _THINGS else 0):
        name = str(rng.choice(["leaf", "trim", "furniture", "shutter", "curtain"]))
        things.append(
            (
                float(rng.uniform(0, 1)),
                float(rng.uniform(0.05, 0.3)),
                float(rng.uniform(0.08, 0.45)),
                name,
            )
        )
    curtain = str(rng.choice(_CURTAINS, p=_CURTAIN_SHARES))
    return replace(
        dressing,
        curtain=curtain,
        share=float(rng.uniform(0.15, 0.95)),
        things=tuple(things),
        joinery=True,
    )
