"""The architectural style of one house: window types, bars, shutters, sills and surrounds, drawn once."""

from dataclasses import dataclass, replace

import numpy as np

from frontage.geometry.arrays import Float
from frontage.simulate.houses.draft import HouseDraft
from frontage.simulate.houses.elevation import Dressing
from frontage.simulate.houses.glazing import SASH_GLASS_M, Design, Division, divide
from frontage.simulate.houses.shapes import BarLayout, opening_ring, plan_bars
from frontage.simulate.scene import OpeningPlan

PLAIN = Dressing()
GLASS_BEHIND_M = 0.03  # from the front of a frame back to its pane
# layouts of bars that are drawn: style, upright bars, transoms; and how often each occurs
_BARS = (("grid", 0, 0), ("grid", 1, 0), ("T", 1, 1), ("grid", 1, 1), ("grid", 1, 2), ("grid", 2, 0),
         ("T", 2, 1), ("grid", 1, 3), ("asymmetric", 1, 0), ("asymmetric", 1, 1), ("grid", 2, 2),
         ("grid", 3, 2), ("grid", 3, 4), ("grid", 0, 1), ("asymmetric", 2, 1), ("grid", 4, 3))  # fmt: skip
_BAR_SHARE = np.array([8, 14, 16, 8, 9, 5, 6, 6, 6, 4, 4, 3, 2, 3, 4, 2]) / 100


@dataclass(frozen=True)
class WindowType:
    """A type of opening that repeats on a house: size, depths and frame width in m, and its dressing.

    bars    how bars divide it: evenly and alike as in a `BarLayout`, or by a `Design`
    rise    m, height of a segmental or triangular head; None = the usual share of the width
    glazed  False for an opaque leaf (doors, gates, garages)
    """

    kind: str
    shape: str
    width: float
    height: float
    depth: float
    frame: float
    bars: BarLayout | Design
    rise: float | None = None
    dressing: Dressing = PLAIN
    glazed: bool = True

    def place(
        self,
        id: str,
        x: float,
        z: float,
        *,
        floor: int,
        bay: int,
        wall_y: float = 0.0,
        shutters: str = "none",
    ) -> OpeningPlan:
        """Return an opening of this type whose bounding box has its lower left corner at (x, z) m."""
        ring = opening_ring(self.shape, x, z, self.width, self.height, rise=self.rise)
        division = self._division(ring)
        glass = self.depth + (GLASS_BEHIND_M if division.meeting is None else SASH_GLASS_M[0])
        return OpeningPlan(
            id, self.kind, self.shape, ring, wall_y, self.depth, division.bars, shutters, self.glazed,
            glass, self.frame, floor, bay,
            glazing=division.glazing, lines=division.lines, meeting=division.meeting, ajar=division.ajar,
        )  # fmt: skip

    def _division(self, ring: Float) -> Division:
        if not self.glazed:
            return Division(())
        if isinstance(self.bars, Design):
            return divide(ring, self.frame, self.bars)
        return Division(plan_bars(ring, self.frame, self.bars))


@dataclass(frozen=True)
class Style:
    """The window type of every storey, and how the windows are arranged.

    upper, noble, top, ground   window types: middle storeys, first floor (piano nobile), top storey, ground
    parapet      m, from the floor up to the sill
    gap          m, least distance between neighbouring windows
    jitter       m, standard deviation of an opening's position, cut off at 3 cm
    odd          share of windows that were replaced by another type
    shutters     share of windows that have shutters
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
        """Return the window type of storey `floor` in a house of `floors` storeys."""
        if floor == 0:
            return self.ground
        if floor == 1:
            return self.noble
        return self.top if floor == floors - 1 else self.upper


def draw_bars(rng: np.random.Generator) -> BarLayout:
    """Draw how bars divide a window."""
    style, vertical, horizontal = _BARS[int(rng.choice(len(_BARS), p=_BAR_SHARE))]
    return BarLayout(
        style, vertical, horizontal, float(rng.uniform(0.06, 0.11)), float(rng.uniform(0.022, 0.04))
    )


def draw_style(draft: HouseDraft, rng: np.random.Generator) -> Style:
    """Draw the style of a house; whatever its specification states is kept."""
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
        "window", shape, width, height if shape != "circle" else width, _draw_reveal(draft, rng),
        float(rng.uniform(0.05, 0.09)), _stated_bars(draft, draw_bars(rng)), float(rng.uniform(0.08, 0.25)),
        _draw_dressing(rng),
    )  # fmt: skip
    if shape == "triangular":
        upper = replace(upper, rise=_draw_gable_rise(draft, upper))
    shutters = rng.random() < 0.3 and shape in ("rectangle", "segmental")
    has_shutters = _stated_or(spec.shutters, bool(shutters))
    gap = width + 0.12 if has_shutters else float(rng.uniform(0.5, 1.6))
    oriel = _stated_or(spec.oriel, rng.random() < 0.2)
    return Style(
        upper=upper,
        noble=_draw_noble(upper, rng, spec.shape is None and spec.vertical is None),
        top=_draw_top(upper, rng, spec.shape is None),
        ground=_draw_ground(upper, draft, rng),
        parapet=parapet,
        gap=max(gap, 0.7) if oriel else gap,
        jitter=float(rng.choice([0.0, 0.005, 0.012, 0.02])),
        odd=float(rng.choice([0.0, 0.0, 0.08, 0.25])) if spec.vertical is None else 0.0,
        shutters=float(rng.uniform(0.6, 1.0)) if has_shutters else 0.0,
        balconies=_stated_or(spec.balconies, rng.random() < 0.35),
        oriel=oriel,
        shop=_stated_or(spec.shop, rng.random() < (0.0 if draft.detached else 0.45)),
        dormers=_stated_or(spec.dormers, rng.random() < 0.45),
    )


def _stated_or(stated: bool | None, drawn: bool) -> bool:
    return drawn if stated is None else stated


def _fitting_width(shape: str, width: float, height: float) -> float:
    """Narrows a window so far that its arch leaves straight sides."""
    limit = {"round": 1.2, "pointed": 0.85}.get(shape, 9.0) * height
    return min(width, limit)


def _draw_gable_rise(draft: HouseDraft, window: WindowType) -> float:
    """Draws the rise (m) of triangular heads, from flat pediments to steep gables, from its own generator."""
    share = float(np.random.default_rng((*draft.seed, 2)).uniform(0.12, 0.8))
    return min(share * window.width, 0.45 * window.height)


def _draw_reveal(draft: HouseDraft, rng: np.random.Generator) -> float:
    drawn = float(0.05 + 0.35 * rng.beta(1.3, 2.4))
    return drawn if draft.spec.reveal is None else draft.spec.reveal


def _stated_bars(draft: HouseDraft, drawn: BarLayout) -> BarLayout:
    """Returns the drawn bars, or those of the specification where it states any."""
    spec = draft.spec
    if spec.vertical is None and spec.horizontal is None and spec.bars is None:
        return drawn
    return replace(
        drawn, style=spec.bars or "grid", vertical=spec.vertical or 0, horizontal=spec.horizontal or 0
    )


def _draw_dressing(rng: np.random.Generator) -> Dressing:
    sill = (float(rng.uniform(0.04, 0.12)), float(rng.uniform(0.03, 0.09)))
    surround = (float(rng.uniform(0.1, 0.18)), float(rng.uniform(0.015, 0.05)))
    return Dressing(sill if rng.random() < 0.85 else None, surround if rng.random() < 0.45 else None)


def _draw_noble(upper: WindowType, rng: np.random.Generator, free: bool) -> WindowType:
    """Draws the type of the first floor: mostly that of the upper storeys, unless `free` to differ."""
    if not free or rng.random() < 0.6:
        return upper
    shape = "round" if upper.shape == "rectangle" and rng.random() < 0.3 else upper.shape
    return replace(
        upper, shape=shape, bars=draw_bars(rng), width=_fitting_width(shape, upper.width, upper.height)
    )


def _draw_top(upper: WindowType, rng: np.random.Generator, free: bool) -> WindowType:
    """Draws the type of the top storey, whose windows may be lower."""
    if not free or rng.random() < 0.6 or upper.shape in ("round", "pointed"):
        return upper
    return replace(upper, height=upper.height * float(rng.uniform(0.72, 0.9)), bars=draw_bars(rng))


def _draw_ground(upper: WindowType, draft: HouseDraft, rng: np.random.Generator) -> WindowType:
    """Draws the type of the ground floor's windows."""
    if draft.spec.shape is not None or rng.random() < 0.5:
        return upper
    shape = "segmental" if upper.shape == "rectangle" and rng.random() < 0.4 else "rectangle"
    return replace(upper, shape=shape, bars=draw_bars(rng))
