"""The layout of a front: window axes and storeys, filled with windows, doors, balconies and oriels."""

from dataclasses import dataclass, replace

import numpy as np

from frontage.errors import OptionError
from frontage.geometry.arrays import Float
from frontage.simulate.houses.draft import HouseDraft
from frontage.simulate.houses.elevation import Balcony, Oriel, placement_problems
from frontage.simulate.houses.groundfloor import lay_out_ground_floor
from frontage.simulate.houses.placements import PlacedOpening, oriel_wall, without_collisions
from frontage.simulate.houses.shapes import BarLayout
from frontage.simulate.houses.style import Style, WindowType, draw_bars

LEAST_PIER_M = 0.12  # between windows that stand as close together as a specification may ask


@dataclass(frozen=True)
class Layout:
    """What stands where on a facade: openings (the earlier ones have precedence), balconies, oriels."""

    placements: tuple[PlacedOpening, ...]
    balconies: tuple[Balcony, ...] = ()
    oriels: tuple[Oriel, ...] = ()


def lay_out_front(
    draft: HouseDraft, style: Style, outline: Float, id: str, rng: np.random.Generator
) -> Layout:
    """Fill the front of a house; openings that would overlap or leave the wall are left out.

    Raises OptionError when the window axes that the specification asks for do not fit.
    """
    axes = draw_axes(draft.width, style, draft.spec.columns, id, rng)
    low = lay_out_ground_floor(draft, style, axes, rng)
    placements = _upper_rows(draft, style, axes, rng)
    oriel = _draw_oriel(draft, style, axes, rng)
    balconies: tuple[Balcony, ...] = ()
    if style.balconies:
        placements, balconies = _add_balconies(
            draft, placements, axes, style.upper.width, oriel=oriel, rng=rng
        )
    if oriel:
        placements = [_move_to_oriel(s, oriel) for s in placements]
    placements = [*low, *placements, *_gable_rows(draft, style, rng)]
    oriels = (oriel,) if oriel else ()
    return Layout(tuple(keep_fitting(placements, outline, oriels)), balconies, oriels)


def lay_out_side(
    draft: HouseDraft, style: Style, outline: Float, id: str, rng: np.random.Generator
) -> Layout:
    """Fill a side or the back of a detached house with a few windows."""
    quiet = replace(style, gap=max(style.gap, 1.2), shutters=style.shutters if rng.random() < 0.5 else 0.0)
    width, count = float(np.ptp(outline[:, 0])), int(rng.integers(0, 4))
    if count == 0:
        return Layout(())
    axes = draw_axes(width, quiet, None, id, rng)[:count]
    placements = []
    for storey in draft.storeys:
        kind = quiet.window_type(storey.number, draft.floors)
        z = storey.floor + quiet.parapet
        placements += [_place_window(quiet, kind, x, z, floor=storey.number, rng=rng) for x in axes]
    return Layout(tuple(keep_fitting([s for s in placements if rng.random() < 0.85], outline, ())))


def keep_fitting(
    placements: list[PlacedOpening], outline: Float, oriels: tuple[Oriel, ...]
) -> list[PlacedOpening]:
    """Keep the openings that lie within the wall, clear of earlier ones and not behind an oriel."""
    front = [s for s in placements if s.wall_y == 0.0]
    blocked = [o.ring for o in oriels]
    problems = placement_problems(
        [*blocked, *(s.ring for s in front)], [outline] * (len(blocked) + len(front))
    )
    kept = {id(s) for s, p in zip(front, problems[len(blocked) :], strict=True) if not p}
    for oriel in oriels:
        own = [s for s in placements if s.wall_y != 0.0]
        problems = placement_problems([s.ring for s in own], [oriel_wall(oriel)] * len(own))
        kept |= {id(s) for s, p in zip(own, problems, strict=True) if not p}
    return without_collisions([s for s in placements if id(s) in kept])


def draw_axes(
    width: float, style: Style, count: int | None, id: str, rng: np.random.Generator
) -> list[float]:
    """Draw the left edges (m) of the windows of a storey, evenly spread or in a looser rhythm.

    Raises OptionError when `count` windows do not fit on `width` m.
    """
    w = max(t.width for t in (style.upper, style.noble, style.top, style.ground))
    margin = 0.5 + (w / 2 if style.shutters else 0.0)
    room = width - 2 * margin + style.gap
    n = count or max(1, int(room // (w + style.gap)))
    free = width - 2 * margin - n * w
    if count and n * (w + LEAST_PIER_M) + LEAST_PIER_M > width:
        raise OptionError(
            f"house {id}: {n} columns of windows {w:.2f} m wide do not fit on {width:.2f} m; ask for fewer"
        )
    weight = np.ones(n - 1) if rng.random() < 0.65 else rng.uniform(0.75, 1.35, n - 1)
    if n == 1 or free <= 0:
        pier = (width - n * w) / (n + 1)
        return [pier + k * (w + pier) for k in range(n)]
    spread = min(1.0, (style.gap * 1.8 * (n - 1)) / free)
    gaps = free * spread * weight / weight.sum()
    start = margin + free * (1 - spread) / 2
    return [float(start + k * w + gaps[:k].sum()) for k in range(n)]


def _upper_rows(
    draft: HouseDraft, style: Style, axes: list[float], rng: np.random.Generator
) -> list[PlacedOpening]:
    placements = []
    for storey in draft.storeys[1:]:
        kind = style.window_type(storey.number, draft.floors)
        for x in axes:
            own = kind if rng.random() >= style.odd else replace(kind, bars=draw_bars(rng))
            z = storey.floor + style.parapet
            placements.append(_place_window(style, own, x, z, floor=storey.number, rng=rng))
    return placements


def _place_window(
    style: Style, kind: WindowType, x: float, z: float, *, floor: int, rng: np.random.Generator
) -> PlacedOpening:
    """Places a window, jittered, on the axis of the style's upper windows; draws its shutters and curtain."""
    dx, dz = np.clip(rng.normal(0, style.jitter, 2) if style.jitter else np.zeros(2), -0.03, 0.03)
    shutters = "none"
    if rng.random() < style.shutters:
        shutters = "open" if rng.random() < 0.75 else "closed"
    curtain = str(rng.choice(["none", "sides", "net", "blind"], p=[0.35, 0.3, 0.2, 0.15]))
    dressing = replace(kind.dressing, curtain=curtain, share=float(rng.uniform(0.15, 0.8)))
    middle = x + style.upper.width / 2
    return PlacedOpening(
        replace(kind, dressing=dressing),
        float(middle - kind.width / 2 + dx),
        float(z + dz),
        floor,
        0.0,
        shutters,
    )


def _draw_oriel(draft: HouseDraft, style: Style, axes: list[float], rng: np.random.Generator) -> Oriel | None:
    """Draws an oriel over one or two axes and some upper storeys; None where windows stand too close."""
    if not style.oriel or draft.floors < 2:
        return None
    spans = (1, 2) if len(axes) > 3 else (1,)
    places = [(k, n, slant) for n in spans for k in range(len(axes) - n + 1) for slant in (0.0, 0.25)]
    fits = [p for p in places if _oriel_fits(draft, style, axes, p)]
    if not fits:
        return None
    first, span, slant = fits[int(rng.integers(len(fits)))]
    x0, x1 = _oriel_span(style, axes, (first, span, slant))
    last = int(rng.integers(1, draft.floors))
    z1 = draft.level(last + 1) - 0.25 if last + 1 < draft.floors else draft.eaves - 0.45
    highest = max(t.height for t in (style.upper, style.noble, style.top)) + style.parapet + 0.12
    if z1 < draft.level(last) + highest:
        z1 = draft.level(last) + highest
    return Oriel(x0, x1, draft.level(1) - 0.2, z1, float(rng.uniform(0.4, 0.9)), slant)


def _oriel_span(style: Style, axes: list[float], place: tuple[int, int, float]) -> tuple[float, float]:
    """Returns the left and right edge (m) of an oriel at `place`: first axis, number of axes, slant m."""
    first, span, slant = place
    return axes[first] - 0.22 - slant, axes[first + span - 1] + style.upper.width + 0.22 + slant


def _oriel_fits(draft: HouseDraft, style: Style, axes: list[float], place: tuple[int, int, float]) -> bool:
    """Checks that an oriel keeps 12 cm from the windows beside it and 42 cm from the wall's ends."""
    first, span, _ = place
    x0, x1 = _oriel_span(style, axes, place)
    left = axes[first - 1] + style.upper.width if first else 0.3
    right = axes[first + span] if first + span < len(axes) else draft.width - 0.3
    return x0 >= left + 0.12 and x1 <= right - 0.12


def _move_to_oriel(placement: PlacedOpening, oriel: Oriel) -> PlacedOpening:
    """Moves a window to the front of the oriel that covers it."""
    x, z = placement.x + placement.type.width / 2, placement.z + placement.type.height / 2
    if not (oriel.x0 < x < oriel.x1 and oriel.z0 < z < oriel.z1):
        return placement
    dressing = replace(placement.type.dressing, surround=None, flare=0.12)
    kind = replace(placement.type, dressing=dressing, depth=min(placement.type.depth, 0.16))
    return replace(placement, type=kind, wall_y=-oriel.projection, shutters="none")


def _add_balconies(
    draft: HouseDraft,
    placements: list[PlacedOpening],
    axes: list[float],
    width: float,
    *,
    oriel: Oriel | None,
    rng: np.random.Generator,
) -> tuple[list[PlacedOpening], tuple[Balcony, ...]]:
    """Adds balconies, and turns the windows of one axis or of a row of axes into their doors."""
    first = int(rng.integers(0, len(axes)))
    last = first if rng.random() < 0.6 else min(first + int(rng.integers(1, 3)), len(axes) - 1)
    x0, x1 = max(axes[first] - 0.35, 0.15), min(axes[last] + width + 0.35, draft.width - 0.15)
    if oriel and x0 < oriel.x1 + 0.1 and x1 > oriel.x0 - 0.1:
        return placements, ()
    floors = [k for k in range(1, draft.floors) if rng.random() < 0.7]
    projection, style = float(rng.uniform(0.35, 1.3)), str(rng.choice(["bars", "bars", "solid"]))
    balconies = [Balcony(x0, x1, draft.level(k), projection, style=style) for k in floors]
    changed = []
    for placement in placements:
        middle = placement.x + placement.type.width / 2
        changed.append(
            _as_door(placement, draft) if placement.floor in floors and x0 < middle < x1 else placement
        )
    return changed, tuple(balconies)


def _as_door(placement: PlacedOpening, draft: HouseDraft) -> PlacedOpening:
    if placement.type.shape == "circle":
        return placement
    z = draft.level(placement.floor) + 0.04
    height = placement.z + placement.type.height - z
    dressing = replace(placement.type.dressing, sill=None)
    return replace(
        placement, type=replace(placement.type, kind="door", height=height, dressing=dressing), z=z
    )


def _gable_rows(draft: HouseDraft, style: Style, rng: np.random.Generator) -> list[PlacedOpening]:
    """Places windows in a gable that faces the street, row by row as long as there is room."""
    if draft.roof != "street_gable":
        return []
    placements = []
    plain = replace(style, shutters=0.0)
    small = replace(style.top, width=style.top.width * 0.8, height=style.top.height * 0.75, shape="rectangle")
    for row in range(3):
        z = draft.eaves + 0.5 + 2.5 * row
        clear = draft.width * (1 - (z + small.height - draft.eaves) / draft.rise) - 0.5
        count = int(clear // (small.width + 0.7))
        if count < 1:
            oculus = replace(small, shape="circle", width=0.7, height=0.7, bars=BarLayout())
            if clear >= 0.6:
                placements.append(PlacedOpening(oculus, draft.width / 2 - 0.35, z, draft.floors + row))
            break
        pitch = small.width + 0.7
        start = draft.width / 2 - count * pitch / 2 + 0.35
        for k in range(min(count, 4)):
            shift = (count - min(count, 4)) * pitch / 2
            x = start + shift + k * pitch - (style.upper.width - small.width) / 2
            placements.append(_place_window(plain, small, x, z, floor=draft.floors + row, rng=rng))
    return placements
