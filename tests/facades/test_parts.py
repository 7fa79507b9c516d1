"""The parts of a wall on both sides of an avant-corps are facades, and none is lost."""

import numpy as np

from frontage.facades import find_facades
from frontage.model import Building, Facade, Scan, WorldRef

WORLD = WorldRef(np.array([0, 0, 0]))
EYES = np.array([[2.0, -12.0, 1.7], [14.0, -12.0, 1.7]])
SPACING, HIGH = 0.04, 9.0


def surface(rng, x, y, z):
    """Points on a level or upright rectangle; each of x, y, z is a place or a range, m."""
    ranges = [np.arange(*v, SPACING) if isinstance(v, tuple) else np.array([v]) for v in (x, y, z)]
    points = np.stack(np.meshgrid(*ranges), axis=-1).reshape(-1, 3)
    return points + rng.normal(0.0, 0.004, points.shape)


def test_both_walls_beside_an_avant_corps_on_the_ground_are_facades():
    rng = np.random.default_rng(0)
    walls = [surface(rng, (a, b), y, (0.0, HIGH)) for a, b, y in ((0, 5, 0.0), (5, 11, -0.8), (11, 16, 0.0))]
    walls += [surface(rng, x, (-0.8, 0.0), (0.0, HIGH)) for x in (5.0, 11.0)]
    # a drain in the plane of the wall runs on below the avant-corps
    xyz = np.vstack(
        [*walls, surface(rng, (5.0, 11.0), 0.0, (0.0, 0.2)), surface(rng, (-3, 19), (-6, 0), 0.0)]
    )
    scan = Scan("front", xyz, WORLD, EYES, np.repeat([0, 1], [len(xyz) // 2, len(xyz) - len(xyz) // 2]))
    facades = find_facades(scan, Building("B01", np.arange(len(xyz)), 0.0))
    spans = []
    for f in facades:
        assert isinstance(f, Facade)
        if abs(f.frame.R[1, 1]) > 0.99:
            q = f.frame.apply(np.insert(f.outline, 1, 0.0, axis=1))
            spans.append((q[:, 0].min(), q[:, 0].max(), q[:, 1].mean()))
            own = f.frame.inverse.apply(scan.xyz[f.inliers])
            assert np.abs(own[:, [0, 2]].mean(0)).max() < 1e-6  # the origin is the barycentre
    expected = [(0, 5, 0.0), (5, 11, -0.8), (11, 16, 0.0)]
    assert np.allclose(sorted(spans), expected, atol=0.15)
