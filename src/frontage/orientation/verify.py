"""Does the scan, drawn again at the final pose, agree with the photo? And nowhere else as well?

Two tests per photo, after Meierhold et al. (2010) and against repeated windows, besides that of places far
away (`elsewhere`):

- templates of the rendering must be found where the pose puts them more often than chance would: with a share
  `p` of the search window counting as "there", k of n hits have a binomial tail probability;
- the correlation summed over all templates must be highest where the scan is, and not when it is moved along
  the wall. On a facade of equal windows a pose
  that is wrong by one window fits almost as well, but not better. Whether it is *significantly* higher
  elsewhere follows from the scatter of the differences from template to template.
"""

import math
from dataclasses import dataclass

import numpy as np
from scipy.stats import binom

from frontage.geometry.arrays import Array, Bool, Float, Int
from frontage.model import Photo
from frontage.orientation.control import rendering_channels
from frontage.orientation.gradients import oriented_gradients, padded
from frontage.orientation.reflectance.render import Rendering, pixel_factor, render
from frontage.orientation.reflectance.surface import ScannedSurface
from frontage.orientation.reflectance.tones import ImageOf, photo_tone
from frontage.orientation.significance import CRITICAL
from frontage.orientation.templates import correlation_surfaces

_PIXEL_M = 0.06  # of the rendering: fine enough for window frames
_REACH_M = 3.6  # how far off is looked for: one axis of windows, and more than most
_RADIUS = round(_REACH_M / _PIXEL_M)  # px of the rendering
_NEAR_PX = 3.0  # of the rendering: the peak of the sum lies there when the pose is right
_SHARE = float(np.pi * _NEAR_PX**2 / (2 * _RADIUS + 1) ** 2)  # of the places of a template that are there
_STEP = 24
_GRID_M = 0.12  # between the places that are tried
_SEEN = 0.4  # share of the templates that must be in view at a place
_WALL_M = 0.5  # to the piece of surface that a template lies on
_CHANCE = 1e-6  # probability of a chance result below which a pose is confirmed
_RIVAL = 0.85  # agreement elsewhere, relative to that here, from which a pose is not confirmed
_FEWEST = 8  # templates, below which nothing can be said

NO_CHANCE = -math.log(_CHANCE)
"""Evidence from which it is no chance that a scan agrees with a photo."""


@dataclass(frozen=True)
class Verdict:
    """What drawing the scan again says of a pose.

    templates    number of templates that were compared
    agreeing     number of them that were found where the pose puts them
    chance       probability of as many by chance
    shift        px of the photo, from the pose to the best agreement of all templates together
    rival        sum of correlation at the best place apart from it, relative to its own
    excess       how much better the templates agree there, in standard errors; negative if worse
    far          how much likelier the best place in all of the scan is, in standard errors; negative if less
    away         m, how far off that is
    """

    templates: int
    agreeing: int
    chance: float
    shift: float
    rival: float
    excess: float
    far: float = -math.inf
    away: float = 0.0

    @property
    def decided(self) -> bool:
        """Whether the photo shows enough of the scan for a verdict."""
        return self.templates >= _FEWEST

    @property
    def confirmed(self) -> bool:
        """Whether the scan is where the pose says, beyond chance, and nowhere else as well."""
        return self.decided and self.chance < _CHANCE and self.alone

    @property
    def alone(self) -> bool:
        """Whether the scan agrees with the photo better here than far away, and clearly so nearby."""
        return self.rival < _RIVAL and self.far <= 0.0

    @property
    def doubted(self) -> bool:
        """Whether the scan agrees better elsewhere, be it by chance or not."""
        return self.far > 0.0 or self._is_better_nearby

    @property
    def contradicted(self) -> bool:
        """Whether the scan is found elsewhere, significantly better than where the pose puts it."""
        return self.far > CRITICAL or (self._is_better_nearby and self.excess > CRITICAL)

    @property
    def _is_better_nearby(self) -> bool:
        """Whether the templates together agree better at another place near the pose."""
        return self.decided and self.shift > 0.0

    @property
    def distance(self) -> str:
        """How far off the scan is found."""
        return f"{self.away:.1f} m" if self.far > 0.0 else f"{self.shift:.0f} px"

    @property
    def evidence(self) -> float:
        """Minus the log of the probability that as many templates are found by chance."""
        return _evidence(self.agreeing, self.templates)


def verify(photo: Photo, surface: ScannedSurface, image_of: ImageOf) -> Verdict:
    """Compares a photo with the scan drawn at its pose."""
    drawn, scale, at, surfaces = _compared(photo, surface, image_of)
    if not len(at):
        return Verdict(0, 0, 1.0, 0.0, 0.0, 0.0)
    agreeing = _agreeing(surfaces)
    chance = math.exp(-_evidence(agreeing, len(at)))
    shift, rival, excess = _elsewhere(drawn, surface, at, surfaces)
    return Verdict(len(at), agreeing, chance, shift * scale, rival, excess)


def evidence(photo: Photo, surface: ScannedSurface, image_of: ImageOf) -> float:
    """Returns minus the log of the probability that a photo agrees by chance as well with the scan."""
    _, _, at, surfaces = _compared(photo, surface, image_of)
    return _evidence(_agreeing(surfaces), len(at)) if len(at) else 0.0


def likelier(there: float, here: float) -> float:
    """Returns how much more evidence there is at one place than at another, in standard errors.

    Every template that is found adds minus the log of its chance, and their number scatters as counts do.
    """
    error = math.sqrt(-math.log(_SHARE) * (there + here))
    return (there - here) / error if error > 0.0 else 0.0


def _compared(
    photo: Photo, surface: ScannedSurface, image_of: ImageOf
) -> tuple[Rendering, float, Int, Array]:
    """The scan drawn at a pose, px of the photo per pixel, templates (n, 2) of it and their surfaces."""
    factor = max(1.0, pixel_factor(photo, surface, _PIXEL_M))
    drawn = render(photo, surface, factor)
    tone, scale = photo_tone(image_of(photo.id), factor)
    template, picture = (
        padded(c, _RADIUS) for c in (rendering_channels(drawn, surface), oriented_gradients(tone))
    )
    at, surfaces = correlation_surfaces(template, picture, _RADIUS, _STEP)
    at = at - _RADIUS
    solid = drawn.depth[at[:, 1], at[:, 0]] > 0
    return drawn, float(scale.mean()), at[solid], surfaces[solid]


def _agreeing(surfaces: Array) -> int:
    """How many templates are found where the pose puts them."""
    row, column = np.divmod(surfaces.reshape(len(surfaces), -1).argmax(1), 2 * _RADIUS + 1)
    return int((np.hypot(row - _RADIUS, column - _RADIUS) <= _NEAR_PX).sum())


def _evidence(agreeing: int, templates: int) -> float:
    """Minus the log probability that so many templates agree by chance; every second is independent."""
    independent = max(1, templates // 2)
    count = round(agreeing * independent / max(1, templates))
    return -float(binom.logsf(count - 1, independent, _SHARE))


def _elsewhere(
    drawn: Rendering, surface: ScannedSurface, at: Int, surfaces: Array
) -> tuple[float, float, float]:
    """Where all templates together agree best, apart from here.

    Returns how far off that is in px, 0 if they agree better here; how well they agree there relative to
    here; and the excess in standard errors.

    Every template is moved as its piece of the wall would be seen if the scan were moved along the wall, to
    the side and up: in a slanted view a window is not equally wide everywhere.
    """
    steps = np.arange(-_REACH_M, _REACH_M + 1e-9, _GRID_M)
    aside, up = (g.ravel() for g in np.meshgrid(steps, steps))
    xyz = drawn.points(at)
    along = _wall_direction(surface, xyz)
    moved = np.column_stack([aside[:, None] * along[:2], up])
    places = (xyz[:, None] + moved).reshape(-1, 3)
    seen = drawn.photo.project(places).reshape(len(at), len(moved), 2) / drawn.scale
    value, inside, off = _values(surfaces, seen, at, drawn.known.shape)
    near = np.hypot(aside, up) <= _NEAR_PX * _PIXEL_M
    here = value[:, np.flatnonzero(near)[value[:, near].sum(0).argmax()]]
    far = (np.hypot(aside, up) > 2 * _NEAR_PX * _PIXEL_M) & (inside.sum(0) >= _SEEN * len(at))
    if not far.any():
        return 0.0, 0.0, 0.0
    # Compared on the templates that are in view at both places.
    relative = value.sum(0) / np.maximum((here[:, None] * inside).sum(0), 1e-9)
    best = int(np.where(far, relative, -np.inf).argmax())
    rival = float(relative[best])
    shift = float(np.nanmedian(np.linalg.norm(off[:, best], axis=1))) if rival > 1.0 else 0.0
    both = inside[:, best]
    return shift, rival, _standard_errors(value[both, best] - here[both])


def _standard_errors(difference: Float) -> float:
    """The mean of differences (n,) in its standard errors; templates overlap, and every second counts."""
    scatter = float(difference.std(ddof=1)) if len(difference) > 1 else 0.0
    error = scatter / float(np.sqrt(max(1.0, len(difference) / 2)))
    return float(difference.mean()) / max(error, 1e-9)


def _values(surfaces: Array, seen: Float, at: Int, shape: tuple[int, ...]) -> tuple[Float, Bool, Float]:
    """The correlation (n, k) of templates moved to k places, where it is known, and the moves in px."""
    off = seen - (at[:, None] + 0.5)
    radius, (h, w) = surfaces.shape[1] // 2, shape
    with np.errstate(invalid="ignore"):
        inside = (
            (np.abs(off) < radius).all(-1) & (seen > _STEP).all(-1) & (seen < (w - _STEP, h - _STEP)).all(-1)
        )
    cell = np.where(inside[..., None], np.rint(np.nan_to_num(off)), 0.0).astype(np.int64) + radius
    value = surfaces[np.arange(len(at))[:, None], cell[..., 1], cell[..., 0]]
    return np.where(inside, value, 0.0), inside, off


def _wall_direction(surface: ScannedSurface, xyz: Float) -> Float:
    """The horizontal direction (3,) along the walls that most of the points (n, 3) lie on."""
    piece = surface.near(_WALL_M, xyz)
    normal = surface.pieces.normal[piece[piece >= 0]][:, :2]
    across = np.linalg.eigh(normal.T @ normal)[1][:, 1] if len(normal) else np.array([0.0, 1.0])
    return np.array([-across[1], across[0], 0.0])
