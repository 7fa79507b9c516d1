"""Builds a street from its specification."""

from dataclasses import dataclass

import numpy as np
import shapely

from frontage.geometry.rigid import Rigid3
from frontage.model import WorldRef
from frontage.simulate.houses.draft import HouseDraft, draft_house
from frontage.simulate.houses.house import build_house
from frontage.simulate.houses.housespec import HouseSpec
from frontage.simulate.meshing import MeshBuilder, Pen
from frontage.simulate.scene import House, Scene
from frontage.simulate.spec import SceneSpec
from frontage.simulate.street.ground import StreetProfile, draw_ground
from frontage.simulate.street.hedges import LEAST_SETBACK_M, PlotFront, draw_hedge, entrance_spans
from frontage.simulate.street.obstacles import draw_obstacles

_BEYOND_M = 60.0  # of street before the first and after the last house


@dataclass(frozen=True)
class Plot:
    """The plot of a house: side of the street, s at its start, setback from the building line (m), draft.

    twin    whether the house repeats the one before it
    """

    side: int
    start: float
    setback: float
    draft: HouseDraft
    twin: bool


def build_street(spec: SceneSpec) -> Scene:
    """Build the street that `spec` asks for; the same specification gives the same bytes.

    The scene's notes say what the specification asked for and a house had no room for.

    Raises OptionError when openings that the specification places leave their wall, overlap or do not fit.
    """
    rng = np.random.default_rng((spec.seed, 0))
    profile = _draw_profile(spec, rng)
    local_from_street = _draw_frame(rng)
    sides = 2 if spec.opposite else 1
    plots = [p for side in range(sides) for p in _plots(spec, side, profile)]
    builder = MeshBuilder()
    houses, notes = _build_houses(builder, local_from_street, profile, plots)
    ends = [(p.start, p.start + p.draft.width) for p in plots] or [(0.0, 20.0)]
    s0, s1 = min(a for a, _ in ends), max(b for _, b in ends)
    pen = Pen(builder, local_from_street)
    footprints = [_footprint(p, profile) for p in plots]
    span = (s0 - _BEYOND_M, s1 + _BEYOND_M)
    draw_ground(pen, profile, span, footprints, np.random.default_rng((spec.seed, 1)))
    _draw_hedges(pen, profile, spec, plots, houses)
    draw_obstacles(pen, profile, spec, (s0 - 5, s1 + 5), np.random.default_rng((spec.seed, 5)))
    return Scene(
        name=spec.name,
        seed=spec.seed,
        world=WorldRef(np.array(spec.origin), spec.crs),
        local_from_street=local_from_street,
        mesh=builder.mesh(),
        surfaces=tuple(builder.surfaces),
        materials=tuple(builder.materials),
        houses=tuple(houses),
        road=local_from_street.apply(profile.centre_line(s0, s1)),
        notes=tuple(notes),
    )


def _draw_profile(spec: SceneSpec, rng: np.random.Generator) -> StreetProfile:
    rise = float(rng.uniform(1, 8) * rng.choice([-1, 1]))
    width = float(rng.uniform(11, 18))
    pavement = float(rng.uniform(1.6, 3.0))
    width = width if spec.street_width is None else spec.street_width
    slope = (rise if spec.slope is None else spec.slope) / 100
    return StreetProfile(width, min(pavement, width / 4), slope)


def _draw_frame(rng: np.random.Generator) -> Rigid3:
    """Draws the direction of the street, and an origin that differs from that of the local frame."""
    c, s = np.cos(turn := float(rng.uniform(0, 2 * np.pi))), np.sin(turn)
    R = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    return Rigid3("local", "street", R, rng.uniform((10, 10, 5), (60, 60, 30)))


def _plots(spec: SceneSpec, side: int, profile: StreetProfile) -> list[Plot]:
    """Returns the plots of one side from s = 0 on; only houses of side 0 can be specified."""
    asked = list(spec.house) if side == 0 else []
    count = (len(spec.house) or 4) if spec.houses is None else max(spec.houses, len(asked))
    asked += [HouseSpec()] * (count - len(asked))
    free = np.random.default_rng((spec.seed, 2))
    setting = spec.setting or str(free.choice(["terrace", "terrace", "detached"]))
    line = float(np.random.default_rng((spec.seed, 7, side)).uniform(2.0, 5.5))
    plots: list[Plot] = []
    s = 0.0
    for k, house in enumerate(asked):
        rng = np.random.default_rng((spec.seed, 3, side, k))
        detached = setting == "detached"
        width, gap, setback = _draw_plot(house, line if detached else None, rng)
        twin = k > 0 and (house.twin or (house == HouseSpec() and bool(rng.random() < 0.12)))
        seed: tuple[int, ...] = (spec.seed, 4, side, k)
        if twin:
            before = plots[-1]
            seed, setback = before.draft.seed, before.setback
            width = before.draft.width
            house = before.draft.spec
        slope = profile.slope if side == 0 else -profile.slope
        draft = draft_house(house, seed, slope, detached, width)
        plots.append(Plot(side, s, setback, draft, twin))
        s += width + gap
    return plots


def _draw_plot(house: HouseSpec, line: float | None, rng: np.random.Generator) -> tuple[float, float, float]:
    """Draws the width of a house, the gap to the next one and the setback; m.

    `line` is the common setback of detached houses, from which each differs a little; None in a terrace.
    """
    detached = line is not None
    width = float(rng.uniform(7.5, 12.5) if detached else rng.uniform(5.0, 14.0))
    gap = float(rng.uniform(2.5, 6.0)) if detached else 0.0
    aside = float(rng.uniform(-0.6, 0.6) if detached else rng.choice([0.0, 0.0, rng.uniform(0, 0.4)]))
    setback = aside + (line or 0.0)
    return (
        width if house.width is None else house.width,
        gap if house.gap is None else house.gap,
        setback if house.setback is None else house.setback,
    )


def _build_houses(
    builder: MeshBuilder, local_from_street: Rigid3, profile: StreetProfile, plots: list[Plot]
) -> tuple[list[House], list[str]]:
    houses: list[House] = []
    notes: list[str] = []
    numbers = [1, 2]
    for k, plot in enumerate(plots):
        pen = Pen(builder, local_from_street @ _street_from_house(plot, profile), f"B{k + 1:02d}", house=k)
        address = f"{numbers[plot.side]} Long Street"
        numbers[plot.side] += 2
        twin_of = houses[-1].id if plot.twin else None
        house, unmet = build_house(
            pen, plot.draft, f"B{k + 1:02d}", address=address, side=plot.side, twin_of=twin_of
        )
        houses.append(house)
        notes += unmet
    return houses, notes


def _draw_hedges(
    pen: Pen, profile: StreetProfile, spec: SceneSpec, plots: list[Plot], houses: list[House]
) -> None:
    """Draws hedges along the building line, in front of half of the houses that are set back."""
    for k, (plot, house) in enumerate(zip(plots, houses, strict=True)):
        rng = np.random.default_rng((spec.seed, 6, k))
        drawn = bool(rng.random() < 0.5)
        if plot.setback < LEAST_SETBACK_M or not (drawn if spec.hedges is None else spec.hedges):
            continue
        s0, s1 = plot.start, plot.start + plot.draft.width
        near = plot.side == 0
        ways = tuple((s0 + a, s0 + b) if near else (s1 - b, s1 - a) for a, b in entrance_spans(house))
        d, towards = (0.0, 1.0) if near else (-profile.width, -1.0)
        front = PlotFront(s0, s1, profile.height(s0, d), profile.height(s1, d), ways)
        draw_hedge(pen.with_prefix(f"hedge{k + 1}"), front, d, towards, rng)


def _footprint(plot: Plot, profile: StreetProfile) -> shapely.Polygon:
    """Returns the house's footprint in the street's (s, d)."""
    near, far = plot.setback, plot.setback + plot.draft.depth
    d0, d1 = (near, far) if plot.side == 0 else (-profile.width - far, -profile.width - near)
    return shapely.box(plot.start, d0, plot.start + plot.draft.width, d1)


def _street_from_house(plot: Plot, profile: StreetProfile) -> Rigid3:
    """Returns the house's frame: the front's lower left corner as seen from the street, with its lean."""
    draft = plot.draft
    c, s = np.cos(draft.lean), np.sin(draft.lean)
    lean = np.array([[1.0, 0, 0], [0, c, s], [0, -s, c]])
    ends = [profile.slope * plot.start, profile.slope * (plot.start + draft.width)]
    if plot.side == 0:
        return Rigid3("street", "house", lean, np.array([plot.start, plot.setback, min(ends)]))
    turn = np.diag([-1.0, -1.0, 1.0])
    t = np.array([plot.start + draft.width, -profile.width - plot.setback, min(ends)])
    return Rigid3("street", "house", turn @ lean, t)
