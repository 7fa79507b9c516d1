"""What stands between the sensors and the houses, and where: trees, cars, lamps, pedestrians."""

from collections.abc import Callable

import numpy as np

from frontage.geometry.arrays import Float
from frontage.geometry.rigid import Rigid3
from frontage.simulate.meshing import Pen
from frontage.simulate.spec import SceneSpec
from frontage.simulate.street.ground import StreetProfile
from frontage.simulate.street.objects import draw_car, draw_lamp, draw_person
from frontage.simulate.street.trees import draw_tree

Draw = Callable[[Pen, str, np.random.Generator], None]


def draw_obstacles(
    pen: Pen, profile: StreetProfile, spec: SceneSpec, s0: float, s1: float, rng: np.random.Generator
) -> None:
    """Draw obstacles between s0 and s1 m with a pen in the street's frame; those not counted are drawn."""
    length, p, w = s1 - s0, profile.pavement, profile.width
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
    _place(pen, profile, "lamp", draw_lamp, lamps, (s0, s1, 1.0), (-edge, edge - w), np.pi / 2, taken, rng)
    _place(pen, profile, "tree", tree, trees, (s0, s1, 2.5), (-edge, edge - w), 0.0, taken, rng)
    lane = p + 1.05
    if w > 2 * lane + 3.0:
        _place(pen, profile, "car", draw_car, cars, (s0, s1, 5.2), (-lane, lane - w), 0.0, [], rng)
    walk = max(p * 0.5, 0.5)
    _place(pen, profile, "person", draw_person, people, (s0, s1, 1.0), (-walk, walk - w), 0.0, [], rng)


def _count(asked: int | None, drawn: int) -> int:
    return drawn if asked is None else asked


def _place(
    pen: Pen, profile: StreetProfile, name: str, draw: Draw, count: int, span: tuple[float, float, float],
    lanes: tuple[float, float], turn: float, taken: list[tuple[float, float]], rng: np.random.Generator,
) -> None:  # fmt: skip
    """Draw `count` things along two lanes (d, m), at least span[2] m apart; fewer where there is no room.

    On the first lane their x points `turn` rad from s, on the second the other way.
    """
    s0, s1, apart = span
    placed = 0
    for _ in range(count * 8):
        if placed == count:
            break
        s, far = float(rng.uniform(s0, s1)), int(rng.random() < 0.5)
        if any(abs(s - a) < apart and lanes[far] == b for a, b in taken):
            continue
        taken.append((s, lanes[far]))
        placed += 1
        d = lanes[far] + float(rng.uniform(-0.12, 0.12))
        angle = (np.pi - turn if far else -turn) + float(rng.normal(0, 0.04))
        frame = Rigid3("street", "thing", _turned(angle, profile.slope if name == "car" else 0.0),
                       np.array([s, d, profile.height(s, d)]))  # fmt: skip
        draw(pen.in_frame(pen.local_from_frame @ frame), f"{name}{placed}", rng)


def _turned(angle: float, slope: float) -> Float:
    """Rotation (3, 3) by `angle` rad about the upright, then onto ground that rises by `slope` along s."""
    c, s = np.cos(angle), np.sin(angle)
    run, rise = np.array([1.0, slope]) / np.hypot(1.0, slope)
    lift = np.array([[run, 0.0, -rise], [0.0, 1.0, 0.0], [rise, 0.0, run]])
    return np.asarray(lift @ np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]))
