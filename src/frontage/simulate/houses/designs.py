"""The designs that windows of real streets have, as often as they occur there.

Shares follow the panes per window of 9,002 labelled photographs of windows (WinSyn): 8 % have one pane, 15 %
two, 11 % three, 15 % four, 5 % five, 10 % six, 22 % seven to twelve, and 14 % more.
"""

from collections.abc import Callable

import numpy as np

from frontage.geometry.arrays import Float
from frontage.simulate.houses.glazing import Design, Field, divide, least_pane

_LEAST_PANE_M = 0.13
_LEAST_HEAD = 0.3  # rise of an arched head with spokes, as a share of its width
_TRIES = 40
_GLASS = Field()


def draw_design(ring: Float, frame: float, rng: np.random.Generator) -> Design:
    """Draw a design for an opening with outline `ring` (k, 2) m and a frame `frame` m wide.

    Designs whose panes would be too small for the opening are drawn again; a single pane always fits.
    """
    width, height = (np.ptp(ring, axis=0) - 2 * frame).tolist()
    arched = len(ring) > 5 and ring[:, 1].max() - ring[2, 1] > _LEAST_HEAD * np.ptp(ring[:, 0])
    for _ in range(_TRIES):
        maker = _MAKERS[int(rng.choice(len(_MAKERS), p=_SHARES))]
        design = maker(rng, width, height)
        if design.spokes and not (arched and ring[2, 1] - ring[:, 1].min() > 0.5 * height):
            continue
        if least_pane(design.field, width, height) >= _LEAST_PANE_M and _drawable(ring, frame, design):
            return design
    return Design(_GLASS)


def _drawable(ring: Float, frame: float, design: Design) -> bool:
    """Whether every bar lies within the frame and is longer than it is wide."""
    try:
        division = divide(ring, frame, design)
    except ValueError:  # a bar that misses the opening has no ends
        return False
    return all(b.extent[1] - b.extent[0] > 0.1 for b in division.bars)


def even(count: int) -> tuple[float, ...]:
    """Return the shares at which `count` bars divide a field evenly."""
    return tuple((np.arange(1, count + 1) / (count + 1)).tolist())


def _narrow(rng: np.random.Generator) -> float:
    return float(rng.uniform(0.018, 0.03))


def _wide(rng: np.random.Generator) -> float:
    return float(rng.uniform(0.06, 0.14))


def _transom(rng: np.random.Generator) -> float:
    """Draws how high a transom is, as a share of the height."""
    return float(rng.uniform(0.6, 0.78))


def _single(rng: np.random.Generator, width: float, height: float) -> Design:
    return Design(_GLASS)


def _pair(rng: np.random.Generator, width: float, height: float) -> Design:
    """Two casements, sometimes of different width."""
    at = 0.5 if rng.random() < 0.75 else float(rng.choice([1 / 3, 0.38, 0.62, 2 / 3]))
    return Design(Field((at,), width=_wide(rng)))


def _fanlight(rng: np.random.Generator, width: float, height: float) -> Design:
    """One casement and a fanlight, above it or, rarely, below."""
    at = _transom(rng) if rng.random() < 0.8 else float(rng.uniform(0.25, 0.4))
    return Design(Field(horizontal=(at,), width=_wide(rng)))


def _t_window(rng: np.random.Generator, width: float, height: float) -> Design:
    pair = Field((0.5,), width=_wide(rng))
    return Design(Field(horizontal=(_transom(rng),), width=_wide(rng), parts=(pair, _GLASS)))


def _three_lights(rng: np.random.Generator, width: float, height: float) -> Design:
    """Three casements, the middle one often wider."""
    side = 1 / 3 if rng.random() < 0.4 else float(rng.uniform(0.22, 0.3))
    return Design(Field((side, 1 - side), width=_wide(rng)))


def _asymmetric(rng: np.random.Generator, width: float, height: float) -> Design:
    """A tall casement beside a fanlight over a fixed pane."""
    split = Field(horizontal=(_transom(rng),), width=float(rng.uniform(0.05, 0.09)))
    at = float(rng.uniform(0.34, 0.46))
    flip = bool(rng.random() < 0.5)
    parts = (_GLASS, split) if flip else (split, _GLASS)
    return Design(Field((1 - at if flip else at,), width=_wide(rng), parts=parts))


def _cross(rng: np.random.Generator, width: float, height: float) -> Design:
    wide = _wide(rng)
    return Design(Field((0.5,), (_transom(rng),), wide))


def _lights_over(rng: np.random.Generator, width: float, height: float) -> Design:
    """Casements below a transom, and above it a fanlight with glazing bars of its own."""
    below = Field(even(int(rng.choice([1, 1, 2]))), width=_wide(rng))
    above = Field(even(int(rng.integers(1, 4))), width=_narrow(rng))
    return Design(Field(horizontal=(_transom(rng),), width=_wide(rng), parts=(below, above)))


def _bars_below(rng: np.random.Generator, width: float, height: float) -> Design:
    """A cross window whose casements have glazing bars, and whose fanlights have none (or the reverse)."""
    bars = Field(horizontal=even(int(rng.integers(1, 3))), width=_narrow(rng))
    wide = _wide(rng)
    plain = Field((0.5,), width=wide)
    barred = Field((0.5,), width=wide, parts=(bars, bars))
    if rng.random() < 0.2:
        above = Field(even(1), width=_narrow(rng))
        return Design(
            Field(
                horizontal=(_transom(rng),),
                width=wide,
                parts=(plain, Field((0.5,), width=wide, parts=(above, above))),
            )
        )
    return Design(Field(horizontal=(_transom(rng),), width=wide, parts=(barred, plain)))


def _barred_pair(rng: np.random.Generator, width: float, height: float) -> Design:
    """Two casements, each divided by the same glazing bars."""
    columns = int(rng.random() < 0.25)
    bars = Field(even(columns), even(int(rng.integers(1, 4))), _narrow(rng))
    return Design(Field((0.5,), width=_wide(rng), parts=(bars, bars)))


def _three_cross(rng: np.random.Generator, width: float, height: float) -> Design:
    return Design(Field(even(2), (_transom(rng),), _wide(rng)))


def _grid(rng: np.random.Generator, width: float, height: float) -> Design:
    """Narrow glazing bars only: old fixed windows, workshops, stairs."""
    return Design(Field(even(int(rng.integers(1, 5))), even(int(rng.integers(1, 5))), _narrow(rng)))


def _uneven(rng: np.random.Generator, width: float, height: float) -> Design:
    """Glazing bars along the border of a large pane, or lights of unequal width."""
    if rng.random() < 0.5:
        rim = float(rng.uniform(0.16, 0.24))
        return Design(Field((rim, 1 - rim), (rim * width / height, 1 - rim * width / height), _narrow(rng)))
    at = np.sort(rng.uniform(0.15, 0.85, 2))
    return Design(Field((float(at[0]), float(at[1])), (_transom(rng),), float(rng.uniform(0.03, 0.08))))


def _sash(upper: tuple[int, int], lower: tuple[int, int]) -> Callable[..., Design]:
    """Returns what draws sashes with so many upright bars and transoms above and below the meeting rail."""

    def make(rng: np.random.Generator, width: float, height: float) -> Design:
        width = _narrow(rng)
        parts = tuple(Field(even(v), even(h), width) for v, h in (lower, upper))
        at = 0.5 if rng.random() < 0.8 else float(rng.choice([0.42, 0.6]))
        return Design(
            Field(horizontal=(at,), width=float(rng.uniform(0.034, 0.048)), parts=parts), sashes=True
        )

    return make


def _leaded(rng: np.random.Generator, width: float, height: float) -> Design:
    small = float(rng.uniform(0.09, 0.15))
    post = Field((0.5,), width=_wide(rng)) if width > 0.8 else _GLASS
    return Design(
        post, leads=(small, small * float(rng.uniform(1.2, 1.6))), diamonds=bool(rng.random() < 0.6)
    )


def _radial(rng: np.random.Generator, width: float, height: float) -> Design:
    below = Field((0.5,), width=_wide(rng)) if rng.random() < 0.7 else _GLASS
    return Design(below, spokes=int(rng.integers(1, 6)))


# what draws a design, and how often it occurs, in percent
_CATALOGUE: tuple[tuple[Callable[..., Design], float], ...] = (
    (_single, 8), (_pair, 7), (_sash((0, 0), (0, 0)), 6), (_fanlight, 3), (_t_window, 7), (_three_lights, 3),
    (_asymmetric, 3), (_cross, 7), (_sash((1, 0), (1, 0)), 5), (_lights_over, 6), (_barred_pair, 8),
    (_three_cross, 3), (_bars_below, 6), (_sash((2, 1), (0, 0)), 3), (_sash((2, 1), (2, 1)), 6),
    (_sash((1, 1), (1, 1)), 3), (_grid, 6), (_uneven, 3), (_sash((3, 1), (3, 1)), 2), (_leaded, 3),
    (_radial, 2),
)  # fmt: skip
_MAKERS = tuple(maker for maker, _ in _CATALOGUE)
_SHARES = np.array([share for _, share in _CATALOGUE]) / 100
