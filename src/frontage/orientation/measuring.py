"""Control points of one photo for an adjustment, with templates as large as precise points take."""

from dataclasses import dataclass

import numpy as np

from frontage.model import Photo
from frontage.orientation.control import ControlPoints, find_control
from frontage.orientation.reflectance.surface import ScannedSurface
from frontage.orientation.reflectance.tones import ImageOf
from frontage.orientation.result import MANY, PRECISE_PX
from frontage.orientation.significance import CRITICAL_DISTANCE
from frontage.orientation.templates import HALF

_ROUNDS = 3  # of tests, each by what the one before has left


@dataclass(frozen=True)
class Search:
    """How control is looked for, in px of renderings.

    radius   the largest shift
    step     the distance of templates
    largest  how far templates reach to every side; those larger than `HALF` may become `wider`
    """

    radius: int
    step: int
    largest: int = HALF
    wider: int = 2


def measured_control(
    photo: Photo, surface: ScannedSurface, image_of: ImageOf, search: Search
) -> ControlPoints:
    """Returns the most precise control points of every part of a photo.

    The scan shows an edge displaced by a part of its spacing, and the larger a template is, the more of that
    averages out. Where too few points agree with the pose as well as is wanted, because the scan is sparse
    there, larger templates are tried, which tell less of single places. Steps in depth, which are all that
    shape alone has, are displaced to one side, which no template averages out.
    """

    def found(wider: int) -> ControlPoints:
        radius, step, largest = search.radius, search.step, search.largest
        points = find_control(
            photo, surface, image_of, radius=radius, step=step, largest=largest, wider=wider
        )
        return points.telling()

    control = found(1)
    if search.largest <= HALF or surface.tone is None:
        return control
    as_it_is = agreement(control)
    if as_it_is.surely_precise:
        return control
    larger = found(search.wider)
    return larger if agreement(larger).better_than(as_it_is) else control


@dataclass(frozen=True)
class Agreement:
    """How control points agree with a pose.

    count  of those that do
    rms    px per axis, of the most precise of them, as many as determine a photo well
    apart  how many of these do not overlap, which tells how well their rms is known
    """

    count: int
    rms: float
    apart: int

    @property
    def surely_precise(self) -> bool:
        """Whether there are enough, and their rms would be good enough with a standard error more."""
        error = self.rms / np.sqrt(4.0 * max(1, self.apart))  # two axes each
        return self.count >= MANY and self.rms + error <= PRECISE_PX

    def better_than(self, other: "Agreement") -> bool:
        """Whether these points are more precise, or more where either are too few."""
        if min(self.count, other.count) >= MANY:
            return self.rms < other.rms
        return self.count > other.count


def agreement(control: ControlPoints) -> Agreement:
    """How control points agree with the pose that they were looked for with.

    It is that of an adjustment before, and these points will hardly move it.
    """
    far = np.linalg.norm(control.moved, axis=1) / control.sigma
    rows = np.arange(len(control))
    for _ in range(_ROUNDS):
        rows = rows[far[rows] <= CRITICAL_DISTANCE * np.sqrt((far[rows] ** 2).sum() / max(1, 2 * len(rows)))]
    best = rows[np.argsort(control.sigma[rows], kind="stable")[:MANY]]
    if not len(best):
        return Agreement(0, np.inf, 0)
    places = np.floor(control.pixels[best] / control.side[best, None])
    rms = float(np.sqrt((control.moved[best] ** 2).mean()))
    return Agreement(len(rows), rms, len(np.unique(places, axis=0)))
