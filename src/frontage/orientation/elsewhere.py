"""Does another part of the scan agree better with a photo, or with all photos of a block?

Templates tell of the surroundings of a pose only. Where facades repeat themselves, or two walls are painted
alike, a pose may be wrong by any distance and agree in a part of the picture beyond any chance. The photo is
therefore drawn on the wall that it shows and compared with all walls of the scan, at all shifts. It is moved
to where it fits best, and the scan is drawn once more. The likelier of both places is the one where chance
would be less likely to find as many templates.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from frontage.geometry.arrays import Int
from frontage.model import Estimate, Photo
from frontage.orientation.drawnwall import DrawnWall, Fit, Similarity, shown_part
from frontage.orientation.place import FINE_M, distinct
from frontage.orientation.placed import agrees_with_prior
from frontage.orientation.reflectance.surface import ScannedSurface
from frontage.orientation.reflectance.tones import ImageOf
from frontage.orientation.verify import NO_CHANCE, Verdict, evidence, likelier
from frontage.orientation.wallpicture import scan_on_wall
from frontage.orientation.walls import scan_walls
from frontage.solve.abreast import each

_TRIED = 2  # places of a photo
_LIKELY = 0.5  # gain of the picture of a wall at another place, relative to that at the pose, to be tried
_HERE_M = 1.0  # from where its pose puts it
_SAME_SIZE = np.ones(1)


@dataclass(frozen=True, eq=False)
class OtherPlace:
    """Where photos may have to be moved to.

    motion   of the photos, in local metres
    away     m, its length at the wall
    there    evidence at that place, and `here` at their poses
    """

    motion: Similarity
    away: float
    there: float
    here: float

    @property
    def excess(self) -> float:
        """How much likelier this place is, in standard errors."""
        return likelier(self.there, self.here)


class OtherPlaces:
    """All walls of a scan, on which photos are looked for."""

    def __init__(self, surface: ScannedSurface, image_of: ImageOf) -> None:
        self._surface, self._image_of = surface, image_of
        self._walls = scan_walls(surface.pieces)
        self._charts = [scan_on_wall(surface, wall, FINE_M) for wall in self._walls]

    def judged(
        self, photos: Sequence[Photo], given: Sequence[Photo], verdicts: Sequence[Verdict], blocks: Int
    ) -> list[Verdict]:
        """Returns the verdicts (p,) on photos with what other places tell.

        given   (p,) with their approximate poses, if these are known: what contradicts them is no other place
        blocks  (p,) numbers the blocks of the photos

        A photo of which much is in view is judged by itself as well, others by their whole block.
        """
        found = list(each(lambda k: self._best(photos[k], given[k], verdicts[k]), range(len(photos))))
        judged = list(verdicts)
        for number in np.unique(blocks):
            own: list[int] = np.flatnonzero(blocks == number).tolist()
            together = self._of_block(photos, verdicts, own, found)
            for k in own:
                alone = found[k] if verdicts[k].decided or len(own) == 1 else None
                best = _likeliest([place for place in (alone, together) if place is not None])
                if best is not None and best.there > NO_CHANCE:  # else it may be chance that it fits there
                    judged[k] = replace(verdicts[k], far=best.excess, away=best.away)
        return judged

    def _best(self, photo: Photo, given: Photo, verdict: Verdict) -> OtherPlace | None:
        """The likeliest other place of a photo; None where none fits nearly as well."""
        motions, here = self._motions(photo, given), verdict.evidence
        return _likeliest([OtherPlace(m, away, self._moved(photo, m), here) for m, away in motions])

    def _of_block(
        self,
        photos: Sequence[Photo],
        verdicts: Sequence[Verdict],
        own: Sequence[int],
        found: Sequence[OtherPlace | None],
    ) -> OtherPlace | None:
        """The other place of a whole block which is the likeliest for one of its photos."""
        best = _likeliest([place for k in own if (place := found[k]) is not None])
        if best is None or best.excess <= 0.0 or len(own) == 1:
            return None
        there = sum(self._moved(photos[k], best.motion) for k in own)
        return replace(best, there=there, here=sum(verdicts[k].evidence for k in own))

    def _moved(self, photo: Photo, motion: Similarity) -> float:
        """The evidence for a moved photo."""
        there = Estimate(motion.pose(photo.pose), np.zeros((6, 6)), 0.0)
        return evidence(replace(photo, local_from_camera=there), self._surface, self._image_of)

    def _motions(self, photo: Photo, given: Photo) -> list[tuple[Similarity, float]]:
        """Motions to the best places where a photo fits nearly as well as at its pose; their lengths, m."""
        length = dict(self._fits(photo))
        own = max((fit.gain for fit, away in length.items() if away <= _HERE_M), default=0.0)
        others = [
            fit
            for fit, away in length.items()
            if away > _HERE_M
            and fit.gain > _LIKELY * own
            and agrees_with_prior(fit.similarity.pose(photo.pose), given)
        ]
        best = distinct(sorted(others, key=lambda fit: -fit.gain), _TRIED)
        return [(replace(fit.similarity, scale=1.0), length[fit]) for fit in best]

    def _fits(self, photo: Photo) -> Iterator[tuple[Fit, float]]:
        """The places of a photo on all walls of the scan, each with its distance from the pose, m."""
        for wall in self._walls:
            part = shown_part(photo, wall)
            if part is None:
                continue
            x0, z0, x1, z1 = part.extent
            middle = part.pose.apply(np.array([[0.5 * (x0 + x1), 0.0, 0.5 * (z0 + z1)]]))
            drawn = DrawnWall(part, 1.0, [photo], self._image_of)
            for number, host in enumerate(self._walls):
                for fit in drawn.places(host, self._charts[number], FINE_M, _SAME_SIZE, number):
                    yield fit, float(np.linalg.norm(fit.similarity.apply(middle) - middle))


def _likeliest(places: Sequence[OtherPlace]) -> OtherPlace | None:
    """Returns the place that is likelier than its photos' own by most; None if there is no place."""
    return max(places, key=lambda place: place.excess, default=None)
