"""Photos whose control points agree on another pose than the one that their tie points lead to.

Tie points between different things that look alike, such as leaves and cars, agree with one another, and
where nothing was scanned the scan does not contradict them. There may be so many of them that the adjustment
takes the control points of their photo for the gross errors. Control points are found one by one: when many
of them agree on one pose, it is the ties that are wrong.
"""

from dataclasses import dataclass, replace

import numpy as np

from frontage.geometry.arrays import Bool, Float
from frontage.geometry.rigid import Rigid3
from frontage.model import Estimate, Photo
from frontage.orientation.adjusted import AdjustedPhotos
from frontage.orientation.network import CONTROL
from frontage.orientation.placed import Placed
from frontage.orientation.resection import resect
from frontage.orientation.significance import CRITICAL, CRITICAL_DISTANCE


@dataclass(frozen=True, eq=False)
class Outvoted:
    """A photo, by its place among those adjusted, and the pose that its control points agree on.

    excess  how many more of them agree with it than with the adjusted pose, in standard errors
    """

    photo: int
    pose: Rigid3
    excess: float


def most_outvoted(state: AdjustedPhotos, seed: int) -> Outvoted | None:
    """Returns the photo whose control points contradict its adjusted pose most; None if none do.

    Photos without tie points have the pose that their control points tell, and those of rigs have one that
    their fellows see to.
    """
    photos = state.improved.photos
    tied = [k for k in range(len(photos)) if len(state.fellows(k)) == 1 and len(state.ties_of(k))]
    found = [one for k in tied if (one := _outvoted(state, k, photos[k], seed)) is not None]
    return max(found, key=lambda one: one.excess, default=None)


def by_control_alone(placed: Placed, one: Outvoted) -> Placed:
    """Returns the photos with one of them at the pose of its control points and without its tie points."""
    photos = list(placed.photos)
    photos[one.photo] = _posed(photos[one.photo], one.pose)
    kept = placed.ties.take(placed.ties.photo != one.photo)
    return Placed(placed.numbers, tuple(photos), kept)


def _outvoted(state: AdjustedPhotos, k: int, photo: Photo, seed: int) -> Outvoted | None:
    found, images, control = state.adjustment, state.network.images, state.control[k]
    sigma = images.sigma[(images.photo == k) & (images.group == CONTROL)]
    near = CRITICAL_DISTANCE * np.sqrt(found.factors[CONTROL]) * sigma
    if not len(near):
        return None
    own = resect(photo.camera, control.pixels, control.xyz, float(np.median(near)), seed=seed)
    if own is None:
        return None

    def agree(pose: Rigid3) -> Bool:
        seen = _posed(photo, pose).project(control.xyz)
        return np.asarray(np.linalg.norm(control.pixels - seen, axis=1) < near)

    gained = agree(own.pose).astype(np.float64) - agree(photo.pose)
    excess = _standard_errors(gained, control.pixels / control.side[:, None])
    return Outvoted(k, own.pose, excess) if excess > CRITICAL else None


def _standard_errors(gained: Float, place: Float) -> float:
    """Returns the sum of differences (n,) over its standard error; those in one template count as one."""
    template = np.unique(np.floor(place), axis=0, return_inverse=True)[1].ravel()
    each = np.bincount(template, gained)
    return float(each.sum() / max(np.linalg.norm(each), 1e-9))


def _posed(photo: Photo, pose: Rigid3) -> Photo:
    return replace(photo, local_from_camera=Estimate(pose, np.zeros((6, 6)), 0.0))
