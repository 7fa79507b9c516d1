"""Does the scan, drawn again at the final pose, agree with the photo? And nowhere else nearby as well?

Two tests per photo, after Meierhold et al. (2010) and against repeated windows:

- templates of the rendering must be found where the pose puts them more often than chance would: with a share
  `p` of the search window counting as "there", k of n hits have a binomial tail probability;
- the correlation summed over all templates must be highest at no shift. On a facade of equal windows a pose
  that is wrong by one window fits almost as well, but not better.
"""

from dataclasses import dataclass

import numpy as np
from scipy.stats import binom

from frontage.model import Photo
from frontage.orientation.control import rendering_channels
from frontage.orientation.gradients import oriented_gradients, padded
from frontage.orientation.reflectance.render import FINEST, render, rendering_factor
from frontage.orientation.reflectance.surface import ScannedSurface
from frontage.orientation.reflectance.tones import ImageOf, photo_tone
from frontage.orientation.templates import correlation_surfaces

_PIXEL_M = 0.06  # of the rendering: fine enough for window frames
_REACH_M = 3.6  # how far off is looked for: one axis of windows, and more than most
_NEAR_PX = 3.0  # of the rendering: the peak of the sum lies there when the pose is right
_STEP = 36
_CHANCE = 1e-6  # probability of a chance result below which a pose is confirmed
_FEWEST = 8  # templates, below which nothing can be said


@dataclass(frozen=True)
class Verdict:
    """What drawing the scan again says of a pose.

    templates    number of templates that were compared
    agreeing     number of them that were found where the pose puts them
    chance       probability of as many by chance
    shift        px of the photo, from the pose to the best agreement of all templates together
    rival        sum of correlation at the best place apart from it, relative to its own
    """

    templates: int
    agreeing: int
    chance: float
    shift: float
    rival: float

    @property
    def decided(self) -> bool:
        """Whether the photo shows enough of the scan for a verdict."""
        return self.templates >= _FEWEST

    @property
    def confirmed(self) -> bool:
        """Whether the scan is where the pose says, beyond chance, and nowhere else as well."""
        return self.decided and self.chance < _CHANCE and self.shift == 0.0

    @property
    def contradicted(self) -> bool:
        """Whether the scan is found clearly elsewhere."""
        return self.decided and self.shift > 0.0


def verify(photo: Photo, surface: ScannedSurface, image_of: ImageOf) -> Verdict:
    """Compares a photo with the scan drawn at its pose."""
    spacing = rendering_factor(photo, surface) / FINEST
    factor = max(spacing * _PIXEL_M / float(np.median(surface.spacing)), 1.0)
    drawn = render(photo, surface, factor)
    tone, scale = photo_tone(image_of(photo.id), factor)
    radius = round(_REACH_M / _PIXEL_M)
    template, picture = (
        padded(c, radius) for c in (rendering_channels(drawn, surface), oriented_gradients(tone))
    )
    at, surfaces = correlation_surfaces(template, picture, radius, _STEP)
    if not len(at):
        return Verdict(0, 0, 1.0, 0.0, 0.0)
    row, column = np.divmod(surfaces.reshape(len(at), -1).argmax(1), 2 * radius + 1)
    agreeing = int((np.hypot(row - radius, column - radius) <= _NEAR_PX).sum())
    share = np.pi * _NEAR_PX**2 / (2 * radius + 1) ** 2
    # Templates overlap, so that only every second is independent.
    independent = max(1, len(at) // 2)
    chance = float(binom.sf(round(agreeing * independent / len(at)) - 1, independent, share))
    return _judged(surfaces.sum(0), radius, float(scale.mean()), len(at), agreeing, chance)


def _judged(
    total: np.ndarray, radius: int, scale: float, templates: int, agreeing: int, chance: float
) -> Verdict:
    rows, columns = np.mgrid[-radius : radius + 1, -radius : radius + 1]
    distance = np.hypot(rows, columns)
    own = float(total[distance <= _NEAR_PX].max())
    other = np.where(distance > 2 * _NEAR_PX, total, -np.inf)
    best = float(other.max())
    shift = float(distance.ravel()[other.argmax()]) * scale if best > own else 0.0
    return Verdict(templates, agreeing, chance, shift, best / max(own, 1e-9))
