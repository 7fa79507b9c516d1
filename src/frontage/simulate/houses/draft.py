"""A house before it is drawn: its measures, levels and materials, from the specification or the seed."""

from dataclasses import dataclass

import numpy as np

from frontage.simulate.houses.housespec import HouseSpec
from frontage.simulate.houses.palette import Palette, draw_palette, varied_palette

SLAB_M = 0.3  # thickness of the structure between two storeys
ROOFS = ("gable", "street_gable", "hip", "mansard", "flat")
# how often detached houses have 1, 2, 3 storeys, and terraced ones 2, 3, 4, 5
_FLOORS = {True: [0.25, 0.55, 0.2], False: [0.2, 0.35, 0.3, 0.15]}


@dataclass(frozen=True)
class Storey:
    """One storey: its number (-1 = basement, 0 = ground floor) and the heights of floor and ceiling, m."""

    number: int
    floor: float
    ceiling: float


@dataclass(frozen=True)
class HouseDraft:
    """The measures of a house in its own frame: x right, y into the house, z up from its lowest ground.

    ground          m, height of the pavement at the left and right corner; the lower one is 0
    step            m, height of the ground floor above the highest pavement
    rise            m, height of the ridge above the eaves
    detached        whether its sides stand free and have openings
    roughness       m, standard deviation of its walls' surface, correlated over `correlation` m
    lean            rad, rotation about the foot of the front; positive: the top leans back
    inner           m, from the main plane to the inner face of the outer walls
    seed            seed of its layout, shared by twins
    """

    spec: HouseSpec
    width: float
    depth: float
    floors: int
    floor_height: float
    ground_floor_height: float
    step: float
    ground: tuple[float, float]
    roof: str
    rise: float
    lean: float
    roughness: float
    correlation: float
    detached: bool
    inner: float
    palette: Palette
    seed: tuple[int, ...]

    @property
    def entrance(self) -> float:
        """Height of the ground floor's floor, m."""
        return max(self.ground) + self.step

    @property
    def eaves(self) -> float:
        """Height of the eaves, m."""
        return self.entrance + self.ground_floor_height + self.floor_height * (self.floors - 1)

    @property
    def ridge(self) -> float:
        """Height of the ridge, m."""
        return self.eaves + self.rise

    def level(self, floor: int) -> float:
        """Height of a storey's floor, m."""
        upper = self.ground_floor_height + self.floor_height * (floor - 1)
        return self.entrance + (upper if floor > 0 else 0.0)

    @property
    def storeys(self) -> tuple[Storey, ...]:
        """The storeys above ground, from the lowest up."""
        tops = [self.level(k + 1) if k + 1 < self.floors else self.eaves for k in range(self.floors)]
        return tuple(Storey(k, self.level(k), top - SLAB_M) for k, top in enumerate(tops))

    def ground_at(self, x: float) -> float:
        """Height of the pavement at x along the front, m."""
        left, right = self.ground
        return left + (right - left) * x / self.width


def draft_house(
    spec: HouseSpec, seed: tuple[int, ...], slope: float, detached: bool, width: float
) -> HouseDraft:
    """Draft a house `width` m wide; `slope` is the rise of the ground per metre along its x axis.

    Whatever `spec` leaves out is drawn from `seed`.
    """
    rng = np.random.default_rng(seed)
    floors = spec.floors or int(rng.choice([1, 2, 3] if detached else [2, 3, 4, 5], p=_FLOORS[detached]))
    height = float(rng.uniform(2.65, 2.9) if detached else rng.uniform(2.75, 3.7))
    ground_height = height + float(0.0 if detached else rng.uniform(0.0, 0.9))
    depth = float(rng.uniform(8.5, 12.0))
    depth = spec.depth or depth
    roof, rise = _draw_roof(spec, detached, width, depth, rng)
    lean = float(rng.uniform(-0.5, 0.5) if rng.random() < 0.6 else 0.0)
    step = float(rng.uniform(0.12, 0.35) if rng.random() < 0.5 else rng.uniform(0.5, 0.95))
    roughness = float(rng.uniform(0.001, 0.005))
    climb = slope * width
    palette = draw_palette(rng, spec.wall)
    if spec.windows == "varied":
        palette = varied_palette(palette, seed)
    return HouseDraft(
        spec=spec,
        width=width,
        depth=depth,
        floors=floors,
        floor_height=spec.floor_height or height,
        ground_floor_height=spec.ground_floor_height or ground_height,
        step=step,
        ground=(max(-climb, 0.0), max(climb, 0.0)),
        roof=roof,
        rise=rise,
        lean=float(np.radians(lean if spec.lean is None else spec.lean)),
        roughness=roughness if spec.roughness is None else spec.roughness,
        correlation=float(rng.uniform(0.12, 0.5)),
        detached=detached,
        inner=max([0.52, *(o.depth + 0.12 for o in spec.opening)]),
        palette=palette,
        seed=seed,
    )


def _draw_roof(
    spec: HouseSpec, detached: bool, width: float, depth: float, rng: np.random.Generator
) -> tuple[str, float]:
    """Draws the form of the roof and its rise, m."""
    drawn = rng.choice(ROOFS, p=[0.45, 0.2, 0.15, 0.05, 0.15] if detached else [0.5, 0.18, 0, 0.17, 0.15])
    roof = spec.roof or str(drawn)
    span = width if roof == "street_gable" else depth
    pitched = span / 2 * float(np.tan(np.radians(rng.uniform(30, 48))))
    return roof, {"flat": 0.0, "mansard": 3.6}.get(roof, pitched)
