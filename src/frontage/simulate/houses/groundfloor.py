"""The ground floor of a front: doors, shop fronts, gates and garages, basement windows."""

from dataclasses import replace

import numpy as np

from frontage.simulate.houses.draft import HouseDraft
from frontage.simulate.houses.elevation import Dressing
from frontage.simulate.houses.placements import PlacedOpening
from frontage.simulate.houses.shapes import BarLayout
from frontage.simulate.houses.style import Style, WindowType, draw_bars

_NO_BARS = BarLayout()
_PIER_M = 0.38  # least width of a pier between shop fronts


def lay_out_ground_floor(
    draft: HouseDraft, style: Style, axes: list[float], rng: np.random.Generator
) -> list[PlacedOpening]:
    """Place the openings of the ground floor and the basement, the most important ones first."""
    if style.shop and draft.width > 4.5:
        return _shops(draft, style, rng)
    placements = [_door(draft, style, _entrance_axis(style, axes, rng), rng)]
    if draft.width > 8 and rng.random() < (0.5 if draft.detached else 0.25):
        placements.append(_gate(draft, style, rng))
    z = draft.entrance + style.parapet
    placements += [_window(style, x, z, rng) for x in axes]
    return placements + _basement(draft, style, axes)


def _entrance_axis(style: Style, axes: list[float], rng: np.random.Generator) -> float:
    """Draws the window axis of the entrance and returns its middle, m."""
    return axes[int(rng.integers(len(axes)))] + style.upper.width / 2


def _door(draft: HouseDraft, style: Style, middle: float, rng: np.random.Generator) -> PlacedOpening:
    """Places an entrance with an opaque leaf, at the pavement or up some steps."""
    width = float(rng.uniform(0.95, 1.35))
    shape = style.ground.shape if style.ground.shape in ("segmental", "round") else "rectangle"
    z = _threshold(draft, middle - width / 2, middle + width / 2)
    top = draft.entrance + min(draft.ground_floor_height - 0.5, float(rng.uniform(2.1, 2.7)))
    top = min(top, z + 2.9)
    kind = WindowType(
        "door", shape, width, top - z, style.upper.depth, 0.07, _NO_BARS, 0.15,
        Dressing(surround=style.upper.dressing.surround, leaf=str(rng.choice(["panels", "boards"]))), False,
    )  # fmt: skip
    return PlacedOpening(kind, middle - width / 2, z, 0)


def _threshold(draft: HouseDraft, x0: float, x1: float) -> float:
    """Returns the lower edge (m) of a door: on the ground floor where steps lead up, else at the pavement."""
    ground = max(draft.ground_at(x0), draft.ground_at(x1))
    lowest = min(draft.ground_at(x0), draft.ground_at(x1))
    return draft.entrance + 0.02 if draft.entrance - lowest < 0.45 else ground + 0.08


def _gate(draft: HouseDraft, style: Style, rng: np.random.Generator) -> PlacedOpening:
    """Places a gate to the yard, or a garage, at the left or right end of the front."""
    garage = draft.detached or bool(rng.random() < 0.3)
    width = float(rng.uniform(2.3, 2.9) if garage else rng.uniform(2.4, 3.1))
    x = 0.6 if rng.random() < 0.5 else draft.width - 0.6 - width
    z = max(draft.ground_at(x), draft.ground_at(x + width)) + 0.08
    height = 2.2 if garage else min(draft.ground_floor_height - 0.4, float(rng.uniform(2.7, 3.4)))
    shape = "rectangle" if garage else str(rng.choice(["rectangle", "segmental", "round"]))
    height = max(height, 1.3 + (width / 2 if shape == "round" else 0.4))
    depth = max(style.upper.depth, float(rng.uniform(0.12, 0.4)))
    dressing = Dressing(leaf="ribs" if garage else "boards")
    kind = WindowType(
        "garage" if garage else "passage", shape, width, height, depth, 0.07, _NO_BARS, 0.3, dressing, False
    )
    return PlacedOpening(kind, x, z, 0)


def _window(style: Style, x: float, z: float, rng: np.random.Generator) -> PlacedOpening:
    kind = style.ground
    dx, dz = np.clip(rng.normal(0, style.jitter, 2) if style.jitter else np.zeros(2), -0.03, 0.03)
    curtain = str(rng.choice(["none", "sides", "net", "blind"], p=[0.2, 0.25, 0.4, 0.15]))
    dressing = replace(kind.dressing, curtain=curtain, share=float(rng.uniform(0.15, 0.8)))
    left = x + (style.upper.width - kind.width) / 2
    shutters = "none"
    if rng.random() < style.shutters:
        shutters = "open" if rng.random() < 0.75 else "closed"
    return PlacedOpening(replace(kind, dressing=dressing), float(left + dx), float(z + dz), 0, 0.0, shutters)


def _basement(draft: HouseDraft, style: Style, axes: list[float]) -> list[PlacedOpening]:
    """Places low windows below those of a raised ground floor, where the pavement leaves room."""
    placements = []
    kind = WindowType(
        "basement", "rectangle", 0.75, 0.36, min(style.upper.depth, 0.2), 0.05, BarLayout("grid", 1, 0, 0.05)
    )
    for x in axes:
        left = x + style.upper.width / 2 - kind.width / 2
        z = draft.entrance - 0.2 - kind.height
        if z - max(draft.ground_at(left), draft.ground_at(left + kind.width)) > 0.12:
            placements.append(PlacedOpening(kind, left, z, -1))
    return placements


def _shops(draft: HouseDraft, style: Style, rng: np.random.Generator) -> list[PlacedOpening]:
    """Places shop fronts between piers, a house door at one end, and a glazed shop door if there is room."""
    left, right = 0.45, draft.width - 0.45
    door_left = bool(rng.random() < 0.5)
    door = _door(draft, style, left + 0.7 if door_left else right - 0.7, rng)
    if door_left:
        left = door.x + door.type.width + _PIER_M
    else:
        right = door.x - _PIER_M
    placements = [door]
    if right - left > 4.0:
        width = float(rng.uniform(0.95, 1.15))
        at = left + (right - left - width) * float(rng.choice([0.0, 0.5, 1.0]))
        placements.append(_shop_door(draft, style, at, width))
        spans = [(left, at - _PIER_M), (at + width + _PIER_M, right)]
    else:
        spans = [(left, right)]
    bars = draw_bars(rng)
    height = min(draft.ground_floor_height - 0.75, 2.7)
    shape = str(rng.choice(["rectangle", "rectangle", "rectangle", "segmental", "round"]))
    for span in spans:
        placements += _row_of_shops(draft, style, span, height=height, shape=shape, bars=bars)
    return placements


def _row_of_shops(
    draft: HouseDraft,
    style: Style,
    span: tuple[float, float],
    *,
    height: float,
    shape: str,
    bars: BarLayout,
) -> list[PlacedOpening]:
    """Fills a span (m) of the ground floor with shop fronts of equal width."""
    x0, x1 = span
    if x1 - x0 < 1.0:
        return []
    count = max(1, int(np.ceil((x1 - x0 + _PIER_M) / (3.6 + _PIER_M))))
    width = (x1 - x0 - _PIER_M * (count - 1)) / count
    shape = shape if height > 0.6 * width or shape == "rectangle" else "segmental"
    bars = replace(bars, vertical=min(4, int(width // 1.3)), main=0.06, thin=0.05)
    kind = WindowType(
        "shopfront", shape, width, height, max(0.06, style.upper.depth * 0.7), 0.06, bars, 0.2,
        Dressing(sill=(0.06, 0.05)),
    )  # fmt: skip
    return [PlacedOpening(kind, x0 + k * (width + _PIER_M), draft.entrance + 0.35, 0) for k in range(count)]


def _shop_door(draft: HouseDraft, style: Style, x: float, width: float) -> PlacedOpening:
    height = min(draft.ground_floor_height - 0.5, 2.55)
    bars = BarLayout("asymmetric", 0, 1, 0.1, 0.1)
    kind = WindowType(
        "door", "rectangle", width, height, max(0.06, style.upper.depth * 0.7), 0.09, bars, None, Dressing()
    )
    return PlacedOpening(kind, x, draft.entrance + 0.02, 0)
