"""The solid parts of a simulated street: houses with openings and protrusions, trees, cars, poles.

Frames: the *street* frame has s along the street, d into the buildings of side 0, z up. A *facade* frame
has its origin on the wall plane at the lower left corner of the house, x right as seen from the street,
y into the building, z up. Lengths in metres.
"""

from dataclasses import dataclass

import numpy as np

from frontage.geometry.arrays import Array, Float
from frontage.geometry.rigid import Rigid3

GROUND, FACADE, INTERIOR, TREE, CAR, ROOF, POLE, CLUTTER, SIDE = range(9)
STREET_WIDTH = 14.0
KERB = 3.0
FRAME, BAR = 0.06, 0.035  # widths of window frames and bars, m


@dataclass(frozen=True)
class OpeningTruth:
    """A rectangular opening, x0 z0 x1 z1 in the facade frame, frame and glass `depth` behind the wall."""

    kind: str
    x0: float
    z0: float
    x1: float
    z1: float
    depth: float
    bars_vertical: tuple[float, ...] = ()
    bars_horizontal: tuple[float, ...] = ()


@dataclass(frozen=True)
class Box:
    """An axis-aligned box: `low`, `high` (3,) in the frame of whatever holds it."""

    low: tuple[float, float, float]
    high: tuple[float, float, float]
    kind: str = "box"


@dataclass(frozen=True)
class Ball:
    """A tree crown: centre (3,) in the street frame and radius; `density` is its share of opaque rays."""

    centre: tuple[float, float, float]
    radius: float
    density: float = 0.7


@dataclass(frozen=True, eq=False)
class HouseTruth:
    """One house: s0..s1 along the street, its facade's frame and what is cut into and stuck onto the wall."""

    id: str
    side: int
    s0: float
    s1: float
    offset: float
    height: float
    ground_z: float
    local_from_facade: Rigid3
    openings: tuple[OpeningTruth, ...]
    boxes: tuple[Box, ...]
    colour: tuple[float, float, float]
    seed: int

    @property
    def width(self) -> float:
        return self.s1 - self.s0

    def opening_at(self, x: Array, z: Array) -> Array:
        """Index (n,) of the opening that holds the points (x, z) of the wall plane, -1 where wall."""
        if not self.openings:
            return np.full(np.shape(x), -1, np.int32)
        table, ex, ez = self._cells()
        return table[np.searchsorted(ez, z), np.searchsorted(ex, x)]

    def _cells(self) -> tuple[Array, Float, Float]:
        ex = np.unique([v for o in self.openings for v in (o.x0, o.x1)])
        ez = np.unique([v for o in self.openings for v in (o.z0, o.z1)])
        table = np.full((len(ez) + 1, len(ex) + 1), -1, np.int32)
        for i, o in enumerate(self.openings):
            r0, r1 = np.searchsorted(ez, (o.z0, o.z1)) + 1
            c0, c1 = np.searchsorted(ex, (o.x0, o.x1)) + 1
            table[r0:r1, c0:c1] = i
        return table, ex, ez


@dataclass(frozen=True)
class Style:
    """What a house looks like; twins share one."""

    width: float
    floors: int
    floor_height: float
    ground_height: float
    bay: float
    window: tuple[float, float]
    sill: float
    depth: float
    bars: tuple[int, int]
    shop: bool
    balcony: bool
    colour: tuple[float, float, float]
    offset: float


PALETTE = ((0.72, 0.45, 0.36), (0.82, 0.76, 0.62), (0.62, 0.66, 0.70), (0.80, 0.62, 0.42), (0.70, 0.72, 0.60))


def draw_style(rng: np.random.Generator, number: int) -> Style:
    return Style(
        width=float(rng.uniform(6.0, 10.0)),
        floors=int(rng.integers(3, 6)),
        floor_height=float(rng.uniform(2.9, 3.5)),
        ground_height=float(rng.uniform(3.4, 4.2)),
        bay=float(rng.uniform(2.0, 2.6)),
        window=(float(rng.uniform(0.95, 1.25)), float(rng.uniform(1.5, 1.9))),
        sill=float(rng.uniform(0.75, 0.95)),
        depth=float(rng.uniform(0.10, 0.20)),
        bars=(int(rng.integers(0, 3)), int(rng.integers(0, 3))),
        shop=bool(rng.random() < 0.4),
        balcony=bool(rng.random() < 0.4),
        colour=PALETTE[number % len(PALETTE)],
        offset=float(rng.choice([-0.35, -0.15, 0.0, 0.0, 0.2, 0.4])),
    )


def _window(style: Style, cx: float, z0: float, kind: str = "window") -> OpeningTruth:
    w, h = style.window
    x0, x1, z1 = cx - w / 2, cx + w / 2, z0 + h
    nv, nh = style.bars
    return OpeningTruth(
        kind, x0, z0, x1, z1, style.depth,
        tuple(np.linspace(x0, x1, nv + 2)[1:-1].tolist()),
        tuple(np.linspace(z0, z1, nh + 2)[1:-1].tolist()),
    )  # fmt: skip


def openings_of(style: Style, rng: np.random.Generator) -> tuple[OpeningTruth, ...]:
    """Bays and floors of windows over a ground floor with a door and windows or a shopfront."""
    bays = max(2, round((style.width - 0.8) / style.bay))
    centres = (np.arange(bays) + 0.5) * style.width / bays
    floors = [style.ground_height + f * style.floor_height + style.sill for f in range(style.floors - 1)]
    out = [_window(style, float(c), z) for z in floors for c in centres]
    door = int(rng.integers(bays))
    for k, c in enumerate(centres):
        if k == door:
            out.append(OpeningTruth("door", float(c) - 0.55, 0.15, float(c) + 0.55, 2.55, style.depth + 0.1))
        elif style.shop:
            half = style.width / bays / 2 - 0.25
            out.append(OpeningTruth("shopfront", float(c) - half, 0.5, float(c) + half, 2.8, 0.12))
        else:
            out.append(_window(style, float(c), 1.05))
    return tuple(out)


def boxes_of(style: Style, height: float, openings: tuple[OpeningTruth, ...]) -> tuple[Box, ...]:
    """Cornice, string course, sills and, on some houses, balconies: all in front of the wall (y < 0)."""
    w = style.width
    boxes = [
        Box((0.0, -0.30, height - 0.35), (w, 0.0, height), "cornice"),
        Box((0.0, -0.08, style.ground_height - 0.15), (w, 0.0, style.ground_height + 0.05), "string course"),
    ]
    windows = [o for o in openings if o.kind == "window"]
    boxes += [
        Box((o.x0 - 0.08, -0.07, o.z0 - 0.10), (o.x1 + 0.08, 0.0, o.z0 - 0.02), "sill") for o in windows
    ]
    if style.balcony and style.floors > 2:
        z = style.ground_height + style.floor_height
        above = [o for o in windows if z < o.z0 < z + style.floor_height]
        o = above[len(above) // 2]
        x0, x1 = o.x0 - 0.3, o.x1 + 0.3
        boxes.append(Box((x0, -0.90, z - 0.05), (x1, 0.0, z + 0.10), "balcony"))
        boxes.append(Box((x0, -0.90, z + 0.10), (x1, -0.85, z + 0.75), "rail"))
    return tuple(boxes)


def street_frame(azimuth: float) -> Rigid3:
    """local_from_street for a street whose s axis has `azimuth` (rad, counter-clockwise from east)."""
    c, s = np.cos(azimuth), np.sin(azimuth)
    return Rigid3("local", "street", np.array([[c, -s, 0], [s, c, 0], [0, 0, 1.0]]), np.zeros(3))


def build_house(
    number: int, side: int, s0: float, style: Style, slope: float, frame: Rigid3, seed: int
) -> HouseTruth:
    """Place a house at s0 on a side of the street and cut its openings."""
    rng = np.random.default_rng(seed)
    s1 = s0 + style.width
    height = style.ground_height + (style.floors - 1) * style.floor_height + 0.6
    ground = slope * (s0 + s1) / 2
    openings = openings_of(style, rng)
    if side == 0:
        street_from_facade = Rigid3("street", "facade", np.eye(3), np.array([s0, style.offset, ground]))
    else:  # the other side looks back: x and y turn round
        t = np.array([s1, -STREET_WIDTH - style.offset, ground])
        street_from_facade = Rigid3("street", "facade", np.diag([-1.0, -1.0, 1.0]), t)
    return HouseTruth(
        f"H{number}", side, s0, s1, style.offset, height, ground, frame @ street_from_facade,
        openings, boxes_of(style, height, openings), style.colour, seed,
    )  # fmt: skip


def build_houses(
    rng: np.random.Generator, count: int, both_sides: bool, twins: bool, slope: float, frame: Rigid3
) -> tuple[HouseTruth, ...]:
    """Terraces of `count` houses per side. Twins all share one style; only their marks and tints differ."""
    out: list[HouseTruth] = []
    seed = int(rng.integers(1 << 30))
    for side in range(2 if both_sides else 1):
        s = 0.0
        shared = draw_style(rng, side)
        for k in range(count):
            style = shared if twins else draw_style(rng, side * count + k)
            out.append(
                build_house(len(out), side, s, style, slope, frame, seed if twins else seed + len(out))
            )
            s += style.width
    return tuple(out)
