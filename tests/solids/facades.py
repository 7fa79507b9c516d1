"""Random facades for tests of the solid builder; everything that may touch does so in some of them."""

import numpy as np

from frontage.geometry.plane import facade_axes
from frontage.geometry.rigid import Rigid3
from frontage.geometry.ring import rectangle
from frontage.model import Solid, WorldRef
from frontage.solids.coarse.extrude import facade_block
from frontage.solids.coarse.host import Host
from frontage.solids.curves import arch_ring, circle_ring
from frontage.solids.relief import FacadeReliefs, Relief

WORLD = WorldRef(np.array([678_000, 5_403_000, 300]))
KINDS = (
    "plain",
    "plain",
    "touching",
    "corner",
    "border",
    "arch",
    "oriel",
    "ground",
    "overlap",
    "close",
    "odd",
)


def frame(azimuth: float, lean: float = 0.0, at: tuple[float, float, float] = (12.0, -7.0, 3.0)) -> Rigid3:
    """Returns a facade frame whose inward normal has an azimuth (rad) and leans by an angle (rad)."""
    flat = np.cos(lean)
    inward = np.array([np.cos(azimuth) * flat, np.sin(azimuth) * flat, np.sin(lean)])
    return Rigid3("local", "facade", facade_axes(inward), np.array(at))


def block(local_from_facade: Rigid3, outline: np.ndarray, depth: float = 9.0) -> Solid:
    """Returns a block behind a facade."""
    made = facade_block("B", local_from_facade, outline, depth, WORLD)
    assert isinstance(made, Host)
    return made.solid


def random_facade(rng: np.random.Generator, azimuth: float | None = None) -> tuple[Solid, FacadeReliefs]:
    """Returns a block with a straight or gabled outline, and reliefs of every kind on a loose raster."""
    wide, high = np.round(rng.uniform(6, 25), 3), np.round(rng.uniform(5, 18), 3)
    turn = rng.uniform(0, 2 * np.pi) if azimuth is None else azimuth
    place = frame(turn, at=(round(rng.uniform(-50, 50), 4), round(rng.uniform(-50, 50), 4), 2.0))
    outline = rectangle(0, 0, float(wide), float(high))
    if rng.random() < 0.3:
        outline = np.insert(outline, 3, [wide * rng.uniform(0.3, 0.7), high + 3], axis=0)
        outline = np.array(
            sorted(outline.tolist(), key=lambda p: np.arctan2(p[1] - high / 2, p[0] - wide / 2))
        )
    reliefs: list[Relief] = []
    for i, x in enumerate(np.arange(0.3, wide - 1.8, 2.2)):
        for j, z in enumerate(np.arange(0.4, high - 2.3, 2.6)):
            if rng.random() < 0.8:
                spot = (float(np.round(x, 3)), float(np.round(z, 3)))
                reliefs += _some(rng, f"{i}-{j}", spot, float(wide))
    return block(place, outline), FacadeReliefs("F", place, outline, tuple(reliefs))


def _deep(rng: np.random.Generator) -> float | None:
    return None if rng.random() < 0.15 else float(np.round(rng.uniform(0.02, 0.5), 4))


def _some(rng: np.random.Generator, name: str, at: tuple[float, float], wide: float) -> list[Relief]:
    """Returns one or two reliefs near a spot."""
    x, z = at
    w, h = np.round(rng.uniform(0.5, 1.6), 4), np.round(rng.uniform(0.5, 1.9), 4)
    one = Relief(name, rectangle(x, z, x + w, z + h), _deep(rng))

    def other(x0: float, z0: float, x1: float, z1: float) -> list[Relief]:
        return [one, Relief(name + "b", rectangle(x0, z0, x1, z1), _deep(rng), "Door")]

    match KINDS[int(rng.integers(len(KINDS)))]:
        case "touching":
            return other(x + w, z + rng.uniform(-0.3, 0.3), x + w + 0.4, z + h)
        case "corner":
            return other(x + w, z + h, x + w + 0.4, z + h + 0.4)
        case "close":
            return other(x + w + rng.uniform(-0.015, 0.019), z + 0.1, x + w + 0.5, z + h + 0.2)
        case "overlap":
            return other(x + w * 0.8, z + h * 0.6, x + w * 0.8 + 0.8, z + h * 0.6 + 0.9)
        case "border":
            return [Relief(name, rectangle(x - 0.35, z, x + w, z + h), _deep(rng))]
        case "ground":
            return [Relief(name, rectangle(x, rng.uniform(-0.1, 0.03), x + w, z + h), _deep(rng), "Door")]
        case "arch":
            rise = w * rng.choice([0.2, 0.5, 0.8])
            ring = arch_ring(x, x + w, z, spring=z + h * 0.5, rise=rise, chord_error=0.003)
            return [Relief(name, ring, _deep(rng))]
        case "odd":
            turn = np.sort(rng.uniform(0, 2 * np.pi, 6))
            ring = np.column_stack([x + w / 2 + np.cos(turn) * w / 2, z + h / 2 + np.sin(turn) * h / 2])
            return [Relief(name, ring, _deep(rng))]
        case "oriel":
            pane = Relief(name + "p", circle_ring(x + w / 2, z + h / 2, 0.2, 0.004), _deep(rng))
            base = z if rng.random() < 0.7 else -0.01
            out = -float(np.round(rng.uniform(0.1, 1.2), 4))
            niche = Relief(
                name + "n",
                rectangle(x + 0.05, z + 0.05, x + w - 0.05, z + h - 0.02),
                0.1,
                "WallSurface",
                (pane,),
            )
            return [Relief(name, rectangle(x, base, x + w, z + h), out, "WallSurface", (niche,))]
    return [one]
