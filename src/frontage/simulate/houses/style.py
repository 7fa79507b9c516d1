"""The taste of one facade: window types, their bars, shutters, sills and surrounds, drawn once per house."""

from dataclasses import dataclass, replace

import numpy as np

from frontage.simulate.houses.draft import HouseDraft
from frontage.simulate.houses.elevation import Dressing
from frontage.simulate.houses.shapes import BarLayout, opening_ring, plan_bars
from frontage.simulate.scene import OpeningPlan

PLAIN = Dressing()
GLASS_BEHIND = 0.03  # m, pane behind the front of its frame
_BARS = (("grid", 0, 0), ("grid", 1, 0), ("T", 1, 1), ("grid", 1, 1), ("grid", 1, 2), ("grid", 2, 0),
         ("T", 2, 1), ("grid", 1, 3), ("asymmetric", 1, 0), ("asymmetric", 1, 1), ("grid", 2, 2),
         ("grid", 3, 2), ("grid", 3, 4), ("grid", 0, 1), ("asymmetric", 2, 1), ("grid", 4, 3))  # fmt: skip
_BAR_SHARE = np.array([8, 14, 16, 8, 9, 5, 6, 6, 6, 4, 4, 3, 2, 3, 4, 2]) / 100


@dataclass(frozen=True)
class WindowType:
    """A kind of opening that repeats: size and depths in m, and how it is dressed."""

    kind: str
    shape: str
    width: float
    height: float
    depth: float
    frame: float
    bars: BarLayout
    rise: float | None = None
    dressing: Dressing = PLAIN
    glazed: bool = True

    def place(
        self, id: str, x: float, z: float, floor: int, bay: int, wall_y: float = 0.0, shutters: str = "none"
    ) -> OpeningPlan:
        """The opening of this type with the lower left corner of its bounding box at (x, z) m."""
        ring = opening_ring(self.shape, x, z, self.width, self.height, self.rise)
        bars = plan_bars(ring, self.frame, self.bars) if self.glazed else ()
        glass = self.depth + GLASS_BEHIND
        return OpeningPlan(
            id, self.kind, self.shape, ring, wall_y, self.depth, bars, shutters, self.glazed,
            glass, self.frame, floor, bay,
        )  # fmt: skip


@dataclass(frozen=True)
class Style:
    """A house's taste: types per storey, and what the grid of its windows looks like.

    upper, noble, top, ground   window types of the storeys
    parapet      m, sill above the floor
    gap          m, least distance of neighbouring windows
    jitter       m, one sigma of an opening's place, cut off at 3 cm
    odd          share of windows that were replaced by another type
    shutters     share of windows that have some
    """

    upper: WindowType
    noble: WindowType
    top: WindowType
    ground: WindowType
    parapet: float
    gap: float
    jitter: float
    odd: float
    shutters: float
    balconies: bool
    oriel: bool
    shop: bool
    dormers: bool

    def window_type(self, floor: int, floors: int) -> WindowType:
        """The window type of a storey."""
        if floor == 0:
            return self.ground
        if floor == 1:
            return self.noble
        return self.top if floor == floors - 1 else self.upper


def draw_bars(rng: np.random.Generator) -> BarLayout:
    """Draw a layout of bars."""
    style, vertical, horizontal = _BARS[int(rng.choice(len(_BARS), p=_BAR_SHARE))]
    return BarLayout(
        style, vertical, horizontal, float(rng.uniform(0.06, 0.11)), float(rng.uniform(0.022, 0.04))
    )


def draw_style(draft: HouseDraft, rng: np.random.Generator) -> Style:
    """Draw the taste of a house; what its spec says is kept."""
    spec = draft.spec
    room = draft.floor_height - 0.3
    parapet = float(rng.uniform(0.55, 1.0))
    low = bool(room - parapet < 1.75)
    height = float(rng.uniform(1.05, 1.45) if low else rng.uniform(1.4, min(2.3, room - parapet - 0.12)))
    height = min(height, room - parapet - 0.1)
    width = float(rng.uniform(0.85, 1.4) if not low else rng.uniform(0.9, 1.7))
    shape = spec.shape or str(
        rng.choice(["rectangle", "segmental", "round", "pointed"], p=[0.58, 0.22, 0.14, 0.06])
    )
    width = _fitting_width(shape, width, height)
    upper = WindowType(
        "window", shape, width, height if shape != "circle" else width, _reveal(draft, rng),
        float(rng.uniform(0.05, 0.09)), _bars(draft, draw_bars(rng)), float(rng.uniform(0.08, 0.25)),
        _dressing(rng),
    )  # fmt: skip
    if shape == "triangular":
        upper = replace(upper, rise=_gable(draft, upper))
    shutters = rng.random() < 0.3 and shape in ("rectangle", "segmental")
    has_shutters = bool(shutters) if spec.shutters is None else spec.shutters
    gap = width + 0.12 if has_shutters else float(rng.uniform(0.5, 1.6))
    oriel = _chosen(spec.oriel, rng.random() < 0.2)
    return Style(
        upper=upper,
        noble=_noble(upper, rng, spec.shape is None and spec.vertical is None),
        top=_top(upper, rng, spec.shape is None),
        ground=_ground(upper, draft, rng),
        parapet=parapet,
        gap=max(gap, 0.7) if oriel else gap,
        jitter=float(rng.choice([0.0, 0.005, 0.012, 0.02])),
        odd=float(rng.choice([0.0, 0.0, 0.08, 0.25])) if spec.vertical is None else 0.0,
        shutters=float(rng.uniform(0.6, 1.0)) if has_shutters else 0.0,
        balconies=_chosen(spec.balconies, rng.random() < 0.35),
        oriel=oriel,
        shop=_chosen(spec.shop, rng.random() < (0.0 if draft.detached else 0.45)),
        dormers=_chosen(spec.dormers, rng.random() < 0.45),
    )


def _chosen(asked: bool | None, drawn: bool) -> bool:
    return drawn if asked is None else asked


def _fitting_width(shape: str, width: float, height: float) -> float:
    """Narrow a window so that its arch leaves straight sides."""
    limit = {"round": 1.2, "pointed": 0.85}.get(shape, 9.0) * height
    return min(width, limit)


def _gable(draft: HouseDraft, window: WindowType) -> float:
    """Rise m of triangular heads, from flat pediments to steep gables; from a stream of its own."""
    share = float(np.random.default_rng((*draft.seed, 2)).uniform(0.12, 0.8))
    return min(share * window.width, 0.45 * window.height)


def _reveal(draft: HouseDraft, rng: np.random.Generator) -> float:
    drawn = float(0.05 + 0.35 * rng.beta(1.3, 2.4))
    return drawn if draft.spec.reveal is None else draft.spec.reveal


def _bars(draft: HouseDraft, drawn: BarLayout) -> BarLayout:
    spec = draft.spec
    if spec.vertical is None and spec.horizontal is None and spec.bars is None:
        return drawn
    return replace(
        drawn, style=spec.bars or "grid", vertical=spec.vertical or 0, horizontal=spec.horizontal or 0
    )


def _dressing(rng: np.random.Generator) -> Dressing:
    sill = (float(rng.uniform(0.04, 0.12)), float(rng.uniform(0.03, 0.09)))
    surround = (float(rng.uniform(0.1, 0.18)), float(rng.uniform(0.015, 0.05)))
    return Dressing(sill if rng.random() < 0.85 else None, surround if rng.random() < 0.45 else None)


def _noble(upper: WindowType, rng: np.random.Generator, free: bool) -> WindowType:
    if not free or rng.random() < 0.6:
        return upper
    shape = "round" if upper.shape == "rectangle" and rng.random() < 0.3 else upper.shape
    return replace(
        upper, shape=shape, bars=draw_bars(rng), width=_fitting_width(shape, upper.width, upper.height)
    )


def _top(upper: WindowType, rng: np.random.Generator, free: bool) -> WindowType:
    if not free or rng.random() < 0.6 or upper.shape in ("round", "pointed"):
        return upper
    return replace(upper, height=upper.height * float(rng.uniform(0.72, 0.9)), bars=draw_bars(rng))


def _ground(upper: WindowType, draft: HouseDraft, rng: np.random.Generator) -> WindowType:
    if draft.spec.shape is not None or rng.random() < 0.5:
        return upper
    shape = "segmental" if upper.shape == "rectangle" and rng.random() < 0.4 else "rectangle"
    return replace(upper, shape=shape, bars=draw_bars(rng))
