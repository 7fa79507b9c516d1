"""Scenes of a few rectangles with chosen reflectances, for tests of the simulated lasers' physics."""

from dataclasses import dataclass, replace

import numpy as np

from frontage.geometry.arrays import Array, Float
from frontage.geometry.rigid import Rigid3
from frontage.model import WorldRef
from frontage.simulate.scene import Part, Scene, SceneMesh, SceneSurface, SurfaceMaterial
from frontage.simulate.sensors.instrument import Instrument, ScannerSpec, draw_instrument

QUIET = {"sigma_range": 0.0, "sigma_angle": 0.0, "strays": 0.0, "colour": False}
PENCIL = {**QUIET, "divergence": 0.0, "exit_beam": 0.0, "subrays": 1}


@dataclass(frozen=True)
class Sheet:
    """A rectangle: its lower left corner and two edges, m. Its front is the side that a x b points to."""

    corner: tuple[float, float, float]
    a: tuple[float, float, float]
    b: tuple[float, float, float]
    part: Part = Part.WALL
    laser: float = 0.5
    gloss: float = 0.0
    roughness: float = 0.0


def wall(
    y: float, x: tuple[float, float] = (-30, 30), z: tuple[float, float] = (-5, 20), **more: object
) -> Sheet:
    """Returns an upright rectangle at `y` m that faces -y."""
    return Sheet((x[0], y, z[0]), (x[1] - x[0], 0, 0), (0, 0, z[1] - z[0]), **more)  # type: ignore[arg-type]


def ground(z: float = 0.0, size: float = 60.0) -> Sheet:
    """Returns level ground, `size` m to each side of the origin."""
    return Sheet((-size, -size, z), (2 * size, 0, 0), (0, 2 * size, 0), Part.GROUND, 0.3)


def scene_of(*sheets: Sheet, seed: int = 0, kind: str = "paint") -> Scene:
    """Returns a scene whose surface k is sheet k. The street frame is the local frame; the road is the x axis
    from 0 to 20 m."""
    vertices, corners, surfaces = [], [], []
    for k, s in enumerate(sheets):
        o, a, b = (np.array(v, float) for v in (s.corner, s.a, s.b))
        vertices += [o, o + a, o + a + b, o + b]
        corners += [[4 * k, 4 * k + 1, 4 * k + 2], [4 * k, 4 * k + 2, 4 * k + 3]]
        u, v = (tuple(w / np.linalg.norm(w)) for w in (a, b))
        surfaces.append(SceneSurface(f"S{k}", s.part, k, 0, origin=s.corner, u=u, v=v, roughness=s.roughness))
    materials = [
        SurfaceMaterial(f"M{k}", kind, (0.5, 0.5, 0.5), (0.5, 0.5, 0.5), s.laser, s.gloss)
        for k, s in enumerate(sheets)
    ]
    return Scene(
        "sheets",
        seed,
        WorldRef(np.array([500_000, 5_000_000, 100]), "EPSG:25832"),
        Rigid3.identity("local", "street"),
        SceneMesh(np.array(vertices), np.array(corners), np.repeat(np.arange(len(sheets)), 2)),
        tuple(surfaces),
        tuple(materials),
        (),
        np.array([[0.0, 0.0, 0.0], [20.0, 0.0, 0.0]]),
    )


def instrument(seed: int = 0, **values: object) -> Instrument:
    """Returns a scanner without noise that has the given properties."""
    drawn = draw_instrument(ScannerSpec(**QUIET), np.random.default_rng(seed))
    return replace(drawn, **{"speckle": 0.0, "levels": 1 << 24, "ranging": "pulsed", **values})  # type: ignore[arg-type]


def towards(points: Float, origin: Array) -> Float:
    """Returns unit directions (n, 3) from `origin` to points (n, 3)."""
    d = points - origin
    return np.asarray(d / np.linalg.norm(d, axis=1, keepdims=True))
