"""Why no photo shows a facade although photos were given."""

from collections import Counter
from collections.abc import Sequence

import numpy as np

from frontage.model import Photo, PhotoRemark
from frontage.ortho.surface import DrawingSurface
from frontage.ortho.views import ViewPlan

_GRID = 33  # places along each side of the facade that are looked for in a photo


def why_no_photo(
    surface: DrawingSurface, photos: Sequence[Photo], plan: ViewPlan | None, left_out: frozenset[str]
) -> tuple[PhotoRemark, ...]:
    """Counts the conditions that excluded all photos; empty where a plan uses some or none were given.

    Those in `left_out` contradict other pictures, or nothing told their orientation.
    """
    if plan is not None or not photos:
        return ()
    counts = Counter(
        "left out for another reason" if photo.id in left_out else _reason(surface, photo) for photo in photos
    )
    reasons = ", ".join(f"{number} {reason}" for reason, number in sorted(counts.items()))
    text = f"none of {len(photos)} photos shows this facade ({reasons}); it is drawn from the scan"
    hint = "if photos were taken of it, check their poses, and [photos] offset"
    return (PhotoRemark("F304", text, hint),)


def _reason(surface: DrawingSurface, photo: Photo) -> str:
    """The condition that excluded a photo: the first that it does not meet."""
    if photo.local_from_camera is None:
        return "without a pose"
    facade, raster = surface.facade, surface.raster
    if facade.frame.inverse.apply(photo.pose.t[None])[0, 1] >= 0.0:
        return "behind it"
    column, row = np.linspace(0, raster.width, _GRID), np.linspace(0, raster.height, _GRID)
    at = surface.projection_into(photo, "full")(column[None, :], row[:, None], 0.0)
    with np.errstate(invalid="ignore"):
        inside = (at > 1.0).all(-1) & (at < np.array([photo.camera.width, photo.camera.height]) - 1.0).all(-1)
    return "where something hides it" if inside.any() else "looking elsewhere"
