"""Finds openings closed level with the wall: shutters, panes, grilles that look a little different.

They are looked for where something was seen, in the rows and columns of the other openings, in the forms of
these. There the means of relief, intensity and colour must step together by the same amount on all sides,
sharply, where the borders are expected, and be alike within. The wall itself tells how large such steps are
on it by chance.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from frontage.geometry.arrays import Bool, Float
from frontage.model.facade import Facade
from frontage.model.ortho import OrthoImage
from frontage.model.scan import Scan
from frontage.openings.borders.outline import Outline
from frontage.openings.boxes import Box
from frontage.openings.closed.borders import Contrast, measure_closed
from frontage.openings.closed.channels import ChannelLayer, WallSamples, photo_layer, scan_layer, wall_points
from frontage.openings.closed.places import CandidatePlaces, along_lines, at_crossings
from frontage.openings.closed.sides import contrasts_of, gains_of
from frontage.openings.closed.steps import ChannelMap, wall_steps
from frontage.openings.layout.inferred import SEEN, state_of
from frontage.openings.wall.beams import Beams
from frontage.openings.wall.evidence import Evidence

_SURE = 0.99  # posterior probability that an opening needs
_TELLS = float(np.log(_SURE / (1.0 - _SURE)))  # nats for it at even odds
_LIKELY = 3.0  # nats from which a place may be an opening, and is not used to learn how the wall looks
_PRIOR = 0.05  # share of the crossings seen as wall that hold a closed opening
_BESIDE = 0.06  # m: clear places nearer to one another belong to one opening
_REACH = (0.05, 0.3)  # m before the wall and behind it: walls are that thick, rooms lie deeper


@dataclass(frozen=True, eq=False)
class ClosedOpening:
    """An opening that is closed level with the wall, its posterior probability, and its evidence in nats."""

    outline: Outline
    confidence: float
    evidence: float


def find_closed_openings(
    facade: Facade,
    scan: Scan,
    beams: Beams,
    evidence: Evidence,
    outlines: Sequence[Outline],
    *,
    ortho: OrthoImage | None = None,
) -> list[ClosedOpening]:
    """Returns the closed openings where beams came back, like `outlines` and in a row or a column with them.

    Posterior: the likelihood of the four steps against that of the wall's own steps, with a price for every
    place that was tried. Openings that were found make further rows and columns. `ortho`, the facade's
    ortho-image, adds colours where photos saw the wall.
    """
    if not outlines:
        return []
    surface = wall_points(facade, scan, beams, _REACH)
    layers = [scan_layer(surface, facade, scan), photo_layer(ortho, facade) if ortho is not None else None]
    search = _Search(surface, [v for v in layers if v is not None], evidence)
    found: list[ClosedOpening] = []
    while True:
        known = [*outlines, *(f.outline for f in found)]
        more = search.at_crossings(known) or search.along_lines(known)
        if not more:
            return found
        found += more


@dataclass(frozen=True, eq=False)
class _Peak:
    """A place whose steps speak for an opening by `gain` nats, and its contrasts with the wall."""

    gain: float
    places: CandidatePlaces
    k: int
    contrasts: Sequence[Contrast]


def _are_blind(steps: Sequence[Float], walls: Sequence[Float], node: bool) -> Bool:
    """Returns which places (n,) step back as openings do, but look like the wall: blind windows and panels.

    `steps` (n, 4, c) and `walls` (4, c, c) are those of the layers. The first channel of the first layer is
    the relief. Without any other channel nothing tells how a place looks, and none is blind.
    """
    relief = gains_of(steps[0][..., :1], walls[0][:, :1, :1], node)
    others = zip((steps[0][..., 1:], *steps[1:]), (walls[0][:, 1:, 1:], *walls[1:]), strict=True)
    look = [gains_of(own, wall, node) for own, wall in others if own.shape[2] > 0]
    if not look:
        return np.zeros(len(relief), np.bool_)
    return np.asarray((relief > 0.0) & (np.maximum(look, 0.0).sum(0) < _TELLS), np.bool_)


def _beside_others(peaks: Sequence[_Peak]) -> Bool:
    """Returns which peaks (n,) may be one opening with one of those before them, seen from two cells."""
    corner = np.array([p.places.box(p.k)[:2] for p in peaks]).reshape(-1, 2)
    owner = np.array([id(p.places) for p in peaks], np.uint64)
    near = np.abs(corner[:, None] - corner).max(2, initial=0.0) < _BESIDE
    return np.asarray(np.tril(near & (owner[:, None] == owner), -1).any(1))


class _Search:
    """Tests many places of one facade."""

    def __init__(self, surface: WallSamples, layers: Sequence[ChannelLayer], evidence: Evidence) -> None:
        self._surface, self._layers, self._evidence = surface, layers, evidence
        self._cell = max(v.picture.raster.cell for v in layers)

    def at_crossings(self, known: Sequence[Outline]) -> list[ClosedOpening]:
        """Searches at the crossings of rows and columns."""
        places = at_crossings(known, self._evidence)
        return self._tried(places, known, [p.box(0) for p in places])

    def along_lines(self, known: Sequence[Outline]) -> list[ClosedOpening]:
        """Searches anywhere along a row or a column."""
        return self._tried(list(along_lines(known, self._evidence, self._cell)), known, [])

    def _tried(
        self, places: Sequence[CandidatePlaces], known: Sequence[Outline], taken: Sequence[Box]
    ) -> list[ClosedOpening]:
        """Returns the openings among all places.

        What may be an opening (at first those `taken`) is not used to learn how the wall looks: otherwise
        several closed windows would hide one another.
        """
        likely = [outline.place for _, outline in self._clear(places, known, taken, _LIKELY, tails=False)]
        if not likely:
            return []
        tries = sum(len(p.x) for p in places)
        price = float(np.log(tries * (1.0 - _PRIOR) / _PRIOR))
        least = price + _TELLS
        clear = self._clear(places, known, likely, least)
        return [ClosedOpening(o, float(1.0 / (1.0 + np.exp(price - gain))), gain) for gain, o in clear]

    def _clear(
        self,
        places: Sequence[CandidatePlaces],
        known: Sequence[Outline],
        taken: Sequence[Box],
        least: float,
        tails: bool = True,
    ) -> list[tuple[float, Outline]]:
        """Returns the nats and outlines of the places that gain `least` nats, the clearest first.

        The wall is what is neither `known` nor `taken`.
        """
        bare = [v.picture.without([*(o.place for o in known), *taken]) for v in self._layers if places]
        peaks = sorted((q for p in places for q in self._peaks(p, bare, least, tails)), key=lambda q: -q.gain)
        found: list[tuple[float, Outline]] = []
        beside = _beside_others(peaks)
        for n, peak in enumerate(peaks):
            others = [*known, *(outline for _, outline in found)]
            if beside[n] or not self._seen(peak.places.box(peak.k), others):
                continue
            like = known[peak.places.like]
            made = (measure_closed(peak.places, peak.k, like, c, self._surface) for c in peak.contrasts)
            outline = next((o for o in made if o is not None), None)
            if outline is not None and self._seen(outline.place, others):
                found.append((peak.gain, outline))
        return found

    def _seen(self, place: Box, others: Sequence[Outline]) -> bool:
        """Returns whether beams came back from a free place."""
        return state_of(place, others, self._evidence) in SEEN

    def _peaks(
        self, places: CandidatePlaces, bare: Sequence[ChannelMap], least: float, tails: bool
    ) -> Iterator[_Peak]:
        """Yields those of the places that gain `least` nats."""
        walls = [wall_steps(own, places.form, tails) for own in bare]
        steps = [v.picture.steps(places.x, places.z, places.form) for v in self._layers]
        gains = [gains_of(own, w, places.node) for own, w in zip(steps, walls, strict=True)]
        gain = np.maximum(gains, 0.0).sum(0)  # an opening need not show in all layers
        likely = np.flatnonzero(gain >= least)
        likely = likely[~_are_blind([own[likely] for own in steps], walls, places.node)]
        for k in likely:
            n = int(np.argmax([g[k] for g in gains]))
            contrasts = [Contrast(self._layers[n], *c) for c in contrasts_of(steps[n][k], walls[n])]
            yield _Peak(float(gain[k]), places, int(k), contrasts)
