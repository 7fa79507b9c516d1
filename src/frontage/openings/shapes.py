"""Which head an opening has: flat, segmental, round or pointed, or whether it is a circle."""

from dataclasses import dataclass

import numpy as np

from frontage.geometry.arrays import Float

_GAIN = 10.0  # nats that a curve must gain over a straight head: "very strong" (Kass and Raftery 1995)
_SOLID = np.log(0.97 / 0.12)  # nats of a hit on the wall, see evidence.py
_OPEN = np.log(0.97 / 0.03)
_RISES = np.linspace(0.06, 0.46, 21)  # of segmental heads, as a share of the width
_STEP = 0.002  # m, raster of heights and radii
_ARC = 24  # pieces of a head: chord error 3 mm on a half circle of 2 m
_ROUND = (0.8, 1.25)  # height over width of what may be a circle


@dataclass(frozen=True)
class Head:
    """A shape, the height of its top m, its rise m (top less springing), and the nats it gains over flat."""

    shape: str
    top: float
    rise: float
    gain: float


def _below(shape: str, rise: float, half: float, u: Float) -> Float:
    """Height (n,) m below the top (negative) at u (n,) m from the middle of a head of that half width.

    Segmental and round heads are arcs of one circle, pointed ones of two whose centres are the springings.
    """
    if shape == "rectangle":
        return np.zeros(len(u))
    v = np.minimum(np.abs(u), half)
    if shape == "pointed":
        full = 2.0 * half
        return np.asarray(np.sqrt(np.maximum(full**2 - (half + v) ** 2, 0.0)) - np.sqrt(full**2 - half**2))
    radius = (half**2 + rise**2) / (2.0 * rise)
    return np.asarray(np.sqrt(np.maximum(radius**2 - v**2, 0.0)) - radius)


def find_head(
    solid: Float, opened: Float, box: tuple[float, float, float, float], density: float, reach: float
) -> Head:
    """The likeliest head of an opening.

    solid, opened  (n, 2), (m, 2) x, z m of beams around the opening
    box            x0, z0, x1, z1 m with a straight head; density of beams on the wall per m2; reach m, how
                   far from z1 tops are tried

    Poisson log-likelihood ratio of the region under a curve being open; every curve is a shift of the points,
    so that all tops of one curve are one sorted search.
    """
    x0, z0, x1, z1 = box
    half, middle = (x1 - x0) / 2, (x0 + x1) / 2
    low, high = max(z0 + 0.1 * (z1 - z0), z1 - reach), z1 + reach
    tops = np.arange(low + 0.3 * (z1 - low), high, _STEP)

    def within(p: Float) -> Float:
        keep = (np.abs(p[:, 0] - middle) < half) & (p[:, 1] > low) & (p[:, 1] < high)
        return np.asarray(p[keep] - (middle, 0.0))

    s, o = within(solid), within(opened)
    through = (o[:, 1] < z1 - 0.3 * (z1 - low)).sum() / max(2 * half * 0.7 * (z1 - low), 1e-6)
    per_area = 0.85 * density - 0.97 * through
    u = (np.arange(200) + 0.5) / 200 * 2 * half - half

    def best(shape: str, rise: float) -> tuple[float, float]:
        hits = np.sort(s[:, 1] - _below(shape, rise, half, s[:, 0]))
        passed = np.sort(o[:, 1] - _below(shape, rise, half, o[:, 0]))
        area = np.maximum(tops[:, None] + _below(shape, rise, half, u)[None, :] - low, 0).mean(1) * 2 * half
        score = per_area * area - _SOLID * np.searchsorted(hits, tops) + _OPEN * np.searchsorted(passed, tops)
        k = int(score.argmax())
        return float(score[k]), float(tops[k])

    flat, top = best("rectangle", 0.0)
    found = Head("rectangle", top, 0.0, 0.0)
    price = _GAIN
    trials = [("round", half), ("pointed", np.sqrt(3.0) * half)]
    trials += [("segmental", float(r) * 2 * half) for r in _RISES]
    for shape, rise in trials:
        if rise > 0.9 * (z1 + reach - z0):
            continue
        score, top = best(shape, rise)
        if score - flat > max(price, found.gain):
            found = Head(shape, top, rise, score - flat)
    return found


def find_circle(
    solid: Float, opened: Float, box: tuple[float, float, float, float], density: float
) -> tuple[float, float]:
    """Radius m of the likeliest circle about the middle of a box, and the nats it gains over the box."""
    x0, z0, x1, z1 = box
    wide, high = x1 - x0, z1 - z0
    if not _ROUND[0] < high / wide < _ROUND[1]:
        return 0.0, 0.0
    centre = np.array([(x0 + x1) / 2, (z0 + z1) / 2])
    s, o = solid - centre, opened - centre
    s = s[np.abs(s).max(1) < 0.75 * wide]
    o = o[np.abs(o).max(1) < 0.75 * wide]
    core = np.hypot(o[:, 0], o[:, 1]) < 0.4 * wide
    per_area = 0.85 * density - 0.97 * core.sum() / (np.pi * (0.4 * wide) ** 2)
    radii = np.arange(0.4 * wide, 0.7 * wide, _STEP)

    def score(hits: Float, passed: Float, size: Float, area: Float) -> Float:
        inside, through = np.searchsorted(np.sort(hits), size), np.searchsorted(np.sort(passed), size)
        return np.asarray(per_area * area - _SOLID * inside + _OPEN * through)

    scale = np.array([1.0, wide / high])
    round_ = score(np.hypot(s[:, 0], s[:, 1]), np.hypot(o[:, 0], o[:, 1]), radii, np.pi * radii**2)
    square = score(np.abs(s * scale).max(1), np.abs(o * scale).max(1), radii, 4.0 * radii**2 * high / wide)
    return float(radii[round_.argmax()]), float(round_.max() - square.max())


def ring_of(shape: str, box: tuple[float, float, float, float], rise: float) -> tuple[Float, Float]:
    """Ring (k, 2) m, counter-clockwise, and how its coordinates (2k,) follow the borders: (2k, 4) weights of
    left, right, bottom, top.
    """
    x0, z0, x1, z1 = box
    if shape == "circle":
        angle = np.arange(2 * _ARC) * np.pi / _ARC
        share = np.column_stack([0.5 + 0.5 * np.cos(angle), 0.5 + 0.5 * np.sin(angle)])
        base = (x0 + share[:, 0] * (x1 - x0), z0 + share[:, 1] * (z1 - z0))
    else:
        u = np.linspace(1.0, 0.0, 2 if shape == "rectangle" else _ARC + 1)
        half = (x1 - x0) / 2
        head = z1 + _below(shape, rise, half, (2.0 * u - 1.0) * half)
        share = np.column_stack([np.r_[0.0, 1.0, u], np.r_[0.0, 0.0, np.ones(len(u))]])
        base = (x0 + share[:, 0] * (x1 - x0), np.r_[z0, z0, head])
    weights = np.zeros((2 * len(share), 4))
    weights[0::2, 0], weights[0::2, 1] = 1.0 - share[:, 0], share[:, 0]
    weights[1::2, 2], weights[1::2, 3] = 1.0 - share[:, 1], share[:, 1]
    return np.column_stack(base), weights
