"""Openings closed level with the wall: shutters and panes that looks or a slight relief tell from it.

They are looked for where the wall was seen, in the rows and columns of the other openings, in the forms of
these. There the means of a channel (relief, intensity, colours of scan and photos) must step by the same
amount on all sides, sharply, where the borders are expected, and be alike within. How large such steps are on
this wall by itself, the wall tells.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from scipy import stats

from frontage.geometry.arrays import Float
from frontage.model.facade import Facade
from frontage.model.ortho import OrthoImage
from frontage.model.scan import Scan
from frontage.openings.beams import Beams
from frontage.openings.borders import Place
from frontage.openings.evidence import Evidence
from frontage.openings.flushborders import Told, outlined
from frontage.openings.flushplaces import Places, crossings, lines
from frontage.openings.inferred import state_of
from frontage.openings.outline import Outline
from frontage.openings.reflectance import Channel, Surface, photo_channels, scan_channels, surface_of
from frontage.openings.steps import Picture, wall_steps

_SURE = 0.99  # posterior that an opening needs
_PRIOR = 0.05  # share of the crossings seen as wall that hold a closed opening
_EXPECTED = 0.5  # nats (factor 1.6), one sigma of the step from wall to shutter
_UNEVEN = 0.3  # of the step, one sigma between the four sides
_LARGEST = 2.5  # nats, largest step that is tried
_TAILS = 4.0  # degrees of freedom of the wall's own steps: courses, repairs and stains have heavy tails
_TELLS = 5.0  # nats at which a channel tells of borders, too
_BESIDE = 0.06  # m: clear places nearer to one another are one opening's
_REACH = (0.05, 0.08)  # m before the wall and behind it: what lies deeper is found as any opening is


@dataclass(frozen=True, eq=False)
class Flush:
    """An opening that is closed level with the wall, its posterior probability, and its evidence, nats."""

    outline: Outline
    confidence: float
    evidence: float


def find_flush(
    facade: Facade,
    scan: Scan,
    beams: Beams,
    evidence: Evidence,
    outlines: Sequence[Outline],
    ortho: OrthoImage | None = None,
) -> list[Flush]:
    """Closed openings where the wall was seen, like `outlines` and in a row or a column with them.

    Posterior: likelihood of the four steps against that of the wall's own steps, with a price for every place
    and every channel that was tried. What was found makes further rows and columns.
    """
    if not outlines:
        return []
    surface = surface_of(facade, scan, beams, _REACH)
    channels = scan_channels(surface, facade, scan)
    if ortho is not None:
        channels += photo_channels(ortho, facade)
    search = _Search(surface, channels, evidence)
    found: list[Flush] = []
    while True:
        known = [*outlines, *(f.outline for f in found)]
        more = search.at_crossings(known) or search.along_lines(known)
        if not more:
            return found
        found += more


@dataclass(frozen=True, eq=False)
class _Peak:
    """A place whose steps speak for an opening by `gain` nats; `walls`: the bare wall's, by channel."""

    gain: float
    places: Places
    k: int
    walls: Sequence[Float]

    def beside(self, other: "_Peak") -> bool:
        """Whether both may be one opening, seen from two cells."""
        (x, z), (u, v) = (p.places.box(p.k)[:2] for p in (self, other))
        return self.places is other.places and max(abs(x - u), abs(z - v)) < _BESIDE


class _Search:
    """The test at many places of one facade."""

    def __init__(self, surface: Surface, channels: Sequence[Channel], evidence: Evidence) -> None:
        self._surface, self._channels, self._evidence = surface, channels, evidence
        self._cell = max(c.picture.raster.cell for c in channels)

    def at_crossings(self, known: Sequence[Outline]) -> list[Flush]:
        """Of rows and columns; sills hide the wall below: three sides suffice."""
        places = crossings(known, self._evidence)
        return self._tried(places, known, [p.box(0) for p in places], 3)

    def along_lines(self, known: Sequence[Outline]) -> list[Flush]:
        """Anywhere along a row or a column."""
        return self._tried(list(lines(known, self._evidence, self._cell)), known, [], 4)

    def _tried(
        self, places: Sequence[Places], known: Sequence[Outline], taken: Sequence[Place], sides: int
    ) -> list[Flush]:
        """The openings among all places, the clearest first; `sides` of the four must be known."""
        tries = max(sum(len(p.x) for p in places) * len(self._channels), 1)
        price = float(np.log(tries * (1.0 - _PRIOR) / _PRIOR))
        least = price + float(np.log(_SURE / (1.0 - _SURE)))
        bare = [c.picture.without([*(o.place for o in known), *taken]) for c in self._channels if places]
        peaks = sorted((q for p in places for q in self._peaks(p, bare, least, sides)), key=lambda q: -q.gain)
        found: list[Flush] = []
        for n, peak in enumerate(peaks):
            others = [*known, *(f.outline for f in found)]
            if any(peak.beside(q) for q in peaks[:n]) or not self._is_wall(peak.places.box(peak.k), others):
                continue
            outline = self._outlined(peak, known[peak.places.like])
            if outline is not None and self._is_wall(outline.place, others):
                found.append(Flush(outline, float(1.0 / (1.0 + np.exp(price - peak.gain))), peak.gain))
        return found

    def _is_wall(self, place: Place, others: Sequence[Outline]) -> bool:
        return state_of(place, others, self._evidence) == "wall"

    def _peaks(self, places: Places, bare: Sequence[Picture], least: float, sides: int) -> Iterator[_Peak]:
        """Those of the places that gain so much, by relief, by looks or by both."""
        walls = [wall_steps(own, places.form) for own in bare]
        steps = [c.picture.steps(places.x, places.z, places.form) for c in self._channels]
        gains = [_gain(own, w, _TELLS, sides) for own, w in zip(steps, walls, strict=True)]
        relief, looks = gains[0], np.max([*gains[1:], np.full(len(gains[0]), -np.inf)], axis=0)
        # what gives a wall its relief gives it no colour: the nats of both add up
        gain = np.maximum(relief, looks) + np.maximum(np.minimum(relief, looks), 0.0)
        for k in np.flatnonzero(gain >= least):
            yield _Peak(float(gain[k]), places, int(k), walls)

    def _outlined(self, peak: _Peak, like: Outline) -> Outline | None:
        """The outline at a peak, by the clearest of the channels that make one."""
        gained: list[tuple[float, Told]] = []
        x, z = peak.places.x[[peak.k]], peak.places.z[[peak.k]]
        for channel, wall in zip(self._channels, peak.walls, strict=True):
            own = channel.picture.steps(x, z, peak.places.form)
            gained.append((float(_gain(own, wall, _TELLS, 3)[0]), Told(channel, own[0], wall)))
        told = [t for gain, t in sorted(gained, key=lambda g: -g[0]) if gain >= _TELLS]
        made = (outlined(peak.places, peak.k, like, first, told, self._surface) for first in told)
        return next((o for o in made if o is not None), None)


def _gain(own: Float, wall: Float, least: float, sides: int) -> Float:
    """Nats (n,) for one common step on the four sides `own` (n, 4) against steps of the wall, one sigma
    `wall` (4,); -inf where fewer than so many `sides` are known, or it would be less than `least`.
    """
    known = np.isfinite(own) & (wall > 0.0)
    sigma = np.where(wall > 0.0, wall, 1.0)
    own = np.where(known, own, 0.0)
    closed = np.where(known, stats.t.logpdf(own, _TAILS, 0.0, sigma), 0.0).sum(1)
    most = -np.where(known, np.log(sigma * np.sqrt(2.0 * np.pi)), 0.0).sum(1)
    out: Float = np.full(len(own), -np.inf)
    some = np.flatnonzero((known.sum(1) >= sides) & (most - closed >= least))
    step = np.linspace(-_LARGEST, _LARGEST, 201)[:, None]
    each = stats.norm.logpdf(own[some, None], step, np.hypot(sigma, _UNEVEN * step))
    prior = stats.norm.logpdf(step[:, 0], 0.0, _EXPECTED) + np.log(step[1, 0] - step[0, 0])
    opened = np.logaddexp.reduce(np.where(known[some, None], each, 0.0).sum(2) + prior, axis=1)
    out[some] = opened - closed[some]
    return np.where(out >= least, out, -np.inf)
