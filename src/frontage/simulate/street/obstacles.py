"""Places the obstacles between sensors and houses: trees, cars, lamps, pedestrians."""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from frontage.geometry.arrays import Float
from frontage.geometry.rigid import Rigid3
from frontage.simulate.meshing import Pen
from frontage.simulate.spec import SceneSpec
from frontage.simulate.street.ground import StreetProfile
from frontage.simulate.street.objects import draw_car, draw_lamp, draw_person
from frontage.simulate.street.trees import draw_tree

Draw = Callable[[Pen, str, np.random.Generator], None]


@dataclass(frozen=True)
class _Lanes:
    """Two lines along the street on which objects of one kind stand.

    span    m, from s to s
    d       m, of the lane near side 0 and of the opposite one
    apart   m, least distance between two objects of a lane
    turn    rad, from s to the x axis of an object of the first lane; on the second it points the other way
    slope   rise of the ground along s that the objects follow, m per m; 0 = they stand upright
    taken   (s, d) of what stands on the lanes already
    """

    span: tuple[float, float]
    d: tuple[float, float]
    apart: float
    turn: float = 0.0
    slope: float = 0.0
    taken: list[tuple[float, float]] = field(default_factory=list)


def draw_obstacles(
    pen: Pen,
    profile: StreetProfile,
    spec: SceneSpec,
    span: tuple[float, float],
    rng: np.random.Generator,
) -> None:
    """Draw obstacles over a `span` of s (m) with a pen in the street's frame.

    Numbers that the specification does not state are drawn.
    """
    length, p, w = span[1] - span[0], profile.pavement, profile.width
    wooded = bool(rng.random() < 0.55)
    trees = _count(spec.trees, int(length / rng.uniform(9, 20)) if wooded else 0)
    lamps = _count(spec.lamps, int(length / rng.uniform(18, 30)) + 1)
    cars = _count(spec.cars, int(rng.poisson(length / 11)))
    people = _count(spec.people, int(rng.poisson(length / 14)))
    edge = p - 0.4  # m, trees and lamps stand along the kerb
    radius = min(float(rng.uniform(1.1, 2.3)), edge - 0.15)

    def tree(own: Pen, name: str, generator: np.random.Generator) -> None:
        draw_tree(own, name, radius, generator)

    taken: list[tuple[float, float]] = []
    along_kerb = _Lanes(span, (-edge, edge - w), 1.0, turn=np.pi / 2, taken=taken)
    _scatter(pen, profile, along_kerb, ("lamp", draw_lamp, lamps), rng)
    _scatter(pen, profile, _Lanes(span, (-edge, edge - w), 2.5, taken=taken), ("tree", tree, trees), rng)
    lane = p + 1.05
    if w > 2 * lane + 3.0:
        parked = _Lanes(span, (-lane, lane - w), 5.2, slope=profile.slope)
        _scatter(pen, profile, parked, ("car", draw_car, cars), rng)
    walk = max(p * 0.5, 0.5)
    _scatter(pen, profile, _Lanes(span, (-walk, walk - w), 1.0), ("person", draw_person, people), rng)


def _count(asked: int | None, drawn: int) -> int:
    return drawn if asked is None else asked


def _scatter(
    pen: Pen, profile: StreetProfile, lanes: _Lanes, what: tuple[str, Draw, int], rng: np.random.Generator
) -> None:
    """Draws objects at random places of two lanes, fewer than asked for where there is no room.

    `what` is their name, the function that draws one, and their number.
    """
    name, draw, count = what
    placed = 0
    for _ in range(count * 8):
        if placed == count:
            break
        s, far = float(rng.uniform(*lanes.span)), int(rng.random() < 0.5)
        if any(abs(s - a) < lanes.apart and lanes.d[far] == b for a, b in lanes.taken):
            continue
        lanes.taken.append((s, lanes.d[far]))
        placed += 1
        d = lanes.d[far] + float(rng.uniform(-0.12, 0.12))
        angle = (np.pi - lanes.turn if far else -lanes.turn) + float(rng.normal(0, 0.04))
        foot = np.array([s, d, profile.height(s, d)])
        frame = Rigid3("street", "thing", _rotation(angle, lanes.slope), foot)
        draw(pen.in_frame(pen.local_from_frame @ frame), f"{name}{placed}", rng)


def _rotation(angle: float, slope: float) -> Float:
    """Returns the rotation (3, 3) by `angle` rad about the vertical, then onto ground that rises along s."""
    c, s = np.cos(angle), np.sin(angle)
    run, rise = np.array([1.0, slope]) / np.hypot(1.0, slope)
    lift = np.array([[run, 0.0, -rise], [0.0, 1.0, 0.0], [rise, 0.0, run]])
    return np.asarray(lift @ np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]))
